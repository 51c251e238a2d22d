"""The physics of the tutorial's scene in this process: a pass of the server's simulation, and its bare steps."""

from __future__ import annotations

import os
from contextlib import ExitStack
from unittest.mock import patch

import mujoco

from simx_server.app.server import open_world
from simx_server.joints.native.loading import VARIABLE
from simx_server.settings.settings import Settings


class Physics:
    """The scene as it is after the start."""

    def __init__(
        self,
        stack: ExitStack,
        time_step: float | None = None,
        scene: str = "ur5_rg2_kinect",
        *,
        in_python: bool = False,
    ) -> None:
        """Load it, with a simulation step of this many seconds; gone when the stack is closed.

        Args:
            stack: closes it.
            time_step: length of a simulation step in seconds; None: that of the scene.
            scene: name of the scene.
            in_python: whether physics steps are not those in C.
        """
        self.simulation = open_world(Settings(scene=scene, time_step=time_step), stack)
        self.simulation.simulation.start()
        stack.callback(self.simulation.simulation.stop)
        self.model = self.simulation.simulation.model
        self.data = mujoco.MjData(self.model)
        mujoco.mj_copyData(self.data, self.model, self.simulation.simulation.data)
        self.substeps = self.simulation.simulation.substeps
        # The first step chooses the form of all.
        with patch.dict(os.environ, {VARIABLE: "python"} if in_python else {}):
            self.simulation.step()

    @staticmethod
    def count(scene: str, time_step: float) -> int:
        """Return the physics steps of a simulation step of this many seconds."""
        with ExitStack() as stack:
            return open_world(Settings(scene=scene, time_step=time_step), stack).simulation.substeps

    def step(self) -> None:
        """The physics steps of one pass, and nothing else."""
        for _ in range(self.substeps):
            mujoco.mj_step(self.model, self.data)
