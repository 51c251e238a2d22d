"""A finger presses a box against a fixed jaw: the box stays, and the finger presses with exactly its maximum force.

Fingers that press against each other, and cannot move past each other, do so with no more than their friction.
"""

import mujoco
import numpy as np
import pytest
from handler_calls import World

_STEP = 0.05

_MOTOR = "mode=force motor=on control=velocity rigid=yes cyclic=no max_force="

_GRIPPER = f"""
<mujoco>
  <option timestep="0.005" integrator="implicitfast" cone="elliptic" impratio="100" noslip_iterations="3"/>
  <default><geom friction="0.71 0.005 0.0001" solref="0.005 1"/></default>
  <worldbody>
    <body name="palm" pos="0 0 1" gravcomp="1">
      <joint name="tilt" type="hinge" axis="0 1 0"/>
      <geom type="box" size="0.06 0.03 0.01" mass="1" contype="0" conaffinity="0"/>
      <body name="finger" pos="-0.04 0 -0.2">
        <joint name="finger" type="slide" axis="1 0 0"/>
        <geom type="box" size="0.005 0.01 0.02" mass="0.05"/>
      </body>
      <geom name="jaw" type="box" size="0.005 0.01 0.02" pos="0.0301 0 -0.2" mass="0.05"/>
    </body>
    <body name="box" pos="0 0 0.8"><freejoint/><geom type="box" size="0.025 0.025 0.025" mass="0.2"/></body>
    <geom type="cylinder" size="0.01 0.1" pos="0 0 0.675"/>
  </worldbody>
  <custom>
    <text name="simx:joint:tilt" data="{_MOTOR}1000"/>
    <text name="simx:joint:finger" data="{_MOTOR}20 target_velocity=0.05"/>
  </custom>
</mujoco>
"""

_FINGER = """
<body name="{name}" pos="{place} 0 0">
  <joint name="{name}" type="hinge" axis="0 1 0"/>
  <geom type="sphere" size="0.005" mass="0.05" contype="0" conaffinity="0"/>
  <body pos="0 0 -0.1">
    <joint name="{name}_tip" type="hinge" axis="0 1 0"/>
    <geom type="box" size="0.005 0.01 0.02" mass="0.05"/>
  </body>
</body>"""

_CLOSED_FINGERS = f"""
<mujoco>
  <option timestep="0.005" integrator="implicitfast" cone="elliptic" impratio="100" noslip_iterations="3"/>
  <default><geom friction="0.71 0.005 0.0001" solref="0.005 1"/></default>
  <worldbody>
    <body pos="0 0 1">
      <joint name="sway" type="hinge" axis="0 0 1"/>
      <geom type="box" size="0.06 0.03 0.01" mass="1" contype="0" conaffinity="0"/>
      {_FINGER.format(name="left", place=-0.04)}
      {_FINGER.format(name="right", place=0.04)}
    </body>
  </worldbody>
  <custom>
    <text name="simx:joint:sway" data="{_MOTOR}1000"/>
    <text name="simx:joint:left" data="{_MOTOR}1 target_velocity=-0.5"/>
    <text name="simx:joint:right" data="{_MOTOR}1 target_velocity=0.5"/>
    <text name="simx:joint:left_tip" data="{_MOTOR}0.01"/>
    <text name="simx:joint:right_tip" data="{_MOTOR}0.01"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def gripper() -> World:
    """The gripper when it has closed on the box."""
    world = World(_GRIPPER)
    world.run(20)
    return world


def _step(world: World, seconds: float) -> None:
    for _ in range(round(seconds / _STEP)):
        world.parts.step()


def _place_in_hand(world: World) -> np.ndarray:
    palm, box = world.sim.data.body("palm"), world.sim.data.body("box")
    return palm.xmat.reshape(3, 3).T @ (box.xpos - palm.xpos)


def test_a_box_stays_in_the_hand_that_turns_upside_down(gripper):
    gripper.sim.joints.set_target_velocity(gripper.handle("tilt"), 1.0)
    _step(gripper, 0.2)  # it leaves its pedestal with a jerk
    at_first = _place_in_hand(gripper)
    _step(gripper, 3.0)
    assert np.linalg.norm(_place_in_hand(gripper) - at_first) < 1e-4


def test_a_box_stays_in_the_hand_for_30_seconds(gripper):
    gripper.sim.joints.set_target_velocity(gripper.handle("tilt"), 1.0)
    _step(gripper, 1.5)
    gripper.sim.joints.set_target_velocity(gripper.handle("tilt"), 0.0)
    _step(gripper, 0.5)
    at_first = _place_in_hand(gripper)
    _step(gripper, 30.0)
    assert np.linalg.norm(_place_in_hand(gripper) - at_first) < 1e-4


def test_a_stalled_finger_presses_with_exactly_its_maximum_force(gripper):
    joints, finger = gripper.sim.joints, gripper.handle("finger")
    forces = []
    for _ in range(round(5 / _STEP)):
        gripper.parts.step()
        forces.append(joints.force(finger))
    assert np.abs(forces) == pytest.approx(20.0, rel=1e-3)


def test_closed_fingers_press_with_no_more_than_their_friction_while_the_hand_sways():
    world = World(_CLOSED_FINGERS)
    world.run(20)
    model, data, sway = world.sim.model, world.sim.data, world.handle("sway")
    force = np.zeros(6)
    for number in range(100):
        world.sim.joints.set_target_velocity(sway, 2 * np.sin(number / 3))
        world.parts.step()
        assert data.ncon
        for index in range(data.ncon):
            mujoco.mj_contactForce(model, data, index, force)
            assert np.linalg.norm(force[1:3]) <= 0.72 * force[0] + 1e-6
    assert model.opt.noslip_iterations == 3
