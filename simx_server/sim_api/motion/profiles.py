"""Motion profiles that a script steps itself: several values, limited in velocity, acceleration and jerk."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.motion_profiles import Goal, Limits, Profile, State, Synchronisation
from simx_server.sim_api.base import ApiPart

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

MIN_VELOCITY, MIN_ACCELERATION = 0x100, 0x200
"""Flags: separate negative bounds follow the others."""

_ONLY_PHASE = 2
"""`sim.rml_only_phase_sync`; as in CoppeliaSim with Ruckig it falls back to time synchronisation."""


class ProfileFunctions(ApiPart):
    """Functions for profiles. Tables hold all positions, then all velocities, then all accelerations, in rad or m.
    The profiles of a script are deleted with it.
    """

    CONSTANTS = MappingProxyType(
        {
            "ruckig_phasesync": 0,
            "ruckig_timesync": 1,
            "ruckig_nosync": 3,
            "ruckig_minvel": MIN_VELOCITY,
            "ruckig_minaccel": MIN_ACCELERATION,
            "rml_phase_sync_if_possible": 0,
            "rml_only_time_sync": 1,
            "rml_only_phase_sync": _ONLY_PHASE,
            "rml_no_sync": 3,
            "rml_keep_target_vel": 0,
            "rml_recompute_trajectory": 4,
            "rml_disable_extremum_motion_states_calc": 8,
            "rml_keep_current_vel_if_fallback_strategy": 16,
        }
    )

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._profiles: dict[int, Profile] = {}
        self._next_profile = 1

    def ruckigPos(
        self,
        count: int,
        _smallest_step: float,
        flags: int,
        state: list[float],
        limits: list[float],
        selection: list[bool],
        goal: list[float],
    ) -> int:
        """Create a profile to a position and velocity; return a handle for ruckigStep.

        Args:
            count: number of values that move.
            _smallest_step: any; time is continuous here.
            flags: a sim.ruckig_*sync, -1 for the default.
            limits: maximum velocities, accelerations, jerks (0: none), then the bounds that the flags announce.
            goal: positions, velocities.
        """
        low, low_acceleration = _announced(flags)
        most = _split(limits, count, 3 + low + low_acceleration, "limits")
        velocities, accelerations, jerks = most[:3]
        bounds = Limits(
            velocities, accelerations, jerks, most[3] if low else None, most[-1] if low_acceleration else None
        )
        position, velocity = _split(goal, count, 2, "a goal: positions and velocities")
        return self._keep(state, Goal(position, velocity), bounds, flags, selection, count)

    def ruckigVel(
        self,
        count: int,
        _smallest_step: float,
        flags: int,
        state: list[float],
        limits: list[float],
        selection: list[bool],
        goal: list[float],
    ) -> int:
        """Create a profile to a velocity at any position; return a handle for ruckigStep.

        Args:
            count: number of values that move.
            _smallest_step: any; time is continuous here.
            flags: as for ruckigPos.
            limits: maximum accelerations, jerks (0: none), then the bounds that the flags announce.
            goal: velocities.
        """
        _, low = _announced(flags)
        most = _split(limits, count, 2 + low, "limits")
        bounds = Limits([math.inf] * count, most[0], most[1], None, most[2] if low else None)
        (velocity,) = _split(goal, count, 1, "a goal: velocities")
        return self._keep(state, Goal(None, velocity), bounds, flags, selection, count)

    def ruckigStep(self, handle: int, seconds: float) -> tuple[int, list[float], float]:
        """Advance by this time; return 0, or 1 once the goal is reached; the new state; and the remaining seconds.

        After the goal its velocity is kept.
        """
        if seconds <= 0:
            raise CommandError(f"a step takes a time above 0, not {seconds:g}")
        profile = self._profile(handle)
        state = profile.advance(seconds)
        return int(profile.is_over), state.flat(), profile.time_left

    def ruckigRemove(self, handle: int) -> int:
        """Delete a profile; return 1."""
        self._profile(handle)
        del self._profiles[handle]
        return 1

    def rmlPosition(
        self,
        count: int,
        seconds: float,
        flags: int,
        state: list[float],
        limits: list[float],
        selection: list[bool],
        goal: list[float],
    ) -> tuple[int, list[float], float]:
        """Make one step of a motion to a position; return what rmlStep returns. V-REP's oldest form."""
        return self._one_step(self.ruckigPos(count, seconds, flags, state, limits, selection, goal), seconds)

    def rmlVelocity(
        self,
        count: int,
        seconds: float,
        flags: int,
        state: list[float],
        limits: list[float],
        selection: list[bool],
        goal: list[float],
    ) -> tuple[int, list[float], float]:
        """Make one step of a motion to a velocity; return what rmlStep returns. V-REP's oldest form."""
        return self._one_step(self.ruckigVel(count, seconds, flags, state, limits, selection, goal), seconds)

    # V-REP's names.
    rmlPos = ruckigPos
    rmlVel = ruckigVel
    rmlStep = ruckigStep
    rmlRemove = ruckigRemove

    def _one_step(self, handle: int, seconds: float) -> tuple[int, list[float], float]:
        try:
            return self.ruckigStep(handle, seconds)
        finally:
            self.ruckigRemove(handle)

    def _keep(
        self, state: list[float], goal: Goal, bounds: Limits, flags: int, selection: list[bool], count: int
    ) -> int:
        """Create and store the profile of `count` values; return its handle."""
        profile = Profile(
            _state(state, count), goal, bounds, synchronisation(flags), _chosen(selection, count)
        )
        handle, self._next_profile = self._next_profile, self._next_profile + 1
        self._profiles[handle] = profile
        return handle

    def _profile(self, handle: int) -> Profile:
        if handle not in self._profiles:
            known = ", ".join(map(str, self._profiles)) or "none"
            raise CommandError(f"no motion profile {handle}; those of this script: {known}")
        return self._profiles[handle]


def synchronisation(flags: int) -> Synchronisation:
    """Return the synchronisation that the two lowest bits select; -1 is the default."""
    kind = flags & 3 if flags >= 0 else 0
    return Synchronisation.PHASE if kind == _ONLY_PHASE else Synchronisation(kind)


def _announced(flags: int) -> list[bool]:
    """Return whether negative bounds of velocity, and of acceleration, follow."""
    return [flags >= 0 and bool(flags & bit) for bit in (MIN_VELOCITY, MIN_ACCELERATION)]


def _split(values: Sequence[float], count: int, parts: int, what: str) -> list[list[float]]:
    """Split values into `parts` lists of `count`; more values are ignored, as in V-REP."""
    if count < 1:
        raise CommandError(f"at least 1 value moves, not {count}")
    if len(values) < count * parts:
        raise CommandError(f"{what} of {count} values are {count * parts} numbers, not {len(values)}")
    return [list(values[index * count : (index + 1) * count]) for index in range(parts)]


def _state(values: Sequence[float], count: int) -> State:
    return State(*_split(values, count, 3, "a state: positions, velocities and accelerations"))


def _chosen(selection: Sequence[bool], count: int) -> list[bool]:
    if len(selection) < count:
        raise CommandError(f"the selection must say of each of {count} values whether it moves (1 or 0)")
    return list(selection[:count])
