"""Functions of scripts for joints."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

HINGE = "local j = sim.getObjectHandle('hinge')\n"

TRIO = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base"><geom size="0.1"/>
      <body name="first" pos="1 0 0"><joint name="lead" axis="0 0 1"/><geom size="0.1"/></body>
      <body name="second" pos="2 0 0"><joint name="follower" axis="0 0 1"/><geom size="0.1"/></body>
      <body name="third" pos="3 0 0"><joint name="ball" type="ball"/><geom size="0.1"/></body>
      <body name="fourth" pos="4 0 0"><joint name="slide" type="slide"/><geom size="0.1"/></body>
    </body>
  </worldbody>
  <custom>
    <text name="simx:joint:lead" data="mode=passive"/>
    <text name="simx:joint:follower" data="mode=dependent master=lead multiplication=2 offset=0.1"/>
    <text name="simx:joint:ball" data="mode=passive"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def trio(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, TRIO, owner="base")


def test_a_joint_is_put_somewhere_and_driven_to_a_target(world: ScriptWorld) -> None:
    assert world.lua(HINGE + "return sim.setJointPosition(j, 0.5), sim.getJointPosition(j)") == [
        1,
        pytest.approx(0.5),
    ]
    assert world.lua(HINGE + "return sim.setJointTargetPosition(j, -0.5), sim.getJointTargetPosition(j)") == [
        1,
        -0.5,
    ]
    world.passes(1)
    assert world.value("sim.getJointVelocity(sim.getObjectHandle('hinge'))") < -0.5
    world.passes(39)
    assert world.value("sim.getJointPosition(sim.getObjectHandle('hinge'))") == pytest.approx(-0.5, abs=1e-3)


def test_the_target_velocity_is_kept_in_any_mode(world: ScriptWorld) -> None:
    assert world.lua(HINGE + "return sim.setJointTargetVelocity(j, 0.7), sim.getJointTargetVelocity(j)") == [
        1,
        0.7,
    ]


@pytest.mark.parametrize(
    "call", ["sim.setJointForce(j, -7)", "sim.setJointMaxForce(j, -7)", "sim.setJointTargetForce(j, -7)"]
)
def test_every_name_of_the_force_limit_sets_the_same(world: ScriptWorld, call: str) -> None:
    assert world.lua(HINGE + f"return {call}, sim.getJointMaxForce(j)") == [1, 7]


def test_the_force_of_a_motor_that_accelerates_is_read(world: ScriptWorld) -> None:
    assert world.lua(HINGE + "return sim.getJointForce(j), sim.setJointTargetPosition(j, 1)") == [0, 1]
    world.passes(1)
    assert world.value("sim.jointGetForce(sim.getObjectHandle('hinge'))") < 0  # it pushes upwards


def test_an_interval_is_a_minimum_and_a_range(world: ScriptWorld) -> None:
    assert world.lua(HINGE + "return sim.getJointInterval(j)") == [False, [-2, 4]]
    assert world.lua(HINGE + "return sim.setJointInterval(j, false, {-1, 1.5}), sim.getJointInterval(j)") == [
        1,
        False,
        [-1, 1.5],
    ]
    assert world.lua(HINGE + "sim.setJointInterval(j, true, {0, 0}) return sim.getJointInterval(j)") == [
        True,
        [pytest.approx(-math.pi), pytest.approx(2 * math.pi)],
    ]
    world.fails(HINGE + "sim.setJointInterval(j, true, {0})", "least value, range")


def test_the_mode_can_be_changed_with_hybrid_operation(world: ScriptWorld) -> None:
    assert world.lua(HINGE + "return sim.getJointMode(j)") == [5, 0]
    assert world.value("math.type(select(2, sim.getJointMode(sim.getObject('/hinge'))))") == "integer"
    assert world.lua(HINGE + "return sim.setJointMode(j, sim.jointmode_passive, 1), sim.getJointMode(j)") == [
        1,
        0,
        True,
    ]
    assert world.lua(HINGE + "sim.setJointMode(j, sim.jointmode_passive, 0) return sim.getJointMode(j)") == [
        0,
        False,
    ]
    world.fails(HINGE + "sim.setJointMode(j, 9, 0)", "9 is no joint mode; those are 0 passive")


def test_the_three_types_of_joints_have_their_numbers(trio: ScriptWorld) -> None:
    source = "return {sim.getJointType(sim.getObjectHandle('lead')), sim.getJointType(sim.getObjectHandle('slide')), "
    source += "sim.getJointType(sim.getObjectHandle('ball'))}, "
    source += "{sim.joint_revolute_subtype, sim.joint_prismatic_subtype, sim.joint_spherical_subtype}"
    assert trio.lua(source) == [[10, 11, 12]] * 2


def test_the_matrix_of_a_joint_is_what_its_value_does(trio: ScriptWorld) -> None:
    turned = trio.value(
        "(function() local j = sim.getObjectHandle('lead') sim.setJointPosition(j, math.pi / 2) "
        "return sim.getJointMatrix(j) end)()"
    )
    assert turned == pytest.approx([0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0], abs=1e-9)


def test_a_spherical_joint_is_turned_by_a_matrix(trio: ScriptWorld) -> None:
    source = "local j = sim.getObjectHandle('ball') "
    source += "return sim.setSphericalJointMatrix(j, {0, -1, 0, 5, 1, 0, 0, 5, 0, 0, 1, 5}), "
    source += "sim.getSphericalJointMatrix(j)"
    assert trio.lua(source) == [1, pytest.approx([0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0], abs=1e-9)]
    trio.fails("sim.getSphericalJointMatrix(sim.getObjectHandle('lead'))", "no spherical joint")


def test_a_dependency_is_read_and_changed(trio: ScriptWorld) -> None:
    both = "local f, l = sim.getObjectHandle('follower'), sim.getObjectHandle('lead')\n"
    lead = trio.handle("lead")
    assert trio.lua(both + "return sim.getJointDependency(f)") == [lead, 0.1, 2]
    assert trio.lua(both + "return sim.setJointDependency(f, l, 0.2, -1), sim.getJointDependency(f)") == [
        1,
        lead,
        0.2,
        -1,
    ]
    assert trio.lua(both + "sim.setJointPosition(l, 0.5) return sim.getJointPosition(f)") == [
        pytest.approx(-0.3)
    ]
    assert trio.lua(both + "sim.setJointDependency(f, -1) return sim.getJointDependency(f)")[0] == -1


PENDULUM = """
<mujoco>
  <worldbody>
    <body name="wheel"><joint name="lead" axis="0 1 0"/><geom type="cylinder" size=".1 .02" euler="90 0 0"/></body>
    <body name="rod" pos="1 0 0"><joint name="follower" axis="0 1 0"/><geom size=".05" pos=".3 0 0" mass="2"/></body>
  </worldbody>
