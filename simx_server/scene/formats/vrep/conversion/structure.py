"""The bodies of a scene, and the body on which each object rides.

V-REP keeps a tree of objects, of which physics links some; MuJoCo keeps a tree of bodies. The rules are V-REP's:

* A dynamic shape is a link when a joint or a force sensor above it holds it; else it is a free body, wherever it is
  in the tree.
* All other objects ride on what their parent rides on. A static shape adds no mass.
* A joint moves what is below it. Physics moves it in force mode, when a dynamic shape or a linked dummy is below it.

Each joint has a separate body, without an object, so that its z axis is the axis of MuJoCo's joint.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from simx_client.protocol import constants as c
from simx_server.scene.formats.annotations import WORLD
from simx_server.scene.formats.vrep.objects import (
    Camera,
    Dummy,
    ForceSensor,
    Graph,
    Joint,
    JointType,
    Light,
    OtherObject,
    Path,
    Shape,
    VrepFile,
    VrepObject,
)
from simx_server.scene.naming.names import INTERNAL
from simx_server.scene.objects import ANNOTATED_KINDS
from simx_server.scene.poses.poses import IDENTITY, NO_TURN, Pose, about, compose, inverse

from .context import Conversion
from .geometry.abilities import annotate_abilities_of_dummy
from .numbers import unusual

LOOP = 0
"""Link type of two dummies that physics holds together."""

Leaf = Callable[[Conversion, Any, Any, Pose], object]
"""Adds an object that is not a body: conversion, object, MjSpec body, the object's frame in that body."""


@dataclass(frozen=True)
class Carrier:
    """The body that carries the children of an object."""

    body: Any
    """A body of the MjSpec."""
    at: Pose
    """The frame of the children in it; of a joint, the moving one."""
    owner: int
    """Handle of the object that the loader would take for their parent, -1 for none."""


