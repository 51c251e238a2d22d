"""Configurations: the poses of an object or a tree relative to its parent, and the positions of its joints."""

from __future__ import annotations

from typing import Any

from simx_server.errors import CommandError
from simx_server.handlers import joints
from simx_server.handlers.objects import poses
from simx_server.joints import JointMode
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.scripting.interpreter import Plain
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads
from simx_server.sim_api.values.matrices import as_numbers, as_pose
from simx_server.sim_api.values.tables import pack_table, unpack_table

_NEAR = 1e-9
"""Tolerance in metres or quaternion components: objects that moved by no more are not placed again."""

_SPHERICAL = 12


class ConfigurationFunctions(ApiPart, effect="changes"):
    """Functions for configurations: bytes that only this server reads, and that refer to the objects they were
    taken from.
    """

    @reads
    def getObjectConfiguration(self, handle: int) -> bytes:
        """Return the configuration of one object."""
        return pack_table([self._taken(self._self(handle))])

    def setObjectConfiguration(self, configuration: bytes) -> int:
        self.setConfigurationTree(configuration)
        return 1

    @reads
    def getConfigurationTree(self, handle: int) -> bytes:
        """Return the configuration of an object and all below it."""
        base = self._sim.scene.get(self._self(handle)).handle
        return pack_table([self._taken(each) for each in (base, *self._sim.scene.descendants(base))])

    def setConfigurationTree(self, configuration: bytes) -> int:
        """Restore a configuration. Removed objects are skipped; objects that have to be moved are at rest
        afterwards.
        """
        entry: Plain
        for entry in unpack_table(configuration):
            if not isinstance(entry, dict) or "handle" not in entry:
                raise CommandError("these bytes are no configuration; take one with sim.getConfigurationTree")
            if entry["handle"] in self._sim.scene.objects:
                self._bring_back(entry)
        return 1

    def _taken(self, handle: int) -> dict[str, Any]:
        sim = self._sim
        entry: dict[str, Any] = {
            "handle": handle,
            "pose": as_numbers(frames.get_pose(sim, handle, frames.PARENT)),
        }
        if self._has_one_value(handle):
            entry["position"] = joints.get_joint_position(self._world, handle)
            entry["target"] = sim.joints.target_position(handle)
        return entry

    def _bring_back(self, entry: dict[str, Any]) -> None:
        sim, handle = self._sim, int(entry["handle"])
        present = as_numbers(frames.get_pose(sim, handle, frames.PARENT))
        item = sim.scene.get(handle)
        moved = any(abs(new - old) > _NEAR for new, old in zip(entry["pose"], present, strict=True))
        if moved and item.element != "tendon":
            poses.set_object_pose(self._world, handle, frames.PARENT, as_pose(entry["pose"]))
            self._world.surfaces.put([handle, *sim.scene.descendants(handle)])
        if "position" in entry and self._has_one_value(handle):
            joints.set_joint_position(self._world, handle, entry["position"])
            if sim.joints.mode(handle) == JointMode.FORCE:
                joints.set_joint_target_position(self._world, handle, entry["target"])

    def _has_one_value(self, handle: int) -> bool:
        is_joint = self._sim.scene.get(handle).kind == ObjectKind.JOINT
        return is_joint and self._sim.joints.joint_type(handle) != _SPHERICAL
