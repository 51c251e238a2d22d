"""Types of the compiled module; `_physics_step.c` documents it."""

from collections.abc import Callable, Mapping

import mujoco
import numpy as np

HEADER: int
SOURCE_HASH: str
LIMIT_SEPARATION: int
KEEP_DOWN: int
LAST_FORCE: int
UPDATE: int
API: object

class NoRoom(Exception): ...

class PhysicsStep:
    is_finite: bool
    has_deep_contacts: bool
    has_diverged: bool
    seconds: float
    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        table: Mapping[str, np.ndarray],
        friction_rows: int,
        averages_sensors: bool,
        grip: Callable[[mujoco.MjModel, mujoco.MjData], object],
        is_immobile: Callable[[mujoco.MjModel, mujoco.MjData], object],
    ) -> None: ...
    def run(self, made: int, end: int, count: int, seconds: float, flags: int, /) -> int: ...

def connect(
    addresses: Mapping[str, int],
    model_type: type[mujoco.MjModel],
    data_type: type[mujoco.MjData],
    fatal_error: type[Exception],
    /,
) -> None: ...
