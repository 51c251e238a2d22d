"""Statistics of pictures, images that are set, external input, and what changes the next picture."""

from __future__ import annotations

import math

import numpy as np
import pytest
from handler_calls import World, floats

from simx_server.errors import CommandError
from simx_server.scene.cameras.image import CameraImage
from simx_server.sensors.vision.judging import statistics

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <statistic extent="1"/>
  <worldbody>
    <body name="head" pos="0 0 1">
      <camera name="eye" resolution="4 2" fovy="45"/>
      <camera name="depth_eye" resolution="4 2" output="depth"/>
      <camera name="flat" resolution="4 2" projection="orthographic" fovy="3"/>
      <camera name="asked" resolution="4 2"/>
      <camera name="fed" resolution="4 2"/>
      <camera name="over_floor" resolution="4 2"/>
      <camera name="over_line" resolution="4 2"/>
      <camera name="over_grey" resolution="4 2"/>
    </body>
  </worldbody>
  <custom>
    <text name="simx:vision:asked" data="explicit=yes"/>
    <text name="simx:vision:fed" data="external=yes"/>
    <text name="simx:vision:over_floor" data="detect_above=0.5"/>
    <text name="simx:vision:over_line" data="detect_below=0.5"/>
    <text name="simx:vision:over_grey" data="detect_above=0.3 detect_below=0.7"/>
  </custom>
