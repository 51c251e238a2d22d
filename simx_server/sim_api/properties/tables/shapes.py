"""Properties of shapes: what physics does with them, mass and inertia, friction, colours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.editing import shape_looks
from simx_server.errors import CommandError
from simx_server.handlers.objects import poses, shape_properties
from simx_server.parts import physics_engine_parameters, shape_colors
from simx_server.scene.editing import editing
from simx_server.scene.geometry import inertia
from simx_server.scene.poses.frames import xyzw_from_wxyz
from simx_server.sim_api.properties.entry import Property
from simx_server.sim_api.properties.property_types import (
    BOOL,
    COLOR,
    FLOAT,
    FLOAT_ARRAY,
    HANDLE_ARRAY,
    INT,
    INT_ARRAY,
    QUATERNION,
    VECTOR3,
    PropertyType,
)

if TYPE_CHECKING:
    from simx_server.world.world import World


def _set_dynamic(world: World, handle: int, dynamic: bool) -> None:
    editing.set_static(world.simulation, handle, not dynamic)
    world.object_settings.apply_masks()


def _set_respondable(world: World, handle: int, respondable: bool) -> None:
    shape_properties.set_respondable(world.simulation, handle, respondable)
    world.object_settings.apply_masks()


def _first_velocity(name: str, start: int) -> Property:
    def get(world: World, handle: int) -> list[float]:
        return list(world.object_settings.first_velocity(handle)[start : start + 3])

    def put(world: World, handle: int, value: list[float]) -> None:
        for place, each in enumerate(value, start):
            world.object_settings.set_first_velocity(handle, place, each)

    return Property(name, VECTOR3, get, put)


_BEHAVIOUR = (
    Property(
        "dynamic",
        BOOL,
        lambda world, handle: not shape_properties.is_static(world.simulation, handle),
        _set_dynamic,
    ),
    Property(
        "respondable",
        BOOL,
        lambda world, handle: shape_properties.is_respondable(world.simulation, handle),
        _set_respondable,
    ),
    Property(
        "respondableMask",
        INT,
        lambda world, handle: world.object_settings.mask(handle),
        lambda world, handle, mask: world.object_settings.set_mask(handle, mask),
    ),
    _first_velocity("initLinearVelocity", 0),
    _first_velocity("initAngularVelocity", 3),
    Property("dynLinearVelocity", VECTOR3, lambda world, handle: poses.get_velocity(world, handle)[0]),
    Property("dynAngularVelocity", VECTOR3, lambda world, handle: poses.get_velocity(world, handle)[1]),
    Property("compound", BOOL, lambda world, handle: shape_properties.is_compound(world.simulation, handle)),
    Property("primitive", BOOL, lambda world, handle: shape_looks.pure_type(world, handle)[0] != 0),
    Property("convex", BOOL, lambda world, handle: shape_looks.is_convex(world, handle)),
)


def _change_inertia(
    world: World, handle: int, *, moments: list[float] | None = None, centre: list[float] | None = None
) -> None:
    mass, present, middle = inertia.get_inertia(world.simulation, handle)
    if moments is not None:
        if len(moments) != 9:
            raise CommandError(f"an inertia matrix is 9 numbers, row by row, not {len(moments)}")
        present = np.array(moments).reshape(3, 3)
    if centre is not None:
        middle = np.array(centre)
    inertia.set_inertia(world.simulation, handle, mass, present, middle)


def _principal(world: World, handle: int) -> tuple[list[float], list[float]]:
    """Return the principal moments, and the rotation of their axes in the shape's frame (x, y, z, w)."""
    _, moments, _ = inertia.get_inertia(world.simulation, handle)
    values, axes = np.linalg.eigh((moments + moments.T) / 2)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, axes.ravel())
    w, x, y, z = quat.tolist()
    return values.tolist(), list(xyzw_from_wxyz((w, x, y, z)))


_MASS = (
    Property(
        "mass",
        FLOAT,
        lambda world, handle: shape_properties.get_mass(world.simulation, handle),
        lambda world, handle, mass: shape_properties.set_mass(world.simulation, handle, mass),
    ),
    Property(
        "inertia",
        FLOAT_ARRAY,
        lambda world, handle: inertia.get_inertia(world.simulation, handle)[1].ravel().tolist(),
        lambda world, handle, moments: _change_inertia(world, handle, moments=moments),
    ),
    Property(
        "centerOfMass",
        VECTOR3,
        lambda world, handle: inertia.get_inertia(world.simulation, handle)[2].tolist(),
        lambda world, handle, centre: _change_inertia(world, handle, centre=centre),
    ),
    Property("principalMomentOfInertia", FLOAT_ARRAY, lambda world, handle: _principal(world, handle)[0]),
    Property("pmiQuaternion", QUATERNION, lambda world, handle: _principal(world, handle)[1]),
)
"""Inertia is about the centre of mass, along the axes of the shape's frame, kg m^2."""


