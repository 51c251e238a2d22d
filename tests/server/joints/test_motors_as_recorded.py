"""Motors move as those of V-REP and CoppeliaSim, whose recorded data gave these laws.

* A position controller removes the part P of its error in each 5 ms, whatever the physics step.
* The reported force is that of the inverse dynamics, in motion too, and no motor acts with its maximum force in free
  motion.
* Wheels keep the commanded velocity under load; the robot turns by (right - left) radius / track.
* A stalled motor presses with exactly its maximum force.
"""

from __future__ import annotations

import copy
import math

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from scenes_for_tests import slider, world_of

from simx_server.world.world import World

LINKS = "".join(
    f"""<body name="link{number}" pos="0 0 {0.1 if number else 0.2}">
      <joint name="joint{number}" axis="{axis}"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.1" size="0.04" mass="{mass}" contype="0" conaffinity="0"/>"""
    for number, (axis, mass) in enumerate(
        zip(("0 0 1", "0 1 0") * 3 + ("0 0 1",), (4, 4, 3, 3, 2, 1, 0.5), strict=True)
    )
)
NOTE = "motor=on control=position P=0.1 max_force=87 upper_velocity=2"
SEVEN = f"""
<mujoco model="seven joints">
  <option timestep="{{timestep}}" integrator="implicitfast"/>
  <worldbody>{LINKS}{"</body>" * 7}</worldbody>
  <custom>
    <numeric name="simx:time_step" data="0.05"/>
    {"".join(f'<text name="simx:joint:joint{n}" data="{NOTE}"/>' for n in range(7))}
  </custom>
</mujoco>"""


def drive(world: World, command: NDArray[np.float64]) -> None:
    for joint, value in enumerate(command.tolist()):
        handle = world.simulation.scene.resolve(f"joint{joint}")
        world.simulation.joints.set_target_position(handle, value)


@pytest.mark.parametrize("timestep", [0.005, 0.0025])
def test_forces_of_a_moving_arm_are_those_of_the_inverse_dynamics(timestep: float) -> None:
    """All joints at up to 1 rad/s: the mean force of each simulation step within 3 % of the largest one."""
    world = world_of(SEVEN.format(timestep=timestep))
    sim = world.simulation
    start = np.array([0.3, 0.6, -0.4, 0.8, 0.2, -0.5, 0.1])
    speed = np.array([0.5, -0.8, 1.0, 0.7, -0.6, 0.9, 1.0])
    drive(world, start)
    sim.start()
    for _ in range(60):
        world.step()
    data = sim.data
    bare = copy.copy(sim.model)  # without motors, which are MuJoCo's friction loss
    bare.dof_frictionloss[:] = 0
    checked = mujoco.MjData(bare)
    errors: list[np.ndarray] = []
    largest = np.zeros(7)
    for number in range(25):
        drive(world, start + speed * 0.05 * (number + 1))
        wanted: list[np.ndarray] = []

        def compare(_index: int, _count: int, is_over: bool, wanted: list[np.ndarray] = wanted) -> None:
            if is_over:
                checked.qacc[:] = data.qacc
                mujoco.mj_inverse(bare, checked)
                wanted.append(checked.qfrc_inverse.copy())
            else:
                checked.qpos[:], checked.qvel[:] = data.qpos, data.qvel

        sim.joints.controllers.accompany(compare)
        world.step()
        reported = [-sim.joints.force(sim.scene.resolve(f"joint{n}")) for n in range(7)]
        errors.append(np.mean(wanted, axis=0) - reported)
        largest = np.maximum(largest, np.abs(reported))
    assert (np.abs(errors[2:]).max(axis=0) < 0.03 * largest + 0.01).all()
    assert (largest < 40).all()


@pytest.mark.parametrize("timestep", [0.005, 0.0025, 0.002, 0.001])
@pytest.mark.parametrize("p", [0.1, 0.035])
def test_a_position_controller_leaves_what_vreps_leaves(timestep: float, p: float) -> None:
    world = slider(note=f"motor=on control=position P={p} upper_velocity=10")
    sim = world.simulation
    sim.model.opt.timestep = timestep
    sim.set_physics_step(timestep)
    rail = sim.scene.resolve("rail")
    sim.joints.set_target_position(rail, 0.01)
    sim.start()
    world.step()
    left = (1 - p) ** 10
    assert 0.01 - sim.joints.position(rail) == pytest.approx(0.01 * left, rel=0.005)
    for number in range(100):
        sim.joints.set_target_position(rail, 0.01 + 0.002 * (number + 1))
        world.step()
    lag = sim.joints.target_position(rail) - sim.joints.position(rail)
    assert lag == pytest.approx(0.002 * left / (1 - left), rel=0.005)


