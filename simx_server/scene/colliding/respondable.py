"""Collisions by V-REP's respondable masks.

Two shapes collide when their masks have a bit in common: of the low bytes when both belong to one tree (the same object
is at its top), else of the high bytes.

* Shapes whose scene file gives them a mask have bits that follow from all masks, see `mask_bits.py`. A change of a mask
  writes them into the model.
* The bits of other shapes are those of the file. There a mask only excludes pairs of bodies: pairs that the file keeps
  apart stay apart.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.editing.recompile import edit
from simx_server.scene.objects import ObjectKind, SceneObject

from .mask_bits import ALL_MASKS, EXCLUSION, MOST, Masked, Motion, assign

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_LOCAL, _GLOBAL = 0x00FF, 0xFF00

_FLAT = 1e-6
"""Ratio of a mesh's thickness to its size below which it counts as flat."""


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
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH.value or model.mesh_graphadr[mesh] >= 0:
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
    governed = governed_shapes(sim)
    wanted = _excluded_pairs(sim, masks, {item.handle for item in governed})
    wanted |= _write_bits(sim, governed, masks)
    if wanted == _present_pairs(sim.model):
        return

    def surgery(spec: mujoco.MjSpec) -> None:
        for exclude in list(spec.excludes):
            if EXCLUSION in exclude.name:
                spec.delete(exclude)
        in_file = {_pair(exclude) for exclude in spec.excludes}
        for index, (first, second) in enumerate(sorted(wanted - in_file)):
            spec.add_exclude(name=f"{EXCLUSION}{index}", bodyname1=first, bodyname2=second)

    edit(sim, surgery, set())


def governed_shapes(sim: LiveScene) -> list[SceneObject]:
    """Return the shapes whose bits follow from masks: the scene file gives them one."""
    scene = sim.scene
    names = [name for name, notes in scene.annotations.objects.items() if "mask" in notes.get("shape", {})]
    found = [scene.objects[handle] for handle in map(scene.by_name, names) if handle in scene.objects]
    return [item for item in found if item.element == "body"]


def _write_bits(
    sim: LiveScene, shapes: Sequence[SceneObject], masks: Mapping[int, int]
) -> set[tuple[str, str]]:
    """Give the geoms of shapes that collide the bits of the masks; return the bodies that these do not keep apart."""
    bits = assign(
        [
            Masked(masks.get(each.handle, ALL_MASKS), _top(sim, each.handle), _motion(sim, each))
            for each in shapes
        ]
    )
    model, is_changed = sim.model, False
    firsts, counts = model.body_geomadr.tolist(), model.body_geomnum.tolist()
    # Most shapes have the values already: a look at the numbers is much cheaper than one at names.
    present = list(zip(model.geom_contype.tolist(), model.geom_conaffinity.tolist(), strict=True))
    for item, values in zip(shapes, bits.geoms, strict=True):
        first = firsts[item.body]
        for geom in range(first, first + counts[item.body]):
            if present[geom] not in (values, (0, 0)) or sim.scene.withheld:
                is_changed |= _write_to_geom(sim, geom, values)
    if is_changed:
        collect_masks(sim.model)
        sim.model_edited()
        sim.changed()
    names = [item.element_name for item in shapes]
    return {_sorted(names[one], names[other]) for one, other in bits.excluded}


def _write_to_geom(sim: LiveScene, geom: int, values: tuple[int, int]) -> bool:
    """Set contype and conaffinity of a geom that collides; return whether that changes them.

    A model's property may forbid the geom to collide: it has these values once it may again.
    """
    name, withheld = sim.model.geom(geom).name, sim.scene.withheld
    arrays = {key: getattr(sim.model, key) for key in ("geom_contype", "geom_conaffinity")}
    before = tuple(withheld.get((name, key), int(numbers[geom])) for key, numbers in arrays.items())
    if not any(before) or before == values:
        return False
    for (key, numbers), value in zip(arrays.items(), values, strict=True):
        if (name, key) in withheld:
            withheld[name, key] = value
        else:
            numbers[geom] = value
    return True


def _motion(sim: LiveScene, item: SceneObject) -> Motion:
    """Return what may move a shape."""
    if sim.model.body_weldid[item.body] == 0:
        return Motion.FIXED
    return Motion.CARRIED if item.element_name in sim.scene.weightless_bodies else Motion.DYNAMIC


def _excluded_pairs(
    sim: LiveScene, masks: Mapping[int, int], governed: Collection[int]
) -> set[tuple[str, str]]:
    """Return the pairs of bodies that masks keep apart, of shapes of which one at least has the bits of its file."""
    scene = sim.scene
    shapes = [scene.objects[handle] for handle in scene.of_kind(ObjectKind.SHAPE)]
    own = [shape for shape in shapes if shape.handle in masks and shape.handle not in governed]
    found: set[tuple[str, str]] = set()
    for a in own:
        for b in shapes:
            if a.handle == b.handle:
                continue
            common = masks[a.handle] & masks.get(b.handle, ALL_MASKS)
            in_one_tree = _top(sim, a.handle) == _top(sim, b.handle)
            if not common & (_LOCAL if in_one_tree else _GLOBAL):
                first, second = (o.element_name if o.element == "body" else "world" for o in (a, b))
                found.add(_sorted(first, second))
    return found


def _present_pairs(model: mujoco.MjModel) -> set[tuple[str, str]]:
    """Return the pairs of bodies that are kept apart by masks."""
    found: set[tuple[str, str]] = set()
    for index, signature in enumerate(model.exclude_signature.tolist()):
        if EXCLUSION in model.exclude(index).name:
            first, second = (model.body(body).name for body in divmod(signature, 1 << 16))
            found.add(_sorted(first, second))
    return found


def needs_exclusions(model: mujoco.MjModel) -> bool:
    """Return whether masks keep bodies apart by pairs, or may do so, as all bits are taken."""
    return bool(_present_pairs(model)) or bool((model.geom_contype & 1 << MOST - 1).any())


def _pair(exclude: Any) -> tuple[str, str]:
    return _sorted(exclude.bodyname1, exclude.bodyname2)


def _sorted(one: str, other: str) -> tuple[str, str]:
    return (one, other) if one <= other else (other, one)


def _top(sim: LiveScene, handle: int) -> int:
    while (parent := sim.scene.objects[handle].parent) != -1:
        handle = parent
    return handle
