"""Objects: handles, hierarchy, poses, velocity, group data (the reference's 3.3, 7 and 10)."""

from __future__ import annotations

import math
from typing import Any

import pytest
from conforming import BLOCKING, BUFFER, NO_OBJECT, OK, REMOTE_ERROR, STREAMING, assert_types, of
from real_world import start_stepped, step

import simx_client as v

ALL = v.sim_handle_all
AXIS = 0x400000


@of("simxGetObjectHandle")
@pytest.mark.parametrize("text", ["lid", "lid#", "lid@alt", "/crate/lid", "/lid", b"lid"])
def test_an_object_is_found_by_name_and_path(cid: int, simx: Any, handle: Any, text: Any) -> None:
    assert simx(cid, text, BLOCKING) == (OK, handle("lid"))
    assert_types(simx(cid, text, BLOCKING), (0, 1))


@of("simxGetObjectHandle")
def test_an_unknown_name_is_8_with_handle_0_and_its_text_may_be_silenced(cid: int, simx: Any) -> None:
    assert simx(cid, "nobody", BLOCKING) == (REMOTE_ERROR, 0)
    assert len(v.simxGetLastErrors(cid, BLOCKING)[1]) == 1
    assert simx(cid, "nobody@silentError", BLOCKING) == (REMOTE_ERROR, 0)
    assert v.simxGetLastErrors(cid, BLOCKING) == (OK, [])


@of("simxGetObjects")
def test_objects_come_by_type_in_the_scenes_order_and_never_as_an_error(
    cid: int, simx: Any, handle: Any
) -> None:
    code, everything = simx(cid, ALL, BLOCKING)
    assert code == OK
    assert_types(everything, [1])
    joints = [handle(name) for name in ("shoulder", "elbow", "rail", "ball")]
    assert simx(cid, v.sim_object_joint_type, BLOCKING) == (OK, joints)
    assert set(joints) < set(everything)
    assert simx(cid, v.sim_object_mill_type, BLOCKING) == (OK, [])
    assert simx(cid, 9999, BLOCKING) == (OK, [])


@of("simxGetObjectParent")
def test_the_parent_is_a_handle_or_minus_1_also_for_an_invalid_handle(
    cid: int, simx: Any, handle: Any
) -> None:
    assert simx(cid, handle("lid"), BLOCKING) == (OK, handle("crate"))
    assert simx(cid, handle("upper"), BLOCKING) == (OK, handle("shoulder"))
    assert simx(cid, handle("crate"), BLOCKING) == (OK, -1)
    v.simxGetLastErrors(cid, BLOCKING)
    assert simx(cid, NO_OBJECT, BLOCKING) == (OK, -1)
    assert len(v.simxGetLastErrors(cid, BLOCKING)[1]) == 1


@of("simxGetObjectChild")
def test_children_are_counted_from_0_and_minus_1_ends_the_list(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, handle("watcher"), 0, BLOCKING) == (OK, handle("ahead"))
    assert simx(cid, handle("watcher"), 2, BLOCKING) == (OK, handle("by_hand"))
    assert simx(cid, handle("watcher"), 3, BLOCKING) == (OK, -1)
    assert simx(cid, handle("watcher"), -1, BLOCKING) == (OK, -1)
    v.simxGetLastErrors(cid, BLOCKING)
    assert simx(cid, NO_OBJECT, 0, BLOCKING) == (OK, -1)
    assert simx(cid, -1, 0, BLOCKING) == (OK, -1)
    assert len(v.simxGetLastErrors(cid, BLOCKING)[1]) == 2


def test_texts_of_errors_that_are_no_code_name_the_function_and_can_be_switched_off(cid: int) -> None:
    functions: list[Any] = [v.simxGetObjectParent, v.simxGetObjectChild]
    for function in functions:
        arguments = [NO_OBJECT] if function is v.simxGetObjectParent else [NO_OBJECT, 0]
        function(cid, *arguments, BLOCKING)
        assert v.simxGetLastErrors(cid, BLOCKING)[1][0].startswith(function.__name__)
        v.simxSetIntegerParameter(cid, v.sim_intparam_error_report_mode, 0, BLOCKING)
        function(cid, *arguments, BLOCKING)
        assert v.simxGetLastErrors(cid, BLOCKING) == (OK, [])
        v.simxSetIntegerParameter(cid, v.sim_intparam_error_report_mode, 1, BLOCKING)