def _engine(name: str, numbers: Sequence[int], type_: PropertyType) -> Property:
    """Return the property for parameters of the physics engine, several of them as a table."""
    entries = [physics_engine_parameters.PARAMETERS[number] for number in numbers]
    is_table = type_ in (FLOAT_ARRAY, VECTOR3)

    def get(world: World, handle: int) -> Any:
        found = [entry.get(world.simulation, handle) for entry in entries]
        return found if is_table else int(found[0]) if type_ is INT else found[0]

    def put(world: World, handle: int, value: Any) -> None:
        values = value if is_table else [value]
        if len(values) != len(entries):
            raise CommandError(f"'{name}' has {len(entries)} numbers, not {len(values)}")
        for entry, each in zip(entries, values, strict=True):
            assert entry.set is not None
            entry.set(world.simulation, handle, each)

    return Property(name, type_, get, put)


_CONTACTS = (
    _engine("bullet.friction", [6003], FLOAT),
    _engine("bullet.frictionOld", [6002], FLOAT),
    _engine("ode.friction", [15001], FLOAT),
    _engine("vortex.linearPrimaryAxisFrictionValue", [24001], FLOAT),
    _engine("vortex.linearSecondaryAxisFrictionValue", [24002], FLOAT),
    _engine("newton.staticFriction", [33001], FLOAT),
    _engine("newton.kineticFriction", [33002], FLOAT),
    _engine("mujoco.friction", range(43001, 43004), FLOAT_ARRAY),
    _engine("mujoco.solref", range(43004, 43006), FLOAT_ARRAY),
    _engine("mujoco.solimp", range(43006, 43011), FLOAT_ARRAY),
    _engine("mujoco.solmix", [43011], FLOAT),
    _engine("mujoco.margin", [43012], FLOAT),
    _engine("mujoco.condim", [44001], INT),
    _engine("mujoco.priority", [44002], INT),
)
"""The frictions of all engines are MuJoCo's sliding friction, as for sim.setEngineFloatParam."""

ENGINE = (
    _engine("mujoco.impratio", [37002], FLOAT),
    _engine("mujoco.wind", range(37003, 37006), VECTOR3),
    _engine("mujoco.density", [37006], FLOAT),
    _engine("mujoco.viscosity", [37007], FLOAT),
    _engine("mujoco.iterations", [38002], INT),
)
"""Options of the whole engine: properties of the scene."""


def _paint(name: str, component: int) -> Property:
    def put(world: World, handle: int, color: list[float]) -> None:
        world.shape_colors.set(handle, component, color)

    return Property(name, COLOR, None, put)


_COLORS = (
    _paint("applyColor.diffuse", shape_colors.DIFFUSE),
    _paint("applyColor.specular", shape_colors.SPECULAR),
    _paint("applyColor.emission", shape_colors.EMISSION),
    Property(
        "applyColor.transparency",
        FLOAT,
        None,
        lambda world, handle, share: world.shape_colors.set(handle, shape_colors.TRANSPARENCY, [share]),
    ),
)
"""Colours of all parts of a shape, which CoppeliaSim can only set by these names; sim.getShapeColor reads them."""


def _color(name: str, component: int) -> Property:
    def get(world: World, handle: int) -> list[float]:
        return world.shape_colors.get(handle, component) or []

    def put(world: World, handle: int, color: list[float]) -> None:
        world.shape_colors.set(handle, component, color)

    return Property(name, COLOR, get, put)


def _transparency(world: World, handle: int) -> float:
    return (world.shape_colors.get(handle, shape_colors.TRANSPARENCY) or [0.0])[0]


def _corners(world: World, handle: int) -> list[float]:
    return shape_looks.triangles(world, handle)[0].ravel().tolist()


def _indices(world: World, handle: int) -> list[int]:
    return shape_looks.triangles(world, handle)[1].ravel().tolist()


def _normals(world: World, handle: int) -> list[float]:
    normals = shape_looks.normals(*shape_looks.triangles(world, handle))
    return np.repeat(normals, 3, axis=0).ravel().tolist()


_MESH = (
    Property("vertices", FLOAT_ARRAY, _corners, is_large=True),
    Property("indices", INT_ARRAY, _indices, is_large=True),
    Property("normals", FLOAT_ARRAY, _normals, is_large=True),
    Property("meshes", HANDLE_ARRAY, lambda _world, handle: [handle]),
    _color("color.diffuse", shape_colors.DIFFUSE),
    _color("color.specular", shape_colors.SPECULAR),
    _color("color.emission", shape_colors.EMISSION),
    Property(
        "color.transparency",
        FLOAT,
        _transparency,
        lambda world, handle, share: world.shape_colors.set(handle, shape_colors.TRANSPARENCY, [share]),
    ),
)
"""Properties of CoppeliaSim's meshes, in the shape's frame. A shape is its own mesh here, so programs that colour the
first mesh colour all parts.
"""

SHAPES = (*_BEHAVIOUR, *_MASS, *_CONTACTS, *_COLORS, *_MESH)