</mujoco>
"""
DRAWN = bytes(range(100, 124))
RAMP = np.linspace(0, 1, 8, dtype=np.float32)


@pytest.fixture
def world() -> World:
    world = World(SCENE)
    world.run()
    return world


def image(world: World, name: str, options: int = 0) -> bytes:
    return world.call("simxGetVisionSensorImage", world.handle(name), options)[1]


def depth(world: World, name: str) -> list[float]:
    return floats(world.call("simxGetVisionSensorDepthBuffer", world.handle(name))[1])


def packet(world: World, name: str) -> list[float]:
    triggered, packets = world.call("simxReadVisionSensor", world.handle(name))
    assert triggered is False
    assert len(packets) == 1
    assert len(packets[0]) == 15
    return packets[0]


def draw(world: World, name: str, pixels: bytes = DRAWN, options: int = 0) -> None:
    world.call("simxSetVisionSensorImage", world.handle(name), pixels, options)


def test_cameras_that_nobody_reads_are_not_rendered(world: World) -> None:
    for _ in range(10):
        world.parts.step()
    assert world.painter.views == []


def test_averages_lose_what_is_less_than_a_byte_and_intensity_what_is_less_than_a_third() -> None:
    rgb = np.array([[[10, 20, 31], [11, 20, 33]]], np.uint8)
    found = statistics(CameraImage(rgb, np.array([[0.25, 0.5]], np.float32)), False)
    assert found == pytest.approx(
        [
            *(20 / 255, 10 / 255, 20 / 255, 31 / 255, 0.25),
            *(21 / 255, 11 / 255, 20 / 255, 33 / 255, 0.5),
            *(20 / 255, 10 / 255, 20 / 255, 32 / 255, 0.375),
        ],
        abs=1e-12,
    )


def test_mean_depth_of_a_large_image_keeps_its_digits() -> None:
    values = np.full((2000, 1000), 0.1, np.float32)
    found = statistics(CameraImage(np.zeros((2000, 1000, 3), np.uint8), values), False)
    assert found[14] == float(np.float32(0.1))


def test_set_image_is_what_statistics_are_made_of_and_depth_stays(world: World) -> None:
    before = depth(world, "eye")
    assert before == pytest.approx(RAMP.tolist())
    draw(world, "eye")
    found = packet(world, "eye")
    red = np.arange(100, 124)[0::3]
    assert found[1] == red.min() / 255
    assert found[6] == red.max() / 255
    assert found[11] == int(red.mean()) / 255
    assert (found[4], found[9], found[14]) == pytest.approx((0.0, 1.0, 0.5))
    assert depth(world, "eye") == before
    world.parts.step()
    assert packet(world, "eye")[1] == 0.0


def test_set_image_shows_on_a_depth_sensor_too(world: World) -> None:
    draw(world, "depth_eye")
    assert image(world, "depth_eye") == DRAWN
    assert packet(world, "depth_eye")[1] == 100 / 255
    world.parts.step()
    assert image(world, "depth_eye") != DRAWN


def test_external_input_stays_and_nothing_is_rendered(world: World) -> None:
    assert image(world, "fed") == bytes(24)
    with pytest.raises(CommandError, match="not been handled"):
        packet(world, "fed")
    draw(world, "fed")
    for _ in range(3):
        world.parts.step()
    assert image(world, "fed") == DRAWN
    assert image(world, "fed", 1) == bytes(range(101, 125, 3))
    assert packet(world, "fed")[1] == 100 / 255
    assert depth(world, "fed") == [1.0] * 8
    world.parts.vision.handle(world.handle("fed"))
    assert image(world, "fed") == DRAWN
    assert not world.painter.views
    world.call("simxStopSimulation")
    assert image(world, "fed") == bytes(24)


def test_explicit_sensor_shows_what_came_last(world: World) -> None:
    with pytest.raises(CommandError, match="not been handled"):
        packet(world, "asked")
    draw(world, "asked")
    world.parts.step()
    assert image(world, "asked") == DRAWN
    assert packet(world, "asked")[1] == 100 / 255
    assert depth(world, "asked") == [1.0] * 8
    world.parts.vision.handle(world.handle("asked"))
    world.painter.paint()
    assert image(world, "asked") == bytes(range(24))
    draw(world, "asked")
    assert image(world, "asked") == DRAWN
    assert depth(world, "asked") == pytest.approx(RAMP.tolist())


def test_image_can_be_set_while_stopped() -> None:
    world = World(SCENE)
    with pytest.raises(CommandError, match="not been handled"):
        packet(world, "eye")
    draw(world, "eye", bytes(range(8)), 1)
    assert image(world, "eye", 1) == bytes(range(8))
    assert packet(world, "eye")[0:4] == [0.0] * 4
    assert packet(world, "eye")[5] == 7 / 255


@pytest.mark.parametrize(("count", "options"), [(23, 0), (25, 0), (24, 1), (8, 0), (0, 0), (0, 1)])
def test_image_of_another_size_is_refused(world: World, count: int, options: int) -> None:
    with pytest.raises(CommandError, match=f"bytes, not {count}"):
        draw(world, "eye", bytes(count), options)
    assert image(world, "eye") == bytes(range(24))


def test_options_beside_bit_0_give_grey_as_the_binding_expects(world: World) -> None:
    assert image(world, "eye", 0) == bytes(range(24))
    for options in (1, 2, 3, 0x400000):
        assert image(world, "eye", options) == bytes(range(1, 24, 3))


def test_resolution_angle_clipping_and_size_change_the_next_image(world: World) -> None:
    eye, flat = world.handle("eye"), world.handle("flat")
    draw(world, "eye")
    world.call("simxSetObjectIntParameter", eye, 1002, 2)
    world.call("simxSetObjectIntParameter", eye, 1003, 6)
    assert len(image(world, "eye")) == 36
    world.call("simxSetObjectFloatParameter", eye, 1004, math.radians(90))
    world.call("simxSetObjectFloatParameter", eye, 1000, 0.25)
    world.call("simxSetObjectFloatParameter", eye, 1001, 8.0)
    image(world, "eye")
    view = world.painter.views[-1]
    assert (view.width, view.height, view.near, view.far) == (2, 6, 0.25, 8.0)
    # The angle belongs to the larger side, which is the upright one now.
    assert view.fovy_deg == pytest.approx(90)
    world.call("simxSetObjectFloatParameter", flat, 1005, 2.0)
    image(world, "flat")
    assert world.painter.views[-1].orthographic_size == 2.0


def test_switched_off_handling_shows_the_background(world: World) -> None:
    world.call("simxSetBooleanParameter", 10, False)
    assert image(world, "eye") == bytes(24)
    assert depth(world, "eye") == [1.0] * 8
    with pytest.raises(CommandError, match="unless that is switched off"):
        packet(world, "eye")
    world.parts.vision.handle(world.handle("asked"))
    with pytest.raises(CommandError, match="not been handled"):
        packet(world, "asked")


@pytest.mark.parametrize(
    ("grey", "detected"),
    [(20, [False, True, False]), (140, [True, False, True]), (230, [True, False, False])],
)
def test_sensor_detects_by_the_mean_intensity_of_its_image(
    world: World, grey: int, detected: list[bool]
) -> None:
    found = []
    for name in ("over_floor", "over_line", "over_grey"):
        draw(world, name, bytes([grey] * 24))
        state, packets = world.call("simxReadVisionSensor", world.handle(name))
        assert packets[0][10] == pytest.approx(grey / 255)
        found.append(state)
    assert found == detected
