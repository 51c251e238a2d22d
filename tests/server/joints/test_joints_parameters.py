"""Joint parameters by number as a client asks for them: intrinsic frames, errors, a spherical joint's quaternion."""

from __future__ import annotations

import math

import pytest
from handler_calls import World

from simx_server.errors import CommandError

SCENE = """<mujoco><option integrator="implicitfast"/><worldbody>
  <body name="arm" pos="0 0 1"><joint name="slide" type="slide" axis="1 0 0"/><joint name="turn" axis="0 0 1"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1"/>
    <body name="hand" pos="0.3 0 0"><joint name="wrist" axis="0 1 0"/><geom size="0.02" mass="0.2" pos="0.1 0 0"/>
    </body></body>
  <body name="hip" pos="2 0 1"><joint name="socket" type="ball"/><geom size="0.1" mass="1"/></body>
  </worldbody></mujoco>"""


@pytest.fixture
def world() -> World:
    return World(SCENE)


def read(world: World, name: str, *numbers: int) -> list[float]:
    return [world.call("simxGetObjectFloatParameter", world.handle(name), number) for number in numbers]


def test_intrinsic_frame_is_what_the_value_does(world: World) -> None:
    world.call("simxSetJointPosition", world.handle("slide"), 0.25)
    world.call("simxSetJointPosition", world.handle("turn"), math.pi / 2)
    half = math.sqrt(0.5)
    assert read(world, "slide", *range(2005, 2012)) == pytest.approx([0, 0, 0.25, 0, 0, 0, 1])
    assert read(world, "turn", *range(2005, 2012)) == pytest.approx([0, 0, 0, 0, 0, half, half])
    with pytest.raises(CommandError, match="cannot be set"):
        world.call("simxSetObjectFloatParameter", world.handle("turn"), 2005, 1.0)


def test_spherical_quaternion_acts_when_its_w_is_written(world: World) -> None:
    socket = world.handle("socket")
    for number, value in ((2013, 0.0), (2014, 0.0), (2015, 2.0)):
        world.call("simxSetObjectFloatParameter", socket, number, value)
    assert read(world, "socket", *range(2008, 2012)) == [0, 0, 0, 1]
    world.call("simxSetObjectFloatParameter", socket, 2016, 2.0)
    half = math.sqrt(0.5)
    assert read(world, "socket", *range(2008, 2012)) == pytest.approx([0, 0, half, half])
    with pytest.raises(CommandError, match="cannot be read"):
        read(world, "socket", 2016)
    with pytest.raises(CommandError, match="not spherical"):
        world.call("simxSetObjectFloatParameter", world.handle("turn"), 2013, 1.0)
    for number in (2013, 2014, 2015):
        world.call("simxSetObjectFloatParameter", socket, number, 0.0)
    with pytest.raises(CommandError, match="length 0"):
        world.call("simxSetObjectFloatParameter", socket, 2016, 0.0)


def test_joints_do_not_come_apart_under_load(world: World) -> None:
    world.run(20)
    assert abs(read(world, "wrist", 2010)[0]) < 1
    for name in ("slide", "turn", "wrist", "socket"):
        joint = world.sim.scene.resolve(name)
        if name != "slide":  # its body turns about the next joint too
            assert read(world, name, *range(2022, 2030)) == pytest.approx([0.0] * 8, abs=1e-7), joint


def test_the_weight_in_inverse_kinematics_is_a_setting(world: World) -> None:
    assert read(world, "turn", 2021) == [1.0]
    world.call("simxSetObjectFloatParameter", world.handle("turn"), 2021, 0.5)
    assert read(world, "turn", 2021) == [0.5]
    with pytest.raises(CommandError, match="weight in inverse kinematics must not be below 0"):
        world.call("simxSetObjectFloatParameter", world.handle("turn"), 2021, -0.5)


def test_parameters_of_a_single_value_refuse_spherical_joints(world: World) -> None:
    for number in (2000, 2001, 2030, 2031, 2039):
        with pytest.raises(CommandError, match="spherical"):
            world.call("simxGetObjectIntParameter", world.handle("socket"), number)
    for number in (2002, 2012, 2017, 2018):
        with pytest.raises(CommandError, match="spherical"):
            read(world, "socket", number)


def test_measured_velocity_is_that_of_the_last_step(world: World) -> None:
    world.call("simxSetObjectIntParameter", world.handle("turn"), 2000, 1)
    world.call("simxSetJointTargetVelocity", world.handle("turn"), 0.5)
    world.run(10)
    assert read(world, "turn", 2012) == pytest.approx([0.5], abs=0.02)
    with pytest.raises(CommandError, match="use the Float command"):
        world.call("simxGetObjectIntParameter", world.handle("turn"), 2012)
