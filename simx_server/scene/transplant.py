"""Surgery on an MjSpec: moving a body with all below it, moving a leaf element, deleting with all that refers to it.

MjSpec can delete a body, but not move one. A body is moved by copying it element by element under its new parent: the
originals are renamed first, so that whatever names them (actuators, sensors, tendons, equalities, exclusions) means the
copies from then on, and are deleted afterwards.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.poses import Pose
from simx_server.scene.tree import INTERNAL

_OLD = INTERNAL + "old:"

_NOT_COPIED = frozenset(
    {
        *(
            "id",
            "signature",
            "parent",
            "frame",
            "frames",
            "classname",
            "compiler",
            "plugin",
            "info",
            "childclass",
        ),
        *("bodies", "geoms", "joints", "sites", "cameras", "lights"),
    }
)

_LEAVES = {"site": "sites", "camera": "cameras", "light": "lights", "geom": "geoms", "joint": "joints"}


def move_body(
    spec: mujoco.MjSpec,
    name: str,
    new_parent: str,
    local: Pose,
    *,
    free: bool | None = None,
) -> None:
    """Move a body under another one (`world`: the top) with this local pose.

    `free`: True gives it a free joint if it has none, False takes one away, None leaves joints as they are.
    Raises CommandError for bodies with plugins.
    """
    old = spec.body(name)
    _rename_all(old)
    new = find_body(spec, new_parent).add_body()
    _copy_body(old, new)
    _set_pose(new, local)
    if free is True and not any(j.type == mujoco.mjtJoint.mjJNT_FREE for j in new.joints):
        new.add_freejoint().name = f"{INTERNAL}free:{name}"
    spec.delete(old)
    if free is False:
        for joint in list(new.joints):
            if joint.type == mujoco.mjtJoint.mjJNT_FREE:
                delete(spec, "joint", joint.name)


def move_leaf(
    spec: mujoco.MjSpec, element: str, name: str, new_parent: str, local: Pose, size: np.ndarray | None = None
) -> None:
    """Move a site, camera or light to another body with this local pose. `size`: of a site, as compiled."""
    old = getattr(spec, element)(name)
    old.name = _OLD + name
    new = getattr(find_body(spec, new_parent), f"add_{element}")()
    _copy(old, new)
    if size is not None:
        new.size[:] = size
        new.fromto[:] = np.nan
    _set_pose(new, local)
    spec.delete(old)


def move_joint(spec: mujoco.MjSpec, name: str, new_body: str) -> None:
    """Move a joint to another body, with the same place and axis in that body's frame."""
    old = spec.joint(name)
    old.name = _OLD + name
    _copy(old, find_body(spec, new_body).add_joint())
    spec.delete(old)


def delete(spec: mujoco.MjSpec, element: str, name: str) -> None:
    """Delete an element and every actuator, sensor, tendon, equality and so on that cannot exist without it."""
    if element == "tendon":
        _delete_references(spec, "tendon", name)
        spec.delete(spec.tendon(name))
        return
    if element == "body":
        for child in list(spec.body(name).bodies):
            delete(spec, "body", child.name)
        for kind, many in _LEAVES.items():
            for leaf in list(getattr(spec.body(name), many)):
                delete(spec, kind, leaf.name)
    _delete_references(spec, element, name)
    spec.delete(getattr(spec, element)(name))


def gather_geoms(spec: mujoco.MjSpec, name: str) -> None:
    """Move the geoms of the world into a new body at its origin."""
    body = spec.worldbody.add_body(name=name)
    frames: dict[int, Any] = {}
    for old in list(spec.worldbody.geoms):
        old.name = _OLD + old.name
        twin = body.add_geom()
        _copy(old, twin)
        _copy_frame(old, twin, body, frames)
        spec.delete(old)


def find_body(spec: mujoco.MjSpec, name: str) -> Any:
    """A body of the spec; `world` for the world."""
    return spec.worldbody if name == "world" else spec.body(name)


