"""Friction and bounce of imported shapes, in numbers and in motion."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from vrep_shapes import box_leaf, compiled, converted, file_of, material, settled, shape_of

from simx_server.scene.formats.vrep.conversion.geometry.surfaces import Surfaces, bouncing
from simx_server.scene.formats.vrep.objects import Engine, Leaf, Primitive, Settings, Shape, Surface, VrepFile
from simx_server.scene.poses.poses import Pose, about


def ground(friction: float, restitution: float = 0.0, **parts: Any) -> Shape:
    return shape_of(
        box_leaf((5.0, 5.0, 0.1)),
        handle=1,
        pose=((0.0, 0.0, -0.05), (1.0, 0.0, 0.0, 0.0)),
        is_respondable=True,
        surface=material(friction, restitution, **parts),
    )


def thing(
    friction: float, restitution: float = 0.0, *, pose: Pose, leaf: Leaf | None = None, **parts: Any
) -> Shape:
    return shape_of(
        leaf or box_leaf((0.2, 0.2, 0.1)),
        handle=2,
        pose=pose,
        is_respondable=True,
        is_dynamic=True,
        mass=1.0,
        inertia=(0.004, 0.004, 0.006),
        surface=material(friction, restitution, **parts),
    )


def slides(friction_of_ground: float, friction: float, slope: float) -> bool:
    """Whether a block slides down the ground when gravity is turned by a slope's angle."""
    file = file_of(ground(friction_of_ground), thing(friction, pose=((0.0, 0.0, 0.05), (1.0, 0.0, 0.0, 0.0))))
    model = compiled(file)
    model.opt.gravity[:] = 9.81 * math.sin(slope), 0, -9.81 * math.cos(slope)
    model.opt.impratio, model.opt.noslip_iterations = 10, 3
    return float(settled(model, 1.0).qpos[0]) > 0.02


@pytest.mark.parametrize(("a", "b"), [(1.0, 0.71), (0.71, 0.71), (0.5, 1.0), (0.9, 0.4), (1.0, 1.0)])
def test_friction_with_the_ground_is_the_product(a: float, b: float) -> None:
    angle = math.atan(a * b)
    assert not slides(a, b, angle * 0.9)
    assert slides(a, b, angle * 1.1)


def test_slippery_caster_stays_slippery_on_any_ground_and_does_not_creep() -> None:
    assert slides(1.0, 0.0, 0.02)
    file = file_of(ground(1.0), thing(0.0, pose=((0.0, 0.0, 0.05), (1.0, 0.0, 0.0, 0.0))))
    assert np.abs(settled(compiled(file), 3.0).qvel).max() < 1e-3


def of_two(first: float, second: float) -> tuple[float, bool]:
    """The friction that MuJoCo takes between two shapes on a ground of friction 1; whether the first's counts."""
    surfaces = Surfaces(Engine.BULLET, (1.0, 0.0))
    a, b = (surfaces.contact_of(shape_of(surface=material(each))) for each in (first, second))
    if a.priority == b.priority:
        return max(a.friction[0], b.friction[0]), a.friction[0] >= b.friction[0]
    return (a if a.priority > b.priority else b).friction[0], a.priority > b.priority


def test_between_two_things_the_one_that_differs_more_from_the_ground_decides() -> None:
    assert of_two(0.0, 0.5) == (0.0, True)
    assert of_two(0.71, 1.0) == (pytest.approx(0.71), True)
    assert of_two(0.9, 2.0) == (pytest.approx(2.0), False)
    assert of_two(100.0, 1.0) == (10.0, True)  # Bullet's own limit


@pytest.mark.parametrize("engine", [Engine.ODE, Engine.NEWTON, Engine.VORTEX])
def test_friction_is_that_of_the_engine_of_the_scene(engine: Engine) -> None:
    surface = material(0.9)
    surface.engines |= material(0.2, engine=engine).engines
    shape = shape_of(surface=surface)
    assert Surfaces(engine, (1.0, 0.0)).contact_of(shape).friction[0] == pytest.approx(0.2)
    assert Surfaces(Engine.BULLET, (1.0, 0.0)).contact_of(shape).friction[0] == pytest.approx(0.9)


def test_bullet_of_version_2_83_has_its_own_friction() -> None:
    surface = Surface(engines={Engine.BULLET: ([0.0, 1.0, 0.5], [])})
    shape = shape_of(surface=surface)
    assert Surfaces(Engine.BULLET, (1.0, 0.0)).contact_of(shape).friction[0] == pytest.approx(1.0)
    newer = Surfaces(Engine.BULLET, (1.0, 0.0), has_newer_bullet=True)
    assert newer.contact_of(shape).friction[0] == pytest.approx(0.5)


