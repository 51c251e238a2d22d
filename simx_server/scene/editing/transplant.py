"""Surgery on an MjSpec: move a body with all below it, move a leaf element, delete with all references.

MjSpec can delete a body, but not move one. A body is moved by copying it element by element under its new parent: the
originals are renamed first, so that references by name (actuators, sensors, tendons, equalities, exclusions) mean the
copies from then on, and are deleted afterwards.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mujoco
import numpy as np

from simx_server.scene.formats.annotations import PREFIX
from simx_server.scene.geometry.highlights import SPECULAR
from simx_server.scene.naming.names import INTERNAL
from simx_server.scene.poses.poses import Pose

from .copies.element_copies import LEAVES, Copier
from .least_mass import keep_movable
from .unused_assets import Assets

_OLD = INTERNAL + "old:"

_AS_BEFORE = Copier(lambda name: name.removeprefix(_OLD))

OBJECT_TYPES = {
    "body": (mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_XBODY),
    "joint": (mujoco.mjtObj.mjOBJ_JOINT,),
    "geom": (mujoco.mjtObj.mjOBJ_GEOM,),
    "site": (mujoco.mjtObj.mjOBJ_SITE,),
    "camera": (mujoco.mjtObj.mjOBJ_CAMERA,),
    "light": (mujoco.mjtObj.mjOBJ_LIGHT,),
    "tendon": (mujoco.mjtObj.mjOBJ_TENDON,),
    "actuator": (mujoco.mjtObj.mjOBJ_ACTUATOR,),
}
"""Object types of sensors by kind of element."""

TRANSMISSIONS = {
    "joint": (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT),
    "tendon": (mujoco.mjtTrn.mjTRN_TENDON,),
    "site": (mujoco.mjtTrn.mjTRN_SITE, mujoco.mjtTrn.mjTRN_SLIDERCRANK),
    "body": (mujoco.mjtTrn.mjTRN_BODY,),
}
"""Kind of element that an actuator acts on, by its transmission."""


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
    above = old.parent.name
    _rename_all(old)
    new = find_body(spec, new_parent).add_body()
    _AS_BEFORE.body(old, new)
    set_pose(new, local)
    if free is True and not any(j.type == mujoco.mjtJoint.mjJNT_FREE for j in new.joints):
        new.add_freejoint().name = f"{INTERNAL}free:{name}"
    spec.delete(old)
    if free is False:
        for joint in list(new.joints):
            if joint.type == mujoco.mjtJoint.mjJNT_FREE:
                delete(spec, "joint", joint.name)
    if spec.body(above) is not None:
        keep_movable(spec, above)


def move_leaf(
    spec: mujoco.MjSpec, element: str, name: str, new_parent: str, local: Pose, size: np.ndarray | None = None
) -> None:
    """Move a site, camera or light to another body with this local pose. `size`: of a site, as compiled."""
    old = getattr(spec, element)(name)
    old.name = _OLD + name
    new = getattr(find_body(spec, new_parent), f"add_{element}")()
    _AS_BEFORE.element(old, new)
    if size is not None:
        new.size[:] = size
        new.fromto[:] = np.nan
    set_pose(new, local)
    spec.delete(old)


def move_joint(spec: mujoco.MjSpec, name: str, new_body: str) -> None:
    """Move a joint to another body, with the same place and axis in that body's frame."""
    old = spec.joint(name)
    old.name = _OLD + name
    _AS_BEFORE.element(old, find_body(spec, new_body).add_joint())
    spec.delete(old)


def delete(spec: mujoco.MjSpec, element: str, name: str) -> None:
    """Delete an element and every actuator, sensor, tendon, equality and so on that cannot exist without it."""
    delete_all(spec, [(element, name)])


def delete_all(spec: mujoco.MjSpec, elements: Iterable[tuple[str, str]]) -> None:
    """Delete many (element, name) at once, which is much faster than `delete` for each. Missing ones are skipped.

    Meshes and materials that no geom has any more are deleted too: programs load and remove models all day.
    """
    doomed: dict[str, set[str]] = {kind: set() for kind in (*OBJECT_TYPES, "pair")}
    wanted = list(elements)
    carriers: set[str] = set()
    for element, name in wanted:
        found = getattr(spec, element)(name)
        if found is not None:
            doomed[element].add(name)
            if element == "body":
                carriers.add(found.parent.name)
                _doom_below(found, doomed)
    assets = Assets.of(filter(None, map(spec.geom, doomed["geom"])))
    for reference in _references(spec, doomed):
        spec.delete(reference)
    _delete_bodies(spec, [name for element, name in wanted if element == "body"])
    for element, name in wanted:
        found = getattr(spec, element)(name)  # None: it was deleted with its body
        if found is not None:
            spec.delete(found)
    for name in carriers - doomed["body"]:
        keep_movable(spec, name)
    assets.delete_unused(spec)


