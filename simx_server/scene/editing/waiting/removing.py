"""Remove shapes from a model that is compiled later; see `waiting.py`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.editing.in_place.sites import drop
from simx_server.scene.editing.recompile import refuse_in_physics
from simx_server.scene.editing.transplant import OBJECT_TYPES, TRANSMISSIONS
from simx_server.scene.objects import ObjectKind, Scene, SceneObject
from simx_server.scene.poses.placing import free_joint

from .waiting import Waiting

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_LEAVES = ("site", "cam", "light")


def remove_shape(sim: LiveScene, handle: int) -> bool:
    """Remove a shape that stands or lies for itself; return False, having done nothing, if it is another object.

    Raises CommandError: within a physics step. UnknownHandle.
    """
    item = sim.scene.get(handle)
    refuse_in_physics(sim)
    if not sim.scene.keeps_ids or (sim.waiting is not None and handle in sim.waiting.handles):
        return False
    if not _is_alone(sim.model if sim.waiting is None else sim.waiting.model, sim.scene, item):
        return False
    waiting = sim.waiting or Waiting.of(sim.scene, sim.model, sim.data)
    _take_out(waiting, item)
    waiting.delete(item.element_name)
    sim.hold(waiting)
    return True


def _is_alone(model: mujoco.MjModel, scene: Scene, item: SceneObject) -> bool:
    """Return whether an object is a static or free body at the top of the model with which nothing else has to do."""
    if item.element != "body" or item.kind != ObjectKind.SHAPE or scene.children(item.handle):
        return False
    body = model.body(item.element_name).id
    if model.body_parentid[body] != 0 or (model.body_parentid == body).any() or model.body_mocapid[body] >= 0:
        return False
    if model.body_jntnum[body] and free_joint(model, body) < 0:
        return False
    if any((getattr(model, f"{kind}_bodyid") == body).any() for kind in _LEAVES):
        return False
    return not _is_referred_to(model, body)


def _is_referred_to(model: mujoco.MjModel, body: int) -> bool:
    """Return whether an element outside of a body may refer to it, to its joint or to one of its geoms."""
    first, joint = int(model.body_geomadr[body]), int(model.body_jntadr[body])
    geoms = np.arange(first, first + int(model.body_geomnum[body]))
    own = {"body": [body], "joint": [joint] if joint >= 0 else [], "geom": geoms}
    for kind, ids in own.items():
        types = [each.value for each in OBJECT_TYPES[kind]]
        for prefix in ("sensor_obj", "sensor_ref", "tuple_obj"):
            is_of_kind = np.isin(getattr(model, f"{prefix}type"), types)
            if (is_of_kind & np.isin(getattr(model, f"{prefix}id"), ids)).any():
                return True
        drives = np.isin(model.actuator_trntype, [each.value for each in TRANSMISSIONS.get(kind, ())])
        if (drives & np.isin(model.actuator_trnid[:, 0], ids)).any():
            return True
    # Of these the type is not looked at: they are few.
    ids = np.concatenate(list(own.values()))
    others = (model.eq_obj1id, model.eq_obj2id, model.wrap_objid)
    if any(np.isin(each, ids).any() for each in others):
        return True
    bodies = (
        *divmod(model.exclude_signature, 1 << 16), model.cam_targetbodyid, model.light_targetbodyid,
        model.skin_bonebodyid, model.flex_vertbodyid, model.flex_nodebodyid,
    )  # fmt: skip
    return any((each == body).any() for each in bodies) or any(
        np.isin(each, geoms).any() for each in (model.pair_geom1, model.pair_geom2)
    )


def _take_out(waiting: Waiting, removed: SceneObject) -> None:
    """Take a shape out of the scene; those behind it in the model get the ids that they have without it."""
    scene, model = waiting.scene, waiting.model
    body = model.body(removed.element_name)
    names = {model.geom(int(body.geomadr[0]) + number).name for number in range(int(body.geomnum[0]))}
    joints = int(body.jntnum[0])
    for handle, item in scene.objects.items():
        if item.body > removed.body:
            less = {"body": 1, "joint": joints}.get(item.element, 0)
            scene.objects[handle] = item.renumbered(item.id - less, item.body - 1)
    scene.owners = np.delete(scene.owners, removed.body)
    waiting.sizes["body"] -= 1
    waiting.sizes["joint"] -= joints
    scene.withheld = {key: value for key, value in scene.withheld.items() if key[0] not in names}
    drop(scene, [removed.handle], {})