class Structure:
    """The bodies of one conversion."""

    def __init__(
        self,
        conversion: Conversion,
        add_shape: Leaf,
        add_joint: Callable[[Conversion, Joint, Any, bool], object],
        leaves: Mapping[type[VrepObject], Leaf],
    ) -> None:
        """Prepare the structure of a file.

        Args:
            add_shape: fills a shape's body; the pose is the identity.
            add_joint: adds a joint to its body; the flag says whether physics moves it.
            leaves: adds all other objects, by class.
        """
        self._conversion = conversion
        self._file = conversion.file
        self._add_shape = add_shape
        self._add_joint = add_joint
        self._leaves = leaves
        self._children = children_of(self._file)
        self._below: dict[int, Carrier] = {}
        """By handle: what the children ride on."""
        self.riding: dict[int, tuple[Any, Pose]] = {}
        """By handle: the body on which the object itself rides, and its frame there."""
        self.world_poses: dict[int, Pose] = {}
        self.moving: set[int] = set()
        """Handles of joints that physics moves."""
        self._linked: dict[int, int] = {}
        """Force sensor to the shape that it holds."""

    def build(self) -> None:
        """Add all objects, parents before their children."""
        top = Carrier(self._conversion.spec.worldbody, IDENTITY, -1)
        moved: dict[int, Pose] = {-1: IDENTITY}
        for order, item in enumerate(self.in_order()):
            world = self.world_poses[item.handle] = compose(moved[item.parent], item.pose)
            moved[item.handle] = compose(world, motion_of(item)) if isinstance(item, Joint) else world
            owner = self._place(item, self._below.get(item.parent, top))
            self._describe(item, order, owner)

    def in_order(self) -> Iterator[VrepObject]:
        """Yield all objects, parents before children, siblings in their order."""
        waiting = list(reversed(self._children.get(-1, [])))
        while waiting:
            item = waiting.pop()
            yield item
            waiting += reversed(self._children.get(item.handle, []))

    def is_dynamic(self, shape: Shape) -> bool:
        """Return whether physics moves a shape: it is dynamic, and no model above it forbids that."""
        return shape.is_dynamic and not self.overridden(shape) & c.sim_modelproperty_not_dynamic

    def overridden(self, item: VrepObject) -> int:
        """Return the `sim_modelproperty_*` bits that an object gets from the models around it."""
        bits, above = 0, item.handle
        while above in self._file.objects:
            one = self._file.objects[above]
            bits |= one.model_properties & 0x0FFF if one.is_model_base else 0
            above = one.parent
        return bits

    def _place(self, item: VrepObject, carrier: Carrier) -> int:
        """Add an object; return the handle of the parent that it has in the model."""
        at = compose(carrier.at, item.pose)
        self.riding[item.handle] = carrier.body, at
        if isinstance(item, Joint):
            return self._place_joint(item, carrier, at)
        if isinstance(item, Shape):
            return self._place_shape(item, carrier, at)
        if isinstance(item, ForceSensor):
            return self._place_force_sensor(item, carrier, at)
        is_frame = isinstance(item, (Dummy, OtherObject)) or type(item) not in self._leaves
        if is_frame and self._children.get(item.handle):
            body = self._add_body(carrier.body, self._conversion.name(item), at)
            self.riding[item.handle] = body, IDENTITY
            self._below[item.handle] = Carrier(body, IDENTITY, item.handle)
            return carrier.owner
        self._add_leaf(item, carrier.body, at)
        self._below[item.handle] = Carrier(carrier.body, at, carrier.owner)
        return carrier.owner

    def _place_joint(self, joint: Joint, carrier: Carrier, at: Pose) -> int:
        is_ball = joint.type == JointType.SPHERICAL
        motion = motion_of(joint)
        name = f"{INTERNAL}joint:{self._conversion.name(joint)}"
        body = self._add_body(carrier.body, name, at if is_ball else compose(at, motion))
        if self._is_moved_by_physics(joint):
            self.moving.add(joint.handle)
        self._add_joint(self._conversion, joint, body, joint.handle in self.moving)
        self._below[joint.handle] = Carrier(body, IDENTITY, joint.handle)
        return carrier.owner

    def _place_shape(self, shape: Shape, carrier: Carrier, at: Pose) -> int:
        parent = self._file.objects.get(shape.parent)
        owner, name = carrier.owner, self._conversion.name(shape)
        is_dynamic = self.is_dynamic(shape)
        if not is_dynamic or isinstance(parent, Joint) or self._linked.get(shape.parent) == shape.handle:
            body = self._add_body(carrier.body, name, at)
        else:
            body = self._add_body(self._conversion.spec.worldbody, name, self.world_poses[shape.handle])
            body.add_freejoint(name=f"{INTERNAL}free:{name}")
            owner = -1
        self.riding[shape.handle] = body, IDENTITY
        self._below[shape.handle] = Carrier(body, IDENTITY, shape.handle)
        is_held = parent is not None and self._linked.get(parent.handle) == shape.handle
        if not is_dynamic or is_held:
            self._conversion.annotate("shape", name, static=not is_dynamic)
        self._add_shape(self._conversion, shape, body, IDENTITY)
        if parent is not None and is_held:
            owner = parent.handle
            self._add_leaf(parent, body, inverse(shape.pose))
            self.riding[parent.handle] = body, inverse(shape.pose)
        return owner

    def _place_force_sensor(self, sensor: ForceSensor, carrier: Carrier, at: Pose) -> int:
        """Add a force sensor. One that holds a dynamic shape is added with the shape, on whose body it lies.

        Any other one has a separate body, so that it measures what pulls at its children: linked dummies.
        """
        held = [
            one
            for one in self._children.get(sensor.handle, [])
            if isinstance(one, Shape) and self.is_dynamic(one)
        ]
        if held:
            self._linked[sensor.handle] = held[0].handle
            self._below[sensor.handle] = Carrier(carrier.body, at, carrier.owner)
            return carrier.owner
        body = self._add_body(carrier.body, f"{INTERNAL}force:{self._conversion.name(sensor)}", at)
        self._add_leaf(sensor, body, IDENTITY)
        self.riding[sensor.handle] = body, IDENTITY
        self._below[sensor.handle] = Carrier(body, IDENTITY, sensor.handle)
        return carrier.owner

    def _add_leaf(self, item: VrepObject, body: Any, at: Pose) -> None:
        self._leaves.get(type(item), add_site)(self._conversion, item, body, at)

    def _is_moved_by_physics(self, joint: Joint) -> bool:
        is_driven = joint.mode == _FORCE_MODE or joint.is_hybrid
        if not is_driven or self.overridden(joint) & c.sim_modelproperty_not_dynamic:
            return False
        below = self._children.get(joint.handle, [])
        return any(
            (isinstance(one, Shape) and self.is_dynamic(one)) or self.loop_partner(one) is not None
            for one in below
        )

    def loop_partner(self, item: VrepObject) -> Dummy | None:
        """Return the dummy that physics holds together with this one; None for any other object."""
        if not isinstance(item, Dummy) or item.link_type != LOOP:
            return None
        partner = self._file.objects.get(item.linked)
        return partner if isinstance(partner, Dummy) and partner is not item else None

    def _add_body(self, parent: Any, name: str, at: Pose) -> Any:
        return parent.add_body(name=name, pos=at[0], quat=at[1])

    def _describe(self, item: VrepObject, order: int, owner: int) -> None:
        """Annotate what MJCF cannot say about an object."""
        conversion, name = self._conversion, self._conversion.name(item)
        parent = None
        if owner != item.parent:
            parent = conversion.names[item.parent] if item.parent != -1 else WORLD
        conversion.annotate(
            "object", name, order=order, parent=parent, layers=f"0x{item.layers & 0xFFFF:04x}"
        )
        conversion.annotate("object", name, alias=item.alias if item.alias not in (None, name) else None)
        if isinstance(item, Dummy):
            annotate_abilities_of_dummy(conversion, item)
        if item.flags & 0xFFFF != _SELECTABLE:
            conversion.annotate("object", name, flags=f"0x{item.flags & 0xFFFF:04x}")
        mark = _mark_of(item)
        if mark is not None and (self._children.get(item.handle) or not isinstance(item, Dummy)):
            conversion.annotate("object", name, mark=mark)
        if isinstance(item, OtherObject) and item.kind in ANNOTATED_KINDS:
            conversion.annotate("object", name, type=item.kind)
        if item.size_factor != 1.0 and item.size_factor > 0:
            conversion.annotate("object", name, size_factor=float(item.size_factor))
        if any(value != 1.0 for value in item.size_values):
            conversion.annotate("object", name, size_values=",".join(repr(v) for v in item.size_values))
        if item.is_model_base:
            bits = item.model_properties & 0x0FFF
            conversion.annotate("model", name, base=True, properties=f"0x{bits:03x}" if bits else None)


