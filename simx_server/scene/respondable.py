"""Collisions by V-REP's respondable masks, as pairs of bodies that MuJoCo excludes.

Two shapes collide when their masks have a bit in common: of the low bytes when both belong to one tree (the same object
is at its top), else of the high bytes. The masks only exclude: pairs that the scene file excludes stay excluded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.editing.recompile import edit
from simx_server.scene.objects import ObjectKind
from simx_server.scene.tree import INTERNAL

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

ALL_MASKS = 0xFFFF
"""Mask that meets every other mask except 0."""

_LOCAL, _GLOBAL = 0x00FF, 0xFF00

_FLAT = 1e-6
"""Ratio of a mesh's thickness to its size below which it counts as flat."""

_EXCLUSION = INTERNAL + "mask:"
"""Part of the names of exclusions by masks; in copies a prefix precedes it."""


def collect_masks(model: mujoco.MjModel) -> None:
    """Set the collision masks of bodies to the union of their geoms'. Call this after writing geoms' masks."""
    for of_bodies, of_geoms in (
        (model.body_contype, model.geom_contype),
        (model.body_conaffinity, model.geom_conaffinity),
    ):
        of_bodies[:] = 0
        np.bitwise_or.at(of_bodies, model.geom_bodyid, of_geoms)


def compile_hulls(sim: LiveScene, names: Sequence[str]) -> None:
    """Compile missing convex hulls of the meshes of these geoms, which are to collide.

    MuJoCo computes a hull only for meshes that collide in the file. Without one it finds a single point of contact
    with a plane or another mesh, on which a body rocks, sinks in and creeps. Flat meshes have no hull.

    Raises:
        CommandError: MuJoCo cannot compute a hull, or physics is running.
    """
    wanted = [name for name in names if _lacks_hull(sim.model, sim.model.geom(name).id)]
    if not wanted:
        return

    def surgery(spec: mujoco.MjSpec) -> None:
        for name in names:
            geom = spec.geom(name)
            geom.contype = geom.conaffinity = 1

    edit(sim, surgery, set())


def _lacks_hull(model: mujoco.MjModel, geom: int) -> bool:
    mesh = int(model.geom_dataid[geom])
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH or model.mesh_graphadr[mesh] >= 0:
        return False
    first = int(model.mesh_vertadr[mesh])
    points = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])].astype(float)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[2] > _FLAT * spread[0])


def set_masks(sim: LiveScene, masks: Mapping[int, int]) -> None:
    """Apply these masks, by handle; every shape without one has all bits.

    Raises CommandError for a part of the world: MuJoCo excludes pairs of bodies, and the world is one.
    """
    for handle in masks:
        item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
        if item.element != "body":
            raise CommandError(
                f"'{item.name}' is a part of the world itself; make it a body to give it a mask"
            )
    wanted = _excluded_pairs(sim, masks)
    present = {_pair(e) for e in sim.scene.spec.excludes if _EXCLUSION in e.name}
    if wanted == present:
        return

    def surgery(spec: mujoco.MjSpec) -> None:
        for exclude in list(spec.excludes):
            if _EXCLUSION in exclude.name:
                spec.delete(exclude)
        in_file = {_pair(exclude) for exclude in spec.excludes}
        for index, (first, second) in enumerate(sorted(wanted - in_file)):
            spec.add_exclude(name=f"{_EXCLUSION}{index}", bodyname1=first, bodyname2=second)

    edit(sim, surgery, set())


def _excluded_pairs(sim: LiveScene, masks: Mapping[int, int]) -> set[tuple[str, str]]:
    scene = sim.scene
    shapes = [scene.objects[handle] for handle in scene.of_kind(ObjectKind.SHAPE)]
    found: set[tuple[str, str]] = set()
    for a, b in combinations(shapes, 2):
        if a.handle not in masks and b.handle not in masks:
            continue
        common = masks.get(a.handle, ALL_MASKS) & masks.get(b.handle, ALL_MASKS)
        in_one_tree = _top(sim, a.handle) == _top(sim, b.handle)
        if not common & (_LOCAL if in_one_tree else _GLOBAL):
            first, second = sorted(o.element_name if o.element == "body" else "world" for o in (a, b))
            found.add((first, second))
    return found


def _pair(exclude: Any) -> tuple[str, str]:
    first, second = sorted((exclude.bodyname1, exclude.bodyname2))
    return first, second


def _top(sim: LiveScene, handle: int) -> int:
    while (parent := sim.scene.objects[handle].parent) != -1:
        handle = parent
    return handle
