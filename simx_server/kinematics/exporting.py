"""The file of V-REP's external kinematics: objects, joints and groups of a scene for programs that compute without it.

Little-endian, 32 bits a number: a version (0), the objects, the groups. Found out from the files that come with V-REP.
"""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING

from simx_server.scene.link_constraints import IK
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.frames import pose_from_matrix12
from simx_server.scene.poses.placing import moving_pose, object_pose
from simx_server.scene.poses.poses import NO_TURN, compose, inverse

from .chain import Element, largest_step
from .group import Group

if TYPE_CHECKING:
    from simx_server.parts.dummy_links import DummyLinks
    from simx_server.simulation.simulation import Simulation

    from .groups import IkGroups

_VERSION = 0
_NONE = -1
_REVOLUTE, _SPHERICAL = 10, 12

_ENABLED, _RESTORES_POSITION, _RESTORES_ORIENTATION = 1, 2, 4
_AFTER_FAILURE, _AFTER_PERFORMED, _LIMITS_STEPS, _IS_EXPLICIT = 8, 16, 32, 64
"""Bits of a group."""

_LIMIT_WEIGHT = 1.0
"""V-REP's initial weight of limits."""


def exported(sim: Simulation, groups: IkGroups, links: DummyLinks) -> bytes:
    """Return the file of the present scene."""
    sim.refresh()
    targets = groups.links()
    partners = targets | {target: tip for tip, target in targets.items()}
    objects = list(sim.scene.objects.values())
    data = [struct.pack("<2i", _VERSION, len(objects))]
    for item in objects:
        # Kinds that V-REP 3 did not know have no meaning for kinematics.
        kind = ObjectKind.DUMMY if item.kind is ObjectKind.SCRIPT else item.kind
        data.append(struct.pack("<i", kind) + _place(sim, item))
        if item.kind is ObjectKind.JOINT:
            data.append(_joint(sim, item.handle))
        elif item.handle in partners:
            data.append(struct.pack("<2i", partners[item.handle], IK))
        elif item.kind is ObjectKind.DUMMY:
            data.append(struct.pack("<2i", links.linked(item.handle), links.type(item.handle)))
        else:
            data.append(struct.pack("<2i", _NONE, 0))
    listed = groups.all()
    data.append(struct.pack("<i", len(listed)))
    handles = {group.name: handle for handle, group in listed.items()}
    data += [_group(handle, group, handles.get(group.after, _NONE)) for handle, group in listed.items()]
    return b"".join(data)


def _place(sim: Simulation, item: SceneObject) -> bytes:
    """Return an object's pose in its parent's frame, which moves with a joint; its handle, its parent's, its name."""
    pose = object_pose(sim, item)
    if item.parent != _NONE:
        pose = compose(inverse(moving_pose(sim, sim.scene.get(item.parent))), pose)
    return struct.pack("<7f2i", *pose[1], *pose[0], item.handle, item.parent) + _text(item.name)


def _joint(sim: Simulation, handle: int) -> bytes:
    joints = sim.joints
    kind = joints.joint_type(handle)
    is_ball = kind == _SPHERICAL
    state = joints.spherical_state(handle) if is_ball else joints.state(handle)
    cyclic, least, extent = (True, -math.pi, 2 * math.pi) if is_ball else joints.interval(handle)
    turn = pose_from_matrix12(joints.matrix(handle))[1] if is_ball else NO_TURN
    return struct.pack(
        "<i5fB5f2i2f",
        kind,
        0.0,  # pitch of a screw, which no joint is here
        *turn,
        cyclic,
        least,
        extent,
        0.0 if is_ball else joints.position(handle),
        largest_step(is_hinge=kind in (_REVOLUTE, _SPHERICAL)),
        joints.ik_weight(handle),
        joints.mode(handle),
        state.master,
        state.factor,
        state.shift,
    )


def _group(handle: int, group: Group, after: int) -> bytes:
    how, (slide, hinge) = group.how, group.margins
    flags = (
        (_ENABLED if group.enabled else 0)
        | (_RESTORES_POSITION if "position" in group.restore else 0)
        | (_RESTORES_ORIENTATION if "orientation" in group.restore else 0)
        | (_AFTER_FAILURE | _AFTER_PERFORMED)
        | (0 if group.ignores_steps else _LIMITS_STEPS)
        | (_IS_EXPLICIT if group.explicit else 0)
    )
    keeps_margins = any(group.margins)
    return b"".join(
        (
            struct.pack("<i", handle) + _text(group.name),
            struct.pack(
                "<2i4f2i", how.iterations, 0, _LIMIT_WEIGHT, hinge, slide, how.damping, how.method, after
            ),
            struct.pack("<2Bi", flags, keeps_margins, len(group.elements)),
            *(_element(number, each) for number, each in enumerate(group.elements)),
        )
    )


def _element(number: int, element: Element) -> bytes:
    linear, angular = element.precision
    return struct.pack(
        "<4i2fi2fB",
        *(number, element.tip, element.base, element.axes),
        *(angular, linear, element.constraints, *element.weights, element.enabled),
    )


def _text(name: str) -> bytes:
    return name.encode("utf-8", "replace").replace(b"\0", b"") + b"\0"
