"""Functions of inverse kinematics, paths and motion profiles, called as PyRep calls them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from c_program import CProgram, Out, ffi, numbers

from simx_client.protocol import constants as c
from simx_client.pyrep.worlds import ARGUMENTS

JOINTS = 6
CONFIGURATION = Out(f"float[{JOINTS}]")
PLACE = Out("float[3]")


@pytest.fixture
def arm() -> Iterator[CProgram]:
    with CProgram("ur5") as launched:
        launched.run(1)
        yield launched


def joints_of(program: CProgram) -> list[int]:
    return [program.handle(f"UR5_joint{number}") for number in range(1, JOINTS + 1)]


def positions(program: CProgram) -> list[float]:
    return [program.done("simGetJointPosition", joint, Out("float *")) for joint in joints_of(program)]


def put_target(program: CProgram, shift: tuple[float, float, float]) -> None:
    """Put the group's target beside its tip."""
    tip, target = program.handle("UR5_tip"), program.handle("UR5_target")
    place = program.done("simGetObjectPosition", tip, -1, PLACE)
    turn = program.done("simGetObjectQuaternion", tip, -1, Out("float[4]"))
    program.done("simSetObjectPosition", target, -1, np.add(place, shift).tolist())
    program.done("simSetObjectQuaternion", target, -1, turn)


def bend(program: CProgram) -> None:
    """Move the arm away from its stretched pose, at which it has no free direction."""
    for joint, position in zip(joints_of(program), (0.3, 0.5, 1.2, -0.9, -1.3, 0.3), strict=True):
        program.done("simSetJointPosition", joint, position)


def searched(program: CProgram) -> list[float]:
    """Return the first configuration that a search finds for the target, as PyRep searches."""
    group, joints = program.lib.simGetIkGroupHandle(b"UR5_ik"), joints_of(program)
    low, ranges = [-3.14] * JOINTS, [6.28] * JOINTS
    for _ in range(300):
        result, found = program.call(
            "simGetConfigForTipPose", group, JOINTS, joints, 0.65, 10, CONFIGURATION, ffi.NULL, 0, ffi.NULL, ffi.NULL,
            low, ranges, ffi.NULL,
        )  # fmt: skip
        if result == 1:
            return found
    raise AssertionError("no configuration is found")


def test_a_group_is_solved_for_joints_in_force_mode_without_moving_them(arm: CProgram) -> None:
    bend(arm)
    group = arm.lib.simGetIkGroupHandle(b"UR5_ik")
    assert group > 0
    assert arm.lib.simGetIkGroupHandle(b"none") <= 0
    put_target(arm, (0.02, 0.03, -0.02))
    before = positions(arm)
    result, found = arm.call("simCheckIkGroup", group, JOINTS, joints_of(arm), CONFIGURATION, ffi.NULL)
    assert result == 1
    assert positions(arm) == before
    for joint, position in zip(joints_of(arm), found, strict=True):
        arm.done("simSetJointPosition", joint, position)
    tip = arm.done("simGetObjectPosition", arm.handle("UR5_tip"), arm.handle("UR5_target"), PLACE)
    assert np.linalg.norm(tip) < 1e-3


def test_a_target_out_of_reach_is_no_success(arm: CProgram) -> None:
    group = arm.lib.simGetIkGroupHandle(b"UR5_ik")
    put_target(arm, (5.0, 0.0, 0.0))
    assert arm.call("simCheckIkGroup", group, JOINTS, joints_of(arm), CONFIGURATION, ffi.NULL)[0] != 1


def test_a_configuration_is_searched_for_a_pose(arm: CProgram) -> None:
    bend(arm)
    put_target(arm, (0.1, 0.1, -0.1))
    for joint, position in zip(joints_of(arm), searched(arm), strict=True):
        arm.done("simSetJointPosition", joint, position)
    tip = arm.done("simGetObjectPosition", arm.handle("UR5_tip"), arm.handle("UR5_target"), PLACE)
    assert np.linalg.norm(tip) < 1e-3


def test_a_seed_chooses_the_configurations_that_are_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def found(flags: str) -> list[float]:
        monkeypatch.setenv(ARGUMENTS, flags)
        with CProgram("ur5") as program:
            program.run(1)
            bend(program)
            put_target(program, (0.1, 0.1, -0.1))
            return searched(program)

    first = found("--seed 7")
    assert found("--seed 7") == first
    assert found("--seed 8") != first
    assert found("") == found("--seed 0") != first