def test_what_an_engine_lacks_is_taken_from_bullet_and_else_from_the_default_material() -> None:
    surfaces = Surfaces(Engine.ODE, (1.0, 0.0))
    assert surfaces.contact_of(shape_of(surface=material(0.3))).friction[0] == pytest.approx(0.3)
    assert surfaces.contact_of(shape_of()).friction[0] == pytest.approx(0.71)
    broken = Surface(engines={Engine.ODE: ([math.nan], [])})
    assert surfaces.contact_of(shape_of(surface=broken)).friction[0] == pytest.approx(0.71)


def of_mujoco(**changes: Any) -> Surface:
    reals = [0.9, 0.01, 0.001, 0.03, 0.8, 0.8, 0.9, 0.002, 0.4, 3.0, 2.0, 0.001]
    for place, value in changes.get("reals", {}).items():
        reals[place] = value
    return Surface(engines={Engine.MUJOCO: (reals, changes.get("wholes", [4, 2, 0]))})


def test_parameters_of_mujoco_itself_are_kept() -> None:
    settings = Settings(engine=Engine.MUJOCO)
    shape = shape_of(box_leaf(), is_respondable=True, surface=of_mujoco())
    geom = converted(file_of(shape, settings=settings)).spec.geoms[0]
    assert geom.friction == pytest.approx([0.9, 0.01, 0.001])
    assert geom.solref == pytest.approx([0.03, 0.8])
    assert geom.solimp == pytest.approx([0.8, 0.9, 0.002, 0.4, 3.0])
    assert (geom.condim, geom.priority, geom.solmix, geom.margin) == (4, 2, 2.0, 0.001)


@pytest.mark.parametrize(
    "changes",
    [
        {"reals": {0: -1.0}},
        {"reals": {3: -0.1}},
        {"reals": {5: 1.5}},
        {"reals": {9: 0.5}},
        {"reals": {2: math.inf}},
        {"wholes": [5, 0]},
        {"wholes": [3, -1]},
        {"wholes": []},
    ],
)
def test_parameters_that_mujoco_refuses_are_not_taken(changes: dict[str, Any]) -> None:
    settings = Settings(engine=Engine.MUJOCO)
    shape = shape_of(box_leaf(), is_respondable=True, surface=of_mujoco(**changes))
    model = compiled(file_of(shape, settings=settings))
    assert model.geom_friction[0, 0] == pytest.approx(0.71 * 0.71)
    assert model.geom_condim[0] == 3


def returned(file: VrepFile) -> float:
    """The share of its speed that the second shape has after it hit the first."""
    model = compiled(file)
    model.opt.timestep, model.opt.integrator = 0.002, int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    data = mujoco.MjData(model)
    speeds = []
    for _ in range(400):
        mujoco.mj_step(model, data)
        speeds.append(float(data.qvel[2]))
    return -max(speeds) / min(speeds)


@pytest.mark.parametrize(("own", "floor"), [(0.8, 1.0), (1.0, 0.5), (0.9, 0.9)])
def test_ball_bounces_with_the_product_of_the_restitutions(own: float, floor: float) -> None:
    ball = Leaf(primitive=Primitive.SPHEROID, size=(0.1, 0.1, 0.1))
    at = ((0.0, 0.0, 0.4), about((1.0, 0.0, 0.0), 0.0))
    assert returned(file_of(ground(1.0, floor), thing(1.0, own, pose=at, leaf=ball))) == pytest.approx(
        own * floor, abs=0.06
    )


def test_thing_without_restitution_does_not_bounce_on_an_elastic_floor() -> None:
    ball = Leaf(primitive=Primitive.SPHEROID, size=(0.1, 0.1, 0.1))
    at = ((0.0, 0.0, 0.4), about((1.0, 0.0, 0.0), 0.0))
    assert returned(file_of(ground(1.0, 0.5), thing(1.0, 0.0, pose=at, leaf=ball))) < 0.2


def test_contacts_without_bounce_are_critically_damped() -> None:
    assert bouncing(0.0) == bouncing(0.1) == (0.005, 1.0)
    times, damping = zip(*(bouncing(each) for each in (0.2, 0.5, 0.9)), strict=True)
    assert list(times) == sorted(times)
    assert list(damping) == sorted(damping, reverse=True)
