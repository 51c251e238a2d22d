"""Copy objects as V-REP's copy and paste does: whole models, or objects alone.

The chosen objects are extracted from the scene's spec together with the elements that act on them, prepared, and added
to the scene. Joints, motors, sensors, tendons and equalities between copied objects therefore work in the copy;
elements that reach outside are left out. Collections, collision and distance objects are copied with their objects.
A copy has the present pose and state of its original; if the parent of an object is not copied, the copy goes to the
top of the tree.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.scene import properties
from simx_server.scene.editing.copies.kept import Kept
from simx_server.scene.editing.waiting.basis import Basis
from simx_server.scene.objects import ObjectKind
from simx_server.scene.spec_elements import bodies_of

from .grafts.grafting import Graft, graft
from .grafts.late import may_wait
from .grafts.pruning import Pruned, strip_textures
from .grafts.selecting import Selection

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene
    from simx_server.scene.objects import Scene
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World


def copy_objects(world: World, handles: list[int], kept: Kept | None = None) -> list[int]:
    """Copy objects, stopped or running; return the handle of each copy, of a whole model only its base's.

    Unknown handles are skipped. Raises CommandError when MuJoCo cannot represent the result.
    """
    sim = world.simulation
    kept = kept or Kept()
    about_to_be_copied = _chosen(sim.scene, handles, kept)[1]
    sim.parts.tell(lambda part: part.copying_objects(about_to_be_copied))
    scene = sim.scene
    shown, chosen = _chosen(scene, handles, kept)
    if not chosen:
        return []
    addition = _graft(sim, chosen, kept)
    added = graft(sim, addition, late=may_wait(world, addition))
    items = {handle: scene.objects[handle] for handle in sorted(chosen)}
    copies = {
        handle: added[item.element, item.element_name]
        for handle, item in items.items()
        if (item.element, item.element_name) in added
    }
    sim.scene.override_parents(
        {copy: copies.get(items[handle].parent, -1) for handle, copy in copies.items()}
    )
    for handle, copy in copies.items():
        if handle in scene.model_properties:
            sim.scene.set_model_property(copy, scene.model_properties[handle])
    if not kept.textures:
        _color_plainly(sim, copies)
    properties.apply(sim)
    sim.joints.copy_settings(copies)
    sim.parts.tell(lambda part: part.objects_copied(copies, kept))
    sim.changed()
    return [copies[handle] for handle in shown if handle in copies]


def _chosen(scene: Scene, handles: list[int], kept: Kept) -> tuple[list[int], set[int]]:
    """Return the objects whose copies are returned, and all that are copied."""
    wanted = [handle for handle in dict.fromkeys(handles) if handle in scene.objects]
    models = [handle for handle in wanted if kept.models and scene.is_model_base(handle)]
    inside = {below for base in models for below in scene.descendants(base)}
    shown = [handle for handle in wanted if handle not in inside]
    chosen = set(shown).union(inside)
    if not kept.scripts:
        chosen = {handle for handle in chosen if scene.objects[handle].kind != ObjectKind.SCRIPT}
    return shown, chosen


def _graft(sim: Simulation, chosen: set[int], kept: Kept) -> Graft:
    """Return what the copies add to the scene."""
    selection = Selection(sim, Basis.for_copies(sim, chosen), chosen)
    straight = selection.straight() if kept.textures else None
    if straight is not None:
        return selection.graft(kept, straight, straight.names, {("body_", name) for name in straight.tops})
    if sim.waiting is not None:
        selection = Selection(sim, Basis.of(sim), chosen)
    pruned = Pruned(selection)
    if not kept.textures:
        strip_textures(pruned.spec, sim.scene.spec.materials)
    bodies = [body.name for body in bodies_of(pruned.spec)]
    return selection.graft(kept, pruned.spec, bodies, pruned.moved, pruned.carriers)


def _color_plainly(sim: LiveScene, copies: Mapping[int, int]) -> None:
    """Give copied shapes that lost a textured material its plain colour."""
    model, objects = sim.model, sim.scene.objects
    for original, copy in copies.items():
        if objects[original].element != "body":
            continue
        first, other = (int(model.body_geomadr[objects[handle].id]) for handle in (original, copy))
        for index in range(int(model.body_geomnum[objects[original].id])):
            material = int(model.geom_matid[first + index])
            if material >= 0 and model.geom_matid[other + index] < 0:
                model.geom_rgba[other + index] = model.mat_rgba[material]
