"""Types of the compiled module; `_crew.c` documents it."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ._physics_step import PhysicsStep

HEADER: int
SOURCE_HASH: str

WELL: int
NO_ROOM: int
EXCEPTION: int
FAILED: int
REFUSED: int
UNFINISHED: int

TARGET: int
SPRING: int
CYCLIC_SPRING: int
COMMAND: int
FORCE: int
PLACE: int

POSITION: int
LENGTH: int
RATE: int
MOTOR_FORCE: int
BODY_POSITION: int
POSE_POSITION: int
POSE_QUATERNION: int
POSE_ANGLES: int
VELOCITY: int
ANGULAR_VELOCITY: int

Operation = tuple[int, int, int, int, int, int, float, float, float]

class Course:
    was_written: bool
    is_open: bool
    last_flags: int
    done: int
    outcome: int
    error: BaseException
    made: int
    seconds: float
    has_diverged: bool
    is_finite: bool
    has_deep_contacts: bool
    is_rearranged: bool
    has_overlaps: bool
    is_captured: bool
    steps: int
    all_steps: int
    restarts: int
    def __init__(
        self,
        step: PhysicsStep,
        substeps: int,
        flags: int,
        may_skip_means: bool,
        time_step: float,
        writes: list[Operation],
        starts: list[Operation],
        reads: list[Operation],
        frames: NDArray[np.float64],
        block: NDArray[np.float64],
    ) -> None: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def problem(self) -> str: ...
    def begin(
        self,
        positions: NDArray[np.float64] | None,
        poses: NDArray[np.float64],
        is_rearranged: bool,
        has_overlaps: bool,
        /,
    ) -> None: ...
    def capture(self) -> None: ...
    def memory(self) -> tuple[bytes | None, bytes | None, bytes, bytes, bytes, bytes]: ...
    def read(self, results: NDArray[np.float64], /) -> None: ...
    def write(self, values: NDArray[np.float64], /) -> bool: ...

class Crew:
    workers: int
    def __init__(self, count: int, threads: int) -> None: ...
    def step(
        self,
        places: NDArray[np.intp],
        values: NDArray[np.float64],
        results: NDArray[np.float64],
        times: int,
        /,
    ) -> list[int]: ...
    def restart(
        self, places: NDArray[np.intp], values: NDArray[np.float64], results: NDArray[np.float64], /
    ) -> list[int]: ...
    def submit(self, place: int, flags: int, /) -> None: ...
    def next(self, most: int, /) -> int: ...
    def put(self, place: int, course: Course | None, /) -> None: ...
    def close(self) -> None: ...

def connect(addresses: Mapping[str, int], physics_step: object, type: type[PhysicsStep], /) -> None: ...
