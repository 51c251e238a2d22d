"""Change the tree of a scene, stopped or running: remove objects, set their parents, add dummies.

An edit compiles a new model and carries the whole state over by name; handles stay. During a run the original is kept
and comes back at stop.

Physical meaning of a new parent:
* a body without joints (static or welded) is welded to the new parent's body; a body that was fixed to the world
  weighs nothing there, as V-REP's static shapes do;
* a free body (it falls, it is pushed) stays free: only the tree changes, as in V-REP, where a dynamic shape under
  another shape moves independently of it. Under a **force sensor** it is welded (V-REP's rigid link: gripper scripts
  attach objects to `..._attachPoint`), and released, with its present velocity, when it gets another parent; the same
  holds under a joint that does not move a body yet, such as one that a script has made;
* a link (body with hinges or slides) or a joint moves in the tree with all below it, joints first;
* a site, camera or light moves to the new parent's body; a joint on a tendon only moves in the tree.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError, Unsupported
from simx_server.scene import properties
from simx_server.scene.abilities import NO_ABILITY
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.naming.names import INTERNAL
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.placing import (
    body_pose,
    element_pose,
    free_joint,
    is_linking_sensor,
    moving_pose,
    object_pose,
    place,
)
from simx_server.scene.poses.poses import IDENTITY, Pose, compose, inverse, rotate

from .in_place import sites
from .marks import mark_size, set_mark_size
from .recompile import edit, refuse_in_physics
from .renaming import drop_key
from .transplant import delete, delete_all, find_body, move_leaf
from .welding import (
    body_name,
    body_under,
    holding_joint,
    is_link,
    move_body_object,
    set_static,
)

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

__all__ = [
    "create_dummy",
    "remove_all",
    "remove_model",
    "remove_object",
    "remove_tree",
    "set_parent",
    "set_static",
]

DUMMY_COLOR = (255, 255, 255, 0, 0, 0, 64, 64, 64, 0, 0, 0)
"""Colour of a dummy that is created without one: white, with a faint highlight."""

_COLOR_STARTS = (0, 0, 6, 9)
"""Start of the RGB of each component in a colour's 12 numbers."""

_SENSOR_CARRIER = INTERNAL + "sensor_carrier"
"""Stem of the names of empty bodies that carry force sensors without children."""

_PREFIX = {"site": "site_", "camera": "cam_", "light": "light_"}


_SMALLEST_DUMMY, _LARGEST_DUMMY = 0.0001, 100.0


def set_parent(sim: LiveScene, handle: int, parent: int, keep_in_place: bool) -> None:
    """Give an object another parent (-1: none). `keep_in_place` keeps its world pose, else the local one's numbers.

    Raises UnknownHandle, CommandError (a loop; a part of the world itself).
    """
    refuse_in_physics(sim)
    scene = sim.scene
    item = scene.get(handle)
    if parent != -1:
        scene.get(parent)
        if scene.is_below(parent, handle):
            raise Unsupported(
                f"'{item.name}' cannot get its own child '{scene.get(parent).name}' as parent", 1
            )
        for joint in _joints_of(sim, item):
            if scene.is_below(parent, joint.handle):
                raise Unsupported(
                    f"'{item.name}' moves with its joint '{joint.name}', which carries '{scene.get(parent).name}'; "
                    "give that another parent first"
                )
    if parent == item.parent:
        return
    sim.refresh()
    item = _leave_sensor(sim, item)
    world = object_pose(sim, item)
    local = compose(inverse(_reference(sim, item.parent)), world)
    if item.element in ("body", "joint") or is_linking_sensor(sim, item):
        move_body_object(sim, item, parent)
    elif item.element in _PREFIX:
        _move_leaf(sim, item, parent)
        if item.kind == ObjectKind.FORCE_SENSOR:
            _take_along(sim, handle)
    elif item.element == "geom" and body_under(sim, parent) != 0:
        raise Unsupported(
            f"'{item.name}' is a part of the world itself and cannot move; make it a body to attach it"
        )
    sim.scene.override_parent(handle, parent)
    drop_key(sim, handle, "object", "sibling")
    if _concerns_models(sim, handle):
        properties.apply(sim)
    sim.changed()
    if not keep_in_place:
        sim.refresh()
        place(sim, sim.scene.get(handle), compose(_reference(sim, parent), local), with_joints=True)


def _concerns_models(sim: LiveScene, handle: int) -> bool:
    """Return whether properties of the models above concern an object or one below it: its geoms or its motion."""
    objects = sim.scene.objects
    return any(objects[each].element not in _PREFIX for each in (handle, *sim.scene.descendants(handle)))


