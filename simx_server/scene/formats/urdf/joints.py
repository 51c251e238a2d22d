"""Joints of a URDF as V-REP's importer makes them: motor on under position control, the file's limits, no collisions
between the links that a joint connects.

V-REP's settings of a joint become annotations, so that a scene saved as MJCF contains them too.
"""

from __future__ import annotations

import logging
import math
from collections import defaultdict
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import mujoco

from simx_server.scene.formats.annotations import PREFIX, SceneError
from simx_server.scene.poses.poses import add, rotate

from .actuation import Actuation
from .names import some
from .numbers import number

logger = logging.getLogger(__name__)

_SINGLE = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)

_DEPENDENT = "mode=dependent"

_MOST_PARTED = 20_000
"""Most pairs of links without collisions because a joint connects them or links fixed to them."""

_SMALL_MASS, _SMALL_INERTIA = 1e-3, 1e-6
"""kg and kg m^2 of a moving link for which the file gives neither mass nor a colliding shape."""


@dataclass(frozen=True)
class UrdfJoint:
    """Values of a joint that MuJoCo's reader does not keep."""

    effort: float
    """Largest torque or force, N m or N; 0: not given."""
    velocity: float
    """Largest velocity, rad/s or m/s; 0: not given."""
    is_cyclic: bool
    mimic: tuple[str, float, float] | None
    """Master, multiplier and offset of a joint that follows another."""


def read_joints(root: ElementTree.Element) -> dict[str, UrdfJoint]:
    """Return the joints of a URDF by name."""
    found: dict[str, UrdfJoint] = {}
    for joint in root.findall("joint"):
        limit, mimic = joint.find("limit"), joint.find("mimic")
        found[joint.get("name", "")] = UrdfJoint(
            effort=_attribute(limit, "effort", 0.0),
            velocity=_attribute(limit, "velocity", 0.0),
            is_cyclic=joint.get("type") == "continuous",
            mimic=None
            if mimic is None
            else (
                mimic.get("joint", ""),
                _attribute(mimic, "multiplier", 1.0),
                _attribute(mimic, "offset", 0.0),
            ),
        )
    return found


def complete_joints(spec: mujoco.MjSpec, joints: dict[str, UrdfJoint], actuation: Actuation) -> None:
    """Annotate hinges and slides, move them into their limits, and exclude collisions of the connected links."""
    names = {joint.name for joint in spec.joints if joint.type in _SINGLE}
    equalities = _equalities_by_joint(spec)
    for joint in [each for each in spec.joints if each.type in _SINGLE]:
        described = joints.get(joint.name)
        if described is None:
            continue
        words = _follows(described, names) or _motor(joint.name, described, actuation)
        if words[0] == _DEPENDENT:
            for equality in equalities.pop(joint.name, ()):  # the annotation replaces it
                spec.delete(equality)
        if described.effort > 0:
            words.append(f"max_force={described.effort:g}")
        if described.velocity > 0:
            words.append(f"upper_velocity={described.velocity:g}")
        words.append(f"cyclic={'yes' if described.is_cyclic else 'no'}")
        # V-REP's limit is the motor's and can be set; MuJoCo's limit would stay in effect below it.
        joint.actfrcrange[:] = 0
        joint.actfrclimited = int(mujoco.mjtLimited.mjLIMITED_FALSE)
        spec.add_text(name=f"{PREFIX}joint:{joint.name}", data=" ".join(words))
        _bring_into_limits(joint)
    _part_neighbours(spec)


def give_small_masses(spec: mujoco.MjSpec) -> None:
    """Give moving links without any mass a small one, as MuJoCo cannot move a body without mass."""
    light: list[str] = []
    heavy = {root for body, root in _rigid_roots(spec).items() if _has_mass(body)}
    for body in spec.bodies:
        if list(body.joints) and body not in heavy:
            light.append(body.name)
            body.explicitinertial = True
            body.mass = _SMALL_MASS
            body.inertia[:] = _SMALL_INERTIA
            body.ipos[:], body.iquat[:] = 0.0, (1.0, 0.0, 0.0, 0.0)
    if light:
        logger.warning(
            "%s %s no mass and nothing that collides; taken for %g kg",
            some(light),
            "has" if len(light) == 1 else "have",
            _SMALL_MASS,
        )