@of("simxSetObjectParent")
@pytest.mark.parametrize("runs", [False, True])
def test_a_new_parent_keeps_the_world_pose_or_the_numbers(
    cid: int, simx: Any, handle: Any, runs: bool
) -> None:
    lid, target = handle("lid"), handle("target")
    if runs:
        start_stepped(cid)
    world_pose = v.simxGetObjectPosition(cid, lid, -1, BLOCKING)
    local_pose = v.simxGetObjectPosition(cid, lid, v.sim_handle_parent, BLOCKING)
    assert simx(cid, lid, target, True, BLOCKING) == OK
    assert v.simxGetObjectParent(cid, lid, BLOCKING) == (OK, target)
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[1] == pytest.approx(world_pose[1], abs=1e-6)
    assert simx(cid, lid, -1, 1, BLOCKING) == OK
    assert v.simxGetObjectParent(cid, lid, BLOCKING) == (OK, -1)
    assert simx(cid, lid, handle("crate"), True, BLOCKING) == OK
    assert simx(cid, lid, target, False, BLOCKING) == OK
    numbers = v.simxGetObjectPosition(cid, lid, v.sim_handle_parent, BLOCKING)[1]
    assert numbers == pytest.approx(local_pose[1], abs=1e-6)


@of("simxSetObjectParent")
def test_impossible_parents_are_8(cid: int, simx: Any, handle: Any) -> None:
    crate, lid = handle("crate"), handle("lid")
    assert simx(cid, crate, lid, True, BLOCKING) == REMOTE_ERROR, "its own descendant"
    assert simx(cid, NO_OBJECT, -1, True, BLOCKING) == REMOTE_ERROR
    assert simx(cid, lid, NO_OBJECT, True, BLOCKING) == REMOTE_ERROR
    assert v.simxGetObjectParent(cid, lid, BLOCKING) == (OK, crate)


@of("simxSetObjectParent")
def test_the_assembly_flag_is_8_unless_the_place_is_kept(cid: int, simx: Any, handle: Any) -> None:
    lid, target = handle("lid"), handle("target")
    assert simx(cid, lid + AXIS, target, False, BLOCKING) == REMOTE_ERROR
    assert v.simxGetObjectParent(cid, lid, BLOCKING) == (OK, handle("crate"))
    assert simx(cid, lid + AXIS, target, True, BLOCKING) == OK
    assert v.simxGetObjectParent(cid, lid, BLOCKING) == (OK, target)


@of("simxGetObjectPosition")
def test_a_position_is_metres_in_the_world_the_parent_or_another_object(
    cid: int, simx: Any, handle: Any
) -> None:
    lid, crate, target = handle("lid"), handle("crate"), handle("target")
    assert simx(cid, lid, -1, BLOCKING)[1] == pytest.approx([-2, -3, 0.65], abs=1e-6)
    assert simx(cid, lid, v.sim_handle_parent, BLOCKING)[1] == pytest.approx([0, 0, 0.35], abs=1e-6)
    assert simx(cid, crate, v.sim_handle_parent, BLOCKING)[1] == pytest.approx([-2, -3, 0.3], abs=1e-6)
    assert simx(cid, lid, target, BLOCKING)[1] == pytest.approx([-3.5, -9, 0.15], abs=1e-6)
    assert simx(cid, lid, lid, BLOCKING) == (OK, [0.0] * 3)
    assert_types(simx(cid, lid, -1, BLOCKING), (0, [0.0]))
    for pair in ((NO_OBJECT, -1), (lid, NO_OBJECT), (lid, -2)):
        assert simx(cid, *pair, BLOCKING) == (REMOTE_ERROR, [0.0] * 3)


@of("simxGetObjectPosition")
def test_different_references_are_different_streams(world: Any, cid: int, simx: Any, handle: Any) -> None:
    lid = handle("lid")
    for reference in (-1, v.sim_handle_parent):
        simx(cid, lid, reference, STREAMING)
    world.loop.turn()
    assert simx(cid, lid, -1, BUFFER)[1][2] == pytest.approx(0.65)
    assert simx(cid, lid, v.sim_handle_parent, BUFFER)[1][2] == pytest.approx(0.35)