def _delete_references(spec: mujoco.MjSpec, element: str, name: str) -> None:
    object_type = {
        "body": (mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_XBODY),
        "joint": (mujoco.mjtObj.mjOBJ_JOINT,),
        "geom": (mujoco.mjtObj.mjOBJ_GEOM,),
        "site": (mujoco.mjtObj.mjOBJ_SITE,),
        "camera": (mujoco.mjtObj.mjOBJ_CAMERA,),
        "light": (mujoco.mjtObj.mjOBJ_LIGHT,),
        "tendon": (mujoco.mjtObj.mjOBJ_TENDON,),
        "actuator": (mujoco.mjtObj.mjOBJ_ACTUATOR,),
    }[element]
    transmissions = {
        "joint": (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT),
        "tendon": (mujoco.mjtTrn.mjTRN_TENDON,),
        "site": (mujoco.mjtTrn.mjTRN_SITE, mujoco.mjtTrn.mjTRN_SLIDERCRANK),
        "body": (mujoco.mjtTrn.mjTRN_BODY,),
    }.get(element, ())
    for sensor in list(spec.sensors):
        if (sensor.objname == name and sensor.objtype in object_type) or (
            sensor.refname == name and sensor.reftype in object_type
        ):
            spec.delete(sensor)
    for actuator in list(spec.actuators):
        if actuator.trntype in transmissions and name in (
            actuator.target,
            actuator.refsite,
            actuator.slidersite,
        ):
            delete(spec, "actuator", actuator.name)
    for equality in list(spec.equalities):
        if name in (equality.name1, equality.name2) and _equality_kind(equality) == element:
            spec.delete(equality)
    if element in ("site", "joint", "geom"):
        for tendon in [t for t in spec.tendons if _wraps(t, name)]:
            delete(spec, "tendon", tendon.name)
    if element == "geom":
        for pair in [p for p in spec.pairs if name in (p.geomname1, p.geomname2)]:
            spec.delete(pair)
    if element == "body":
        for exclude in [e for e in spec.excludes if name in (e.bodyname1, e.bodyname2)]:
            spec.delete(exclude)


def _equality_kind(equality: Any) -> str:
    kind = equality.type
    if kind == mujoco.mjtEq.mjEQ_JOINT:
        return "joint"
    if kind == mujoco.mjtEq.mjEQ_TENDON:
        return "tendon"
    return "site" if equality.objtype == mujoco.mjtObj.mjOBJ_SITE else "body"


def _wraps(tendon: Any, name: str) -> bool:
    for wrap in tendon.path:
        target = getattr(wrap, "target", None)
        side = getattr(wrap, "sidesite", None)
        if any(element is not None and element.name == name for element in (target, side)):
            return True
    return False


def _rename_all(body: Any) -> None:
    body.name = _OLD + body.name
    for many in _LEAVES.values():
        for leaf in getattr(body, many):
            leaf.name = _OLD + leaf.name
    for child in body.bodies:
        _rename_all(child)


def _copy_body(old: Any, new: Any) -> None:
    """Everything of a body and below into an empty one. Frames are copied with what stands in them."""
    _copy(old, new)
    frames: dict[int, Any] = {}
    for kind, many in _LEAVES.items():
        for leaf in getattr(old, many):
            twin = getattr(new, f"add_{kind}")()
            _copy(leaf, twin)
            _copy_frame(leaf, twin, new, frames)
    for child in old.bodies:
        twin = new.add_body()
        _copy_body(child, twin)
        _copy_frame(child, twin, new, frames)


def _copy_frame(old: Any, new: Any, body: Any, frames: dict[int, Any]) -> None:
    if old.frame is not None:
        new.set_frame(_frame_twin(old.frame, body, frames))


def _frame_twin(old: Any, body: Any, frames: dict[int, Any]) -> Any:
    if old.id not in frames:
        twin = body.add_frame()
        twin.pos[:], twin.quat[:] = old.pos, old.quat
        _copy_orientation(old.alt, twin.alt)
        if old.frame is not None:
            twin.set_frame(_frame_twin(old.frame, body, frames))
        frames[old.id] = twin
    return frames[old.id]


def _copy(old: Any, new: Any) -> None:
    if getattr(getattr(old, "plugin", None), "active", False):
        raise CommandError(f"'{old.name}' uses a plugin and cannot be moved")
    for name in dir(old):
        if name.startswith("_") or name in _NOT_COPIED:
            continue
        value = getattr(old, name)
        if callable(value):
            continue
        if name in ("alt", "ialt"):
            _copy_orientation(value, getattr(new, name))
        elif name == "name":
            new.name = value.removeprefix(_OLD)
        elif isinstance(value, np.ndarray):
            getattr(new, name)[:] = value
        else:
            setattr(new, name, value)


def _copy_orientation(old: Any, new: Any) -> None:
    new.type = old.type
    for name in ("axisangle", "xyaxes", "zaxis", "euler"):
        getattr(new, name)[:] = getattr(old, name)


def _set_pose(element: Any, local: Pose) -> None:
    element.pos[:] = local[0]
    if hasattr(element, "quat"):
        element.quat[:] = local[1]
        element.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
