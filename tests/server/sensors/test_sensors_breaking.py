"""Force sensors that average, filter and break."""

from __future__ import annotations

import numpy as np
import pytest
from handler_calls import World

from simx_server.errors import CommandError, WrongKind
from simx_server.scene.objects import Scene

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <option timestep="0.002"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    <body name="stand" pos="0 0 1"><geom size="0.05"/>
      <body name="weight" pos="0.2 0 0">
        <geom type="box" size="0.05 0.05 0.05" mass="2"/><site name="cell" pos="-0.2 0 0"/>
        <body name="hook" pos="0 0 -0.1"><geom size="0.01" mass="0.1"/></body>
      </body>
    </body>
    <body name="post" pos="3 0 1"><geom size="0.05"/>
      <body name="arm">
        <joint name="hinge" axis="0 1 0" damping="0.01"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1"/><site name="elbow"/>
      </body>
    </body>
    <body name="cup" pos="6 0 1"><geom size="0.05"/><site name="mount" pos="0.1 0 0"/></body>
    <body name="ball" pos="6.2 0 1"><freejoint/><geom size="0.03" mass="0.5"/></body>
  </worldbody>
  <sensor>
    <force site="cell"/><torque site="cell"/><force site="elbow"/><torque site="elbow"/>
    <force site="mount"/><torque site="mount"/>
  </sensor>
  {custom}
</mujoco>
"""
FORCE = [0, 0, pytest.approx(-2.1 * 9.81, abs=1e-6)]


def world_with(custom: str = "") -> World:
    return World(SCENE.format(custom=f"<custom>{custom}</custom>" if custom else ""))


def read(world: World, name: str = "cell"):
    return world.call("simxReadForceSensor", world.handle(name))


def break_sensor(world: World, name: str) -> None:
    world.call("simxBreakForceSensor", world.handle(name))


def tree(scene: Scene) -> dict[int, int]:
    return {handle: item.parent for handle, item in scene.objects.items()}


def height(world: World, name: str) -> float:
    return world.call("simxGetObjectPosition", world.handle(name), -1)[2]


FALLEN = pytest.approx(1 - 0.5 * 9.81 * 0.2**2, abs=2e-2)
"""Height after 0.2 s of free fall from 1 m."""


def test_broken_sensor_lets_go_and_stays_itself() -> None:
    world = world_with()
    before = tree(world.sim.scene)
    world.run(2)
    assert read(world) == (1, FORCE, pytest.approx([0, 0.42 * 9.81, 0], abs=1e-6))
    break_sensor(world, "cell")
    assert tree(world.sim.scene) == before
    assert read(world) == (2, [0.0] * 3, [0.0] * 3)
    for _ in range(4):
        world.parts.step()
    assert height(world, "weight") == FALLEN
    assert height(world, "hook") == pytest.approx(height(world, "weight") - 0.1, abs=1e-3)
    assert height(world, "cell") == 1.0
    assert read(world) == (2, [0.0] * 3, [0.0] * 3)
    break_sensor(world, "cell")


def test_stop_mends_what_was_broken() -> None:
    world = world_with()
    before, state = tree(world.sim.scene), world.sim.data.qpos.copy()
    world.run(2)
    for name in ("cell", "elbow", "mount"):
        break_sensor(world, name)
    world.parts.step()
    world.call("simxStopSimulation")
    assert tree(world.sim.scene) == before
    assert np.array_equal(world.sim.data.qpos, state)
    assert read(world) == (0, [0.0] * 3, [0.0] * 3)
    world.run(2)
    assert read(world)[:2] == (1, FORCE)


def test_joint_in_front_of_a_broken_sensor_stays_behind() -> None:
    world = world_with()
    world.run(2)
    hinge = world.handle("hinge")
    swing = world.call("simxGetJointPosition", hinge)
    assert swing > 0.05
    speed = world.call("simxGetObjectVelocity", world.handle("arm"))[1][1]
    break_sensor(world, "elbow")
    assert world.call("simxGetJointPosition", hinge) == pytest.approx(swing)
    world.parts.step()
    assert world.call("simxGetObjectVelocity", world.handle("arm"))[1][1] >= speed
    for _ in range(3):
        world.parts.step()
    assert height(world, "arm") < 0.95
    assert height(world, "elbow") == pytest.approx(1.0, abs=1e-6)


def test_what_was_attached_to_a_sensor_falls_off() -> None:
    world = world_with()
    world.sim.start()
    ball = world.handle("ball")
    world.call("simxSetObjectParent", ball, world.handle("mount"), True)
    world.parts.step()
    assert height(world, "ball") == pytest.approx(1.0, abs=1e-4)
    break_sensor(world, "mount")
    for _ in range(4):
        world.parts.step()
    assert height(world, "ball") == FALLEN
    assert world.call("simxGetObjectParent", ball) == world.handle("mount")


def test_stopped_sensor_and_other_objects_cannot_be_broken() -> None:
    world = world_with()
    with pytest.raises(CommandError, match="only while the simulation runs"):
        break_sensor(world, "cell")
    world.run()
    with pytest.raises(WrongKind, match="needs a force sensor"):
        break_sensor(world, "hinge")


def test_load_beyond_the_threshold_breaks_after_so_many_steps() -> None:
    world = world_with('<text name="simx:force:cell" data="max_force=20 violations=3"/>')
    world.run(2)
    assert read(world)[0] == 1
    world.parts.step()
    assert read(world)[0] == 2
    stronger = world_with('<text name="simx:force:cell" data="max_force=21 max_torque=5 violations=1"/>')
    stronger.run(5)
    assert read(stronger)[0] == 1


def test_filter_needs_its_samples_and_takes_the_middle_one() -> None:
    world = world_with('<text name="simx:force:cell" data="samples=3 filter=median"/>')
    world.run(2)
    assert read(world) == (0, [0.0] * 3, [0.0] * 3)
    world.parts.step()
    assert read(world)[:2] == (1, FORCE)
    world.call("simxSetArrayParameter", 0, [0.0, 0.0, -1.0])
    world.parts.step()
    assert read(world)[:2] == (1, FORCE)
    world.parts.step()
    assert read(world)[1] == [0, 0, pytest.approx(-2.1, abs=1e-3)]


def test_average_is_taken_over_the_samples() -> None:
    world = world_with('<text name="simx:force:cell" data="samples=2"/>')
    world.run(2)
    world.call("simxSetArrayParameter", 0, [0.0, 0.0, 0.0])
    world.parts.step()
    assert read(world)[1][2] == pytest.approx(-2.1 * 9.81 / 2, rel=1e-2)


def test_without_dynamics_there_are_no_values() -> None:
    world = world_with()
    world.run(2)
    world.call("simxSetBooleanParameter", 6, False)
    world.parts.step()
    assert read(world) == (0, [0.0] * 3, [0.0] * 3)


def test_overload_that_only_triggers_calls_the_script_and_breaks_nothing() -> None:
    pytest.importorskip("lupa")
    script = "function sysCall_trigger(d) sim.setFloatSignal('load', d.force[3]) end"
    data = "max_force=20 violations=3 overload=trigger"
    world = world_with(
        f'<text name="simx:force:cell" data="{data}"/><text name="simx:lua:cell" data="{script}"/>'
    )
    world.run(2)
    assert world.parts.signals.get_float("load") is None
    world.parts.step()
    assert world.parts.signals.get_float("load") == FORCE[2]
    assert read(world)[0] == 1
