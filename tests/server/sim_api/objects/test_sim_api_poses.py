"""Where objects are and how they move, as scripts ask and tell."""

from __future__ import annotations

import math

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

HALF = math.sqrt(0.5)


def near(values: object, tolerance: float = 1e-9) -> object:
    return pytest.approx(values, abs=tolerance)


@pytest.fixture(autouse=True)
def _handles(world: ScriptWorld) -> None:
    world.lua(
        "for _, name in ipairs{'robot','mark','hinge','arm','tip','cube'} do _G[name] = sim.getObject(name) end"
    )


def test_positions_in_several_frames(world: ScriptWorld) -> None:
    assert world.value("sim.getObjectPosition(mark, -1)") == near([0.1, 0.2, 1.3])
    assert world.value("sim.getObjectPosition(mark, sim.handle_world)") == near([0.1, 0.2, 1.3])
    assert world.value("sim.getObjectPosition(mark)") == near([0.1, 0.2, 1.3])
    assert world.value("sim.getObjectPosition(mark, sim.handle_parent)") == near([0.1, 0.2, 0.3])
    assert world.value("sim.getObjectPosition(cube, sim.handle_self)") == near([2, 0, 0])
    assert world.value("sim.getObjectPosition(sim.handle_self, -1)") == near([0, 0, 1])
    assert world.value("sim.getObjectPosition(robot, mark)") == near([-0.2, 0.1, -0.3])


def test_both_orders_of_arguments_are_understood(world: ScriptWorld) -> None:
    for call in (
        "sim.setObjectPosition(cube, -1, {1,1,1})",
        "sim.setObjectPosition(cube, {1,1,1}, -1)",
        "sim.setObjectPosition(cube, {1,1,1})",
        "sim.setObjectPosition(cube, robot, {1,1,0})",
        "sim.setObjectPosition(cube, {1,1,0}, robot)",
    ):
        world.lua("sim.setObjectPosition(cube, -1, {0,0,5})")
        world.lua(call)
        assert world.value("sim.getObjectPosition(cube, -1)") == near([1, 1, 1]), call
    world.fails("sim.setObjectPosition(cube, -1)", r"must be a position \(a table\) and one a reference")
    world.fails("sim.setObjectPosition(cube, {0,0,0}, {0,0,0})", "one a reference")
    world.fails("sim.setObjectPosition(cube, 'x', {0,0,0})", "a number or a table")


def test_rotations_are_set_and_read(world: ScriptWorld) -> None:
    world.lua("sim.setObjectOrientation(cube, -1, {0.1,0.2,0.3})")
    assert world.value("sim.getObjectOrientation(cube, -1)") == near([0.1, 0.2, 0.3])
    world.lua("sim.setObjectQuaternion(cube, {0,0,1,1})")
    assert world.value("sim.getObjectQuaternion(cube, -1)") == near([0, 0, HALF, HALF])
    assert world.value("sim.getObjectQuaternion(cube + sim.handleflag_wxyzquat, -1)") == near(
        [HALF, 0, 0, HALF]
    )
    world.lua("sim.setObjectQuaternion(cube + sim.handleflag_wxyzquat, {1,1,0,0})")
    assert world.value("sim.getObjectQuaternion(cube, -1)") == near([HALF, 0, 0, HALF])
    assert world.value("sim.getObjectOrientation(cube, -1)") == near([math.pi / 2, 0, 0])


def test_a_quaternion_may_be_of_any_length(world: ScriptWorld) -> None:
    for factor in ("1e-9", "2", "1e300"):
        world.lua(f"sim.setObjectQuaternion(cube, -1, {{0, 0, {factor}, {factor}}})")
        assert world.value("sim.getObjectQuaternion(cube, -1)") == near([0, 0, HALF, HALF]), factor
    world.fails("sim.setObjectQuaternion(cube, -1, {0,0,0,0})", "length 0 is no rotation")


