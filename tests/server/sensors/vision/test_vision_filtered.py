"""Vision sensors with filter chains, as clients see them."""

from __future__ import annotations

import numpy as np
import pytest
from handler_calls import World, floats

ROOM = """
<mujoco>
  <worldbody>
    <body name="head" pos="0 0 1"><camera name="eye" resolution="4 2"/></body>
  </worldbody>
  <custom><text name="simx:vision:eye" data="near=1 far=3 {note}"/></custom>
</mujoco>
"""
RAMP = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
"""The image that every rendering makes; its depth rises from 0 to 1."""


def room(note: str) -> World:
    world = World(ROOM.format(note=note))
    world.run()
    return world


def image(world: World, options: int = 0) -> np.ndarray:
    data = world.call("simxGetVisionSensorImage", world.handle("eye"), options)[1]
    return np.frombuffer(data, np.uint8).reshape(2, 4, -1)


def read(world: World):
    return world.call("simxReadVisionSensor", world.handle("eye"))


def test_clients_get_the_output_of_the_chain_and_statistics_of_the_image() -> None:
    world = room("filters=image|flip_horizontally|output")
    assert np.array_equal(image(world), RAMP[:, ::-1])
    assert np.array_equal(image(world, 1)[..., 0], RAMP[:, ::-1].mean(axis=2).astype(np.uint8))
    detects, packets = read(world)
    assert not detects
    assert packets == [pytest.approx(packets[0])]
    assert packets[0][6] == pytest.approx(21 / 255)
    assert room("filters=image").painter.views == []
    assert not image(room("filters=image")).any()


def test_packets_of_the_chain_follow_the_statistics() -> None:
    chain = "image|binary:0.05,0.5,0.4,0.5,1,0.5,1,0,4,1,yes|output|depth|coordinates:2,1,no"
    detects, packets = read(room(f"filters={chain}"))
    assert detects
    assert [len(packet) for packet in packets] == [15, 5, 2 + 2 * 4]
    assert packets[2][:2] == [2, 1]
    detects, packets = read(room(f"statistics=no filters={chain}"))
    assert [len(packet) for packet in packets] == [0, 5, 10]


def test_depth_that_the_chain_sets_goes_to_clients() -> None:
    world = room("filters=depth|intensity_scale:1,0,yes|output_depth")
    depth = floats(world.call("simxGetVisionSensorDepthBuffer", world.handle("eye"))[1])
    assert depth == pytest.approx(np.linspace(1, 0, 8).tolist(), abs=1e-6)
    plain = room("filters=depth|output")
    depth = floats(plain.call("simxGetVisionSensorDepthBuffer", plain.handle("eye"))[1])
    assert depth == pytest.approx(np.linspace(0, 1, 8).tolist())


def test_sensor_whose_filters_forget_is_rendered_only_when_it_is_read() -> None:
    world = room("filters=image|flip_vertically|output")
    for _ in range(5):
        world.parts.step()
    assert world.painter.views == []


def test_sensor_whose_filters_remember_takes_one_image_in_each_step() -> None:
    world = room("filters=image|add_to_buffer1|from_buffer1|output")
    for _ in range(3):
        world.parts.step()
    world.painter.paint()
    assert len(world.painter.views) == 4
    # The sum of four images, however often it is read.
    assert np.array_equal(image(world), RAMP * 4)
    assert np.array_equal(image(world), RAMP * 4)
    assert len(world.painter.views) == 4
    world.sim.stop()
    world.run()
    assert np.array_equal(image(world), RAMP)


def test_image_that_a_client_sets_passes_the_chain_too() -> None:
    world = room("external=yes filters=image|flip_horizontally|output|binary:0.5,1,0.9,0.5,1,0.5,1,0,4,1,yes")
    assert not image(world).any()
    bright = np.zeros((2, 4, 3), np.uint8)
    bright[:, 0] = 255
    world.call("simxSetVisionSensorImage", world.handle("eye"), bright.tobytes(), 0)
    assert np.array_equal(image(world), bright[:, ::-1])
    detects, packets = read(world)
    assert detects
    assert packets[1][0] == pytest.approx(0.25)
    world.parts.step()
    assert np.array_equal(image(world), bright[:, ::-1])
    assert world.painter.views == []


def test_explicit_sensor_applies_its_chain_when_it_is_handled() -> None:
    world = room("explicit=yes filters=image|flip_horizontally|output")
    eye = world.handle("eye")
    assert not image(world).any()
    world.parts.vision.handle(eye)
    world.painter.paint()
    assert np.array_equal(image(world), RAMP[:, ::-1])
    assert read(world)[0] is False


def test_one_pixel_is_a_resolution() -> None:
    for note, pixels in (("single_pixel=yes", 1), ("", 256 * 256)):
        world = World(ROOM.replace('resolution="4 2"', 'resolution="1 1"').format(note=note))
        world.run()
        assert len(world.call("simxGetVisionSensorImage", world.handle("eye"), 1)[1]) == pixels