@of("simxSetObjectPosition")
def test_a_position_is_set_in_any_frame_and_children_move_along(cid: int, simx: Any, handle: Any) -> None:
    crate, lid, target = handle("crate"), handle("lid"), handle("target")
    assert simx(cid, crate, -1, (1.0, 1.0, 1.0), BLOCKING) == OK
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[1] == pytest.approx([1, 1, 1.35], abs=1e-6)
    assert simx(cid, lid, target, [0, 0, 1], BLOCKING) == OK
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[1] == pytest.approx([1.5, 6, 1.5], abs=1e-6)
    assert simx(cid, lid, v.sim_handle_parent, [0, 0, 0], BLOCKING) == OK
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[1] == pytest.approx([1, 1, 1], abs=1e-6)
    assert simx(cid, lid, lid, [0, 0, 0.5], BLOCKING) == OK, "from where it is"
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[1] == pytest.approx([1, 1, 1.5], abs=1e-6)
    for pair in ((NO_OBJECT, -1), (lid, NO_OBJECT), (lid, -2)):
        assert simx(cid, *pair, [0, 0, 0], BLOCKING) == REMOTE_ERROR


@of("simxSetObjectPosition")
@pytest.mark.parametrize("number", [math.nan, math.inf, 1e39])
def test_numbers_that_are_not_finite_are_8_and_change_nothing(
    cid: int, simx: Any, handle: Any, number: float
) -> None:
    lid = handle("lid")
    before = v.simxGetObjectPosition(cid, lid, -1, BLOCKING)
    assert simx(cid, lid, -1, [0, 0, number], BLOCKING) == REMOTE_ERROR
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING) == before


@of("simxSetObjectPosition")
def test_setting_the_position_of_a_moving_body_takes_its_velocity(cid: int, simx: Any, handle: Any) -> None:
    falling = handle("falling")
    start_stepped(cid)
    step(cid, 0.5)
    assert simx(cid, falling, -1, [0, 0, 40], BLOCKING) == OK
    step(cid, 0.05)
    assert v.simxGetObjectPosition(cid, falling, -1, BLOCKING)[1][2] == pytest.approx(40, abs=0.03)


@of("simxGetObjectOrientation")
def test_an_orientation_is_euler_angles_about_x_then_y_then_z(cid: int, simx: Any, handle: Any) -> None:
    lid = handle("lid")
    v.simxSetObjectQuaternion(cid, lid, -1, _rotated(0.3, -0.4, 0.5), BLOCKING)
    assert simx(cid, lid, -1, BLOCKING)[1] == pytest.approx([0.3, -0.4, 0.5], abs=1e-6)
    assert_types(simx(cid, lid, -1, BLOCKING), (0, [0.0]))
    assert simx(cid, NO_OBJECT, -1, BLOCKING) == (REMOTE_ERROR, [0.0] * 3)


@of("simxSetObjectOrientation")
def test_an_orientation_is_set_as_rx_ry_rz(cid: int, simx: Any, handle: Any) -> None:
    lid = handle("lid")
    assert simx(cid, lid, -1, [0.3, -0.4, 0.5], BLOCKING) == OK
    assert v.simxGetObjectQuaternion(cid, lid, -1, BLOCKING)[1] == pytest.approx(
        _rotated(0.3, -0.4, 0.5), abs=1e-6
    )
    assert simx(cid, NO_OBJECT, -1, [0, 0, 0], BLOCKING) == REMOTE_ERROR


def _rotated(alpha: float, beta: float, gamma: float) -> list[float]:
    """x, y, z, w of Rx(alpha) Ry(beta) Rz(gamma), multiplied out by hand."""
    (sa, ca), (sb, cb), (sg, cg) = ((math.sin(a / 2), math.cos(a / 2)) for a in (alpha, beta, gamma))
    return [
        sa * cb * cg + ca * sb * sg,
        ca * sb * cg - sa * cb * sg,
        ca * cb * sg + sa * sb * cg,
        ca * cb * cg - sa * sb * sg,
    ]


