"""The simulation: the only owner of MjModel and MjData, used by the physics thread alone."""

from __future__ import annotations

import logging
from collections.abc import Callable
from enum import Enum
from pathlib import Path

import mujoco

from simx_server.joints import Joints
from simx_server.scene.objects import Scene
from simx_server.signals import Signals

logger = logging.getLogger(__name__)


class SimulationState(Enum):
    STOPPED = "stopped"
    RUNNING = "running"
    PAUSED = "paused"


class Simulation:
    """See the methods; every attribute here is public."""

    scene: Scene
    model: mujoco.MjModel
    data: mujoco.MjData
    joints: Joints
    signals: Signals
    state: SimulationState
    version: int
    """Bumped whenever anything visible may have changed."""
    pass_count: int
    """Passes of this run; 0 when stopped."""
    on_start: list[Callable[[], None]]
    on_stop: list[Callable[[], None]]
    on_pause: list[Callable[[], None]]
    on_pass_begin: list[Callable[[], None]]
    on_sensing: list[Callable[[], None]]
    on_load: list[Callable[[], None]]
    on_close: list[Callable[[], None]]
    on_model_changed: list[Callable[[], None]]
    """model, data (new objects!) and scene changed by an edit, or back at stop; also called on load and close."""

    def load(self, path: str | Path) -> None:
        """Raises CommandError while not stopped, SceneError for a bad file (the old scene then stays)."""
        raise NotImplementedError

    def close(self) -> None:
        raise NotImplementedError

    def start(self) -> None:
        raise NotImplementedError

    def pause(self) -> None:
        raise NotImplementedError

    def stop(self) -> None:
        raise NotImplementedError

    def advance(self) -> None:
        raise NotImplementedError

    def changed(self) -> None:
        raise NotImplementedError

    def refresh(self) -> None:
        raise NotImplementedError

    @property
    def time(self) -> float:
        raise NotImplementedError

    def measured_velocity(self, handle: int) -> tuple[list[float], list[float], list[float]]:
        """(linear m/s, Euler-angle rates rad/s, angular velocity rad/s), world frame, over the last pass."""
        raise NotImplementedError
