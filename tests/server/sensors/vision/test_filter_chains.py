"""Chains of filters: their texts, and their effect on an image."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simx_server.scene.cameras.image import CameraImage
from simx_server.scene.formats.texts.filter_chains import COMPONENTS, Component, read_chain, write_chain
from simx_server.sensors.vision.filters.chain import Chain, Processed
from simx_server.sensors.vision.filters.image_findings import MOST_BLOBS, blobs
from simx_server.sensors.vision.filters.work import View, Work

WIDTH, HEIGHT = 8, 6
NEAR, FAR = 0.5, 4.5
HALF_TURN = math.pi
VIEW = View((NEAR, FAR), (1.0, 0.75), is_perspective=True)


def picture(depth: float | np.ndarray = 0.5) -> CameraImage:
    """An image in which each pixel is different: red rises to the right, green upwards."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    rgb = np.stack([x * 30, y * 40, np.full_like(x, 7)], axis=2).astype(np.uint8)
    return CameraImage(rgb, np.full((HEIGHT, WIDTH), depth, np.float32))


def process(text: str, image: CameraImage | None = None, work: Work | None = None) -> Processed:
    chain = Chain(read_chain(text))
    return chain.process(image or picture(), VIEW, work or Chain.new_work(WIDTH, HEIGHT))


def shown(text: str) -> np.ndarray:
    """The image that a chain makes."""
    made = process(text).rgb
    assert made is not None
    return made


def _colours() -> np.ndarray:
    made = picture().rgb
    assert made is not None
    return made


RGB = _colours()


def test_every_component_has_an_effect_and_survives_as_text() -> None:
    words = {"passes": "2", "across": "3", "up": "2"}
    for name, checks in COMPONENTS.items():
        values = ",".join(
            words.get(key, "yes" if "switch" in check.__name__ else "0.5") for key, check in checks.items()
        )
        text = f"image|to_buffer1|to_buffer2|{name}{':' if values else ''}{values}|output"
        assert write_chain(read_chain(text)) == text
        made = process(text)
        assert made.rgb.shape == (HEIGHT, WIDTH, 3)
        assert made.rgb.dtype == np.uint8


def test_copy_of_the_image_is_the_image_and_nothing_without_output() -> None:
    assert np.array_equal(shown("image|output"), RGB)
    assert not shown("image").any()
    assert not process("none").rgb.any()


def test_depth_in_grey() -> None:
    ramp = np.linspace(0, 1, WIDTH * HEIGHT, dtype=np.float32).reshape(HEIGHT, WIDTH)
    made = process("depth|output", CameraImage(RGB, ramp))
    assert np.array_equal(made.rgb[..., 0], np.rint(ramp * 255).astype(np.uint8))
    assert np.array_equal(made.rgb[..., 0], made.rgb[..., 2])


@pytest.mark.parametrize(
    ("chain", "expected"),
    [
        ("image|flip_horizontally|output", RGB[:, ::-1]),
        ("image|flip_vertically|output", RGB[::-1]),
        (f"image|rotate:{math.pi}|flip_horizontally|output", RGB[::-1]),
        ("image|to_buffer1|uniform:1,1,1|from_buffer1|output", RGB),
        ("image|to_buffer2|uniform:0,0,0|from_buffer2|output", RGB),
        ("image|to_buffer1|uniform:1,1,1|swap_with_buffer1|output", RGB),
        ("uniform:0,0,0|to_buffer1|image|to_buffer2|swap_buffers|from_buffer1|output", RGB),
        ("image|to_buffer1|add_buffer1|output", np.minimum(RGB.astype(int) * 2, 255)),
        ("image|to_buffer1|subtract_buffer1|output", RGB * 0),
        ("image|to_buffer1|uniform:0,1,0|multiply_with_buffer1|output", RGB * np.array([0, 1, 0], np.uint8)),
        ("image|to_buffer1|add_to_buffer1|from_buffer1|output", np.minimum(RGB.astype(int) * 2, 255)),
        ("image|to_buffer1|subtract_from_buffer1|from_buffer1|output", RGB * 0),
        ("uniform:0,0,1|output", np.tile(np.array([0, 0, 255], np.uint8), (HEIGHT, WIDTH, 1))),
    ],
)  # fmt: skip
def test_images_move_between_buffers_and_turn(chain: str, expected: np.ndarray) -> None:
    assert np.array_equal(shown(chain), expected)


def test_selected_colour_stays_and_the_rest_is_black() -> None:
    kept = shown("image|select_colour:0.82,0.5,0,0.1,1,1,yes,yes,no|output")
    assert np.array_equal(kept[..., 0], np.where(np.abs(RGB[..., 0] / 255 - 0.82) <= 0.1, RGB[..., 0], 0))
    removed = shown("image|select_colour:0.82,0.5,0,0.1,1,1,yes,no,yes|from_buffer1|output")
    assert np.array_equal(removed, kept)


def bright(rows: slice, columns: slice) -> CameraImage:
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    rgb[rows, columns] = 200
    return CameraImage(rgb, np.ones((HEIGHT, WIDTH), np.float32))


LIMITS = "0.5,0.25,0.1,0.5,1,0.5,1,0,4,1"


def test_binary_image_reports_its_patch_and_triggers_if_it_may() -> None:
    quarter = bright(slice(0, 3), slice(0, 4))
    made = process(f"image|output|binary:{LIMITS},yes", quarter)
    assert made.detects
    assert made.packets[0][0] == pytest.approx(0.25)
    assert len(made.packets[0]) == 5
    assert made.rgb.max() == 200  # the output was set before
    assert process(f"image|binary:{LIMITS},yes|output", quarter).rgb.max() == 255
    assert not process(f"image|binary:{LIMITS},no", quarter).detects
    assert not process(f"image|binary:{LIMITS},yes", bright(slice(0, 6), slice(0, 4))).detects