def remove_object(sim: LiveScene, handle: int) -> None:
    """Remove one object; its children move up to its parent and stay where they are. Raises UnknownHandle.

    A link with children stays in the model as a carrier of its mass, without shapes; a removed joint is rigid.
    """
    item = sim.scene.get(handle)
    children = sim.scene.children(handle)
    if sites.is_light(sim, item):
        sites.remove_sites(sim, [item], dict.fromkeys(children, item.parent))
        return
    body = sim.model.body(item.body).name
    is_held = holding_joint(sim, item) is not None
    hollow = item.element == "body" and (bool(children) or is_link(sim, item.id) or is_held)
    start = _pose_in_parent(sim, item.body)

    def surgery(spec: mujoco.MjSpec) -> None:
        if hollow:
            _hollow_out(sim, spec, item)
        else:
            delete(spec, item.element, item.element_name)
        if item.element == "joint" and sim.model.body_jntnum[item.body] == 1:
            spec.body(body).pos[:], spec.body(body).quat[:] = start

    moved: set[tuple[str, str]] = {("body_", body)} if item.element == "joint" else set()
    parents = dict.fromkeys(children, item.parent)
    edit(sim, surgery, moved, removed={handle}, parents=parents, hidden=body if hollow else None)


def remove_model(sim: LiveScene, handle: int) -> None:
    """Remove a whole tree. Raises UnknownHandle, CommandError when the object is not a model base."""
    item = sim.scene.get(handle)
    if not sim.scene.is_model_base(handle):
        raise CommandError(
            f"'{item.name}' is no model base; remove it as an object, or make it one with simxSetModelProperty"
        )
    remove_tree(sim, handle)


def remove_tree(sim: LiveScene, *handles: int) -> None:
    """Remove objects and all below them. Raises UnknownHandle."""
    removed = [each for handle in handles for each in (handle, *sim.scene.descendants(handle))]
    items = [sim.scene.get(h) for h in removed]
    if all(sites.is_light(sim, item) for item in items):
        sites.remove_sites(sim, items, {})
        return

    def surgery(spec: mujoco.MjSpec) -> None:
        moving = [i for i in items if i.element in ("body", "joint") or is_linking_sensor(sim, i)]
        others = [i for i in items if i.element in ("tendon", "geom", *_PREFIX)]
        delete_all(
            spec,
            [("body", sim.model.body(item.body).name) for item in moving]
            + [(item.element, item.element_name) for item in others],
        )

    edit(sim, surgery, set(), removed=set(removed))


def remove_all(sim: LiveScene) -> None:
    """Remove every object (`sim_handle_all`)."""
    remove_tree(sim, *sim.scene.children(-1))


def create_dummy(sim: LiveScene, size: float, color: Sequence[int] | None = None) -> int:
    """Add a dummy of this diameter (m) at the world's origin; return its handle.

    `color`: 12 numbers 0 to 255: ambient and diffuse RGB, 3 reserved, specular RGB, emissive RGB.
    """
    size = _dummy_size(size)
    names = sim.scene.by_names()
    name, count = "Dummy", 0
    while name in names:
        name, count = f"Dummy{count}", count + 1

    numbers = [min(max(number, 0), 255) for number in color or DUMMY_COLOR]
    rgba = [number / 255 for number in numbers[:3]] + [1.0]
    note: Annotation = {"color": " ".join(map(str, numbers)), **NO_ABILITY}
    return sites.add_dummy(sim, name, size / 2, rgba, {"dummy": note})


def _dummy_size(size: float) -> float:
    """Return the nearest diameter within V-REP's limits, metres."""
    return min(max(size, _SMALLEST_DUMMY), _LARGEST_DUMMY)


def dummy_size(sim: LiveScene, handle: int) -> float:
    """Return the diameter of a dummy's mark in metres. Raises UnknownHandle, WrongKind."""
    return mark_size(sim.model, sim.scene.get_kind(handle, ObjectKind.DUMMY))


def set_dummy_size(sim: LiveScene, handle: int, size: float) -> None:
    """Set the diameter of a dummy's mark in metres. Raises UnknownHandle, WrongKind."""
    set_mark_size(sim, sim.scene.get_kind(handle, ObjectKind.DUMMY), _dummy_size(size))


