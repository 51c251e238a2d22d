"""Proximity, force and vision sensors, collisions and distances (the reference's 3.5 and 9)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conforming import BLOCKING, BUFFER, NO_OBJECT, NOVALUE, OK, REMOTE_ERROR, STREAMING, assert_types, of
from real_world import start_stepped, step

import simx_client as v

pytestmark = [pytest.mark.slow, pytest.mark.gl]

ZEROS = [0.0] * 3
NOT_THERE = (REMOTE_ERROR, False, ZEROS, 0, ZEROS)


@of("simxReadProximitySensor")
def test_a_proximity_sensor_gives_point_object_and_normal_in_its_frame(
    cid: int, simx: Any, handle: Any
) -> None:
    start_stepped(cid)
    step(cid, 0.05)
    result = simx(cid, handle("ahead"), BLOCKING)
    assert_types(result, (0, True, [0.0], 1, [0.0]))
    assert result[:2] == (OK, True)
    assert result[2] == pytest.approx([0, 0, 1.0], abs=1e-5)
    assert result[3] == handle("target")
    assert result[4] == pytest.approx([0, 0, -1], abs=1e-5)
    code, detected, *_ = simx(cid, handle("away"), BLOCKING)
    assert (code, detected) == (OK, False)


@of("simxReadProximitySensor")
def test_between_start_and_the_first_pass_8_has_no_text_as_waiting_is_all_there_is_to_do(
    cid: int, simx: Any, handle: Any, caplog: pytest.LogCaptureFixture
) -> None:
    ahead = handle("ahead")
    assert simx(cid, ahead, BLOCKING) == NOT_THERE
    assert len(v.simxGetLastErrors(cid, BLOCKING)[1]) == 1, "stopped: somebody should start it"
    start_stepped(cid)
    caplog.clear()
    assert simx(cid, ahead, BLOCKING) == NOT_THERE
    assert v.simxGetLastErrors(cid, BLOCKING) == (OK, [])
    assert "handled" not in caplog.text


@of("simxReadProximitySensor")
def test_a_proximity_sensor_that_was_never_handled_is_8(cid: int, simx: Any, handle: Any) -> None:
    ahead = handle("ahead")
    assert simx(cid, ahead, BLOCKING) == NOT_THERE, "stopped"
    start_stepped(cid)
    step(cid, 0.05)
    assert simx(cid, ahead, BLOCKING)[0] == OK
    assert simx(cid, handle("by_hand"), BLOCKING) == NOT_THERE, "handled explicitly, by nobody"
    v.simxStopSimulation(cid, BLOCKING)
    assert simx(cid, ahead, BLOCKING) == NOT_THERE, "reset at the end of the run"
    for wrong in (handle("cube"), NO_OBJECT):
        assert simx(cid, wrong, BLOCKING) == NOT_THERE


@of("simxReadForceSensor")
def test_a_force_sensor_reads_the_weight_on_it_in_its_own_frame(cid: int, simx: Any, handle: Any) -> None:
    scale = handle("scale")
    assert simx(cid, scale, BLOCKING) == (OK, 0, ZEROS, ZEROS), "stopped"
    start_stepped(cid)
    step(cid, 0.2)
    code, state, force, torque = simx(cid, scale, BLOCKING)
    assert (code, state) == (OK, 1)
    assert force == pytest.approx([0, 0, -2 * 9.81], rel=0.01, abs=0.05)
    assert torque == pytest.approx(ZEROS, abs=0.05)
    assert_types(simx(cid, scale, BLOCKING), (0, 0, [0.0], [0.0]))
    for wrong in (handle("cube"), NO_OBJECT):
        assert simx(cid, wrong, BLOCKING) == (REMOTE_ERROR, 0, ZEROS, ZEROS)


@of("simxBreakForceSensor")
def test_a_broken_force_sensor_lets_go_and_says_so(cid: int, simx: Any, handle: Any) -> None:
    scale, weight = handle("scale"), handle("weight")
    assert simx(cid, scale, BLOCKING) == REMOTE_ERROR, "stopped"
    start_stepped(cid)
    step(cid, 0.1)
    high = v.simxGetObjectPosition(cid, weight, -1, BLOCKING)[1][2]
    assert simx(cid, scale, BLOCKING) == OK
    step(cid, 0.2)
    assert v.simxReadForceSensor(cid, scale, BLOCKING)[1] & 2 == 2
    assert v.simxGetObjectPosition(cid, weight, -1, BLOCKING)[1][2] < high - 0.05
    assert simx(cid, handle("cube"), BLOCKING) == REMOTE_ERROR
    v.simxStopSimulation(cid, BLOCKING)
    assert v.simxGetObjectPosition(cid, weight, -1, BLOCKING)[1][2] == pytest.approx(high, abs=1e-4)


@of("simxReadVisionSensor")
def test_statistics_of_an_image_are_15_numbers_of_least_greatest_and_mean(
    cid: int, simx: Any, handle: Any
) -> None:
    sensor = handle("colour")
    start_stepped(cid)
    step(cid, 0.05)
    code, detected, packets = simx(cid, sensor, BLOCKING)
    assert_types((code, detected, packets), (0, False, [[0.0]]))
    assert (code, detected, [len(packet) for packet in packets]) == (OK, False, [15])
    least, greatest, mean = (packets[0][start : start + 5] for start in (0, 5, 10))
    assert greatest[1] > 0.5, "some red"
    assert greatest[3] > 0.5, "some blue"
    assert all(a <= c <= b for a, b, c in zip(least, greatest, mean, strict=True))
    assert 0.4 < mean[4] < 0.5, "a wall 1 m away between the planes 0.1 and 2.1 m"
    for wrong in (handle("cube"), NO_OBJECT):
        assert simx(cid, wrong, BLOCKING) == (REMOTE_ERROR, False, [])


@of("simxReadVisionSensor")
def test_a_vision_sensor_that_was_never_handled_has_no_statistics(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, handle("colour"), BLOCKING) == (REMOTE_ERROR, False, [])


@of("simxReadVisionSensor")
def test_vision_sensors_that_are_not_handled_any_more_are_8(cid: int, simx: Any, handle: Any) -> None:
    start_stepped(cid)
    step(cid, 0.05)
    assert simx(cid, handle("colour"), BLOCKING)[0] == OK
    v.simxSetBoolParam(cid, v.sim_boolparam_vision_sensor_handling_enabled, False, BLOCKING)
    step(cid, 0.05)
    assert simx(cid, handle("colour"), BLOCKING) == (REMOTE_ERROR, False, [])


@of("simxReadProximitySensor")
def test_proximity_sensors_that_are_not_handled_any_more_are_8(cid: int, simx: Any, handle: Any) -> None:
    start_stepped(cid)
    step(cid, 0.05)
    v.simxSetBoolParam(cid, v.sim_boolparam_proximity_sensor_handling_enabled, False, BLOCKING)
    step(cid, 0.05)
    assert simx(cid, handle("ahead"), BLOCKING) == NOT_THERE


@of("simxGetVisionSensorImage")
def test_an_image_is_signed_bytes_from_the_bottom_row_up(cid: int, simx: Any, handle: Any) -> None:
    code, resolution, image = simx(cid, handle("colour"), 0, BLOCKING)
    assert (code, resolution, len(image)) == (OK, [8, 6], 8 * 6 * 3)
    assert isinstance(image, list)
    assert all(type(value) is int and -128 <= value <= 127 for value in image)
    assert -1 in image, "255 comes as -1"
    rows = np.array(image, dtype=np.uint8).reshape(6, 8, 3)
    assert rows[0, 0].tolist() == [255, 0, 0], "the wall's lower left is red"
    assert rows[-1, -1].tolist() == [0, 0, 255]
    assert rows[0, -1].tolist() == rows[-1, 0].tolist() == [0, 0, 255]


@of("simxGetVisionSensorImage")
@pytest.mark.parametrize("options", [1, 3, 2])
def test_a_grey_image_is_the_mean_of_the_colours(cid: int, simx: Any, handle: Any, options: int) -> None:
    code, resolution, image = simx(cid, handle("colour"), options, BLOCKING)
    assert (code, resolution, len(image)) == (OK, [8, 6], 48)
    assert set(image) == {85}


@of("simxGetVisionSensorImage")
def test_an_image_streams_and_what_is_no_sensor_is_8(world: Any, cid: int, simx: Any, handle: Any) -> None:
    sensor = handle("colour")
    assert simx(cid, sensor, 0, STREAMING) == (NOVALUE, [], [])
    image = simx(cid, sensor, 0, BLOCKING)[2]
    simx(cid, sensor, 0, STREAMING)
    v.simxStartSimulation(cid, BLOCKING)
    while simx(cid, sensor, 0, BUFFER)[0] == NOVALUE:
        world.loop.turn(max_wait=0.01)
    assert simx(cid, sensor, 0, BUFFER) == (OK, [8, 6], list(image))
    for wrong in (handle("cube"), handle("view"), NO_OBJECT):
        assert simx(cid, wrong, 0, BLOCKING) == (REMOTE_ERROR, [], [])


@of("simxSetVisionSensorImage")
@pytest.mark.parametrize("kind", [list, tuple, bytes, lambda image: np.array(image, dtype=np.uint8)])
def test_an_image_is_replaced_by_signed_or_unsigned_values(
    cid: int, simx: Any, handle: Any, kind: Any
) -> None:
    sensor = handle("colour")
    image = [n % 256 for n in range(8 * 6 * 3)]
    assert simx(cid, sensor, kind(image), 0, BLOCKING) == OK
    given = v.simxGetVisionSensorImage(cid, sensor, 0, BLOCKING)[2]
    assert [value & 0xFF for value in given] == image
    assert simx(cid, sensor, given, 0, BLOCKING) == OK, "what was got is given back"
    assert v.simxGetVisionSensorImage(cid, sensor, 0, BLOCKING)[2] == given


@of("simxSetVisionSensorImage")
def test_an_image_of_another_size_is_8(cid: int, simx: Any, handle: Any) -> None:
    sensor = handle("colour")
    assert simx(cid, sensor, [0] * 48, 0, BLOCKING) == REMOTE_ERROR
    assert simx(cid, sensor, [7] * 48, 1, BLOCKING) == OK, "grey has one byte a pixel"
    assert set(v.simxGetVisionSensorImage(cid, sensor, 0, BLOCKING)[2]) == {7}
    assert simx(cid, sensor, [9] * 144, 2, BLOCKING) == OK, "only bit 0 counts"
    assert set(v.simxGetVisionSensorImage(cid, sensor, 0, BLOCKING)[2]) == {9}
    assert simx(cid, handle("cube"), [0] * 144, 0, BLOCKING) == REMOTE_ERROR


@of("simxGetVisionSensorDepthBuffer")
def test_depth_is_0_at_the_near_plane_1_at_the_far_one_and_linear(cid: int, simx: Any, handle: Any) -> None:
    code, resolution, buffer = simx(cid, handle("distance"), BLOCKING)
    assert (code, resolution, len(buffer)) == (OK, [8, 6], 48)
    assert isinstance(buffer, list)
    assert all(type(value) is float for value in buffer)
    assert buffer[-1] == pytest.approx((1.0 - 0.1) / 2.0, abs=1e-3), "planar, not along the ray"
    assert buffer[0] == pytest.approx((0.99 - 0.1) / 2.0, abs=1e-3), "the red part stands 1 cm out"
    for wrong in (handle("cube"), NO_OBJECT):
        assert simx(cid, wrong, BLOCKING) == (REMOTE_ERROR, [], [])


@of("simxCheckCollision")
def test_collision_is_computed_when_asked_for_whatever_the_flags(cid: int, simx: Any, handle: Any) -> None:
    crate, lid, target = handle("crate"), handle("lid"), handle("target")
    assert simx(cid, crate, target, BLOCKING) == (OK, False)
    v.simxSetObjectPosition(cid, target, -1, [-2, -3, 0.3], BLOCKING)
    assert simx(cid, crate, target, BLOCKING) == (OK, True)
    assert simx(cid, target, v.sim_handle_all, BLOCKING) == (OK, True)
    assert_types(simx(cid, crate, target, BLOCKING), (0, True))
    for pair in ((NO_OBJECT, lid), (lid, NO_OBJECT)):
        assert simx(cid, *pair, BLOCKING) == (REMOTE_ERROR, False)


@of("simxCheckCollision")
def test_collision_switched_off_globally_is_success_and_false(cid: int, simx: Any, handle: Any) -> None:
    v.simxSetObjectPosition(cid, handle("target"), -1, [-2, -3, 0.3], BLOCKING)
    assert v.simxSetBoolParam(cid, v.sim_boolparam_collision_handling_enabled, False, BLOCKING) == OK
    assert simx(cid, handle("crate"), handle("target"), BLOCKING) == (OK, False)


@of("simxCheckDistance")
def test_distance_is_the_least_one_in_metres(cid: int, simx: Any, handle: Any) -> None:
    v.simxSetObjectPosition(cid, handle("target"), -1, [0, -3, 0.3], BLOCKING)
    code, distance = simx(cid, handle("crate"), handle("target"), BLOCKING)
    assert (code, type(distance)) == (OK, float)
    assert distance == pytest.approx(2 - 0.1 - 0.5, abs=1e-4)
    assert simx(cid, NO_OBJECT, handle("target"), BLOCKING) == (REMOTE_ERROR, 0.0)


@of("simxCheckDistance")
def test_distance_to_a_collection_to_all_others_and_switched_off(cid: int, simx: Any, handle: Any) -> None:
    target, boxes = handle("target"), v.simxGetCollectionHandle(cid, "boxes", BLOCKING)[1]
    v.simxSetObjectPosition(cid, target, -1, [0, -3, 0.3], BLOCKING)
    for pair in ((boxes, target), (target, boxes)):
        assert simx(cid, *pair, BLOCKING) == (OK, pytest.approx(1.4, abs=1e-4))
    code, nearest = simx(cid, target, v.sim_handle_all, BLOCKING)
    assert (code, nearest) == (OK, 0.0), "it stands in the floor"
    v.simxSetBoolParam(cid, v.sim_boolparam_distance_handling_enabled, False, BLOCKING)
    assert simx(cid, boxes, target, BLOCKING) == (OK, 0.0)


@of("simxReadCollision")
def test_a_collision_object_is_read_once_it_was_handled(cid: int, simx: Any, handle: Any) -> None:
    bump, asked = (v.simxGetCollisionHandle(cid, name, BLOCKING)[1] for name in ("bump", "asked"))
    assert simx(cid, bump, BLOCKING) == (REMOTE_ERROR, False), "stopped"
    start_stepped(cid)
    step(cid, 0.05)
    assert simx(cid, bump, BLOCKING) == (OK, False)
    assert simx(cid, asked, BLOCKING) == (REMOTE_ERROR, False), "handled explicitly, by nobody"
    v.simxSetObjectPosition(cid, handle("target"), -1, [-2, -3, 0.3], BLOCKING)
    step(cid, 0.05)
    assert simx(cid, bump, BLOCKING) == (OK, True)
    assert_types(simx(cid, bump, BLOCKING), (0, True))
    v.simxStopSimulation(cid, BLOCKING)
    assert simx(cid, bump, BLOCKING) == (REMOTE_ERROR, False)


@of("simxReadDistance")
def test_a_distance_object_is_above_1e36_until_it_was_handled(cid: int, simx: Any, handle: Any) -> None:
    clearance = v.simxGetDistanceHandle(cid, "clearance", BLOCKING)[1]
    code, distance = simx(cid, clearance, BLOCKING)
    assert code == OK
    assert distance > 1e36
    v.simxSetObjectPosition(cid, handle("target"), -1, [0, -3, 0.3], BLOCKING)
    start_stepped(cid)
    step(cid, 0.05)
    assert simx(cid, clearance, BLOCKING) == (OK, pytest.approx(1.4, abs=1e-4))
    assert_types(simx(cid, clearance, BLOCKING), (0, 0.0))


@of("simxReadCollision")
def test_a_collision_object_that_nobody_registered_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, NO_OBJECT, BLOCKING) == (REMOTE_ERROR, False)


@of("simxReadDistance")
def test_a_distance_object_that_nobody_registered_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, NO_OBJECT, BLOCKING) == (REMOTE_ERROR, 0.0)


@of("simxGetCollisionHandle")
def test_the_handle_of_an_unknown_collision_object_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, "Collision", BLOCKING) == (REMOTE_ERROR, 0)
    code, found = simx(cid, "bump", BLOCKING)
    assert (code, type(found)) == (OK, int)
    assert simx(cid, "bump#", BLOCKING) == (OK, found)


@of("simxGetDistanceHandle")
def test_the_handle_of_an_unknown_distance_object_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, "Distance", BLOCKING) == (REMOTE_ERROR, 0)
    code, found = simx(cid, "clearance", BLOCKING)
    assert (code, type(found)) == (OK, int)


@of("simxGetCollectionHandle")
def test_a_collection_may_be_an_integer_signal_and_an_unknown_one_is_8(cid: int, simx: Any) -> None:
    code, boxes = simx(cid, "boxes", BLOCKING)
    assert (code, boxes) == (OK, 2_000_000)
    assert_types((code, boxes), (0, 0))
    assert simx(cid, "my collection", BLOCKING) == (REMOTE_ERROR, 0)
    v.simxSetIntegerSignal(cid, "my collection", 2_000_007, BLOCKING)
    assert simx(cid, "my collection", BLOCKING) == (OK, 2_000_007)