def test_blobs_are_counted() -> None:
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    rgb[0:2, 0:2] = 255
    rgb[4, 6] = 255
    made = process("image|blobs:0.1,0,yes|output", CameraImage(rgb, np.ones((HEIGHT, WIDTH), np.float32)))
    packet = made.packets[0]
    assert packet[:2] == [2, 6]
    assert len(packet) == 2 + 2 * 6
    assert packet[2] == pytest.approx(4 / 48)
    assert packet[8] == pytest.approx(1 / 48)
    assert not np.array_equal(made.rgb[0, 0], made.rgb[4, 6])
    assert not made.detects
    only_large = process(
        "image|blobs:0.1,0.05,no|output", CameraImage(rgb, np.ones((HEIGHT, WIDTH), np.float32))
    )
    assert only_large.packets[0][0] == 1
    assert not only_large.rgb[4, 6].any()


def test_an_image_of_dots_has_a_limited_number_of_blobs() -> None:
    dots = np.zeros((256, 256), bool)
    dots[::2, ::2] = True
    dots[101, 101] = dots[100, 102] = dots[102, 100] = True
    found = blobs(dots, 0.0)
    assert len(found) == MOST_BLOBS
    assert max(len(blob.pixels[0]) for blob in found) == 5
    assert [int(each[0]) for each in found[0].pixels] == [0, 0]


def test_coordinates_lie_on_a_wall() -> None:
    made = process("depth|coordinates:4,3,no|output", picture(0.5))
    packet = made.packets[0]
    assert packet[:2] == [4, 3]
    points = np.array(packet[2:]).reshape(3, 4, 4)
    assert points[..., 2] == pytest.approx(np.full((3, 4), 2.5))
    assert points[0, :, 0] == pytest.approx(np.linspace(-2.5, 2.5, 4))
    assert points[:, 0, 1] == pytest.approx(np.linspace(-1.875, 1.875, 3))
    assert points[..., 3] == pytest.approx(np.linalg.norm(points[..., :3], axis=2))


def test_scan_has_rows_of_one_elevation() -> None:
    packet = process("depth|velodyne:5,3,0.4", picture(0.25)).packets[0]
    assert packet[:2] == [5, 3]
    points = np.array(packet[2:]).reshape(3, 5, 4)
    x, y, z, distance = (points[..., part] for part in range(4))
    assert z == pytest.approx(np.full((3, 5), 1.5))
    elevation = np.arctan2(y, np.hypot(x, z))
    assert elevation == pytest.approx(np.tile(np.array([[-0.2], [0.0], [0.2]]), (1, 5)))
    azimuth = np.arctan2(x, z)
    assert azimuth == pytest.approx(np.tile(np.linspace(-math.pi / 4, math.pi / 4, 5), (3, 1)))
    assert distance == pytest.approx(np.linalg.norm(points[..., :3], axis=2))


def test_scan_beside_the_image_and_beyond_the_far_plane_meets_nothing() -> None:
    points = np.array(process("depth|velodyne:5,3,2.8", picture(0.0)).packets[0][2:]).reshape(3, 5, 4)
    assert points[0, :, 3] == pytest.approx([FAR] * 5)
    assert points[1, 2, 3] == pytest.approx(NEAR)
    nothing = np.array(process("depth|velodyne:5,3,0.2", picture(1.0)).packets[0][2:]).reshape(15, 4)
    assert nothing[:, 3] == pytest.approx([FAR] * 15)


def test_output_depth_replaces_the_depth() -> None:
    made = process("depth|intensity_scale:1,0,yes|output_depth", picture(0.25))
    assert made.depth == pytest.approx(np.full((HEIGHT, WIDTH), 0.75), abs=1e-6)
    assert process("image|output", picture(0.25)).depth == pytest.approx(np.full((HEIGHT, WIDTH), 0.25))


def test_changes_are_against_the_image_before() -> None:
    work = Chain.new_work(WIDTH, HEIGHT)
    chain = "image|changes:0.2|output"
    process(chain, bright(slice(0, 2), slice(0, 1)), work)
    made = process(chain, bright(slice(1, 3), slice(0, 1)), work)
    assert made.packets == ([-1.0, 0.0, 0.0, 1.0, 0.0, 2.0],)
    assert process(chain, bright(slice(1, 3), slice(0, 1)), work).packets == ()


def test_chain_remembers_if_it_reads_what_it_has_not_written() -> None:
    remembering = (
        "from_buffer1|output",
        "image|changes:0.1",
        "output",
        "image|add_buffer1|output",
        "swap_buffers",
    )
    assert all(Chain(read_chain(text)).remembers for text in remembering)
    forgetting = (
        "none",
        "image|output",
        "image|to_buffer1|edges:0.1|add_buffer1|output",
        f"image|binary:{LIMITS},no",
    )
    assert not any(Chain(read_chain(text)).remembers for text in forgetting)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("image|sharpened", "none, or components"),
        ("", "none, or components"),
        ("rotate", "rotate with angle"),
        ("rotate:1,2", "rotate with angle"),
        ("rotate:nan", "a number"),
        ("resize:1,0", "above 0"),
        ("shift:1,2,maybe", "yes or no"),
        ("image:1", "no values"),
        ("coordinates:2000,2000,no", "at most 1000000 points"),
        ("|".join(["image"] * 101), "at most 100"),
    ],
)
def test_wrong_chain_says_what_is_valid(text: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        read_chain(text)


def test_passes_of_a_matrix_are_few() -> None:
    (component,) = read_chain("matrix3:100000,1," + ",".join("0" * 9))
    assert component == Component("matrix3", (100, 1.0, *[0.0] * 9))