def test_a_straight_path_ends_at_the_target(arm: CProgram) -> None:
    bend(arm)
    group, joints = arm.lib.simGetIkGroupHandle(b"UR5_ik"), joints_of(arm)
    put_target(arm, (0.05, 0.0, -0.05))
    path = arm.lib.simGenerateIkPath(group, JOINTS, joints, 10, 0, ffi.NULL, ffi.NULL, ffi.NULL)
    assert path != ffi.NULL
    states = np.reshape(numbers(path, 10 * JOINTS), (10, JOINTS))
    assert np.abs(np.diff(states, axis=0)).max() < 0.2
    for joint, position in zip(joints, states[-1].tolist(), strict=True):
        arm.done("simSetJointPosition", joint, position)
    tip = arm.done("simGetObjectPosition", arm.handle("UR5_tip"), arm.handle("UR5_target"), PLACE)
    assert np.linalg.norm(tip) < 1e-3
    put_target(arm, (5.0, 0.0, 0.0))
    assert arm.lib.simGenerateIkPath(group, JOINTS, joints, 10, 0, ffi.NULL, ffi.NULL, ffi.NULL) == ffi.NULL


def test_the_jacobian_has_the_joints_from_the_tip_on(arm: CProgram) -> None:
    bend(arm)
    group, tip = arm.lib.simGetIkGroupHandle(b"UR5_ik"), arm.handle("UR5_tip")
    put_target(arm, (0.0, 0.0, 0.0))
    arm.call("simCheckIkGroup", group, JOINTS, joints_of(arm), CONFIGURATION, ffi.NULL)
    arm.done("simComputeJacobian", group, 0, ffi.NULL)
    matrix, size = arm.call("simGetIkGroupMatrix", group, 0, Out("int[2]"))
    assert size == [JOINTS, 6]
    jacobian = np.reshape(numbers(matrix, 36), size, order="F")
    speeds = []
    for joint in reversed(joints_of(arm)):
        position = arm.done("simGetJointPosition", joint, Out("float *"))
        before = arm.done("simGetObjectPosition", tip, -1, PLACE)
        arm.done("simSetJointPosition", joint, position + 0.01)
        speeds.append(
            np.linalg.norm(np.subtract(arm.done("simGetObjectPosition", tip, -1, PLACE), before)) / 0.01
        )
        arm.done("simSetJointPosition", joint, position)
    assert np.linalg.norm(jacobian[:, :3], axis=1) == pytest.approx(speeds, abs=0.01)


def test_a_group_has_constraints_and_a_method(arm: CProgram) -> None:
    group, tip = arm.lib.simGetIkGroupHandle(b"UR5_ik"), arm.handle("UR5_tip")
    arm.done(
        "simSetIkElementProperties", group, tip, c.sim_ik_x_constraint | 2 | 4, ffi.NULL, ffi.NULL, ffi.NULL
    )
    for method in (0, 1, 2):
        arm.done("simSetIkGroupProperties", group, method, 50, 0.1, ffi.NULL)
    for joint in joints_of(arm):
        arm.done("simSetJointMode", joint, c.sim_jointmode_ik, 0)
    assert arm.lib.simHandleIkGroup(group) >= 0


def test_a_profile_of_motion_reaches_its_goal_within_its_limits(program: CProgram) -> None:
    lib = program.lib
    step = ffi.cast("double", 0.05)
    for make, limits, goal in (
        (lib.simRMLPos, [1.0, 4.0, 1000.0], [2.0, 0.0]),
        (lib.simRMLVel, [4.0, 1000.0], [0.5]),
    ):
        handle = make(1, ffi.cast("double", 0.0001), -1, [0.0, 0.0, 0.0], limits, [1], goal, ffi.NULL)
        assert handle >= 0
        states = []
        for _ in range(200):
            result, state = program.call("simRMLStep", handle, step, Out("double[3]"), ffi.NULL, ffi.NULL)
            states.append(state)
            if result == 1:
                break
            assert result == 0
        assert states[-1][0 if len(goal) == 2 else 1] == pytest.approx(goal[0], abs=1e-6)
        assert max(abs(state[1]) for state in states) <= 1.0 + 1e-6
        program.done("simRMLRemove", handle)
