"""A program that drives a simulation in its own process with the functions of scripts, as PyRep does."""

from __future__ import annotations

from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_client.connection.embedding import start_server

Array = NDArray[np.float64]

WORLD = -1

_SCENE = -12
"""`sim.handle_scene`."""

_STIFF_FRICTION = 100.0
"""MuJoCo's `impratio` of V-REP's files; the shipped scenes have 10."""


class Program:
    """A program with its simulation; a context, at whose end the simulation is closed."""

    def __init__(self, scene: str = "empty") -> None:
        """Open a scene: a name or file."""
        self._server = start_server([scene, "--workspace", "/", "--allow-code"])
        self._library = self._server.library("1", "grasps")
        self.call("setFloatProperty", _SCENE, "mujoco.impratio", _STIFF_FRICTION)

    def __enter__(self) -> Program:
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        self._library.close()
        self._server.close()

    def call(self, function: str, *arguments: Any) -> Any:
        """Call a function of ``sim``; return its result, or all of them if they are several."""
        found = self._library.call(f"sim.{function}", list(arguments))
        return found[0] if len(found) == 1 else found

    def step(self) -> None:
        """Make a simulation step."""
        self._library.step(if_running=True)

    def handle(self, name: str) -> int:
        """Return the handle of an object."""
        found: int = self.call("getObjectHandle", name)
        return found

    def place(self, handle: int, position: Any, frame: int = WORLD) -> None:
        """Put an object at a position in m."""
        self.call("setObjectPosition", handle, frame, [float(each) for each in position])

    def pose(self, handle: int, frame: int = WORLD) -> Array:
        """Return the pose of an object in another one's frame, 3 x 4."""
        return np.array(self.call("getObjectMatrix", handle, frame)).reshape(3, 4)

    def set_pose(self, handle: int, pose: Array) -> None:
        """Put an object at a pose in the world, 3 x 4."""
        self.call("setObjectMatrix", handle, WORLD, pose.ravel().tolist())