def test_a_velocity_motor_follows_a_sine_to_the_last_step() -> None:
    world = slider(
        note="motor=on control=velocity max_force=100", kind="hinge", gravity="0 0 -9.81", offset=0.3
    )
    sim = world.simulation
    rail = sim.scene.resolve("rail")
    sim.start()
    for number in range(80):
        command = 2 * math.sin(0.1 * number)
        sim.joints.set_target_velocity(rail, command)
        world.step()
        assert sim.joints.velocity(rail) == pytest.approx(command, abs=1e-3)


DRIVE = """
<mujoco model="differential drive">
  <option timestep="0.005" integrator="implicitfast" cone="elliptic" impratio="10" noslip_iterations="3"/>
  <worldbody>
    <geom type="plane" size="50 50 1" friction="1 0.005 0.0001" solref="0.005 1"/>
    <body name="robot" pos="0 0 0.0975"><freejoint/>
      <geom type="box" size="0.2 0.12 0.05" pos="-0.05 0 0.06" mass="9" contype="0" conaffinity="0"/>
      <geom type="sphere" size="0.04" pos="-0.22 0 -0.0575" mass="0.3" condim="1" priority="1" solref="0.005 1"/>
      <body name="left wheel" pos="0 0.1655 0"><joint name="left" axis="0 1 0"/>
        <geom type="ellipsoid" size="0.0975 0.0975 0.025" zaxis="0 1 0" mass="1.5" solref="0.005 1"/></body>
      <body name="right wheel" pos="0 -0.1655 0"><joint name="right" axis="0 1 0"/>
        <geom type="ellipsoid" size="0.0975 0.0975 0.025" zaxis="0 1 0" mass="1.5" solref="0.005 1"/></body>
    </body>
  </worldbody>
  <custom>
    <numeric name="simx:time_step" data="0.05"/>
    <text name="simx:joint:left" data="motor=on control=velocity max_force=3"/>
    <text name="simx:joint:right" data="motor=on control=velocity max_force=3"/>
  </custom>
</mujoco>"""


def test_wheels_keep_their_velocity_and_turn_the_robot_by_their_difference() -> None:
    world = world_of(DRIVE)
    sim = world.simulation
    left, right = (sim.scene.resolve(name) for name in ("left", "right"))
    sim.start()
    for speeds in ((2.0, 2.0), (0.6411, 0.7171), (1.4, 1.05), (2.0, 1.1)):
        rates: list[float] = []
        for handle, speed in zip((left, right), speeds, strict=True):
            sim.joints.set_target_velocity(handle, speed)
        for number in range(60):
            world.step()
            if number >= 20:
                rates.append(float(sim.data.qvel[5]))
                found = [sim.joints.velocity(handle) for handle in (left, right)]
                assert found == pytest.approx(speeds, rel=1e-3)
        assert np.mean(rates) == pytest.approx((speeds[1] - speeds[0]) * 0.0975 / 0.331, rel=0.03, abs=1e-3)


def test_a_drive_of_30_seconds_ends_where_the_wheels_lead() -> None:
    world = world_of(DRIVE)
    sim = world.simulation
    left, right = (sim.scene.resolve(name) for name in ("left", "right"))
    x = y = heading = 0.0
    sim.start()
    for number in range(600):
        speeds = (1.5 + 0.5 * math.sin(0.02 * number), 1.5 - 0.3 * math.sin(0.013 * number))
        sim.joints.set_target_velocity(left, speeds[0])
        sim.joints.set_target_velocity(right, speeds[1])
        world.step()
        turn = (speeds[1] - speeds[0]) * 0.0975 / 0.331 * 0.05
        way = sum(speeds) / 2 * 0.0975 * 0.05
        x, y = x + way * math.cos(heading + turn / 2), y + way * math.sin(heading + turn / 2)
        heading += turn
    assert math.dist(sim.data.qpos[:2], (x, y)) < 0.02


def test_a_gripper_stalls_on_a_block_with_exactly_its_force() -> None:
    world = world_of(
        """
<mujoco model="press">
  <option timestep="0.005" cone="elliptic" impratio="10" noslip_iterations="3" gravity="0 0 0"/>
  <worldbody>
    <geom type="box" size="0.02 0.1 0.1" solref="0.005 1"/>
    <body name="finger" pos="0.06 0 0"><joint name="close" type="slide" axis="-1 0 0"/>
      <geom type="box" size="0.005 0.01 0.03" mass="0.05" solref="0.005 1"/></body>
  </worldbody>
  <custom>
    <numeric name="simx:time_step" data="0.05"/>
    <text name="simx:joint:close" data="motor=on control=velocity max_force=20 target_velocity=0.05"/>
  </custom>
</mujoco>"""
    )
    sim = world.simulation
    close = sim.scene.resolve("close")
    sim.start()
    forces: list[float] = []
    for number in range(260):
        world.step()
        if number >= 60:
            forces.append(-sim.joints.force(close))
    assert np.mean(forces) == pytest.approx(20, rel=1e-3)
    assert np.std(forces) < 0.01 * 20
