"""Models and scenes of V-REP do here what their scripts say."""

from __future__ import annotations

import pytest
from handler_calls import World
from vrep_samples import sample, world_of

from simx_server.editing.models import load_model
from simx_server.scene.poses import frames

pytest.importorskip("lupa")

TABLE = """<mujoco><option timestep="0.005"/><worldbody>
<geom name="floor" type="plane" size="5 5 0.1"/>
<body name="box" pos="0 0 0.05"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="0.5"/></body>
</worldbody></mujoco>"""


def steps(world: World, count: int) -> None:
    for _ in range(count):
        world.parts.step()
        assert world.sim.is_running


def position(world: World, name: str) -> list[float]:
    return frames.get_position(world.sim, world.sim.scene.resolve(name))


def lift(world: World, pad: int) -> None:
    """Lift the pad by 9 cm, slowly, from where its mouth is 1.5 mm above the box."""
    steps(world, 5)
    for height in range(10):
        frames.set_position(world.sim, pad, -1, [0, 0, 0.1165 + 0.01 * height])
        steps(world, 2)


def stopped_scripts(world: World) -> list[str]:
    return [line for line in world.parts.status_bar.messages if "is stopped" in line]


def test_a_suction_pad_lifts_a_box_while_it_is_active() -> None:
    world = World(TABLE)
    pad = load_model(world.parts, sample("suction pad.ttm"))
    frames.set_position(
        world.sim, pad, -1, [0, 0, 0.1165]
    )  # its mouth lies 15 mm lower, 1.5 mm above the box
    world.call("simxSetObjectIntParameter", pad, 3003, 1)
    world.sim.start()
    lift(world, pad)
    assert position(world, "box")[2] == pytest.approx(0.14, abs=2e-3)
    assert stopped_scripts(world) == []


def test_a_suction_pad_that_is_not_active_leaves_a_box_alone() -> None:
    world = World(TABLE)
    pad = load_model(world.parts, sample("suction pad.ttm"))
    frames.set_position(world.sim, pad, -1, [0, 0, 0.1165])
    world.call("simxSetObjectIntParameter", pad, 3003, 1)
    world.parts.script_parameters.set(pad, "active", "false")
    world.sim.start()
    lift(world, pad)
    assert position(world, "box")[2] == pytest.approx(0.05, abs=1e-3)

    frames.set_position(world.sim, pad, -1, [0, 0, 0.1165])
    world.parts.script_parameters.set(pad, "active", "true")
    lift(world, pad)
    assert position(world, "box")[2] == pytest.approx(0.14, abs=2e-3)
    world.parts.script_parameters.set(pad, "active", "false")
    steps(world, 10)
    assert position(world, "box")[2] == pytest.approx(0.05, abs=2e-3)
    assert stopped_scripts(world) == []


def test_a_legacy_client_drives_bubblerob_and_its_nose_sees_what_is_ahead() -> None:
    world = world_of(sample("controlledViaLegacyRemoteApi.ttt"))
    names = ("LeftMotor", "RightMotor", "SensingNose")
    left, right, nose = (world.handle(f"remoteApiControlledBubbleRob{name}") for name in names)
    robot = world.handle("remoteApiControlledBubbleRob")
    world.sim.start()
    steps(world, 2)
    start = world.call("simxGetObjectPosition", robot, -1)
    for motor in (left, right):
        world.call("simxSetJointTargetVelocity", motor, 3.1415)
    steps(world, 40)
    end = world.call("simxGetObjectPosition", robot, -1)
    # The wheels have a radius of 4 cm, and the robot looks along x.
    assert end[0] - start[0] == pytest.approx(3.1415 * 0.04 * 2.0, rel=0.03)
    assert end[1] == pytest.approx(start[1], abs=0.01)
    world.call("simxSetJointTargetVelocity", left, -3.1415)
    steps(world, 10)
    turned = world.call("simxGetObjectOrientation", robot, -1)
    assert turned[2] > 0.3
    seen = world.call("simxReadProximitySensor", nose)
    assert seen[0] in (0, 1)
    world.sim.stop()
    assert world.call("simxGetObjectPosition", robot, -1) == pytest.approx(start, abs=0.02)


def test_an_ik_group_of_the_file_moves_the_tip_to_its_target() -> None:
    world = world_of(sample("7 DoF manipulator.ttm"))
    sim = world.sim
    tip = next(o for o in sim.scene.objects.values() if o.name.endswith("_tip"))
    target = next(o for o in sim.scene.objects.values() if o.name.endswith("_target"))
    sim.start()
    steps(world, 2)
    goal = frames.get_position(sim, target.handle)
    goal = [goal[0] - 0.03, goal[1] + 0.05, goal[2] - 0.04]
    frames.set_position(sim, target.handle, -1, goal)
    steps(world, 20)
    assert frames.get_position(sim, tip.handle) == pytest.approx(goal, abs=5e-3)
