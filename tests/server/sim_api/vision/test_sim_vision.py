"""``simVision``: what scripts do to work images and find in them. The sensor `lazy` has 6 x 4 pixels."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from handler_calls import QuickPainter, floats
from real_world import render_with
from sim_api_calls import SCENE, ScriptWorld

WIDTH, HEIGHT = 6, 4
EXPLICIT = SCENE.replace(
    '<site name="tip"', f'<camera name="lazy" resolution="{WIDTH} {HEIGHT}" fovy="60"/><site name="tip"'
).replace("</custom>", '<text name="simx:vision:lazy" data="explicit=yes near=1 far=3"/></custom>')

START = """
local h = sim.getObjectHandle('lazy')
sim.setVisionSensorCharImage(h, '{image}')
simVision.sensorImgToWorkImg(h)
"""


class Eye(ScriptWorld):
    """Lua on a sensor that shows an image."""

    def worked(self, image: np.ndarray, source: str) -> np.ndarray:
        """(height, width, 3) bytes as clients see them after a piece of Lua; `image` may be (height, width)."""
        self.found(image, source + " simVision.workImgToSensorImg(h)")
        data = self.call("simxGetVisionSensorImage", self.handle("lazy"), 0)[1]
        return np.frombuffer(data, np.uint8).reshape(HEIGHT, WIDTH, 3)

    def found(self, image: np.ndarray, source: str) -> list[Any]:
        """The results of a piece of Lua."""
        rgb = np.repeat(image[..., np.newaxis], 3, axis=2) if image.ndim == 2 else image
        text = "".join(f"\\x{byte:02x}" for byte in rgb.astype(np.uint8).tobytes())
        return self.lua(START.replace("{image}", text) + source)

    def packet(self, image: np.ndarray, source: str) -> list[float]:
        """The numbers of the packet, the second result."""
        return floats(self.found(image, source)[1].encode("latin-1"))


@pytest.fixture
def eye(tmp_path: Path) -> Eye:
    world = Eye(tmp_path, EXPLICIT)
    render_with(world, QuickPainter())
    return world


RAMP = np.arange(WIDTH * HEIGHT * 3).reshape(HEIGHT, WIDTH, 3)
GREYS = np.arange(0, 240, 10).reshape(HEIGHT, WIDTH)
SPOT = np.zeros((HEIGHT, WIDTH), int)
SPOT[1:3, 2:5] = 255


def test_flips_and_shifts_move_pixels(eye: Eye) -> None:
    assert (eye.worked(RAMP, "simVision.horizontalFlipWorkImg(h)") == RAMP[:, ::-1]).all()
    assert (eye.worked(RAMP, "simVision.verticalFlipWorkImg(h)") == RAMP[::-1]).all()
    assert (
        eye.worked(RAMP, "simVision.shiftWorkImg(h, {1/3, 0.5}, true)") == np.roll(RAMP, (2, 2), (0, 1))
    ).all()
    black = eye.worked(RAMP, "simVision.shiftWorkImg(h, {1/3, -0.25}, false)")
    assert (black[:3, 2:] == RAMP[1:, :4]).all()
    assert not black[3].any()
    assert not black[:, :2].any()


def test_a_turn_is_about_the_middle_and_a_stretch_too(eye: Eye) -> None:
    assert (eye.worked(RAMP, "simVision.rotateWorkImg(h, math.pi)") == RAMP[::-1, ::-1]).all()
    quarter = eye.worked(RAMP, "simVision.rotateWorkImg(h, math.pi / 2)")
    assert (quarter[:, 1:5] == np.rot90(RAMP[:, 1:5], -1)).all()  # anticlockwise, as rows go up
    assert not quarter[:, 0].any()
    doubled = eye.worked(RAMP, "simVision.resizeWorkImg(h, {2, 1})")
    assert (doubled == RAMP[:, [1, 2, 2, 3, 3, 4]]).all()
    half = eye.worked(RAMP, "simVision.resizeWorkImg(h, {1, 0.5})")
    assert not half[[0, 3]].any()
    assert half[1:3].any()
    eye.fails("simVision.resizeWorkImg(sim.getObject('/lazy'), {0, 1})", "above 0")


def test_buffers_keep_images_and_are_added_and_subtracted(eye: Eye) -> None:
    assert (eye.worked(GREYS, "simVision.workImgToBuffer1(h) simVision.addBuffer1ToWorkImg(h)")[..., 0]
            == np.minimum(2 * GREYS, 255)).all()  # fmt: skip
    assert not eye.worked(
        GREYS, "simVision.workImgToBuffer1(h) simVision.subtractBuffer1FromWorkImg(h)"
    ).any()
    product = eye.worked(GREYS, "simVision.workImgToBuffer1(h) simVision.multiplyWorkImgWithBuffer1(h)")
    assert product[..., 0] == pytest.approx(GREYS**2 / 255, abs=0.51)
    swapped = "simVision.uniformImgToWorkImg(h, {1, 0.4, 0}) simVision.swapWorkImgWithBuffer1(h) "
    assert (eye.worked(RAMP, "simVision.workImgToBuffer1(h) " + swapped) == RAMP).all()
    assert (eye.worked(RAMP, "simVision.workImgToBuffer1(h) " + swapped + "simVision.buffer1ToWorkImg(h)")
            == [255, 102, 0]).all()  # fmt: skip
    second = "simVision.workImgToBuffer2(h) simVision.horizontalFlipWorkImg(h) simVision.workImgToBuffer1(h) "
    assert (eye.worked(RAMP, second + "simVision.buffer2ToWorkImg(h)") == RAMP).all()
    assert (eye.worked(RAMP, second + "simVision.swapBuffers(h) simVision.buffer1ToWorkImg(h)") == RAMP).all()
    sums = "simVision.workImgToBuffer1(h) simVision.addWorkImgToBuffer1(h) "
    assert (eye.worked(SPOT // 4, sums + "simVision.buffer1ToWorkImg(h)")[..., 0] == SPOT // 4 * 2).all()
    assert not eye.worked(
        SPOT, sums + "simVision.subtractWorkImgFromBuffer1(h) simVision.buffer1ToWorkImg(h)"
    ).any()


def test_intensities_are_stretched_scaled_and_coloured(eye: Eye) -> None:
    stretched = eye.worked(GREYS + 20, "simVision.normalizeWorkImg(h)")[..., 0]
    assert stretched == pytest.approx(GREYS / 230 * 255, abs=0.51)
    assert (
        eye.worked(GREYS, "simVision.intensityScaleOnWorkImg(h, 1, 0, true)")[..., 0] == 255 - GREYS
    ).all()
    thirds = np.zeros((HEIGHT, WIDTH), int)
    thirds[0, :4] = 0, 85, 170, 255
    colours = eye.worked(thirds, "simVision.intensityScaleOnWorkImg(h, 0, 1, false)")[0, :4]
    assert colours.tolist() == [[0, 0, 0], [0, 0, 255], [255, 0, 0], [255, 255, 0]]
    offset = eye.worked(RAMP, "simVision.scaleAndOffsetWorkImg(h, {0.2, 0, 0}, {2, 1, 0}, {0, 0.2, 1}, true)")
    assert offset[..., 0] == pytest.approx(np.minimum((RAMP[..., 0] + 51) * 2, 255), abs=0.51)
    assert offset[..., 1] == pytest.approx(RAMP[..., 1] + 51, abs=0.51)
    assert (offset[..., 2] == 255).all()
    red = np.zeros((HEIGHT, WIDTH, 3), int)
    red[..., 0] = 255
    turned = eye.worked(red, "simVision.scaleAndOffsetWorkImg(h, {1/3, 0, 0}, {1, 1, 1}, {0, 0, 0}, false)")
    assert (turned == [0, 255, 0]).all()


def test_a_colour_is_kept_or_taken_away(eye: Eye) -> None:
    image = np.zeros((HEIGHT, WIDTH, 3), int)
    image[0], image[1], image[2] = [255, 0, 0], [250, 10, 10], [0, 0, 255]
    select = "simVision.selectiveColorOnWorkImg(h, {1, 0, 0}, {0.1, 0.1, 0.1}, true, %s, true) "
    kept = eye.worked(image, select % "true")
    assert (kept[:2] == image[:2]).all()
    assert not kept[2:].any()
    assert (eye.worked(image, select % "true" + "simVision.buffer1ToWorkImg(h)")[2] == [0, 0, 255]).all()
    assert not eye.worked(image, select % "false")[:2].any()
    hue = "simVision.selectiveColorOnWorkImg(h, {0.99, 1, 0.5}, {0.02, 0.2, 0.2}, false, true, false)"
    assert (eye.worked(image, hue)[:2] == image[:2]).all()
    few = eye.worked(image, "simVision.colorSegmentationOnWorkImg(h, 0.1)")
    assert (few[1] == [255, 0, 0]).all()
    assert (few[2] == [0, 0, 255]).all()


def test_cuts_leave_the_middle(eye: Eye) -> None:
    white = np.full((HEIGHT, WIDTH), 255)
    circle = eye.worked(white, "simVision.circularCutWorkImg(h, 1, true)")[..., 0]
    assert circle.tolist() == [
        [0, 0, 255, 255, 0, 0],
        [0, 255, 255, 255, 255, 0],
        [0, 255, 255, 255, 255, 0],
        [0, 0, 255, 255, 0, 0],
    ]
    rest = eye.worked(
        white, "simVision.rectangularCutWorkImg(h, {0.7, 0.5}, true) simVision.buffer1ToWorkImg(h)"
    )
    assert not rest[1:3, 1:5].any()
    assert rest.sum() == (24 - 8) * 3 * 255


def test_kernels_sharpen_blur_and_find_edges(eye: Eye) -> None:
    even = np.full((HEIGHT, WIDTH), 100)
    inside = np.s_[1:3, 1:5, 0]
    assert (eye.worked(even, "simVision.sharpenWorkImg(h)")[inside] == 100).all()
    for side in (3, 5):
        blur = f"simVision.matrix{side}x{side}OnWorkImg"
        blurred = eye.worked(SPOT, f"{blur}(h, 1, 1)")[..., 0]
        assert 0 < blurred[0, 1] < blurred[1, 3] < 255
        assert eye.worked(even, f"{blur}(h, 2, 0.5)")[1, 2, 0] in range(20, 30)
    left = "{0,0,0, 1,0,0, 0,0,0}"
    moved = eye.worked(SPOT, f"simVision.matrix3x3OnWorkImg(h, 1, 1, {left})")[..., 0]
    assert (moved[1:3, 3:5] == 255).all()
    assert moved[1, 2] == 0
    flat = "{" + ",".join("1" if n == 12 else "0" for n in range(25)) + "}"
    same = eye.worked(SPOT // 5, f"simVision.matrix5x5OnWorkImg(h, 1, 0.2, {flat})")[1, 2, 0]
    assert same == round(51 * 0.2 * 25 / 20)  # 20 of the 25 are within the image
    edges = eye.worked(SPOT, "simVision.edgeDetectionOnWorkImg(h, 0.2)")[..., 0]
    assert (edges == SPOT).all()  # three pixels by two are rim all over
    assert not eye.worked(even, "simVision.edgeDetectionOnWorkImg(h, 0.2)")[inside].any()
    eye.fails("simVision.matrix3x3OnWorkImg(sim.getObject('/lazy'), 1, 1, {1})", "has 9 numbers, not 1")


def test_the_bright_part_is_measured_and_triggers_when_it_is_as_wanted(eye: Eye) -> None:
    binary = "return simVision.binaryWorkImg(h, 0.5, %s, 0.1, 0.5, 0.1, 0.5, 0.2, 0, 0.1, 0.9, true)"
    trigger, packet = eye.found(SPOT, binary % 0.25)
    assert trigger is True
    share, x, y, angle, roundness = floats(packet.encode("latin-1"))
    assert (share, x, y, angle) == pytest.approx((0.25, 3 / 6, 1.5 / 4, 0))
    assert roundness == pytest.approx(1.5 / 4)  # two rows of three: 6 / 4 against 4
    assert eye.found(SPOT, binary % 0.5)[0] is False
    assert eye.found(SPOT * 0, binary % 0)[0] is False
    shown = eye.worked(GREYS, "simVision.binaryWorkImg(h, 0.5, 0,0,0,0,0,0,0,0,0, false)")
    assert (shown[..., 0] == np.where(GREYS >= 127.5, 255, 0)).all()
    marked = "simVision.binaryWorkImg(h, 0.5, 0,0,0,0,0,0,0,0,0, false, {0, 1, 0})"
    assert [0, 255, 0] in eye.worked(SPOT, marked).reshape(-1, 3).tolist()


def test_blobs_are_counted_and_measured(eye: Eye) -> None:
    image = SPOT.copy()
    image[3, 0] = 255
    detect = "return simVision.blobDetectionOnWorkImg(h, 0.5, %s, %s)"
    packet = eye.packet(image, detect % (0.0, "false"))
    assert packet[:2] == [2, 6]
    assert packet[2:8] == pytest.approx([6 / 24, 0, 3.5 / 6, 2 / 4, 2 / 6, 1 / 4], abs=1e-6)
    assert packet[8:] == pytest.approx([1 / 24, packet[9], 0.5 / 6, 3.5 / 4, 0, 0], abs=1e-6)
    assert eye.packet(image, detect % (0.1, "false"))[0] == 1
    lonely = eye.worked(image, "simVision.blobDetectionOnWorkImg(h, 0.5, 0.1, false)")
    assert (lonely[..., 0] == SPOT).all()
    painted = eye.worked(image, "simVision.blobDetectionOnWorkImg(h, 0.5, 0, true)")
    assert painted[1, 2].tolist() == [204, 0, 0]
    assert painted[3, 0].tolist() == [0, 204, 0]
    outlined = eye.worked(SPOT, "simVision.blobDetectionOnWorkImg(h, 0.5, 0, false, {0, 0, 1})")
    assert [0, 0, 255] in outlined.reshape(-1, 3).tolist()


def test_changes_are_found_against_what_was_seen_before(eye: Eye) -> None:
    look = "simVision.workImgToBuffer2(h) "
    later = "simVision.shiftWorkImg(h, {1/6, 0}, false) return simVision.changedPixelsOnWorkImg(h, 0.1)"
    packet = eye.packet(SPOT, look + later)
    assert sorted(zip(*[iter(packet)] * 3, strict=True)) == [(-1, 2, 1), (-1, 2, 2), (1, 5, 1), (1, 5, 2)]
    assert eye.found(SPOT, look + "return simVision.changedPixelsOnWorkImg(h, 0.1)") == [False]
    shown = eye.worked(SPOT, look + later.replace("return", ""))[1, :, 0]
    assert shown.tolist() == [128, 128, 0, 128, 128, 255]


def test_a_depth_map_gives_points(eye: Eye) -> None:
    white = np.full((HEIGHT, WIDTH), 255)
    points = "return simVision.coordinatesFromWorkImg(h%s, {3, 1}, %s%s)"
    half = math.tan(math.radians(30)) * WIDTH / HEIGHT
    packet = eye.packet(white // 2, points % ("", "false", ""))
    z = 1 + 127 / 255 * 2
    assert packet[:2] == [3, 1]
    far = math.hypot(half * z, z)
    assert np.reshape(packet[2:], (3, 4)) == pytest.approx(
        np.array([[-half * z, 0, z, far], [0, 0, z, z], [half * z, 0, z, far]]) if far < 3 else np.nan,
        abs=1e-5,
    )
    right, _, left = np.reshape(eye.packet(GREYS, points % ("", "true", ""))[2:], (3, 4))
    assert right[2] > left[2]  # the image gets brighter to the right, which is the sensor's -x
    inside = eye.packet(white // 2, points % ("", "false", ""))[6:9]
    world = eye.packet(white // 2, points % (" + sim.handleflag_abscoords", "false", ""))[6:9]
    assert eye.lua(
        f"return sim.multiplyVector(sim.getObjectMatrix(sim.getObject('/lazy'), -1), {{0, 0, {inside[2]}}})"
    )[0] == pytest.approx(world, abs=1e-5)
    buffered = "simVision.workImgToBuffer1(h) " + points % ("", "false", ", true")
    colours = eye.found(GREYS, buffered)[2].encode("latin-1")
    assert len(colours) == 3 * 3 + 3
    assert colours[0] > colours[6]


def test_the_depth_becomes_a_work_image(eye: Eye) -> None:
    shown = eye.worked(GREYS, "sim.handleVisionSensor(h) simVision.sensorDepthMapToWorkImg(h)")
    assert shown[..., 0].ravel() == pytest.approx(np.linspace(0, 255, 24), abs=0.51)


DEPTH = "return sim.getVisionSensorDepthBuffer(h)"


def test_a_work_image_becomes_the_depth_until_the_next_handling(eye: Eye) -> None:
    grey = np.arange(0, 240, 10).reshape(HEIGHT, WIDTH)
    (found,) = eye.found(grey, f"simVision.workImgToSensorDepthMap(h) {DEPTH}")
    assert found == pytest.approx((grey / 255).ravel().tolist(), abs=1e-6)
    (after,) = eye.lua(f"local h = sim.getObjectHandle('lazy') sim.handleVisionSensor(h) {DEPTH}")
    assert after != pytest.approx(found)


def test_pixels_are_taken_from_other_places(eye: Eye) -> None:
    backwards = ", ".join(map(str, reversed(range(WIDTH * HEIGHT))))
    image, *_ = eye.found(
        RAMP, f"simVision.distort(h, {{{backwards}}}) return sim.getVisionSensorCharImage(h)"
    )
    turned = RAMP[::-1, ::-1].astype(np.uint8)
    assert image.encode("latin-1") == turned.tobytes()
    again, *_ = eye.found(RAMP, "result = simVision.distort(h) return sim.getVisionSensorCharImage(h)")
    assert again.encode("latin-1") == turned.tobytes()  # with the map of the call before
    assert eye.value("result") == 1


def test_depths_are_scaled_in_metres(eye: Eye) -> None:
    same, halves = (", ".join(map(str, each)) for each in (range(WIDTH * HEIGHT), [0.5] * (WIDTH * HEIGHT)))
    code = f"""
    local h = sim.getObjectHandle('lazy') sim.handleVisionSensor(h)
    local before = sim.getVisionSensorDepthBuffer(h)
    simVision.distort(h, {{{same}}}, {{{halves}}})
    return before, sim.getVisionSensorDepthBuffer(h)
    """
    before, after = eye.lua(code)
    expected = [min(max((0.5 * (1 + 2 * depth) - 1) / 2, 0), 1) for depth in before]
    assert after == pytest.approx(expected, abs=1e-6)
    assert max(after) > 0
    ones = ", ".join(["1"] * (WIDTH * HEIGHT))
    code = f"""
    local h = sim.getObjectHandle('lazy') sim.handleVisionSensor(h)
    simVision.distort(h, nil, {{{ones}}})
    return sim.getVisionSensorDepthBuffer(h)
    """
    (unscaled,) = eye.lua(code)  # with the map of the call before, and other factors
    assert unscaled == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        ("h", "the first call needs a map"),
        ("h, {0, 1}", "24 pixels; the map has 2 numbers"),
        ("h, {" + "24, " * 24 + "}", "indices from 0 to 23"),
        ("h, {" + "0, " * 24 + "}, {1}", "24 pixels; the map has 1 numbers"),
    ],
)
def test_maps_of_pixels_must_fit(eye: Eye, call: str, reason: str) -> None:
    eye.fails(f"local h = sim.getObjectHandle('lazy') simVision.distort({call})", reason)


def test_without_a_work_image_the_error_says_what_to_call(eye: Eye) -> None:
    eye.fails("simVision.sharpenWorkImg(sim.getObject('/lazy'))", "sensorImgToWorkImg")
    eye.fails("simVision.inventedOnWorkImg(1)", "is not provided by this server")