def _delete_bodies(spec: mujoco.MjSpec, names: Iterable[str]) -> None:
    """Delete bodies, those of one parent together: MuJoCo copies the whole spec for each deletion."""
    of_parent: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        if (body := spec.body(name)) is not None:
            of_parent.setdefault(body.parent.name, []).append(name)
    for parent, children in of_parent.items():
        # None: it was deleted with one above it.
        bodies: list[Any] = [body for name in children if (body := spec.body(name)) is not None]
        if len(bodies) == 1:
            spec.delete(bodies[0])
        elif bodies:
            together = find_body(spec, parent).add_frame()
            for body in bodies:
                body.set_frame(together)
            spec.delete(together)


def gather_geoms(spec: mujoco.MjSpec, name: str) -> None:
    """Move the geoms of the world into a new body at its origin."""
    body = spec.worldbody.add_body(name=name)
    for old in list(spec.worldbody.geoms):
        old.name = _OLD + old.name
    _AS_BEFORE.leaves(spec.worldbody, body, ["geom"])
    for old in list(spec.worldbody.geoms):
        spec.delete(old)


def find_body(spec: mujoco.MjSpec, name: str) -> Any:
    """Return a body of the spec; `world` for the world."""
    return spec.worldbody if name == "world" else spec.body(name)


def _doom_below(body: Any, doomed: dict[str, set[str]]) -> None:
    for kind, many in LEAVES.items():
        doomed[kind].update(leaf.name for leaf in getattr(body, many))
    for child in body.bodies:
        doomed["body"].add(child.name)
        _doom_below(child, doomed)


def _references(spec: mujoco.MjSpec, doomed: dict[str, set[str]]) -> list[Any]:
    """Return the references to doomed elements; doom tendons and actuators among them too, and their references."""
    paths = doomed["site"] | doomed["joint"] | doomed["geom"]
    tendons = (
        [t for t in spec.tendons if t.name not in doomed["tendon"] and _wraps(t, paths)] if paths else []
    )
    doomed["tendon"].update(tendon.name for tendon in tendons)
    actuators = [a for a in spec.actuators if a.name not in doomed["actuator"] and _acts_on(a, doomed)]
    doomed["actuator"].update(actuator.name for actuator in actuators)
    kind_of = {kind: element for element, kinds in OBJECT_TYPES.items() for kind in kinds}

    def is_doomed(object_type: Any, name: str) -> bool:
        return object_type in kind_of and name in doomed[kind_of[object_type]]

    sensors = [s for s in spec.sensors if is_doomed(s.objtype, s.objname) or is_doomed(s.reftype, s.refname)]
    equalities = [e for e in spec.equalities if not doomed[equality_kind(e)].isdisjoint((e.name1, e.name2))]
    pairs = [p for p in spec.pairs if not doomed["geom"].isdisjoint((p.geomname1, p.geomname2))]
    excludes = [e for e in spec.excludes if not doomed["body"].isdisjoint((e.bodyname1, e.bodyname2))]
    return [*sensors, *actuators, *equalities, *tendons, *pairs, *excludes]


def _acts_on(actuator: Any, doomed: dict[str, set[str]]) -> bool:
    names = {actuator.target, actuator.refsite, actuator.slidersite}
    return any(
        actuator.trntype in kinds and not doomed[element].isdisjoint(names)
        for element, kinds in TRANSMISSIONS.items()
    )


def equality_kind(equality: Any) -> str:
    """Return the kind of elements that an equality connects: joints, tendons, sites or bodies."""
    kind = equality.type
    if kind == mujoco.mjtEq.mjEQ_JOINT:
        return "joint"
    if kind == mujoco.mjtEq.mjEQ_TENDON:
        return "tendon"
    return "site" if equality.objtype == mujoco.mjtObj.mjOBJ_SITE else "body"


def _wraps(tendon: Any, names: set[str]) -> bool:
    for wrap in tendon.path:
        for element in (getattr(wrap, "target", None), getattr(wrap, "sidesite", None)):
            if element is not None and element.name in names:
                return True
    return False


def _rename_all(body: Any) -> None:
    body.name = _OLD + body.name
    for many in LEAVES.values():
        for leaf in getattr(body, many):
            leaf.name = _OLD + leaf.name
    for child in body.bodies:
        _rename_all(child)


def set_pose(element: Any, local: Pose) -> None:
    """Give an element of a spec a pose in its body."""
    element.pos[:] = local[0]
    if hasattr(element, "quat"):
        element.quat[:] = local[1]
        element.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def strip(spec: mujoco.MjSpec) -> None:
    """Remove elements of a whole scene that belong to no object: keyframes, annotations, sensors without an object."""
    for many in (spec.keys, spec.tuples, spec.numerics):
        for element in list(many):
            if not element.name.startswith(SPECULAR):
                spec.delete(element)
    for text in list(spec.texts):
        if text.name.startswith(PREFIX):
            spec.delete(text)
    for sensor in list(spec.sensors):
        if sensor.objtype == mujoco.mjtObj.mjOBJ_UNKNOWN or sensor.objname == "world":
            spec.delete(sensor)