def test_poses_and_matrices_are_set_and_read(world: ScriptWorld) -> None:
    assert world.value("sim.getObjectPose(mark, -1)") == near([0.1, 0.2, 1.3, 0, 0, HALF, HALF])
    assert world.value("sim.getObjectPose(mark | sim.handleflag_wxyzquat, robot)") == near(
        [0.1, 0.2, 0.3, HALF, 0, 0, HALF]
    )
    world.lua("sim.setObjectPose(cube, {0.5,0,0, 0,0,0,1}, mark)")
    assert world.value("sim.getObjectMatrix(cube, -1)") == near([0, -1, 0, 0.1, 1, 0, 0, 0.7, 0, 0, 1, 1.3])
    world.lua("sim.setObjectMatrix(cube, -1, sim.buildMatrix({1,2,3}, {0,0,0}))")
    assert world.value("sim.getObjectPose(cube, -1)") == near([1, 2, 3, 0, 0, 0, 1])
    world.lua("sim.setObjectMatrix(cube, sim.getObjectMatrix(mark, -1))")
    assert world.value("sim.getObjectPose(cube, mark)") == near([0, 0, 0, 0, 0, 0, 1])
    world.lua("sim.setObjectPose(cube | sim.handleflag_wxyzquat, -1, {1,2,3, 0,1,0,0})")
    assert world.value("sim.getObjectPose(cube)") == near([1, 2, 3, 1, 0, 0, 0])
    world.fails("sim.setObjectPose(cube, -1, {1,2,3})", "a pose is 7 numbers")
    world.fails("sim.setObjectMatrix(cube, -1, {1,2,3})", "a matrix is 12 finite numbers")


def test_the_world_seen_from_an_object(world: ScriptWorld) -> None:
    seen = world.value("sim.getObjectPose(mark, sim.handle_inverse)")
    assert seen == near(world.value("sim.invertPose(sim.getObjectPose(mark, -1))"))
    assert world.value("sim.getObjectMatrix(mark, sim.handle_inverse)") == near(
        world.value("sim.getMatrixInverse(sim.getObjectMatrix(mark, -1))")
    )


def test_a_joint_as_reference_means_its_moving_or_its_fixed_frame(world: ScriptWorld) -> None:
    world.lua("sim.setJointPosition(hinge, 0.5)")
    moving = world.value("sim.getObjectPosition(tip, hinge)")
    fixed = world.value("sim.getObjectPosition(tip + sim.handleflag_reljointbaseframe, hinge)")
    assert moving == near([0.4, 0, 0])
    assert fixed == near([0.4 * math.cos(0.5), 0.4 * math.sin(0.5), 0])


def test_velocities_are_those_of_the_last_step(world: ScriptWorld) -> None:
    body = world.sim.model.body("cube").dofadr[0]
    world.sim.data.qvel[body : body + 6] = [0.2, 0, 0, 0, 0, 1.0]
    world.passes(2)
    linear, angular = world.lua("return sim.getVelocity(cube)")
    assert linear == near([0.2, 0, 0], 1e-6)
    assert angular == near([0, 0, 1.0], 1e-6)
    linear, rates = world.lua("return sim.getObjectVelocity(cube)")
    assert (linear, rates) == (near([0.2, 0, 0], 1e-6), near([0, 0, 1.0], 1e-6))
    assert world.lua("return sim.getObjectVelocity(cube + sim.handleflag_axis)")[1] == near([0, 0, 1.0], 1e-6)


def test_a_reset_object_stands_still_where_it_is(world: ScriptWorld) -> None:
    body = world.sim.model.body("cube").dofadr[0]
    for handle in ("cube", "sim.handle_all"):
        world.sim.data.qvel[body : body + 3] = [0.2, 0, 0]
        before = world.value("sim.getObjectPosition(cube, -1)")
        world.lua(f"sim.resetDynamicObject({handle})")
        assert world.value("sim.getObjectPosition(cube, -1)") == near(before)
        world.passes(2)
        assert world.value("sim.getObjectPosition(cube, -1)") == near(before), handle


def test_an_unknown_handle_is_an_error_that_says_so(world: ScriptWorld) -> None:
    world.fails("sim.getObjectPosition(9999, -1)", r"sim\.getObjectPosition: no object with handle 9999")
    world.fails("sim.getObjectMatrix(cube, 9999)", "no object with handle 9999")
