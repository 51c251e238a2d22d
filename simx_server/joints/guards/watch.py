"""Checks between the physics steps of one simulation step: does it diverge, does it take too long."""

from __future__ import annotations

import logging
import math
import time
from threading import get_ident
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

logger = logging.getLogger(__name__)

MOST_AT_ONCE = 32
"""Maximum number of physics steps in one call of MuJoCo, which takes the interpreter lock once."""

FIRST_AT_ONCE = 4
"""Physics steps in the first call of a simulation step. The number doubles while the calls stay short."""

GLANCE = 0.02
"""Maximum duration of such a call in seconds."""

RECORDED_AT_ONCE = 8
"""Physics steps in one call while a recording or a replay has to know when other calls were served."""

READ_EVERY = 0.1
"""Seconds between two readings of the thread's processor time, so a limit of seconds is kept within a tenth."""

MANY = 1024
"""A simulation step of more physics steps than these ends at `LONGEST`."""

SERVES_AFTER = 0.1
"""Seconds of a simulation step after which other calls are served within it."""

CUT_AFTER = 1.0
"""Seconds after which a simulation step is aborted when the server is to end."""

WARNS_AFTER = 0.5
"""Seconds of a simulation step after which its total duration is estimated."""

TOO_LONG = 5.0
"""Default time-out in seconds of clients for the answer to a blocking call."""

LONGEST = 10.0
"""Seconds after which a simulation step of many physics steps is aborted and the run stopped."""


DIVERGED = (
    "the physics diverged; a shorter physics step (timestep of <option>) or weaker forces may keep it stable"
)


def are_finite(data: mujoco.MjData) -> bool:
    """Return whether all positions and velocities are finite.

    The square of a vector's length is finite, except for numbers beyond 1e154, and takes a quarter of the time.
    """
    positions, velocities = data.qpos, data.qvel
    return math.isfinite(positions.dot(positions) + velocities.dot(velocities)) or bool(
        np.isfinite(positions).all() and np.isfinite(velocities).all()
    )


class StepFailed(Exception):
    """A simulation step cannot be completed, and the run is to be stopped.

    The text gives the reason and possible remedies.
    """


class TooSlow(StepFailed):
    """A single physics step takes too long; the same state leads to it again."""


class Watch:
    """Divides the simulation steps of one model into calls of MuJoCo, and checks the progress between them."""

    def __init__(self, sim: LiveScene) -> None:
        self._sim = sim
        self._interruptions = sim.interruptions
        self._cost = GLANCE
        """Duration of a physics step in seconds, from the last ones."""
        self._has_warned = False
        self._read_next = 0.0
        """When the thread's time is read again: reading it takes as long as a small physics step."""

        self._thread, self._thread_time = 0, 0.0
        self._began = self._before = 0.0
        """When the simulation step and its last physics steps started."""
        self._count = self._done = 0

    def begin(self, count: int) -> None:
        """Note that the `count` physics steps of a simulation step start."""
        self._began = self._before = now = time.perf_counter()
        if now >= self._read_next or self._thread != get_ident():
            self._thread, self._thread_time = get_ident(), time.thread_time()
            self._read_next = now + READ_EVERY
        self._count, self._done = count, 0

    def next_end(self, *, stops: bool = False) -> int:
        """Return up to which physics step (from 0, of `count`) to go at once.

        Args:
            stops: the caller's steps stop automatically when `GLANCE` has passed, or when physics diverges.
        """
        left = self._count - self._done
        if left > 1:
            if self._interruptions.physics_point is not None:
                left = min(left, RECORDED_AT_ONCE)
            elif not stops:
                most = min(MOST_AT_ONCE, max(FIRST_AT_ONCE, self._done), int(GLANCE / self._cost))
                left = max(1, min(most, left))
        return self._done + left

    def made(self, done: int, *, has_diverged: bool, seconds: float | None = None) -> None:
        """Check the progress after some physics steps.

        Args:
            done: number of physics steps made in this simulation step.
            has_diverged: whether MuJoCo has found bad numbers in them.
            seconds: how long they took in another thread; None: this thread has made them, and nothing else since.

        Raises:
            StepFailed: the simulation step cannot be completed.
        """
        size, self._done = done - self._done, done
        if has_diverged:
            raise StepFailed(DIVERGED)
        now = time.perf_counter()
        self._cost = cost = (now - self._before if seconds is None else seconds) / size or 1e-9
        self._before = now
        # A process that was suspended for a while has not worked during that time.
        longest = self._sim.limits.step_seconds
        if cost > longest and (each := self._each(done, seconds)) > longest:
            raise TooSlow(_too_slow(each, self._sim))
        if done == self._count:
            return
        if now - self._began > SERVES_AFTER:
            self._look_around(now - self._began, done, self._count)
        point = self._interruptions.physics_point
        if point is not None:
            point()

    def _each(self, done: int, seconds: float | None) -> float:
        """Return the processor time of a physics step in seconds, as far as it is known."""
        return ((time.thread_time() - self._thread_time) if seconds is None else seconds) / done

    def _look_around(self, seconds: float, done: int, count: int) -> None:
        """Serve others, warn or abort within a simulation step that has lasted a while."""
        if self._sim.is_ending and seconds > CUT_AFTER:
            raise StepFailed("the server ends, within a long simulation step")
        if count > MANY and seconds > LONGEST:
            raise StepFailed(
                f"a simulation step has {count} physics steps, and not all were made within {LONGEST:g} s; choose a "
                "longer timestep of <option> or a shorter simulation step"
            )
        whole = seconds * count / done
        if whole > TOO_LONG and seconds > WARNS_AFTER and not self._has_warned:
            self._has_warned = True
            logger.warning(
                "a simulation step of %g s has %d physics steps and takes about %.0f s on this machine: blocking calls "
                "wait that long; choose a longer timestep of <option> or a shorter simulation step",
                self._sim.time_step,
                count,
                whole,
            )
        self._interruptions.serve_others()


def _too_slow(seconds: float, sim: LiveScene) -> str:
    reached = sim.limits.reached("step_seconds", "have fewer contacts or objects")
    return (
        f"a physics step took {seconds:.1f} s of processor time; nobody can be served within one; {reached}"
    )


_DIVERGED = slice(int(mujoco.mjtWarning.mjWARN_BADQPOS), int(mujoco.mjtWarning.mjWARN_BADQACC) + 1)


class Divergence:
    """MuJoCo's counts of diverged positions, velocities and accelerations of one state."""

    def __init__(self, data: mujoco.MjData) -> None:
        self._counts: NDArray[np.intc] = data.warning.number[_DIVERGED]

    def forget(self) -> None:
        """Set the counts to 0."""
        self._counts.fill(0)

    @property
    def is_found(self) -> bool:
        """Return whether any was found since the counts were 0."""
        return bool(self._counts.any())
