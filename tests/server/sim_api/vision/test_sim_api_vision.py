"""Vision sensors in scripts. Images of `eye`, 8 x 4, are ramps; one test renders the scene itself."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from handler_calls import PaintingThread, QuickPainter, floats
from real_world import render_with
from sim_api_calls import SCENE, ScriptWorld

from simx_server.scripting.callbacks import images as pictures
from simx_server.sensors.opengl.backend import RAYCAST, Backend
from simx_server.sensors.rendering.render_thread import RenderThread

TWO_EYES = SCENE.replace(
    '<site name="tip"', '<camera name="lazy" resolution="2 2"/><site name="tip"'
).replace("</custom>", '<text name="simx:vision:lazy" data="explicit=yes near=1 far=3"/></custom>')

EYE = "local eye = sim.getObjectHandle('eye')\n"
LAZY = "local lazy = sim.getObjectHandle('lazy')\n"

RAMP = np.arange(96, dtype=np.uint8).reshape(4, 8, 3)
GREY = RAMP.astype(int).sum(axis=2) // 3


UNHANDLED = [-1, None, None]
"""A reading before the first handling: as many values as one with two packets."""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    world = ScriptWorld(tmp_path, TWO_EYES)
    render_with(world, QuickPainter())
    return world


@pytest.fixture
def handled(world: ScriptWorld) -> ScriptWorld:
    """A world whose first simulation step has handled `eye`."""
    world.passes()
    return world


@pytest.fixture
def rendering() -> Iterator[RenderThread]:
    thread = RenderThread(choose=lambda: Backend(RAYCAST, "the test says so"))
    yield thread
    thread.close()


def data(text: str) -> bytes:
    return text.encode("latin-1")


def test_an_image_is_numbers_or_a_string(handled: ScriptWorld) -> None:
    numbers, text = handled.lua(
        EYE + "return sim.getVisionSensorImage(eye), sim.getVisionSensorImage(eye, 0, 0, 0, 0, 1)"
    )
    assert numbers == pytest.approx((RAMP.ravel() / 255).tolist())
    assert data(text) == RAMP.tobytes()


def test_grey_is_asked_for_by_a_flag_on_the_handle(handled: ScriptWorld) -> None:
    text, width, height = handled.lua(
        EYE + "return sim.getVisionSensorCharImage(eye + sim.handleflag_greyscale)"
    )
    assert (data(text), width, height) == (GREY.astype(np.uint8).tobytes(), 8, 4)


def test_a_region_is_cut_out_from_the_lower_left(handled: ScriptWorld) -> None:
    text, *size = handled.lua(EYE + "return sim.getVisionSensorCharImage(eye, 2, 1, 3, 2)")
    assert (data(text), size) == (RAMP[1:3, 2:5].tobytes(), [8, 4])
    text, size = handled.lua(EYE + "return sim.getVisionSensorImg(eye, 0, 0, {2, 1}, {3, 2})")
    assert (data(text), size) == (RAMP[1:3, 2:5].tobytes(), [3, 2])
    text, size = handled.lua(EYE + "return sim.getVisionSensorImg(eye, 0, 0, {0, 0, 0}, {})")
    assert size == [8, 4]
    handled.fails(EYE + "sim.getVisionSensorImage(eye, 6, 0, 3, 1)", "not within a picture of 8 x 4")


def test_a_cut_off_adds_what_is_near_enough_as_alpha(handled: ScriptWorld) -> None:
    text, size = handled.lua(EYE + "return sim.getVisionSensorImg(eye, 1, 0.5)")
    made = np.frombuffer(data(text), np.uint8).reshape(4, 8, 2)
    assert size == [8, 4]
    assert made[..., 0].tolist() == GREY.tolist()
    assert made[..., 1].ravel().tolist() == [255] * 16 + [0] * 16


def test_the_resolution_has_an_old_and_a_new_name(world: ScriptWorld) -> None:
    assert world.lua(EYE + "return sim.getVisionSensorResolution(eye), sim.getVisionSensorRes(eye)") == [
        [8, 4],
        [8, 4],
    ]


def test_depth_is_a_share_or_metres(world: ScriptWorld) -> None:
    wanted = pytest.approx([0, 1 / 3, 2 / 3, 1])
    get = LAZY + "sim.handleVisionSensor(lazy) return "
    assert world.lua(get + "sim.getVisionSensorDepthBuffer(lazy)") == [wanted]
    assert world.lua(get + "sim.getVisionSensorDepthBuffer(lazy, 0, 1, 1, 1)") == [[pytest.approx(2 / 3)]]
    assert world.lua(get + "sim.getVisionSensorDepthBuffer(lazy + sim.handleflag_depthbuffermeters)") == [
        pytest.approx([1, 5 / 3, 7 / 3, 3])
    ]
    (text,) = world.lua(get + "sim.getVisionSensorDepthBuffer(lazy + sim.handleflag_codedstring)")
    assert floats(data(text)) == wanted
    text, size = world.lua(get + "sim.getVisionSensorDepth(lazy, 1)")
    assert (floats(data(text)), size) == (pytest.approx([1, 5 / 3, 7 / 3, 3]), [2, 2])


def test_statistics_are_read_after_a_pass_and_of_explicit_sensors_after_handling(world: ScriptWorld) -> None:
    assert world.lua(EYE + "return sim.readVisionSensor(eye)") == UNHANDLED
    world.passes()
    result, packet, second = world.lua(EYE + "return sim.readVisionSensor(eye)")
    assert second is None
    assert (result, len(packet), packet[1], packet[5]) == (0, 15, 0, pytest.approx(94 / 255))
    assert world.lua(LAZY + "return sim.readVisionSensor(lazy)") == UNHANDLED
    assert len(world.lua(LAZY + "return sim.handleVisionSensor(lazy)")[1]) == 15
    assert len(world.lua(LAZY + "return sim.readVisionSensor(lazy)")[1]) == 15
    assert world.lua(LAZY + "return sim.resetVisionSensor(lazy), sim.readVisionSensor(lazy)") == [
        1,
        *UNHANDLED,
    ]


def test_handling_all_leaves_explicit_sensors_alone_unless_they_are_meant(world: ScriptWorld) -> None:
    assert world.lua(LAZY + "sim.handleVisionSensor(sim.handle_all_except_explicit) "
                     "return sim.readVisionSensor(lazy)") == UNHANDLED  # fmt: skip
    assert world.lua("return sim.handleVisionSensor(sim.handle_all)") == [0]
    assert world.lua(LAZY + "return sim.readVisionSensor(lazy)")[0] == 0


def test_handling_all_counts_the_sensors_that_detect(tmp_path: Path) -> None:
    scene = TWO_EYES.replace('near=1 far=3"', 'near=1 far=3 detect_below=0.9"')
    world = ScriptWorld(tmp_path, scene)
    render_with(world, QuickPainter())
    assert world.lua("return sim.handleVisionSensor(sim.handle_all_except_explicit)") == [0]
    assert world.lua("return sim.handleVisionSensor(sim.handle_all)") == [1]


def test_a_check_looks_now_and_keeps_nothing(world: ScriptWorld) -> None:
    result, packet, _ = world.lua(LAZY + "return sim.checkVisionSensor(lazy, sim.handle_all)")
    assert (result, len(packet)) == (0, 15)
    assert world.lua(LAZY + "return sim.readVisionSensor(lazy)") == UNHANDLED
    world.fails(LAZY + "sim.checkVisionSensor(lazy, 4711)", "4711")


def test_a_check_gives_the_image_or_the_depth(world: ScriptWorld) -> None:
    check = EYE + "return sim.checkVisionSensorEx(eye, sim.handle_all, {})"
    assert world.lua(check.format("true")) == [pytest.approx((RAMP.ravel() / 255).tolist())]
    assert world.lua(check.format("false")) == [pytest.approx(np.linspace(0, 1, 32).tolist(), abs=1e-6)]


def test_an_image_is_set_from_numbers_or_bytes(world: ScriptWorld) -> None:
    source = LAZY + "local grey = lazy + sim.handleflag_greyscale "
    source += "local done = sim.setVisionSensorImage({0}, {1}) return done, sim.getVisionSensorImage(grey)"
    wanted = [1, pytest.approx([0, 1, 51 / 255, 1])]
    assert world.lua(source.replace("{0}", "grey").replace("{1}", "{0, 1, 0.2, 7}")) == wanted
    assert world.lua(source.replace("{0}", "grey").replace("{1}", "'\\0\\255\\51\\255'")) == wanted
    char = LAZY + "return sim.setVisionSensorCharImage(lazy, ('\\1\\2\\3'):rep(4)), "
    assert world.lua(char + "sim.getVisionSensorImage(lazy, 0, 0, 1, 1, 1)") == [1, "\1\2\3"]
    new = LAZY + "return sim.setVisionSensorImg(lazy, '\\9\\9\\9\\9', 1), "
    assert world.lua(new + "sim.getVisionSensorImage(lazy, 1, 1, 1, 1, 1)") == [1, "\t\t\t"]
    world.fails(LAZY + "sim.setVisionSensorImage(lazy, 'short')", "12 bytes, not 5")


def test_a_part_of_an_image_is_set(world: ScriptWorld) -> None:
    world.lua(LAZY + "screen = lazy sim.setVisionSensorImg(screen, ('\\1\\2\\3'):rep(4))")
    world.lua("sim.setVisionSensorImg(screen, '\\7\\8\\9', 0, {1, 0}, {1, 1})")
    assert world.value("sim.getVisionSensorImg(screen)") == "\1\2\3\7\b\t" + "\1\2\3" * 2
    world.lua("sim.setVisionSensorImg(screen, ('\\4\\5\\6\\99'):rep(4), 2)")
    assert world.value("sim.getVisionSensorImg(screen)") == "\4\5\6" * 4
    world.fails("sim.setVisionSensorImg(screen, 'ab', 0, {1, 0}, {1, 1})", "1 x 1 pixels have 3 bytes, not 2")
    world.fails("sim.setVisionSensorImg(screen, 'abc', 0, {2, 0}, {1, 1})", "is not within a picture")


def test_a_script_waits_for_the_render_thread(handled: ScriptWorld, rendering: RenderThread) -> None:
    render_with(handled, rendering)
    before = handled.lua(EYE + "return sim.getVisionSensorDepth(eye, 1)")
    handled.passes()
    after = handled.lua(EYE + "return sim.getVisionSensorDepth(eye, 1)")
    assert before == after  # nothing moved
    assert len(before[0]) == 4 * 32


def test_an_image_that_never_comes_is_an_error(handled: ScriptWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pictures, "TIMEOUT", 0.01)
    render_with(handled, PaintingThread())
    handled.fails(EYE + "sim.getVisionSensorImage(eye)", "was not ready")


def test_images_and_readings_are_properties(world: ScriptWorld) -> None:
    assert world.lua(EYE + "return sim.getBoolProperty(eye, 'triggerState')") == [False]
    assert world.lua(EYE + "return sim.getFloatArrayProperty(eye, 'packet1')") == [[]]
    world.passes()
    (text,) = world.lua(EYE + "return sim.getBufferProperty(eye, 'imageBuffer')")
    assert data(text) == RAMP.tobytes()
    assert len(world.lua(EYE + "return sim.getFloatArrayProperty(eye, 'packet1')")[0]) == 15
    assert world.lua(EYE + "return sim.getFloatArrayProperty(eye, 'packet2')") == [[]]
    depth = world.lua(EYE + "return sim.getFloatArrayProperty(eye, 'depthBuffer')")[0]
    packed = world.lua(EYE + "return sim.getBufferProperty(eye, 'packedDepthBuffer')")[0]
    assert floats(data(packed)) == depth
    assert "imageBuffer" not in world.lua(EYE + "return sim.getProperties(eye, {skipLarge=true})")[0]
    (text,) = world.lua(
        EYE + "local image = ('x'):rep(96); sim.setBufferProperty(eye, 'imageBuffer', image)"
        "return sim.getBufferProperty(eye, 'imageBuffer')"
    )
    assert data(text) == b"x" * 96
    world.fails(EYE + "sim.setBufferProperty(eye, 'imageBuffer', 'short')", "has 96 bytes, not 5")


IMAGE = "sim.getVisionSensorImage({0}, 0, 0, 0, 0, 1)"
BLANK = "\0" * 96


def seen(world: ScriptWorld, eye: str = "eye") -> str:
    """The bytes of an image, as a script reads them."""
    return world.lua(f"local eye = sim.getObjectHandle('{eye}') return " + IMAGE.format("eye"))[0]


def test_a_sensor_is_black_and_sees_nothing_before_its_first_handling(world: ScriptWorld) -> None:
    assert seen(world) == BLANK
    assert world.lua(EYE + "return sim.getVisionSensorDepthBuffer(eye)") == [[1.0] * 32]
    assert world.lua(EYE + "return sim.getVisionSensorDepthBuffer(eye + sim.handleflag_depthbuffermeters)")[
        0
    ][0] == pytest.approx(world.parts.vision.settings(world.handle("eye")).far)
    assert world.lua(EYE + "return sim.getBufferProperty(eye, 'imageBuffer')") == [BLANK]
    world.lua(EYE + "simVision.sensorImgToWorkImg(eye) simVision.workImgToSensorImg(eye)")
    assert seen(world) == BLANK
    world.passes()
    assert data(seen(world)) == RAMP.tobytes()


def test_a_new_sensor_is_black_until_a_step_or_a_script_handles_it(handled: ScriptWorld) -> None:
    make = "sim.createVisionSensor({}, {{8, 4, 0, 0}}, {{0.01, 5, 1, 0, 0, 0, 0, 0, 0, 0, 0}})"
    (new, asked) = handled.lua(f"return {make.format(2)}, {make.format(3)}")
    read = f"return {IMAGE.format(new)}, {IMAGE.format(asked)}"
    assert handled.lua(read) == [BLANK, BLANK]
    assert data(seen(handled)) == RAMP.tobytes()  # the others keep theirs
    handled.passes()
    shown = handled.lua(read)
    assert (data(shown[0]), shown[1]) == (RAMP.tobytes(), BLANK)
    handled.lua(f"sim.handleVisionSensor({asked})")
    assert data(handled.lua(read)[1]) == RAMP.tobytes()


def test_a_sensor_that_scripts_take_over_keeps_its_last_image(handled: ScriptWorld) -> None:
    handled.lua(EYE + "sim.setExplicitHandling(eye, 1)")
    count = len(handled.painter.views)
    assert data(seen(handled)) == RAMP.tobytes()
    handled.passes(3)
    assert data(seen(handled)) == RAMP.tobytes()
    assert len(handled.painter.views) == count  # it is the image of then
    handled.lua(EYE + "sim.resetVisionSensor(eye)")
    assert seen(handled) == BLANK


def test_another_resolution_a_reset_and_a_stop_blank_an_image(handled: ScriptWorld) -> None:
    handled.lua(EYE + "sim.resetVisionSensor(eye)")
    assert seen(handled) == BLANK
    handled.passes()
    handled.lua(EYE + "sim.setObjectInt32Param(eye, sim.visionintparam_resolution_x, 4)")
    assert seen(handled) == "\0" * 48
    handled.passes()
    assert seen(handled) != "\0" * 48
    handled.call("simxStopSimulation")
    handled.run(0)
    assert seen(handled) == "\0" * 48


def test_clients_of_the_legacy_api_see_the_scene_before_it_is_handled(world: ScriptWorld) -> None:
    assert world.call("simxGetVisionSensorImage", world.handle("eye"), 0)[1] == RAMP.tobytes()
    assert seen(world) == BLANK