def dummy_color(sim: LiveScene, handle: int, component: int) -> list[float]:
    """Return the RGB 0..1 of a dummy: 0 and 1 ambient and diffuse, 2 specular, 3 emission.

    Raises UnknownHandle, WrongKind.
    """
    item = sim.scene.get_kind(handle, ObjectKind.DUMMY)
    if not 0 <= component <= 3:
        raise CommandError(f"a colour's component is 0, 1, 2 or 3, not {component}")
    note = item.annotations.get("dummy", {}).get("color")
    if note is not None:
        start = _COLOR_STARTS[component]
        return [int(number) / 255 for number in str(note).split()[start : start + 3]]
    return sim.model.site_rgba[_mark(item)][:3].tolist() if component < 2 else [0.0, 0.0, 0.0]


def _mark(item: SceneObject) -> int:
    """Return the id of the site that shows a dummy."""
    if item.element != "site":
        raise CommandError(f"'{item.name}' is a body without shapes, which has no mark with a colour")
    return item.id


def _joints_of(sim: LiveScene, item: SceneObject) -> list[SceneObject]:
    """Return the joints between a body and its parent body, anywhere in the tree."""
    objects = sim.scene.objects.values()
    is_body = item.element == "body"
    return [other for other in objects if is_body and other.element == "joint" and other.body == item.body]


def _move_leaf(sim: LiveScene, item: SceneObject, parent: int) -> None:
    target = body_under(sim, parent)
    if target == item.body:
        return
    local = compose(inverse(body_pose(sim, target)), element_pose(sim, item))
    if sites.is_light(sim, item):
        sites.move_site(sim, item, parent, target, local)
        return

    def surgery(spec: mujoco.MjSpec) -> None:
        size = sim.model.site_size[item.id] if item.element == "site" else None
        name, place = body_name(sim, target), local
        if item.kind == ObjectKind.FORCE_SENSOR:
            # In the body itself it would measure the force that holds that body, and be above it in the tree.
            carrier = find_body(spec, name).add_body(
                name=_free_name(spec, _SENSOR_CARRIER), pos=local[0], quat=local[1]
            )
            name, place = carrier.name, IDENTITY
        move_leaf(spec, item.element, item.element_name, name, place, size)
        if item.element == "light":
            spec.light(item.element_name).dir[:] = rotate(local[1], (0.0, 0.0, 1.0))

    edit(sim, surgery, {(_PREFIX[item.element], item.element_name)}, parents={item.handle: parent})


def _leave_sensor(sim: LiveScene, item: SceneObject) -> SceneObject:
    """Let a force sensor, which lies in the body that it holds, stay behind when that body gets another parent."""
    sensor = sim.scene.objects.get(item.parent)
    if item.element != "body" or sensor is None or sensor.body != item.body:
        return item
    if sensor.kind == ObjectKind.FORCE_SENSOR:
        _move_leaf(sim, sensor, sensor.parent)
    return sim.scene.get(item.handle)


def _take_along(sim: LiveScene, sensor: int) -> None:
    """Fix the objects that a sensor holds to the sensor, after it was moved to another body."""
    for child in sim.scene.children(sensor):
        held = sim.scene.get(child)
        if held.element == "body" and free_joint(sim.model, held.id) < 0 and not is_link(sim, held.id):
            move_body_object(sim, held, sensor)


def _free_name(spec: mujoco.MjSpec, stem: str) -> str:
    return next(name for number in count() if spec.body(name := f"{stem}{number}") is None)


def _hollow_out(sim: LiveScene, spec: mujoco.MjSpec, item: SceneObject) -> None:
    """Turn a link with children into a nameless carrier of its mass, without shapes."""
    model, body = sim.model, spec.body(item.element_name)
    delete_all(spec, [("geom", geom.name) for geom in body.geoms])
    if model.body_mass[item.id] == 0:  # static: the spec has its mass
        return
    body.explicitinertial = True
    body.mass = float(model.body_mass[item.id])
    body.inertia[:] = model.body_inertia[item.id]
    body.ipos[:], body.iquat[:] = model.body_ipos[item.id], model.body_iquat[item.id]
    body.fullinertia[:] = np.nan
    body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _pose_in_parent(sim: LiveScene, body: int) -> Pose:
    """Return the present pose of a body in its parent's frame."""
    sim.refresh()
    return compose(inverse(body_pose(sim, int(sim.model.body_parentid[body]))), body_pose(sim, body))


def _reference(sim: LiveScene, parent: int) -> Pose:
    return IDENTITY if parent == -1 else moving_pose(sim, sim.scene.get(parent))