@of("simxGetObjectQuaternion")
def test_a_quaternion_has_its_scalar_last(cid: int, simx: Any, handle: Any) -> None:
    lid = handle("lid")
    assert simx(cid, lid, -1, BLOCKING) == (OK, [0.0, 0.0, 0.0, 1.0])
    assert simx(cid, NO_OBJECT, -1, BLOCKING) == (REMOTE_ERROR, [0.0] * 4)
    v.simxSetObjectOrientation(cid, lid, -1, [0, 0, math.pi / 2], BLOCKING)
    half = math.sqrt(0.5)
    assert simx(cid, lid, -1, BLOCKING)[1] == pytest.approx([0, 0, half, half], abs=1e-6)
    assert simx(cid, lid + AXIS, -1, BLOCKING)[1] == pytest.approx([half, 0, 0, half], abs=1e-6)


@of("simxSetObjectQuaternion")
def test_a_quaternion_is_set_with_its_scalar_last(cid: int, simx: Any, handle: Any) -> None:
    lid = handle("lid")
    half = math.sqrt(0.5)
    assert simx(cid, lid, -1, [half, 0, 0, half], BLOCKING) == OK
    assert v.simxGetObjectOrientation(cid, lid, -1, BLOCKING)[1] == pytest.approx(
        [math.pi / 2, 0, 0], abs=1e-5
    )
    with pytest.raises(IndexError):
        simx(cid, lid, -1, [0, 0, 0, 1, 0], BLOCKING)
    assert simx(cid, NO_OBJECT, -1, [0, 0, 0, 1], BLOCKING) == REMOTE_ERROR
    assert simx(cid, lid, -1, [0, 0, 0, 0], BLOCKING) == REMOTE_ERROR, "no rotation"
    assert simx(cid, lid, -1, [0, 0, 0, 5], BLOCKING) == OK
    assert v.simxGetObjectQuaternion(cid, lid, -1, BLOCKING) == (OK, [0.0, 0.0, 0.0, 1.0])
    assert simx(cid, lid + AXIS, -1, [half, half, 0, 0], BLOCKING) == OK, "with the flag the scalar is first"
    assert v.simxGetObjectQuaternion(cid, lid, -1, BLOCKING)[1] == pytest.approx([half, 0, 0, half], abs=1e-6)


def test_a_joint_as_reference_means_its_moving_frame_and_its_own_pose_ignores_its_value(
    cid: int, handle: Any
) -> None:
    rail, cart = handle("rail"), handle("cart")
    before = v.simxGetObjectPosition(cid, rail, -1, BLOCKING)
    at_rest = v.simxGetObjectPosition(cid, cart, rail, BLOCKING)
    v.simxSetJointPosition(cid, rail, 0.5, BLOCKING)
    assert v.simxGetObjectPosition(cid, rail, -1, BLOCKING) == before
    assert v.simxGetObjectPosition(cid, cart, -1, BLOCKING)[1] == pytest.approx([0.5, 3, 0.2], abs=1e-6)
    assert v.simxGetObjectPosition(cid, cart, rail, BLOCKING)[1] == pytest.approx(at_rest[1], abs=1e-6)
    fixed = v.simxGetObjectPosition(cid, cart + AXIS, rail, BLOCKING)[1]
    assert math.dist(fixed, at_rest[1]) == pytest.approx(0.5, abs=1e-6)


@of("simxGetObjectVelocity")
def test_velocity_is_measured_over_the_last_step(cid: int, simx: Any, handle: Any) -> None:
    falling, shoulder, upper = handle("falling"), handle("shoulder"), handle("upper")
    start_stepped(cid)
    assert simx(cid, falling, BLOCKING) == (OK, [0.0] * 3, [0.0] * 3)
    v.simxSetJointTargetVelocity(cid, shoulder, 1.0, BLOCKING)
    step(cid, 1.0)
    code, linear, angular = simx(cid, falling, BLOCKING)
    assert code == OK
    assert linear == pytest.approx([0, 0, -9.81 * 0.975], rel=0.02)
    assert angular == pytest.approx([0, 0, 0], abs=1e-6)
    assert_types(simx(cid, falling, BLOCKING), (0, [0.0], [0.0]))
    assert simx(cid, upper, BLOCKING)[2] == pytest.approx([0, 0, 1], abs=0.02)
    assert simx(cid, upper + AXIS, BLOCKING)[2] == pytest.approx([0, 0, 1], abs=0.02)
    assert simx(cid, NO_OBJECT, BLOCKING) == (REMOTE_ERROR, [0.0] * 3, [0.0] * 3)
    v.simxStopSimulation(cid, BLOCKING)
    assert simx(cid, falling, BLOCKING) == (OK, [0.0] * 3, [0.0] * 3)


