"""Appearance of a shape: its triangles, its primitive type, its colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.geometry import frames
from simx_server.scene.geometry.poses import matrix
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.world.world import World

AMBIENT_DIFFUSE, TRANSPARENCY = 0, 4
"""`sim_colorcomponent_*` of geoms; highlight and emission belong to materials, which shapes share."""

_UNSET = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom without one: then the colour of its material is used."""

_GEOM = mujoco.mjtGeom
_PURE: dict[int, int] = {
    int(_GEOM.mjGEOM_PLANE): 1,
    int(_GEOM.mjGEOM_BOX): 3,
    int(_GEOM.mjGEOM_SPHERE): 4,
    int(_GEOM.mjGEOM_ELLIPSOID): 4,
    int(_GEOM.mjGEOM_CYLINDER): 5,
    int(_GEOM.mjGEOM_HFIELD): 7,
    int(_GEOM.mjGEOM_CAPSULE): 8,
}
"""`sim_pure_primitive_*` by type of geom; 0 is none."""


def geoms_of(world: World, handle: int) -> list[int]:
    """Return the ids of a shape's geoms. Raises UnknownHandle, WrongKind."""
    world.simulation.scene.get_kind(handle, ObjectKind.SHAPE)
    return world.instants.now().geoms_of([handle]).tolist()


def triangles(world: World, handle: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return points (n, 3) in the shape's frame, metres, and faces (m, 3) of their indices.

    Curved primitives are faceted. Raises UnknownHandle, WrongKind, CommandError: an infinite plane.
    """
    sim = world.simulation
    sim.scene.get_kind(handle, ObjectKind.SHAPE)
    instant = world.instants.now()
    position, quat = frames.get_pose(sim, handle)
    axes = np.array(matrix(quat))
    found: list[NDArray[np.float64]] = []
    for geom in instant.geoms_of([handle]).tolist():
        if sim.model.geom_type[geom] == _GEOM.mjGEOM_PLANE:
            raise CommandError(f"'{sim.scene.get(handle).name}' is a plane, which has no triangles")
        corners = instant.surroundings.triangles.of(geom)[0]
        world = corners @ instant.geom_xmat[geom].reshape(3, 3).T + instant.geom_xpos[geom]
        found.append((world - np.array(position)) @ axes)
    corners = np.concatenate(found).reshape(-1, 3)
    points, index = np.unique(corners.round(9), axis=0, return_inverse=True)
    return points, index.reshape(-1, 3).astype(np.int64)


def pure_type(world: World, handle: int) -> tuple[int, list[float]]:
    """Return `sim_pure_primitive_*` of a shape of one primitive, and its sizes (m); 0 and zeros for others.

    Raises UnknownHandle, WrongKind.
    """
    sim = world.simulation
    geoms = geoms_of(world, handle)
    if len(geoms) != 1:
        return 0, [0.0] * 3
    kind, size = int(sim.model.geom_type[geoms[0]]), sim.model.geom_size[geoms[0]].tolist()
    match mujoco.mjtGeom(kind):
        case _GEOM.mjGEOM_SPHERE:
            size = [size[0]] * 3
        case _GEOM.mjGEOM_CYLINDER:
            size = [size[0], size[0], size[1]]
        case _GEOM.mjGEOM_CAPSULE:
            size = [size[0], size[0], size[1] + size[0]]
        case _GEOM.mjGEOM_HFIELD:
            size = sim.model.hfield_size[sim.model.geom_dataid[geoms[0]]].tolist()
            size = [size[0], size[1], size[2] / 2]
        case _:  # their sizes are those that V-REP has
            pass
    number = _PURE.get(kind, 0)
    return number, [2 * half for half in size[:3]] if number else [0.0] * 3


def is_convex(world: World, handle: int) -> bool:
    """Return whether all parts of a shape are convex. Raises UnknownHandle, WrongKind."""
    surroundings = world.instants.now().surroundings
    return all(surroundings.triangles.is_solid(geom) for geom in geoms_of(world, handle))


def color(world: World, handle: int, component: int) -> list[float]:
    """Return the RGB 0..1 of a shape's first geom; for TRANSPARENCY three times 0 (opaque) to 1.

    Raises UnknownHandle, WrongKind, CommandError: another component.
    """
    _check(component)
    geom, model = geoms_of(world, handle)[0], world.simulation.model
    rgba, material = model.geom_rgba[geom], int(model.geom_matid[geom])
    if material >= 0 and np.allclose(rgba, _UNSET):
        rgba = model.mat_rgba[material]
    return [1.0 - float(rgba[3])] * 3 if component == TRANSPARENCY else rgba[:3].tolist()


def set_color(world: World, handle: int, component: int, values: Sequence[float]) -> None:
    """Set the colour of all geoms of a shape; a material keeps its texture, tinted. Raises as `color`."""
    sim = world.simulation
    _check(component)
    if len(values) < (1 if component == TRANSPARENCY else 3):
        raise CommandError("a colour is {red, green, blue}, each 0 to 1")
    for geom in geoms_of(world, handle):
        rgba, material = sim.model.geom_rgba[geom], int(sim.model.geom_matid[geom])
        if material >= 0 and np.allclose(rgba, _UNSET):
            rgba[:] = sim.model.mat_rgba[material]
        if component == TRANSPARENCY:
            rgba[3] = 1.0 - min(max(values[0], 0.0), 1.0)
        else:
            rgba[:3] = np.clip(values[:3], 0.0, 1.0)
    sim.model_edited()
    sim.changed()


def _check(component: int) -> None:
    if component not in (AMBIENT_DIFFUSE, TRANSPARENCY):
        raise CommandError(
            f"of a shape's colours component {AMBIENT_DIFFUSE} (ambient and diffuse) and {TRANSPARENCY} (transparency) "
            f"are available, not {component}"
        )
