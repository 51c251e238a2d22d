"""Motion profiles: several values move from one state to another within limits of velocity, acceleration and jerk.

Ruckig (MIT licence) computes the fastest such motion in closed form, as V-REP's Reflexxes library did; CoppeliaSim
has used it since 4.3. Units are the caller's: rad or m, and their rates per second.
"""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence
from enum import IntEnum
from types import ModuleType

from simx_client.protocol.cli.installing import package_line
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

MOST_VALUES = 100
"""Maximum number of values in a profile. An arm has 7; a profile must take only a fraction of a simulation step."""

_ROUNDING = 1e-9
"""Seconds by which a sum of time steps may miss the intended duration."""


class Synchronisation(IntEnum):
    """Which values arrive together; the numbers are those of the flags of sim.ruckigPos."""

    PHASE = 0
    """All arrive together, on a straight line if possible."""
    TIME = 1
    NONE = 3


@dataclass(frozen=True, slots=True)
class State:
    """The state at one moment; lists of the same length."""

    position: Sequence[float]
    velocity: Sequence[float]
    acceleration: Sequence[float]

    def __len__(self) -> int:
        return len(self.position)

    def flat(self) -> list[float]:
        """Return positions, velocities, accelerations, as sim.ruckigPos takes them."""
        return [*self.position, *self.velocity, *self.acceleration]


@dataclass(frozen=True, slots=True)
class Limits:
    """Magnitudes per value.

    `least_*`: the negative bounds where they differ. A jerk of 0 or less means no limit, as with the jerk-less
    library that V-REP came with; so does infinity.
    """

    velocity: Sequence[float]
    acceleration: Sequence[float]
    jerk: Sequence[float]
    least_velocity: Sequence[float] | None = None
    least_acceleration: Sequence[float] | None = None


@dataclass(frozen=True, slots=True)
class Goal:
    """The goal of a profile; with `position` None only the velocity counts."""

    position: Sequence[float] | None
    velocity: Sequence[float]


class Profile:
    """The motion from a state to a goal, and the present time in it."""

    def __init__(
        self,
        start: State,
        goal: Goal,
        limits: Limits,
        synchronisation: Synchronisation = Synchronisation.PHASE,
        selected: Sequence[bool] | None = None,
    ) -> None:
        """Compute a profile.

        Args:
            start: the first state.
            goal: the last state.
            limits: velocity, acceleration and jerk.
            synchronisation: which values arrive together.
            selected: the values that take part; the others stay as they are.

        Raises:
            CommandError: the motion is impossible (the text contains Ruckig's reason), or Ruckig is not installed.
        """
        ruckig = _library()
        count = len(start)
        if not 1 <= count <= MOST_VALUES:
            raise CommandError(f"a motion profile has 1 to {MOST_VALUES} values, not {count}")
        self.time = 0.0
        self._start = start
        self._selected = [True] * count if selected is None else [bool(each) for each in selected]
        self._trajectory = ruckig.Trajectory(count)
        wanted = ruckig.InputParameter(count)
        wanted.synchronization = {
            Synchronisation.PHASE: ruckig.Synchronization.Phase,
            Synchronisation.TIME: ruckig.Synchronization.Time,
            Synchronisation.NONE: ruckig.Synchronization.No,
        }[synchronisation]
        wanted.enabled = self._selected
        wanted.current_position = list(start.position)
        wanted.current_velocity = list(start.velocity)
        wanted.current_acceleration = list(start.acceleration)
        if goal.position is None:
            wanted.control_interface = ruckig.ControlInterface.Velocity
        else:
            wanted.target_position = list(goal.position)
        wanted.target_velocity = list(goal.velocity)
        wanted.max_velocity = list(limits.velocity)
        wanted.max_acceleration = list(limits.acceleration)
        wanted.max_jerk = [each if each > 0 else math.inf for each in limits.jerk]
        if limits.least_velocity is not None:
            wanted.min_velocity = list(limits.least_velocity)
        if limits.least_acceleration is not None:
            wanted.min_acceleration = list(limits.least_acceleration)
        _check(limits)
        try:
            result = ruckig.Ruckig(count).calculate(wanted, self._trajectory)
        except ruckig.RuckigError as problem:
            # Only the first line gives the reason; the rest repeats the numbers.
            text = str(problem).strip().splitlines()[0].removeprefix("[ruckig] ")
            if "error in step" in text or "conflict in step" in text:
                text = "the numbers are too far apart; look for one that is by far too large or too small"
            raise CommandError(f"no motion within these limits: {text}") from None
        except ValueError:  # Ruckig's code -101 has no name in Python
            raise CommandError(
                "no motion within these limits: it would take too long; raise the limits"
            ) from None
        if result not in (ruckig.Result.Working, ruckig.Result.Finished):
            raise CommandError(f"no motion within these limits: {result.name}")

    @property
    def duration(self) -> float:
        """Return the duration of the whole motion in seconds."""
        return self._trajectory.duration

    @property
    def is_over(self) -> bool:
        return self.time >= self.duration - _ROUNDING

    @property
    def time_left(self) -> float:
        """Return the seconds until the goal; negative after it."""
        return self.duration - self.time

    def advance(self, seconds: float) -> State:
        """Advance the time and return the state. After the goal its velocity is kept."""
        self.time += seconds
        return self.at(self.time)

    def goal(self) -> State:
        """Return the state at the end; its acceleration is 0.

        Without a limit of jerk, the acceleration jumps to 0 there.
        """
        end = self.at(self.duration)
        return State(end.position, end.velocity, [0.0] * len(end))

    def at(self, time: float) -> State:
        """Return the state at a time in seconds after the start."""
        lists = self._trajectory.at_time(time)[:3]
        kept = (self._start.position, self._start.velocity, self._start.acceleration)
        return State(
            *(
                [now if on else before for now, before, on in zip(new, old, self._selected, strict=True)]
                for new, old in zip(lists, kept, strict=True)
            )
        )


def line(length: float, velocity: float, acceleration: float) -> Profile:
    """Return a profile from 0 to a length, from rest to rest; an acceleration of 0 or less means no limit."""
    limits = Limits([velocity], [acceleration if acceleration > 0 else math.inf], [math.inf])
    return Profile(State([0.0], [0.0], [0.0]), Goal([length], [0.0]), limits)


def _library() -> ModuleType:
    """Load Ruckig when a profile is requested: some systems have no wheel of it, and most scenes do not need it.

    Raises:
        CommandError: it is not installed.
    """
    try:
        import ruckig
    except ImportError:
        raise CommandError(
            f"motion profiles need the package ruckig, which is not installed (for {platform.machine()} on "
            f"{platform.system()} there may be no wheel); where there is a C++ compiler: {package_line('ruckig')}"
        ) from None
    return ruckig


def _check(limits: Limits) -> None:
    for what, values in (("velocity", limits.velocity), ("acceleration", limits.acceleration)):
        for index, value in enumerate(values, 1):
            if not value > 0:
                raise CommandError(f"the greatest {what} must be above 0, but number {index} is {value:g}")