def _equalities_by_joint(spec: mujoco.MjSpec) -> dict[str, list[Any]]:
    """Return MuJoCo's equalities of joints, by the joint that follows another."""
    found: defaultdict[str, list[Any]] = defaultdict(list)
    for equality in spec.equalities:
        if equality.type == mujoco.mjtEq.mjEQ_JOINT:
            found[equality.name1].append(equality)
    return found


def _motor(name: str, described: UrdfJoint, actuation: Actuation) -> list[str]:
    """Return the annotation of a joint that does not follow another one."""
    if described.is_cyclic and actuation.is_without(name):
        return ["motor=off", "switches=yes"]
    control = "velocity" if actuation.is_by_velocity(name) else "position"
    return ["motor=on", f"control={control}", "switches=yes"]


def _follows(described: UrdfJoint, names: set[str]) -> list[str] | None:
    """Return the annotation of a dependent joint; None if it does not depend on a joint."""
    if described.mimic is None:
        return None
    master, multiplication, offset = described.mimic
    if master not in names or " " in master:
        return None
    return [_DEPENDENT, f"master={master}", f"multiplication={multiplication:g}", f"offset={offset:g}"]


def _bring_into_limits(joint: Any) -> None:
    """Set a joint whose limits exclude 0 to the nearest end of its interval, as V-REP does."""
    lower, upper = (float(end) for end in joint.range)
    length = math.hypot(*joint.axis)
    if not lower < upper or lower <= 0 <= upper or not length:
        return
    value = lower if lower > 0 else upper
    body = joint.parent
    axis = tuple(float(part) / length for part in joint.axis)
    joint.ref = value
    if joint.type == mujoco.mjtJoint.mjJNT_SLIDE:
        way = rotate(tuple(body.quat), tuple(value * part for part in axis))
        body.pos[:] = add(tuple(body.pos), way)
        return
    turned = [math.cos(value / 2), *(math.sin(value / 2) * part for part in axis)]
    result = body.quat.copy()
    mujoco.mju_mulQuat(result, body.quat, turned)
    body.quat[:] = result


def _part_neighbours(spec: mujoco.MjSpec) -> None:
    """Exclude collisions of the links on both sides of a joint, with all that is fixed to them."""
    left, roots = _MOST_PARTED, _rigid_roots(spec)
    colliding: defaultdict[Any, list[str]] = defaultdict(list)
    for body, root in roots.items():
        if _collides(body):
            colliding[root].append(body.name)
    for body in spec.bodies:
        if not any(joint.type in (*_SINGLE, mujoco.mjtJoint.mjJNT_BALL) for joint in body.joints):
            continue
        above, below = colliding[roots[body.parent]], colliding[body]
        left -= len(above) * len(below)
        if left < 0:
            raise SceneError(
                f"more than {_MOST_PARTED} pairs of links are connected by joints; fix fewer to each other"
            )
        for one in above:
            for other in below:
                spec.add_exclude(bodyname1=one, bodyname2=other)


def _rigid_roots(spec: mujoco.MjSpec) -> dict[Any, Any]:
    """Return for every body the body that it is fixed to, at any depth: one with joints, the world, or itself."""
    roots: dict[Any, Any] = {}
    waiting = [(spec.worldbody, spec.worldbody)]
    while waiting:
        body, root = waiting.pop()
        roots[body] = root
        children = list(body.bodies)
        waiting += [(child, child if list(child.joints) else root) for child in reversed(children)]
    return roots


def _has_mass(body: Any) -> bool:
    return (body.explicitinertial and body.mass > 0) or _collides(body)


def _collides(body: Any) -> bool:
    return any(geom.contype or geom.conaffinity for geom in body.geoms)


def _attribute(element: ElementTree.Element | None, key: str, default: float) -> float:
    """Return an attribute that MuJoCo's reader may ignore; the default unless it is a finite number."""
    return number(None if element is None else element.get(key), default)
