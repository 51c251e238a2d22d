"""``simIK``: what a joint of an environment moves, follows and reaches."""

from __future__ import annotations

from simx_server.errors import Unsupported
from simx_server.kinematics.own_objects import OwnJoint
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import NO_TURN, Pose, about
from simx_server.sim_api.effects import reads

from .sim_ik_objects import IkObjectFunctions

_AT_LIMIT = 1e-9
"""Tolerance in rad or m within which a joint is at a limit."""

_OVERLAY = "simIK: overlays that show a group (simIK.createDebugOverlay) are not drawn"


class IkJointFunctions(IkObjectFunctions, effect="changes"):
    """Functions for joints of an environment: of the scene, or made in it."""

    @reads
    def getJointMatrix(self, environment: int, joint: int) -> list[float]:
        """Return the rotation or translation of the joint value: 12 numbers, row-major 3 x 4."""
        return frames.matrix12(self._moved(environment, joint))

    @reads
    def getJointTransformation(
        self, environment: int, joint: int
    ) -> tuple[list[float], list[float], list[float]]:
        """Return the translation, and the rotation as a quaternion and as Euler angles, of the joint value."""
        place, turn = self._moved(environment, joint)
        return list(place), frames.xyzw_from_wxyz(turn), frames.euler_from_quat(turn)

    @reads
    def getJointDependency(self, environment: int, joint: int) -> tuple[int, float, float]:
        """Return master (-1: none), offset and factor: position = offset + factor * master's position."""
        chosen = self._environment(environment)
        chosen.joint_position(joint)
        if joint in chosen.own:
            return -1, 0.0, 1.0
        state = self._sim.joints.state(joint)
        return state.master, state.shift, state.factor

    def setJointDependency(
        self, environment: int, joint: int, master: int, offset: float = 0.0, factor: float = 1.0
    ) -> None:
        """Keep the dependency of a joint. Partly: it is that of the scene; another one is an error."""
        if self.getJointDependency(environment, joint) != (master, offset, factor) and master != -1:
            raise Unsupported(
                "a joint follows another one as in the scene; set that with sim.setJointDependency"
            )

    @reads
    def getJointScrewLead(self, environment: int, joint: int) -> float:
        """Return 0: joints of environments turn or shift, and do not both."""
        self._environment(environment).joint_position(joint)
        return 0.0

    def setJointScrewLead(self, environment: int, joint: int, lead: float) -> None:
        """Accept 0. Partly: joints of environments are not screws; another lead is an error."""
        self._environment(environment).joint_position(joint)
        if lead:
            raise Unsupported("joints of environments are not screws; their lead is 0")

    @reads
    def getGroupJointLimitHits(self, environment: int, group: int) -> tuple[list[int], list[float]]:
        """Return the joints of a group that are at one of their limits, and for each how far it would be beyond.

        Partly: joints stop at their limits, so the distances are 0.
        """
        chosen = self._environment(environment)
        found: list[int] = []
        for joint in self.getGroupJoints(environment, group):
            cyclic, least, extent = chosen.interval(joint)
            position = chosen.joint_position(joint)
            if not cyclic and not least + _AT_LIMIT < position < least + extent - _AT_LIMIT:
                found.append(joint)
        return found, [0.0] * len(found)

    def createDebugOverlay(self, environment: int, group: int) -> int:
        """Return 0. Stand-in: overlays are not drawn."""
        self._group(environment, group)
        self._say_once(_OVERLAY)
        return 0

    def eraseDebugOverlay(self, _overlay: int) -> None:
        """Return nil. Stand-in: overlays are not drawn."""

    def _moved(self, environment: int, joint: int) -> Pose:
        chosen = self._environment(environment)
        value = chosen.joint_position(joint)
        if chosen.joint_type(joint) == OwnJoint.PRISMATIC:
            return (0.0, 0.0, value), NO_TURN
        return (0.0, 0.0, 0.0), about((0.0, 0.0, 1.0), value)
