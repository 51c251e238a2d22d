"""Properties of shapes: what physics does with them, mass and inertia, friction, colours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.editing import shape_looks
from simx_server.errors import CommandError
from simx_server.handlers.objects import poses
from simx_server.parts import shape_colors
from simx_server.scene.geometry import inertia
from simx_server.scene.poses.frames import xyzw_from_wxyz
from simx_server.sim_api.properties.entry import Property, numbered
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
)

if TYPE_CHECKING:
    from simx_server.world.world import World


_BEHAVIOUR = (
    numbered("dynamic", BOOL, "shapeintparam_static", inverted=True),
    numbered("respondable", BOOL, "shapeintparam_respondable"),
    numbered("respondableMask", INT, "shapeintparam_respondable_mask"),
    *(
        numbered(name, VECTOR3, *(f"shapefloatparam_init_velocity_{axis}" for axis in axes))
        for name, axes in (("initLinearVelocity", "xyz"), ("initAngularVelocity", "abg"))
    ),
    Property("dynLinearVelocity", VECTOR3, lambda world, handle: poses.get_velocity(world, handle)[0]),
    Property("dynAngularVelocity", VECTOR3, lambda world, handle: poses.get_velocity(world, handle)[1]),
    numbered("compound", BOOL, "shapeintparam_compound"),
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
    numbered("mass", FLOAT, "shapefloatparam_mass"),
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


def _counted(start: str, count: int) -> list[str]:
    return [f"mujoco_{start}{number}" for number in range(1, count + 1)]


_CONTACTS = (
    numbered("bullet.friction", FLOAT, "bullet_body_friction"),
    numbered("bullet.frictionOld", FLOAT, "bullet_body_oldfriction"),
    numbered("ode.friction", FLOAT, "ode_body_friction"),
    numbered("vortex.linearPrimaryAxisFrictionValue", FLOAT, "vortex_body_primlinearaxisfriction"),
    numbered("vortex.linearSecondaryAxisFrictionValue", FLOAT, "vortex_body_seclinearaxisfriction"),
    numbered("newton.staticFriction", FLOAT, "newton_body_staticfriction"),
    numbered("newton.kineticFriction", FLOAT, "newton_body_kineticfriction"),
    numbered("mujoco.friction", FLOAT_ARRAY, *_counted("body_friction", 3)),
    numbered("mujoco.solref", FLOAT_ARRAY, *_counted("body_solref", 2)),
    numbered("mujoco.solimp", FLOAT_ARRAY, *_counted("body_solimp", 5)),
    numbered("mujoco.solmix", FLOAT, "mujoco_body_solmix"),
    numbered("mujoco.margin", FLOAT, "mujoco_body_margin"),
    numbered("mujoco.condim", INT, "mujoco_body_condim"),
    numbered("mujoco.priority", INT, "mujoco_body_priority"),
)
"""The frictions of all engines are MuJoCo's sliding friction, as for sim.setEngineFloatParam."""

ENGINE = (
    numbered("mujoco.impratio", FLOAT, "mujoco_global_impratio"),
    numbered("mujoco.wind", VECTOR3, *_counted("global_wind", 3)),
    numbered("mujoco.density", FLOAT, "mujoco_global_density"),
    numbered("mujoco.viscosity", FLOAT, "mujoco_global_viscosity"),
    numbered("mujoco.iterations", INT, "mujoco_global_iterations"),
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