_STRIDES = {
    0: (0, 0, 1), 1: (1, 0, 0), 2: (1, 0, 0), 3: (0, 3, 0), 4: (0, 3, 0), 5: (0, 3, 0), 6: (0, 3, 0), 7: (0, 4, 0),
    8: (0, 4, 0), 9: (0, 6, 0), 10: (0, 6, 0), 11: (0, 7, 0), 12: (0, 7, 0), 13: (2, 6, 0), 14: (1, 6, 0),
    15: (0, 2, 0), 16: (2, 2, 0), 17: (0, 3, 0), 18: (0, 3, 0), 19: (0, 6, 0), 20: (0, 0, 1), 21: (0, 0, 1),
    99: (0, 0, 0),
}  # fmt: skip


@of("simxGetObjectGroupData")
@pytest.mark.parametrize("data", _STRIDES)
def test_group_data_has_a_constant_stride_over_all_objects(cid: int, simx: Any, data: int) -> None:
    code, handles, ints, floats, strings = simx(cid, v.sim_appobj_object_type, data, BLOCKING)
    assert code == OK
    assert handles == v.simxGetObjects(cid, ALL, BLOCKING)[1]
    assert tuple(len(each) / len(handles) for each in (ints, floats, strings)) == _STRIDES[data]
    assert_types((code, handles, ints, floats, strings), (0, [1], [1], [0.0], [""]))


@of("simxGetObjectGroupData")
def test_group_data_agrees_with_the_single_functions(cid: int, simx: Any, handle: Any) -> None:
    joints = [handle(name) for name in ("shoulder", "elbow", "rail", "ball")]
    joint_type = v.sim_object_joint_type
    assert simx(cid, joint_type, 0, BLOCKING) == (OK, joints, [], [], ["shoulder", "elbow", "rail", "ball"])
    assert simx(cid, joint_type, 1, BLOCKING)[2] == [1] * 4
    assert simx(cid, joint_type, 2, BLOCKING)[2] == [handle("robot"), handle("upper"), -1, -1]
    positions = [x for each in joints for x in v.simxGetObjectPosition(cid, each, -1, BLOCKING)[1]]
    assert simx(cid, joint_type, 3, BLOCKING)[3] == positions
    poses = simx(cid, joint_type, 11, BLOCKING)[3]
    assert poses[:3] == positions[:3]
    assert poses[3:7] == v.simxGetObjectQuaternion(cid, joints[0], -1, BLOCKING)[1]
    local = simx(cid, joint_type, 12, BLOCKING)[3]
    assert local[3:7] == v.simxGetObjectQuaternion(cid, joints[0], v.sim_handle_parent, BLOCKING)[1]


@of("simxGetObjectGroupData")
def test_joint_properties_tell_type_mode_least_value_and_range(cid: int, simx: Any) -> None:
    _, _, ints, floats, _ = simx(cid, v.sim_object_joint_type, 16, BLOCKING)
    assert ints[0::2] == [10, 10, 11, 12], "revolute, revolute, prismatic, spherical"
    assert ints[1::2][:3] == [5, 5, 0]
    assert floats[1] == -1.0, "cyclic"
    assert floats[2:4] == pytest.approx([-2, 4])
    assert floats[4:6] == pytest.approx([-0.5, 2])


@of("simxGetObjectGroupData")
def test_group_data_of_another_kind_of_object_is_minus_1(cid: int, simx: Any) -> None:
    for data, ints in ((13, [-1, -1]), (14, [-1]), (16, [-1, -1])):
        code, handles, found, floats, _ = simx(cid, v.sim_object_dummy_type, data, BLOCKING)
        assert (code, found) == (OK, ints * len(handles))
        assert set(floats) == {0.0}


@of("simxGetObjectGroupData")
def test_group_data_of_a_type_without_objects_is_empty_and_of_no_type_8(cid: int, simx: Any) -> None:
    assert simx(cid, v.sim_object_mill_type, 3, BLOCKING) == (OK, [], [], [], [])
    for wrong in (ALL, -1, 108, 5000):
        assert simx(cid, wrong, 3, BLOCKING) == (REMOTE_ERROR, [], [], [], [])
