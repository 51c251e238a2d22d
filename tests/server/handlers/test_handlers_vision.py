"""Pictures as clients get them: sizes, bytes, settings, and who shares a picture. No renderer is needed."""

from __future__ import annotations

import math
from concurrent.futures import Future

import numpy as np
import pytest
from handler_calls import World, floats

from simx_server.errors import CommandError, WrongKind
from simx_server.scene.cameras.image import RenderError
from simx_server.sensors.vision.futures import then

SCENE = """
<mujoco>
  <statistic extent="1"/>
  <worldbody>
    <body name="head" pos="0 0 1">
      <camera name="eye" resolution="4 2" fovy="45"/>
      <camera name="depth_eye" resolution="4 2" output="depth"/>
      <camera name="plain"/>
      <camera name="asked" resolution="2 2"/>
      <camera name="flat" resolution="4 2" projection="orthographic" fovy="3"/>
      <camera name="window"/>
    </body>
  </worldbody>
  <custom>
    <text name="simx:vision:eye" data="near=0.02 far=3.5 angle_deg=57"/>
    <text name="simx:vision:asked" data="explicit=yes"/>
    <text name="simx:camera:window" data="view=yes"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def world() -> World:
    return World(SCENE)


def image(world: World, name: str, options: int = 0):
    return world.call("simxGetVisionSensorImage", world.handle(name), options)


def test_image_is_rgb_or_grey_bytes_without_a_running_simulation(world: World) -> None:
    assert image(world, "eye") == ([4, 2], bytes(range(24)))
    assert image(world, "eye", 1) == ([4, 2], bytes(range(1, 24, 3)))
    assert len(image(world, "eye", 6)[1]) == 8


def test_depth_is_float32_and_a_depth_sensor_shows_it_in_grey(world: World) -> None:
    size, data = world.call("simxGetVisionSensorDepthBuffer", world.handle("eye"))
    assert size == [4, 2]
    assert floats(data) == pytest.approx(np.linspace(0, 1, 8), abs=1e-6)
    levels = np.rint(np.linspace(0, 1, 8, dtype=np.float32) * 255).astype(np.uint8)
    assert image(world, "depth_eye")[1] == np.repeat(levels, 3).tobytes()
    assert image(world, "depth_eye", 1)[1] == levels.tobytes()


def test_view_follows_annotation_camera_and_defaults(world: World) -> None:
    image(world, "eye")
    view = world.painter.views[-1]
    assert (view.width, view.height, view.near, view.far) == (4, 2, 0.02, 3.5)
    across = math.degrees(2 * math.atan(math.tan(math.radians(view.fovy_deg) / 2) * 2))
    assert across == pytest.approx(57)
    image(world, "plain")
    view = world.painter.views[-1]
    assert (view.width, view.height, view.fovy_deg) == (256, 256, pytest.approx(45))
    image(world, "flat")
    assert world.painter.views[-1].orthographic_size == pytest.approx(6)


def test_equal_state_has_an_equal_version(world: World) -> None:
    world.run()
    image(world, "eye")
    image(world, "eye")
    world.parts.step()
    image(world, "eye")
    first, second, third = world.painter.versions
    assert first == second != third


def test_parameters_change_the_next_image(world: World) -> None:
    eye = world.handle("eye")
    world.call("simxSetObjectIntParameter", eye, 1002, 6)
    world.call("simxSetObjectIntParameter", eye, 1003, 3)
    world.call("simxSetObjectFloatParameter", eye, 1000, 0.5)
    world.call("simxSetObjectFloatParameter", eye, 1004, 1.0)
    assert image(world, "eye")[0] == [6, 3]
    view = world.painter.views[-1]
    assert view.near == 0.5
    assert world.call("simxGetObjectFloatParameter", eye, 1004) == 1.0
    assert world.call("simxGetObjectFloatParameter", eye, 1001) == 3.5
    with pytest.raises(CommandError, match="clip planes"):
        world.call("simxSetObjectFloatParameter", eye, 1000, 9.0)
    with pytest.raises(CommandError, match="cannot be made"):
        world.call("simxSetObjectIntParameter", eye, 1002, 1 << 30)
    assert image(world, "eye")[0] == [6, 3]


def test_a_view_is_switched_between_perspective_and_orthographic(world: World) -> None:
    eye, flat = world.handle("eye"), world.handle("flat")
    assert [world.call("simxGetObjectIntParameter", each, 1018) for each in (eye, flat)] == [1, 0]
    assert world.call("simxGetObjectFloatParameter", eye, 1005) == pytest.approx(0.01)  # V-REP's default
    world.call("simxSetObjectFloatParameter", eye, 1005, 2.0)
    image(world, "eye")
    assert world.painter.views[-1].orthographic_size is None
    world.call("simxSetObjectIntParameter", eye, 1018, 0)
    image(world, "eye")
    assert world.painter.views[-1].orthographic_size == 2.0
    assert world.call("simxGetObjectIntParameter", eye, 1018) == 0
    world.call("simxSetObjectIntParameter", eye, 1018, 1)
    image(world, "eye")
    view = world.painter.views[-1]
    across = math.degrees(2 * math.atan(math.tan(math.radians(view.fovy_deg) / 2) * 2))
    assert (view.orthographic_size, across) == (None, pytest.approx(57))  # the angle was kept
    with pytest.raises(CommandError, match="orthographic size of -1"):
        world.call("simxSetObjectFloatParameter", flat, 1005, -1.0)


def test_components_of_light_are_left_out_by_a_parameter(world: World) -> None:
    eye = world.handle("eye")
    world.call("simxSetObjectIntParameter", eye, 1006, 4)
    image(world, "eye")
    assert world.painter.views[-1].unlit == 4
    assert world.call("simxGetObjectIntParameter", eye, 1006) == 4


def test_the_size_of_a_window_is_kept_for_each_sensor(world: World) -> None:
    eye = world.handle("eye")
    world.call("simxSetObjectIntParameter", eye, 1009, 640)
    world.call("simxSetObjectIntParameter", eye, 1010, 480)
    assert [world.call("simxGetObjectIntParameter", eye, number) for number in (1009, 1010)] == [640, 480]
    assert world.call("simxGetObjectIntParameter", world.handle("flat"), 1009) == 0


def test_explicit_sensor_keeps_the_background_until_handled(world: World) -> None:
    world.call("simxSetArrayParameter", 2, [1.0, 0.0, 0.0])
    asked = world.handle("asked")
    assert image(world, "asked") == ([2, 2], b"\xff\0\0" * 4)
    assert floats(world.call("simxGetVisionSensorDepthBuffer", asked)[1]) == [1.0] * 4
    with pytest.raises(CommandError, match="not been handled"):
        world.call("simxReadVisionSensor", asked)
    world.run()
    world.parts.vision.handle(asked)
    world.painter.paint()
    world.parts.step()
    assert image(world, "asked") == ([2, 2], bytes(range(12)))


def test_set_image_holds_until_the_next_step(world: World) -> None:
    eye = world.handle("eye")
    world.run()
    drawn = bytes(range(200, 224))
    world.call("simxSetVisionSensorImage", eye, drawn, 0)
    assert image(world, "eye")[1] == drawn
    assert image(world, "eye", 1)[1] == bytes(range(201, 224, 3))
    world.call("simxSetVisionSensorImage", eye, bytes(range(8)), 1)
    assert image(world, "eye")[1] == bytes(value for value in range(8) for _ in range(3))
    world.parts.step()
    assert image(world, "eye")[1] == bytes(range(24))
    with pytest.raises(CommandError, match="has 24 bytes, not 5"):
        world.call("simxSetVisionSensorImage", eye, b"12345", 0)


def test_statistics_are_least_greatest_and_mean(world: World) -> None:
    eye = world.handle("eye")
    with pytest.raises(CommandError, match="not been handled"):
        world.call("simxReadVisionSensor", eye)
    world.run()
    triggered, (packet,) = world.call("simxReadVisionSensor", eye)
    assert triggered is False
    red, green, blue = (np.arange(24)[i::3] for i in range(3))
    least, greatest, mean = packet[:5], packet[5:10], packet[10:]
    assert least == pytest.approx([1 / 255, 0, 1 / 255, 2 / 255, 0])
    assert greatest == pytest.approx([22 / 255, 21 / 255, 22 / 255, 23 / 255, 1])
    means = [int(channel.mean()) / 255 for channel in (green, red, green, blue)]
    assert mean == pytest.approx([*means, 0.5])


def test_only_vision_sensors_have_images(world: World) -> None:
    for name in ("head", "window"):
        with pytest.raises(WrongKind, match="needs a vision sensor"):
            image(world, name)


def test_failure_of_the_renderer_reaches_the_asker() -> None:
    future: Future[int] = Future()
    converted = then(future, lambda value: value + 1)
    future.set_exception(RenderError("no graphics"))
    with pytest.raises(CommandError, match="no graphics"):
        converted.result(timeout=1)
    future = Future()
    converted = then(future, lambda value: value // 0)
    future.set_result(1)
    with pytest.raises(ZeroDivisionError):
        converted.result(timeout=1)
