"""The task: a UR5 picks up a cube and lays it on a mark. An operator, a program or a network moves its tip.

All of them make the calls of teleoperation that the web viewer makes, so a recording is the same whoever drives.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_client import Client
from simx_client.gym.tasks.pick_place import HALF_CUBE, NEAR, START
from simx_client.protocol.add_ons import teleoperation as t

OBSERVATIONS = ("UR5_tip.position", "Cube.position", "Mark.position", "RG2_openCloseJoint.position")
ACTIONS = ("teleoperation.velocity", "RG2_open.int_signal")
"""Names for ``simx export --observe ... --act ...``."""

STEPS = 300
"""Simulation steps of 50 ms after which an episode has failed."""

Numbers = NDArray[np.float64]
Pilot = Callable[[Numbers], tuple[Numbers, bool]]
"""Returns from (10,) observed numbers the velocity of the tip (3,) in m/s, and whether the gripper is to be open."""


class Cell:
    """The simulation, in this process."""

    def __init__(self, record: Path | None = None) -> None:
        """Open the scene; `record`: a new file for a recording."""
        settings: dict[str, Any] = {} if record is None else {"record": str(record)}
        self.client = Client.embedded("pick_place", **settings)
        self._arm = self.client.joints(*[f"UR5_joint{number}" for number in range(1, 7)])
        self._seen = [self.client.object(name) for name in ("UR5_tip", "Cube", "Mark")]
        self._finger = self.client.joint("RG2_openCloseJoint")

    def episode(self, seed: int, pilot: Pilot) -> bool:
        """Drive one episode, with cube and mark where a seed puts them; return whether it succeeded."""
        random = np.random.default_rng(seed)
        _, cube, mark = self._seen
        signals = self.client.signals.ints
        signals[t.MARK], signals["RG2_open"] = t.STARTED, 1
        is_done = False
        with self.client.stepping(self._observe) as step:
            self._arm.positions = np.array(START)
            self._arm.target_positions = np.array(START)
            cube.position = (random.uniform(-0.3, -0.15), random.uniform(-0.08, 0.05), HALF_CUBE)
            mark.position = (random.uniform(-0.3, -0.15), random.uniform(0.15, 0.25), 0.001)
            observation, was_open = step(), True
            for _ in range(STEPS):
                velocity, is_open = pilot(observation)
                self._call(t.DRIVE, floats=[*velocity.tolist(), 0.0, 0.0, 0.0])
                if is_open != was_open:
                    self._call(t.GRIPPER, integers=[int(is_open)])
                    was_open = is_open
                observation = step()
                if is_done := lies_on_mark(observation):
                    break
            signals[t.MARK] = t.SUCCEEDED if is_done else t.DISCARDED
        return is_done

    def close(self) -> None:
        self.client.close()

    def _observe(self) -> Numbers:
        return np.concatenate([*(each.position for each in self._seen), [self._finger.position]])

    def _call(
        self, function: str, integers: list[int] | None = None, floats: list[float] | None = None
    ) -> None:
        self.client.call(function, t.ADD_ON, integers or [], floats or [], script_type=t.ADD_ON_TYPE)


def lies_on_mark(observation: Numbers) -> bool:
    """Return whether the cube lies on the mark, and the gripper has left it."""
    tip, cube, mark = observation[:3], observation[3:6], observation[6:9]
    is_there = math.hypot(*(cube - mark)[:2]) < NEAR and cube[2] < HALF_CUBE + 0.005
    return bool(is_there and np.linalg.norm(tip - cube) > 2 * HALF_CUBE)