_FORCE_MODE = 5
_SELECTABLE = 0x20
"""Flags of an object without others."""


def _mark_of(item: VrepObject) -> float | None:
    """Return the size of an object's mark in metres; None for V-REP's usual size, or no mark."""
    if not isinstance(item, (Dummy, Camera, Light, Graph, Path)):
        return None
    return unusual(item.size, type(item).size)


def children_of(file: VrepFile) -> dict[int, list[VrepObject]]:
    """Return the children of each object by handle, in the order of V-REP; -1 for the top."""
    found: dict[int, list[VrepObject]] = {}
    for item in file.objects.values():
        found.setdefault(item.parent, []).append(item)
    for siblings in found.values():
        siblings.sort(key=lambda one: one.order if one.order is not None else 0)
    return found


def world_poses(file: VrepFile) -> dict[int, Pose]:
    """Return the pose of each object in the world, by handle."""
    poses: dict[int, Pose] = {}
    moved: dict[int, Pose] = {-1: IDENTITY}
    children = children_of(file)
    waiting = list(children.get(-1, []))
    while waiting:
        item = waiting.pop()
        pose = poses[item.handle] = compose(moved[item.parent], item.pose)
        moved[item.handle] = compose(pose, motion_of(item)) if isinstance(item, Joint) else pose
        waiting += children.get(item.handle, [])
    return poses


def motion_of(joint: Joint) -> Pose:
    """Return the pose of a joint's moving frame in its fixed one."""
    if joint.type == JointType.SPHERICAL:
        return (0.0, 0.0, 0.0), joint.turn
    position = position_of(joint)
    if joint.type == JointType.PRISMATIC:
        return (0.0, 0.0, position), NO_TURN
    return (0.0, 0.0, position * joint.pitch), about((0.0, 0.0, 1.0), position)


def position_of(joint: Joint) -> float:
    """Return a joint's position, 0 for one that is not finite."""
    return joint.position if math.isfinite(joint.position) else 0.0


def add_site(conversion: Conversion, item: VrepObject, body: Any, at: Pose) -> None:
    """Add an object that is only a frame."""
    size = item.size / 2 if isinstance(item, Dummy) and 0 < item.size < 1e3 else _SIZE
    color = item.color.diffuse if isinstance(item, Dummy) else (1.0, 1.0, 1.0)
    body.add_site(
        name=conversion.name(item), pos=at[0], quat=at[1], size=[size] * 3, rgba=[*color, 1.0], group=_UNSEEN
    )


_SIZE = 0.005
"""Radius in metres of the mark of objects without a size."""

_UNSEEN = 4
"""A group that images do not show, as for the dummies that programs create."""
