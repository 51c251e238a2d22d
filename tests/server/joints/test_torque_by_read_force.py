"""Torque control that takes the direction from the force it reads, on a two-link arm in steps of 1 ms.

Public programs do it so: V-REP's remote API has no torque command, and `simxGetJointForce` gives the reverse of what
the motor applies. They turn the wanted torques round, and reverse a motor whose force has another sign than that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from real_world import BLOCKING, RealWorld, handle_of, start_stepped

import simx_client as vrep

pytestmark = pytest.mark.slow

ONESHOT = vrep.simx_opmode_oneshot
FIRST, SECOND = 0.42, 0.225
MASS = (1.2, 0.7)
TIME_STEP = 0.001
FAST = 10000.0
STRONGEST = 20.0

SCENE = f"""
<mujoco model="two_links">
  <option timestep="{TIME_STEP}" integrator="implicitfast"/>
  <worldbody>
    <body name="stand">
      <geom type="box" size="0.05 0.05 0.05"/>
      <body pos="0 0 0.2">
        <joint name="joint0" axis="0 0 1"/>
        <geom type="capsule" fromto="0 0 0 {FIRST} 0 0" size="0.02" mass="{MASS[0]}"/>
        <body pos="{FIRST} 0 0">
          <joint name="joint1" axis="0 0 1"/>
          <geom type="capsule" fromto="0 0 0 {SECOND} 0 0" size="0.02" mass="{MASS[1]}"/>
          <site name="hand" pos="{SECOND} 0 0"/>
        </body>
      </body>
    </body>
    <site name="target" pos="0.3 0.42 0.2"/>
  </worldbody>
</mujoco>
"""

Read = Callable[[int, int], float]
"""The force of a joint as a program reads it: client, handle."""


@pytest.fixture
def client(tmp_path: Path) -> Iterator[int]:
    (tmp_path / "scene.xml").write_text(SCENE, encoding="utf-8")
    world = RealWorld(tmp_path / "scene.xml")
    try:
        yield world.client()
    finally:
        world.close()


def read_force(client: int, joint: int) -> float:
    return vrep.simxGetJointForce(client, joint, BLOCKING)[1]


def jacobian(q: np.ndarray) -> np.ndarray:
    """Of the hand, in the plane."""
    both = q[0] + q[1]
    inner = SECOND * np.array([-math.sin(both), math.cos(both)])
    outer = FIRST * np.array([-math.sin(q[0]), math.cos(q[0])])
    return np.column_stack([outer + inner, inner])


def inertia(q: np.ndarray) -> np.ndarray:
    """Of the joints: thin rods."""
    (m1, m2), bend = MASS, math.cos(q[1])
    own = m2 * SECOND**2 / 3
    mixed = own + m2 * FIRST * SECOND / 2 * bend
    return np.array([[m1 * FIRST**2 / 3 + m2 * FIRST**2 + 2 * mixed - own, mixed], [mixed, own]])


def torques(q: np.ndarray, dq: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Operational-space control: the hand is drawn to the target, the joints are damped."""
    j, m = jacobian(q), inertia(q)
    hand_inertia = np.linalg.inv(j @ np.linalg.inv(m) @ j.T)
    return np.clip(j.T @ hand_inertia @ (400.0 * error) - m @ (40.0 * dq), -STRONGEST, STRONGEST)


def reach(client: int, steps: int, read: Read) -> list[float]:
    """How far from the target the hand is after each step, in metres."""
    joints = [handle_of(client, name) for name in ("joint0", "joint1")]
    hand, target = handle_of(client, "hand"), handle_of(client, "target")
    vrep.simxSetFloatingParameter(client, vrep.sim_floatparam_simulation_time_step, TIME_STEP, BLOCKING)
    for joint, angle in zip(joints, (0.3, 0.8), strict=True):
        vrep.simxSetJointPosition(client, joint, angle, BLOCKING)
    speeds = [FAST, FAST]
    for joint, speed in zip(joints, speeds, strict=True):
        vrep.simxSetJointTargetVelocity(client, joint, speed, ONESHOT)
        vrep.simxSetJointForce(client, joint, 0.0, ONESHOT)
    start_stepped(client)
    distances: list[float] = []
    for _ in range(steps):
        q = np.array([vrep.simxGetJointPosition(client, joint, BLOCKING)[1] for joint in joints])
        dq = np.array(
            [vrep.simxGetObjectFloatParameter(client, joint, 2012, BLOCKING)[1] for joint in joints]
        )
        at, goal = (
            np.array(vrep.simxGetObjectPosition(client, each, -1, BLOCKING)[1][:2]) for each in (hand, target)
        )
        distances.append(float(np.linalg.norm(goal - at)))
        wanted = -torques(q, dq, goal - at)
        for index, joint in enumerate(joints):
            if np.sign(read(client, joint)) * np.sign(wanted[index]) <= 0:
                speeds[index] = -speeds[index]
                vrep.simxSetJointTargetVelocity(client, joint, speeds[index], ONESHOT)
            vrep.simxSetJointForce(client, joint, abs(wanted[index]), ONESHOT)
        assert vrep.simxSynchronousTrigger(client) == vrep.simx_return_ok
    return distances


def test_the_hand_reaches_its_target_by_the_sign_of_the_force_read(client: int) -> None:
    distances = reach(client, 600, read_force)
    assert distances[0] > 0.2
    assert max(distances[-50:]) < 0.01


def test_the_other_sign_drives_the_hand_away(client: int) -> None:
    distances = reach(client, 300, lambda *joint: -read_force(*joint))
    assert max(distances) > 3 * distances[0]
