"""``simx``: functions that this server's own scripts need and that V-REP and CoppeliaSim lack."""

from __future__ import annotations

from simx_server.errors import CommandError
from simx_server.kinematics import Element
from simx_server.kinematics.chain import make_arms
from simx_server.scene.objects import ObjectKind

from .base import ApiPart
from .effects import writes_files

_TIP_ENDINGS = ("iktip", "tip")
"""Endings of names in lower case, the more likely one first."""


class SimxFunctions(ApiPart, effect="changes"):
    """All functions of ``simx``."""

    def isCodeAllowed(self) -> bool:
        """Return whether the server was started with --allow-code, so that it runs code sent by clients."""
        return self._world.scripts.allows_code

    @writes_files
    def openFile(self, path: str, append: bool = False) -> int:
        """Open a file of the workspace for writing and return its number; Lua's io.open does so.

        Of a path that leads out of the workspace only the last part counts. The end of a run closes all files.
        """
        return self._world.written_files.open(path, append=append)

    @writes_files
    def writeFile(self, file: int, data: bytes) -> None:
        """Write at the end of an open file."""
        self._world.written_files.write(file, data)

    def flushFile(self, file: int) -> None:
        """Store what was written so far."""
        self._world.written_files.flush(file)

    def closeFile(self, file: int) -> None:
        """Store what was written, and close the file."""
        self._world.written_files.close(file)

    def setSearchSeed(self, seed: int) -> None:
        """Start the random numbers of inverse kinematics and path planning from a seed, 0 or more, now and in each run.

        It holds until the stop if it is set during a run, else until another scene is loaded. Each scene starts with 0,
        so equal runs find equal configurations and paths.
        """
        if seed < 0:
            raise CommandError(f"a seed is 0 or more, not {seed}")
        self._world.ik_groups.seed(seed)

    def getArm(self, robot: int) -> tuple[int, list[int]]:
        """Return the tip of a robot and the joints between the robot and its tip, those nearest to the robot first.

        The tip is that of an IK group of the scene (simx:ik:NAME) below the robot; without one, a dummy below it
        whose name ends in ikTip or tip. All hinges and slides in between count, in any mode.
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
