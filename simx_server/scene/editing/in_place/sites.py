"""Dummies, and other sites, without a compile: make, move to another body, remove."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.scene.editing.recompile import edit, refuse_in_physics
from simx_server.scene.editing.transplant import delete_all, move_leaf
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.naming.names import alias_of
from simx_server.scene.objects import ObjectKind, Scene, SceneObject
from simx_server.scene.poses.poses import Pose

from .same_model import SameModel

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_GROUP = 4
"""Group of dummies that programs make."""

_SITE = mujoco.mjtObj.mjOBJ_SITE.value


def add_dummy(
    sim: LiveScene, name: str, radius: float, rgba: Sequence[float], notes: Mapping[str, Annotation]
) -> int:
    """Add a dummy at the world's origin, and return its handle. Raises CommandError.

    Args:
        name: a name that no object has.
        radius: of its mark, metres.
        rgba: its colour, each 0..1.
        notes: annotations by kind.
    """
    refuse_in_physics(sim)
    sim.limits.check("objects", len(sim.scene.objects) + 1, "remove some")
    if not sim.scene.slots.sites:
        sim.scene.slots = sim.scene.slots.with_more_sites()
        edit(sim, lambda spec: None, set(), repeats=0)
    old, model = sim.scene, sim.model
    element_name = old.slots.sites[0]
    site = mujoco.mj_name2id(model, _SITE, element_name)

    def change(spec: Any) -> None:
        spec.worldbody.add_site(name=element_name, size=[radius] * 3, group=_GROUP, rgba=list(rgba))

    scene = old.edited_in_place(change, 1)
    _write(model, site, 0, ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)))
    model.site_size[site], model.site_group[site], model.site_rgba[site] = radius, _GROUP, rgba
    scene.slots = old.slots.without_site(element_name)
    scene.unseen_sites = old.unseen_sites - {element_name}
    scene.annotations = replace(
        old.annotations,
        objects={**old.annotations.objects, name: {kind: dict(n) for kind, n in notes.items()}},
    )
    handle = scene.next_handle
    dummy = SceneObject(
        handle, name, ObjectKind.DUMMY, -1, "site", element_name, site, 0, alias_of(name),
        scene.annotations.objects[name],
    )  # fmt: skip
    scene.append([dummy])
    sim.replace_scene(scene, SameModel(old, model, {"site": [site]}))
    return handle


def is_light(sim: LiveScene, item: SceneObject) -> bool:
    """Return whether an object is a site that physics and MuJoCo's sensors do not know, rays excepted."""
    model, site = sim.model, item.id
    if item.element != "site" or item.kind == ObjectKind.FORCE_SENSOR:
        return False
    sensed = (model.sensor_objtype == _SITE) & (model.sensor_objid == site)
    sensed &= model.sensor_type != mujoco.mjtSensor.mjSENS_RANGEFINDER.value
    sensed |= (model.sensor_reftype == _SITE) & (model.sensor_refid == site)
    wrapped = (model.wrap_type == mujoco.mjtWrap.mjWRAP_SITE.value) & (model.wrap_objid == site)
    # A tendon's path has the site beside a geom in its parameter.
    beside = np.isin(model.wrap_type, _WITH_SIDE_SITES) & (np.rint(model.wrap_prm) == site)
    driven = np.isin(model.actuator_trntype, _ON_SITES) & (model.actuator_trnid == site).any(axis=1)
    joined = (model.eq_objtype == _SITE) & ((model.eq_obj1id == site) | (model.eq_obj2id == site))
    return not any(each.any() for each in (sensed, wrapped, beside, driven, joined))


_WITH_SIDE_SITES = (mujoco.mjtWrap.mjWRAP_SPHERE.value, mujoco.mjtWrap.mjWRAP_CYLINDER.value)
_ON_SITES = (mujoco.mjtTrn.mjTRN_SITE.value, mujoco.mjtTrn.mjTRN_SLIDERCRANK.value)


def move_site(sim: LiveScene, item: SceneObject, parent: int, body: int, local: Pose) -> None:
    """Fix a light site to another body, with this pose there, and give it another parent."""
    old, model, element_name = sim.scene, sim.model, item.element_name
    body_name = "world" if body == 0 else model.body(body).name
    size = np.array(model.site_size[item.id])

    def change(spec: mujoco.MjSpec) -> None:
        move_leaf(spec, "site", element_name, body_name, local, size)

    scene = old.edited_in_place(change)
    _write(model, item.id, body, local)
    scene.objects[item.handle] = item.renumbered(item.id, body)
    scene.override_parents({item.handle: parent})
    sim.replace_scene(scene, SameModel(old, model))


def remove_sites(sim: LiveScene, items: Collection[SceneObject], parents: Mapping[int, int]) -> None:
    """Remove light sites. `parents`: handle to new parent, of the objects below."""
    refuse_in_physics(sim)
    old = sim.scene
    names = [item.element_name for item in items]

    def change(spec: mujoco.MjSpec) -> None:
        delete_all(spec, [("site", name) for name in names])

    scene = old.edited_in_place(change)
    scene.unseen_sites = old.unseen_sites | frozenset(names)
    drop(scene, [item.handle for item in items], parents)
    sim.replace_scene(scene, SameModel(old, sim.model, {"site": [item.id for item in items]}))


def drop(scene: Scene, handles: Collection[int], parents: Mapping[int, int]) -> None:
    """Take objects out of a twin; `parents`: handle to new parent, of the objects below."""
    for handle in handles:
        del scene.objects[handle]
        scene.model_properties.pop(handle, None)
    for handle in parents:
        scene.objects[handle] = replace(scene.objects[handle])  # the original stays in the scene before
    scene.parent_overrides = {
        handle: parent
        for handle, parent in scene.parent_overrides.items()
        if handle in scene.objects and (parent == -1 or parent in scene.objects)
    }
    scene.override_parents(parents)
    scene.reindex()


def _write(model: mujoco.MjModel, site: int, body: int, local: Pose) -> None:
    """Fix a site to a body, with this pose there."""
    model.site_bodyid[site] = body
    # MuJoCo skips the local pose of an element whose frame coincided with the body's at compile time.
    model.site_sameframe[site] = mujoco.mjtSameFrame.mjSAMEFRAME_NONE
    model.site_pos[site], model.site_quat[site] = local
