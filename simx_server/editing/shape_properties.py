"""Physical properties of a shape: static or not, colliding or not, its mass (parameters 3003, 3004, 3005)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.errors import Unsupported
from simx_server.scene.colliding.respondable import collect_masks, compile_hulls
from simx_server.scene.editing import welding
from simx_server.scene.editing.model_changes import undone_on_failure
from simx_server.scene.objects import ObjectKind, SceneObject

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

_LEAST_MASS, _GREATEST_MASS = 1e-9, 1e30
"""Masses in kilograms; MuJoCo cannot step a moving body without mass."""


def is_static(sim: Simulation, handle: int) -> bool:
    """Return whether the shape moves only with its parent: it has no own joint, free or other.

    Shapes that a force sensor or a joint's own body holds count as dynamic, as in V-REP. `scene.editing.set_static`
    sets the property.
    """
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    if item.element != "body":
        return True
    if welding.holding_joint(sim, item) is not None:
        return not welding.is_held_link(sim, item)
    if welding.is_link(sim, item.id):
        joints = welding.joints_of_link(sim, item)
        return bool(joints) and all(map(sim.joints.is_fixed, joints))
    return sim.model.body_jntnum[item.id] == 0 and item.element_name not in sim.scene.welded_bodies


def is_respondable(sim: Simulation, handle: int) -> bool:
    """Return whether any geom of the shape can collide."""
    model = sim.model
    return any(model.geom_contype[g] or model.geom_conaffinity[g] for g in _geoms(sim, handle))


def set_respondable(sim: Simulation, handle: int, respondable: bool) -> None:
    """Make a shape collide or not; switched on again, its geoms collide as in the scene file (all, if none do)."""
    if respondable == is_respondable(sim, handle):
        return
    names = [sim.model.geom(geom).name for geom in _geoms(sim, handle)]
    originals = [sim.scene.spec.geom(name) for name in names]
    masks = [(original.contype, original.conaffinity) for original in originals]
    if not any(any(mask) for mask in masks):
        masks = [(1, 1)] * len(masks)
        if respondable:
            compile_hulls(sim, names)
    model = sim.model
    for name, (contype, conaffinity) in zip(names, masks, strict=True):
        geom = model.geom(name).id
        model.geom_contype[geom] = contype if respondable else 0
        model.geom_conaffinity[geom] = conaffinity if respondable else 0
    collect_masks(model)
    sim.model_edited()
    sim.changed()


def is_compound(sim: Simulation, handle: int) -> bool:
    """Return whether the shape consists of several geoms."""
    return len(_geoms(sim, handle)) > 1


def get_mass(sim: Simulation, handle: int) -> float:
    """Return the mass in kilograms; a part of the world has none."""
    if sim.scene.get_kind(handle, ObjectKind.SHAPE).element != "body":
        return 0.0
    return float(sim.model.body_mass[_body(sim, handle)])


def set_mass(sim: Simulation, handle: int, mass: float) -> None:
    """Set the mass in kilograms; the inertia changes in proportion.

    Raises:
        Unsupported: the mass is not above 0, or the shape's body does not have its own mass.
    """
    body = _body(sim, handle)
    model = sim.model
    if mass < _LEAST_MASS or model.body_mass[body] <= 0.0:
        raise Unsupported("a mass must be above 0 kg, and its shape must have one already")
    if mass > _GREATEST_MASS:
        raise Unsupported(f"a mass is at most {_GREATEST_MASS:g} kg, not {mass:g}")
    with undone_on_failure(sim):
        model.body_inertia[body] *= mass / model.body_mass[body]
        model.body_mass[body] = mass
        sim.joints.masses_changed()
    sim.model_edited()
    sim.changed()


def _body(sim: Simulation, handle: int) -> int:
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    if item.element != "body":
        raise Unsupported(f"'{item.name}' is a part of the world, which has no mass")
    return item.body


def _geoms(sim: Simulation, handle: int) -> list[int]:
    item: SceneObject = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    if item.element == "geom":
        return [item.id]
    start = int(sim.model.body_geomadr[item.body])
    return list(range(start, start + int(sim.model.body_geomnum[item.body])))
