"""Static shapes drag what touches them: belts with a velocity, and shapes that programs move."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from handler_calls import World
from sim_api_calls import ScriptWorld

from simx_server.handlers.objects.poses import reset_dynamic_object

SCENE = """
<mujoco>
  <option timestep="0.005" {option}/>
  <worldbody>
    <geom name="floor" type="plane" size="9 9 0.1"/>
    <body name="belt" pos="0 0 0.5"><geom type="box" size="2 0.3 0.05"/></body>
    <body name="box" pos="0 0 0.6"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="1"/></body>
    <body name="ball" pos="1 0 0.6"><freejoint/><geom size="0.05" mass="1"/></body>
    <body name="other" pos="0 3 0.05"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="1"/></body>
  </worldbody>
</mujoco>
"""

VELOCITY = {axis: 3000 + index for index, axis in enumerate("xyz")} | {"g": 3022}
"""`sim_shapefloatparam_init_velocity_*`."""


def position(world: World, name: str) -> list[float]:
    return world.call("simxGetObjectPosition", world.handle(name), -1)


def drive(world: World, name: str, **velocity: float) -> None:
    for axis, value in velocity.items():
        world.call("simxSetObjectFloatParameter", world.handle(name), VELOCITY[axis], value)


@pytest.mark.parametrize(
    "option",
    ["", 'cone="elliptic"', 'integrator="RK4"', 'integrator="implicitfast" jacobian="sparse"'],
    ids=["pyramidal", "elliptic", "RK4", "sparse"],
)
def test_a_belt_carries_a_box_at_its_velocity_and_makes_a_ball_roll(option: str) -> None:
    world = World(SCENE.format(option=option))
    drive(world, "belt", x=0.3)
    world.run(20)
    before, ball, still = position(world, "box"), position(world, "ball"), position(world, "other")
    world.run(20)
    after = position(world, "box")
    assert after[0] - before[0] == pytest.approx(0.3, abs=0.005)
    assert after[1:] == pytest.approx(before[1:], abs=2e-3)
    # A ball that the belt rolls gets 2/7 of its velocity.
    assert position(world, "ball")[0] - ball[0] == pytest.approx(0.3 * 2 / 7, abs=0.003)
    assert position(world, "other") == pytest.approx(still, abs=1e-3)
    assert position(world, "belt") == [0, 0, 0.5]


def test_a_turntable_carries_a_box_round() -> None:
    world = World(SCENE.format(option=""))
    world.call("simxSetObjectPosition", world.handle("box"), -1, [0.2, 0, 0.6])
    drive(world, "belt", g=1.0)
    world.run(20)
    x, y, _ = position(world, "box")
    assert math.hypot(x, y) == pytest.approx(0.2, abs=0.02)
    angle = world.call("simxGetObjectOrientation", world.handle("box"), -1)[2]
    assert angle == pytest.approx(1.0, abs=0.05)
    assert math.atan2(y, x) == pytest.approx(angle, abs=0.05)


def test_a_belt_stops_when_it_is_reset_without_velocity_and_with_the_run(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, SCENE.format(option=""), owner="belt")
    belt = "local b = sim.getObjectHandle('belt') sim.resetDynamicObject(b) "
    # V-REP's belts reset the shape first, and set its velocity in the same simulation step.
    world.lua(belt + "sim.setObjectFloatParameter(b, sim.shapefloatparam_init_velocity_x, -0.4)")
    world.passes(20)
    before = position(world, "box")[0]
    assert before == pytest.approx(-0.4, abs=0.05)
    world.passes(10)
    assert position(world, "box")[0] - before == pytest.approx(-0.2, abs=0.01)
    world.lua(belt + "sim.setObjectFloatParameter(b, sim.shapefloatparam_init_velocity_x, 0)")
    world.passes(5)
    before = position(world, "box")[0]
    world.passes(10)
    assert position(world, "box")[0] == pytest.approx(before, abs=1e-3)
    world.lua(belt + "sim.setObjectFloatParameter(b, sim.shapefloatparam_init_velocity_x, 1)")
    world.call("simxStopSimulation")
    world.run(10)
    assert position(world, "box")[0] == pytest.approx(0, abs=1e-3)


def test_a_shape_that_is_moved_drags_and_pushes() -> None:
    world = World(SCENE.format(option=""))
    world.run(1)
    belt = world.handle("belt")
    for step in range(1, 31):
        world.call("simxSetObjectPosition", belt, -1, [0.01 * step, 0, 0.5])
        world.run(1)
    assert position(world, "box")[0] == pytest.approx(0.3, abs=0.02)
    for step in range(1, 31):  # up, from below: nothing jumps
        world.call("simxSetObjectPosition", belt, -1, [0.3, 0, 0.5 + 0.01 * step])
        world.run(1)
        assert position(world, "box")[2] == pytest.approx(0.6 + 0.01 * step, abs=0.012)
    assert position(world, "belt") == pytest.approx([0.3, 0, 0.8])


def test_what_is_put_far_away_throws_nothing() -> None:
    world = World(SCENE.format(option=""))
    world.run(1)
    world.call("simxSetObjectPosition", world.handle("belt"), -1, [0, 3, 0.16])
    world.run(20)
    assert position(world, "other")[2] < 0.4
    assert max(map(abs, position(world, "other")[:1])) < 0.2


def test_a_shape_that_is_reset_before_it_is_moved_drags_nothing() -> None:
    world = World(SCENE.format(option=""))
    world.run(1)
    belt, box = world.handle("belt"), world.handle("box")
    reset_dynamic_object(world.parts, belt)
    world.call("simxSetObjectPosition", belt, -1, [0.2, 0.1, 0.5])
    world.call("simxSetObjectPosition", box, -1, [0.2, 0.1, 0.6])
    world.run(1)
    assert position(world, "box") == pytest.approx([0.2, 0.1, 0.6], abs=1e-3)
    world.call("simxSetObjectPosition", belt, -1, [0.21, 0.1, 0.5])  # the reset was for one simulation step
    world.run(1)
    assert position(world, "box")[0] == pytest.approx(0.21, abs=3e-3)


def test_a_shape_that_a_configuration_brings_back_drags_nothing(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, SCENE.format(option=""), owner="belt")
    world.passes(1)
    world.lua("kept = sim.getConfigurationTree(sim.getObjectHandle('belt'))")
    world.lua("sim.setObjectPosition(sim.getObjectHandle('belt'), -1, {0.1, 0, 0.45})")
    world.passes(20)
    before = position(world, "box")
    world.lua(
        "sim.setConfigurationTree(kept) sim.setObjectPosition(sim.getObjectHandle('box'), -1, {0, 0, 0.6})"
    )
    world.passes(2)
    assert before[2] == pytest.approx(0.55, abs=2e-3)
    assert position(world, "box") == pytest.approx([0, 0, 0.6], abs=2e-3)


def test_what_sleeps_on_a_belt_wakes_when_it_starts() -> None:
    world = World(
        SCENE.format(option="").replace("<option", '<option><flag sleep="enable"/></option><option')
    )
    world.run(40)
    drive(world, "belt", x=0.3)
    world.call("simxSetObjectPosition", world.handle("belt"), -1, [0, 0, 0.5])
    world.run(20)
    assert position(world, "box")[0] > 0.2


def test_only_moving_surfaces_change_how_physics_is_stepped() -> None:
    still, moving = World(SCENE.format(option="")), World(SCENE.format(option=""))
    drive(moving, "other", x=0.0)
    moving.run(1)
    moving.parts.simulation.joints.controllers.call_within_steps(lambda model, data: None)
    still.run(20)
    moving.run(19)
    assert still.sim.data.qpos.tolist() == moving.sim.data.qpos.tolist()
    assert still.sim.joints.controllers.within_steps is None


def test_two_worlds_keep_their_belts_apart() -> None:
    first, second = World(SCENE.format(option="")), World(SCENE.format(option=""))
    drive(first, "belt", x=0.3)
    drive(second, "belt", x=-0.3)
    for _ in range(20):
        first.run(1)
        second.run(1)
    assert position(first, "box")[0] == pytest.approx(-position(second, "box")[0])
    assert position(first, "box")[0] > 0.2
    first.call("simxStopSimulation")
    before = position(second, "box")[0]
    second.run(10)
    assert position(second, "box")[0] < before - 0.1
