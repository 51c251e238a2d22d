"""Joints of a URDF as V-REP's importer makes them: motor on under position control, the file's limits, no collisions
between the links that a joint connects.

What V-REP keeps of a joint goes into annotations, so that a scene saved as MJCF has it too.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import mujoco

from simx_server.scene.annotations import PREFIX, SceneError
from simx_server.scene.poses import add, rotate

logger = logging.getLogger(__name__)

_SINGLE = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)

_MOST_PARTED = 20_000
"""Pairs of links that do not collide since a joint connects them, or what they are fixed to."""

_SMALL_MASS, _SMALL_INERTIA = 1e-3, 1e-6
"""kg and kg m^2 of a moving link for which the file gives neither mass nor a shape that collides."""


@dataclass(frozen=True)
class UrdfJoint:
    """What MuJoCo's reader does not keep of a joint."""

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
            effort=_number(limit, "effort", 0.0),
            velocity=_number(limit, "velocity", 0.0),
            is_cyclic=joint.get("type") == "continuous",
            mimic=None
            if mimic is None
            else (mimic.get("joint", ""), _number(mimic, "multiplier", 1.0), _number(mimic, "offset", 0.0)),
        )
    return found


def complete_joints(spec: mujoco.MjSpec, joints: dict[str, UrdfJoint]) -> None:
    """Annotate the hinges and slides, bring them into their limits, and part the links that they connect."""
    names = {joint.name for joint in spec.joints if joint.type in _SINGLE}
    for joint in [each for each in spec.joints if each.type in _SINGLE]:
        described = joints.get(joint.name)
        if described is None:
            continue
        words = _follows(spec, joint, described, names) or ["motor=on", "control=position", "switches=yes"]
        if described.effort > 0:
            words.append(f"max_force={described.effort:g}")
        if described.velocity > 0:
            words.append(f"upper_velocity={described.velocity:g}")
        words.append(f"cyclic={'yes' if described.is_cyclic else 'no'}")
        # V-REP's limit is the motor's and can be set; MuJoCo's would stay beneath it.
        joint.actfrcrange[:] = 0
        joint.actfrclimited = int(mujoco.mjtLimited.mjLIMITED_FALSE)
        spec.add_text(name=f"{PREFIX}joint:{joint.name}", data=" ".join(words))
        _bring_into_limits(joint)
    _part_neighbours(spec)


def give_small_masses(spec: mujoco.MjSpec) -> None:
    """Give moving links without any mass a small one, as MuJoCo cannot move nothing."""
    light: list[str] = []
    for body in spec.bodies:
        if list(body.joints) and not any(_has_mass(each) for each in _rigid_group(body)):
            light.append(body.name)
            body.explicitinertial = True
            body.mass = _SMALL_MASS
            body.inertia[:] = _SMALL_INERTIA
            body.ipos[:], body.iquat[:] = 0.0, (1.0, 0.0, 0.0, 0.0)
    if light:
        logger.warning(
            "%s %s no mass and nothing that collides; taken for %g kg",
            ", ".join(f"'{name}'" for name in light[:5]) + (" ..." if len(light) > 5 else ""),
            "has" if len(light) == 1 else "have",
            _SMALL_MASS,
        )


def _follows(spec: mujoco.MjSpec, joint: Any, described: UrdfJoint, names: set[str]) -> list[str] | None:
    """The words of a dependent joint, which replace MuJoCo's equality; None if it depends on no joint."""
    if described.mimic is None:
        return None
    master, multiplication, offset = described.mimic
    if master not in names or " " in master:
        return None
    for equality in list(spec.equalities):
        if equality.type == mujoco.mjtEq.mjEQ_JOINT and equality.name1 == joint.name:
            spec.delete(equality)
    return ["mode=dependent", f"master={master}", f"multiplication={multiplication:g}", f"offset={offset:g}"]


def _bring_into_limits(joint: Any) -> None:
    """A joint that may not be at 0 begins at the nearest end of its interval, as in V-REP."""
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
    """Links on both sides of a joint do not collide, with all that is fixed to them."""
    left = _MOST_PARTED
    for body in spec.bodies:
        if not any(joint.type in (*_SINGLE, mujoco.mjtJoint.mjJNT_BALL) for joint in body.joints):
            continue
        above = [each for each in _rigid_group(_rigid_root(body.parent)) if _collides(each)]
        below = [each for each in _rigid_group(body) if _collides(each)]
        left -= len(above) * len(below)
        if left < 0:
            raise SceneError(
                f"more than {_MOST_PARTED} pairs of links are connected by joints; fix fewer to each other"
            )
        for one in above:
            for other in below:
                spec.add_exclude(bodyname1=one.name, bodyname2=other.name)


def _rigid_root(body: Any) -> Any:
    while body.name != "world" and not list(body.joints):
        body = body.parent
    return body


def _rigid_group(body: Any) -> Iterator[Any]:
    """A body and all that is fixed to it, at any depth."""
    yield body
    for child in body.bodies:
        if not list(child.joints):
            yield from _rigid_group(child)


def _has_mass(body: Any) -> bool:
    return (body.explicitinertial and body.mass > 0) or _collides(body)


def _collides(body: Any) -> bool:
    return any(geom.contype or geom.conaffinity for geom in body.geoms)


def _number(element: ElementTree.Element | None, key: str, default: float) -> float:
    """An attribute that MuJoCo's reader may not look at; what is no finite number counts as not given."""
    try:
        value = float("" if element is None else element.get(key, ""))
    except ValueError:
        return default
    return value if math.isfinite(value) else default
