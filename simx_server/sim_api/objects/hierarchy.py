"""Places of objects in the hierarchy, and the pose that a joint's own motion gives to its children."""

from __future__ import annotations

import math

from simx_client.protocol import constants as c
from simx_server.editing.sibling_order import move_among_siblings, place_among_siblings
from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.poses import IDENTITY, Pose
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads
from simx_server.sim_api.values.matrices import as_numbers, as_pose

_NEAR = 1e-6
"""Tolerance in metres and quaternion components of a pose that should be the identity."""


class HierarchyFunctions(ApiPart, effect="changes"):
    """Functions for the order of siblings, references between objects, and poses of children."""

    @reads
    def getObjectHierarchyOrder(self, handle: int) -> tuple[int, int]:
        """Return the place of an object among its siblings, from 0, and how many they are with it."""
        item = self._sim.scene.get(self._self(handle))
        return place_among_siblings(self._sim, item.handle), len(self._sim.scene.children(item.parent))

    def setObjectHierarchyOrder(self, handle: int, order: int) -> None:
        """Move an object to a place among its siblings, from 0."""
        move_among_siblings(self._sim, self._self(handle), order)

    @reads
    def getObjectChildPose(self, handle: int) -> list[float]:
        """Return the pose of an object's children relative to it: of a joint its own motion, with the error of
        physics; of any other object the identity.
        """
        return as_numbers(self._child_pose(self._self(handle)))

    def setObjectChildPose(self, handle: int, pose: list[float]) -> None:
        """Move a joint so that its children have a pose relative to it: the turn about its axis, the shift along it,
        or any turn of a spherical joint. The other parts of the pose are ignored. Other objects accept the identity.
        """
        own = self._self(handle)
        position, turn = as_pose(pose)
        item = self._sim.scene.get(own)
        if item.kind != ObjectKind.JOINT:
            numbers = (*position, *(abs(part) for part in turn))
            if any(abs(a - b) > _NEAR for a, b in zip(numbers, (0, 0, 0, 1, 0, 0, 0), strict=True)):
                raise CommandError(f"'{item.name}' is not a joint: children have the pose of their parent")
            return
        joints = self._sim.joints
        match joints.joint_type(own):
            case c.sim_joint_spherical_subtype:
                joints.set_spherical_rotation(own, turn)
            case c.sim_joint_prismatic_subtype:
                joints.set_position(own, position[2])
            case _:
                joints.set_position(own, 2.0 * math.atan2(turn[3], turn[0]))

    def _child_pose(self, handle: int) -> Pose:
        item = self._sim.scene.get(handle)
        return self._sim.joints.intrinsic(handle) if item.kind == ObjectKind.JOINT else IDENTITY

    @reads
    def getObjectsWithTag(self, tag: str, only_models: bool = False) -> list[int]:
        """Return the objects that have a custom data block of this name; `only_models`: only bases of models."""
        scene = self._sim.scene
        return [
            handle
            for handle in scene.descendants(-1)
            if (not only_models or scene.is_model_base(handle))
            and self._world.custom_data.read(handle, tag) is not None
        ]
