"""Functions of sensors, collisions, distances and contacts, called as PyRep calls them."""

from __future__ import annotations

import numpy as np
import pytest
from c_program import CProgram, Out, ffi, numbers

from simx_client.protocol import constants as c

METRES = 0x800000
POINT = Out("float[3]")
FLOOR_CONTACT = 0x400000


def image_of(program: CProgram, sensor: int, function: str, channels: int) -> np.ndarray:
    """Read an image as PyRep does: by the item type of what is returned."""
    pixels = getattr(program.lib, function)(sensor)
    item = ffi.getctype(ffi.typeof(pixels).item)
    assert item == "float"
    _, (width, height) = program.call("simGetVisionSensorResolution", sensor & 0xFFFFF, Out("int[2]"))
    size = width * height * channels * ffi.sizeof(item)
    return np.frombuffer(ffi.buffer(pixels, size), "f4").reshape(height, width, channels)


def test_an_image_has_numbers_from_0_to_1_with_the_lowest_row_first(program: CProgram) -> None:
    colour = program.handle("colour")
    _, values, counts = program.call("simHandleVisionSensor", colour, Out("float **"), Out("int **"))
    assert numbers(counts, 2) == [1, 15]
    assert len(numbers(values, 15)) == 15
    image = image_of(program, colour, "simGetVisionSensorImage", 3)
    assert image.shape == (6, 8, 3)
    assert np.array_equal(image[0, 0], [1, 0, 0]), "the wall's left lower quarter is red"
    assert np.array_equal(image[-1, -1], [0, 0, 1])


def test_statistics_of_the_last_handling_are_read_again(program: CProgram) -> None:
    colour = program.handle("colour")
    program.call("simHandleVisionSensor", colour, Out("float **"), Out("int **"))
    state, values, counts = program.call("simReadVisionSensor", colour, Out("float **"), Out("int **"))
    assert state == 0
    assert numbers(counts, 2) == [1, 15]
    assert max(numbers(values, 15)) == 1.0


def test_depths_are_shares_between_the_planes_or_metres(program: CProgram) -> None:
    distance = program.handle("distance")
    program.call("simHandleVisionSensor", distance, Out("float **"), Out("int **"))
    shares = image_of(program, distance, "simGetVisionSensorDepthBuffer", 1)
    metres = image_of(program, distance + METRES, "simGetVisionSensorDepthBuffer", 1)
    assert metres[-1, -1, 0] == pytest.approx(1.0, abs=0.01)
    assert np.allclose(metres, 0.1 + shares * 2.0, atol=1e-5)


def test_a_vision_sensor_is_made(program: CProgram) -> None:
    sizes = [0.01, 5.0, 1.0, 0.1, 0.1, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
    sensor = program.lib.simCreateVisionSensor(1 | 2, [16, 8, 0, 0], sizes, ffi.NULL)
    assert program.lib.simGetObjectType(sensor) == c.sim_object_visionsensor_type
    assert program.done("simGetVisionSensorResolution", sensor, Out("int[2]")) == [16, 8]


def test_a_proximity_sensor_finds_the_target(program: CProgram) -> None:
    ahead, target = program.handle("ahead"), program.handle("target")
    program.run(1)
    state, point, found, normal = program.call("simReadProximitySensor", ahead, POINT, Out("int *"), POINT)
    assert (state, found) == (1, target)
    assert np.linalg.norm(point) == pytest.approx(1.0, abs=1e-4)
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-4)
    assert program.call("simCheckProximitySensor", ahead, target, POINT)[0] == 1
    assert program.call("simCheckProximitySensor", ahead, program.handle("cube"), POINT) == (0, [0, 0, 0])


def test_a_force_sensor_carries_a_weight(program: CProgram) -> None:
    program.run(5)
    state, force, torque = program.call("simReadForceSensor", program.handle("scale"), POINT, POINT)
    assert state & 1
    assert abs(force[2]) == pytest.approx(2 * 9.81, rel=0.01)
    assert torque == pytest.approx([0, 0, 0], abs=1e-3)


def test_a_force_sensor_is_made_and_broken(program: CProgram) -> None:
    sensor = program.lib.simCreateForceSensor(0, [0, 1, 1, 0, 0], [0.01, 0, 0, 0, 0], ffi.NULL)
    assert program.lib.simGetObjectType(sensor) == c.sim_object_forcesensor_type
    program.run(1)
    program.lib.simBreakForceSensor(program.handle("scale"))
    program.lib.simExtStep(True)
    assert program.call("simReadForceSensor", program.handle("scale"), POINT, POINT)[0] & 2


def test_collisions_are_checked_now_and_by_registered_objects(program: CProgram) -> None:
    lib, cube, wall = program.lib, program.handle("cube"), program.handle("wall")
    assert lib.simCheckCollision(cube, wall) == 0
    place = program.done("simGetObjectPosition", wall, -1, POINT)
    program.done("simSetObjectPosition", cube, -1, place)
    assert lib.simCheckCollision(cube, wall) == 1
    assert lib.simGetCollectionHandle(b"boxes") > 0
    assert lib.simGetCollectionHandle(b"none") == -1
    program.run(1)
    assert lib.simReadCollision(lib.simGetCollisionHandle(b"bump")) == 0


def test_distances_are_measured_now_and_by_registered_objects(program: CProgram) -> None:
    lib, crate, target = program.lib, program.handle("crate"), program.handle("target")
    data = program.done("simCheckDistance", crate, target, -1, Out("float [7]"))
    assert data[6] == pytest.approx(np.linalg.norm(np.subtract(data[3:6], data[:3])), rel=1e-5)
    clearance = lib.simGetDistanceHandle(b"clearance")
    assert program.done("simHandleDistance", clearance, Out("float *")) == pytest.approx(data[6], abs=0.5)
    assert program.done("simReadDistance", clearance, Out("float *")) > 1.0


def test_contacts_are_listed_until_none_is_left(program: CProgram) -> None:
    cube = program.handle("cube")
    program.run(3)
    contacts = []
    for index in range(100):
        found, objects, contact = program.call(
            "simGetContactInfo", c.sim_handle_all, cube, index + FLOOR_CONTACT, Out("int[2]"), Out("float[9]")
        )
        if found <= 0:
            break
        contacts.append((objects, contact))
    assert contacts
    assert all(objects[0] == cube for objects, _ in contacts)
    assert sum(contact[5] for _, contact in contacts) == pytest.approx(0.5 * 9.81, rel=0.05)