</mujoco>
"""


def test_a_dependency_that_a_script_sets_carries_forces(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, PENDULUM, owner="wheel", kind="customization")
    world.fails(
        "sim.setJointDependency(sim.getObjectHandle('follower'), sim.getObjectHandle('lead'))", "mode"
    )
    assert world.sim.model.neq == 0, "a call that fails changes nothing"
    both = "local f, l = sim.getObjectHandle('follower'), sim.getObjectHandle('lead')\n"
    world.lua(both + "sim.setJointMode(f, sim.jointmode_dependent, 0) sim.setJointDependency(f, l, 0, 2)")
    assert world.sim.model.neq == 1
    model = world.sim.model
    world.lua(both + "sim.setJointDependency(f, l, 0, 2)")
    assert world.sim.model is model, "a second call compiles nothing"
    world.passes(5)
    lead, follower = world.lua(both + "return sim.getJointPosition(l), sim.getJointPosition(f)")
    assert lead > 0.1  # the weight of the pendulum turns the wheel
    assert follower == pytest.approx(2 * lead, abs=1e-3)
    world.lua(both + "sim.setJointDependency(f, -1)")
    assert not world.sim.data.eq_active.any()
    world.sim.stop()
    assert world.sim.model.neq == 0, "it was made in the run"


def test_targets_bring_the_limits_of_their_motion(trio: ScriptWorld) -> None:
    lead = "local j = sim.getObjectHandle('lead')\n"
    trio.fails(lead + "sim.setJointTargetPosition(j, 1)", "upper_acceleration")
    trio.lua(lead + "sim.setJointTargetPosition(j, 1, {2, 8, 0})")
    trio.passes(5)
    assert trio.value("sim.getJointPosition(sim.getObjectHandle('lead'))") == pytest.approx(0.25, abs=1e-2)
    assert trio.lua(lead + "return sim.getObjectFloatParam(j, 2036), sim.getObjectFloatParam(j, 2037)") == [
        2,
        8,
    ]
    trio.lua(lead + "sim.setJointTargetVelocity(j, 0, {100})")
    trio.passes(2)
    assert trio.value("sim.getJointVelocity(sim.getObjectHandle('lead'))") == pytest.approx(0.0, abs=1e-6)


def test_the_sign_of_a_target_force_is_a_direction(world: ScriptWorld) -> None:
    def after(*calls: str) -> Any:
        lines = "\n".join(f"sim.setJointTarget{call}" for call in calls)
        return world.lua(f"{HINGE}{lines}\nreturn sim.getJointTargetForce(j), sim.getJointTargetVelocity(j)")

    assert after("Velocity(j, 2)", "Force(j, -3)") == [-3, -2]
    assert after("Force(j, 1)") == [1, 2], "the sign comes back"
    assert after("Velocity(j, -2)") == [-1, -2]
    assert after("Force(j, 3, false)") == [-3, -2], "only the magnitude is given"
    assert after("Velocity(j, 0)", "Force(j, 1)", "Force(j, -3)") == [-3, 0], "without a velocity too"


def test_a_joint_in_force_control_pushes_where_its_target_force_points(world: ScriptWorld) -> None:
    hinge = world.handle("hinge")
    joints = world.sim.joints
    world.lua(HINGE + "sim.setJointTargetForce(j, -50)")
    world.lua(HINGE + "sim.setObjectInt32Param(j, sim.jointintparam_dynctrlmode, sim.jointdynctrl_force)")
    forces = []
    for call in ("Force(j, -50)", "Force(j, 50)", "Velocity(j, -1)", "Force(j, 50, false)"):
        world.lua(f"{HINGE}sim.setJointTarget{call}")
        world.passes(1)
        forces.append(-joints.force(hinge))
    assert forces == pytest.approx([-50, 50, -50, -50])
