"""Contacts of imported scenes: wheels, links of one robot that touch, the ground, light loops."""

from __future__ import annotations

import math

import mujoco
import pytest
from handler_calls import QuickPainter, World
from vrep_samples import sample, world_of
from vrep_writer import VrepWriter

from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.reading import read_file

FLAT = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""Turns z to -y: the axle of a wheel beside a robot that faces x."""


def world_with(writer: VrepWriter) -> World:
    spec, _ = convert(read_file(writer.bytes(), "scene.ttt"))
    world = World(painter=QuickPainter())
    world.sim.use(*build(spec, None))
    return world


def colliding(model: mujoco.MjModel, body: str) -> list[int]:
    start, count = model.body(body).geomadr[0], model.body(body).geomnum[0]
    return [
        int(model.geom_type[geom])
        for geom in range(start, start + count)
        if model.geom_contype[geom] or model.geom_conaffinity[geom]
    ]


def floor(writer: VrepWriter) -> None:
    writer.shape("floor", cuboid=(4, 4, 0.1), respondable=True, position=(0, 0, -0.05))
    writer.settings(time_step=0.05)


@pytest.mark.parametrize(
    ("size", "quat", "form"),
    [
        ((0.2, 0.2, 0.05), FLAT, mujoco.mjtGeom.mjGEOM_ELLIPSOID),
        ((0.2, 0.2, 0.5), FLAT, mujoco.mjtGeom.mjGEOM_CYLINDER),
        ((0.2, 0.2, 0.05), (1.0, 0.0, 0.0, 0.0), mujoco.mjtGeom.mjGEOM_CYLINDER),
    ],
    ids=["a wheel", "a roller", "a turntable"],
)
def test_a_cylinder_that_turns_about_a_level_axle_rolls_on_one_point(
    size: tuple[float, float, float], quat: tuple[float, float, float, float], form: mujoco.mjtGeom
) -> None:
    writer = VrepWriter(25)
    base = writer.shape("base", cuboid=(0.3, 0.2, 0.1), dynamic=True, respondable=True, position=(0, 0, 0.5))
    joint = writer.joint("axle", parent=base, motor=True, position=(0, 0.3, 0), quaternion=quat)
    writer.shape("wheel", parent=joint, cylinder=size, dynamic=True, respondable=True)
    model = world_with(writer).sim.model
    assert colliding(model, "wheel") == [form]


def test_links_that_touch_in_the_file_do_not_brake_each_other() -> None:
    """The tops of the wheels touch the body above them, which V-REP does not mind: they turn, and the robot drives."""
    writer = VrepWriter(25)
    floor(writer)
    base = writer.shape(
        "base", cuboid=(0.3, 0.3, 0.1), dynamic=True, respondable=True, mass=1.0, position=(0, 0, 0.15)
    )
    for number, (x, y) in enumerate(((-0.1, -0.1), (-0.1, 0.1), (0.1, -0.1), (0.1, 0.1))):
        fork = writer.joint(f"fork{number}", parent=base, motor=True, lock=True, position=(x, y, -0.05))
        crown = writer.shape(f"crown{number}", parent=fork, cuboid=(0.01, 0.01, 0.01), dynamic=True, mass=0.1)
        axle = writer.joint(
            f"axle{number}", parent=crown, motor=True, limits=None, position=(0, 0, -0.05), quaternion=FLAT
        )
        writer.shape(
            f"wheel{number}", parent=axle, cylinder=(0.1, 0.1, 0.05), dynamic=True, respondable=True, mass=0.4
        )
    world = world_with(writer)
    assert world.sim.model.npair == 4
    for number in range(4):
        world.call("simxSetJointTargetVelocity", world.handle(f"axle{number}"), 1.0)
    world.run(20)
    before = world.call("simxGetObjectPosition", world.handle("base"), -1)[0]
    world.run(40)
    speed = (world.call("simxGetObjectPosition", world.handle("base"), -1)[0] - before) / 2
    assert abs(speed) == pytest.approx(0.05, rel=0.02)


def test_a_wheel_of_a_sample_drives_at_its_commanded_velocity() -> None:
    """One radian per second on wheels of 50 mm: 0.05 m/s. Its third wheel touches the body at a gap of 0."""
    world = world_of(sample("Mobile_robots.ttt"))
    wheels = [world.handle(name) for name in ("Left_drive", "Right_drive")]
    for wheel in wheels:
        world.call("simxSetJointTargetVelocity", wheel, 1.0)
    world.call("simxSetJointTargetPosition", world.handle("Steering_drive"), 0.0)
    world.run(40)
    before = world.call("simxGetObjectPosition", world.handle("Robot"), -1)
    world.run(40)
    after = world.call("simxGetObjectPosition", world.handle("Robot"), -1)
    assert math.dist(before, after) / 2 == pytest.approx(0.05, rel=0.01)
    assert [world.call("simxGetJointForce", wheel) for wheel in wheels] == pytest.approx([0, 0], abs=0.1)


@pytest.mark.parametrize("speed", [5.0, 100.0, 300.0])
def test_nothing_falls_through_the_floor_however_fast(speed: float) -> None:
    writer = VrepWriter(25)
    floor(writer)
    writer.shape("ball", spheroid=(0.1, 0.1, 0.1), dynamic=True, respondable=True, position=(0, 0, 3))
    world = world_with(writer)
    world.sim.start()
    dof = int(world.sim.model.body("ball").dofadr[0])
    world.sim.data.qvel[dof + 2] = -speed
    world.run(400)
    assert world.call("simxGetObjectPosition", world.handle("ball"), -1)[2] > 0.04


def test_a_floor_with_something_below_it_stays_as_thin_as_it_is() -> None:
    writer = VrepWriter(25)
    floor(writer)
    writer.shape("cellar", cuboid=(1, 1, 1), respondable=True, position=(0, 0, -2))
    model = world_with(writer).sim.model
    assert model.geom_size[model.body("floor").geomadr[0], 2] == pytest.approx(0.05)
