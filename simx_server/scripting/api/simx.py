"""``simx``: what this server's own scripts ask that neither V-REP nor CoppeliaSim has a function for."""

from __future__ import annotations

from ...errors import CommandError
from ...kinematics import Element
from ...kinematics.chain import make_arms
from ...scene.objects import ObjectKind
from .base import ApiPart

_TIP_ENDINGS = ("iktip", "tip")
"""Of names, lower case, the likelier first."""


class SimxFunctions(ApiPart):
    """The whole namespace."""

    def isCodeAllowed(self) -> bool:
        """Whether the server was started with --allow-code: then code that clients send may be run."""
        return self._world.scripts.allows_code

    def getArm(self, robot: int) -> tuple[int, list[int]]:
        """The tip of a robot and the joints from it up to the robot, those nearest to the robot first.

        The tip is that of an IK group of the scene (simx:ik:NAME) that lies below the robot; without one, a dummy below
        it whose name ends in ikTip or tip. All hinges and slides between count, whatever their mode is.
        """
        scene, handle = self._sim.scene, self._self(robot)
        item = scene.get(handle)
        below = scene.descendants(handle)
        tips = [element.tip for element in self._world.ik_groups.elements() if element.tip in below]
        for ending in _TIP_ENDINGS:
            tips += [
                each
                for each in below
                if scene.objects[each].kind == ObjectKind.DUMMY
                and scene.objects[each].name.split("#")[0].lower().endswith(ending)
            ]
        if not tips:
            raise CommandError(
                f"'{item.name}' has no tip below it: register an inverse kinematics group with a text simx:ik:NAME, "
                "or name a dummy at its end with the ending ikTip"
            )
        joints, _ = make_arms(self._sim, [Element(tips[0], tips[0], handle)], lambda _: True)
        return tips[0], list(joints.handles)
