"""The clock and the scheduling of a run, and the processor time that other programs take meanwhile."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path

_PROC = Path("/proc")
_TICK = 1 / os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 0.01

MOST_SHARE = 0.15
"""Cores: a turn is disturbed while other programs, and other guests of the host, use more than this."""

_GRANULARITY = 0.03
"""Seconds that the system's counters may be wrong."""

_POLICIES = ("SCHED_OTHER", "SCHED_BATCH", "SCHED_IDLE", "SCHED_FIFO", "SCHED_RR")


def go_real_time() -> bool:
    """Run this process and those that it starts with SCHED_RR, ahead of other programs; return whether it is permitted.

    The kernel leaves other programs a twentieth of the time.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except (AttributeError, OSError):
        return False
    return True


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def scheduling() -> list[str]:
    """Return the clock and the scheduling in words, a line each."""
    clock = time.get_clock_info("perf_counter")
    source = _read("/sys/devices/system/clocksource/clocksource0/current_clocksource")
    governor = _read("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
    lines = [
        f"clock: {clock.implementation}, resolution {clock.resolution * 1e9:.0f} ns"
        + (f", source {source}" if source else ""),
        f"cores used: {cores()} of {os.cpu_count()}; governor "
        + (governor or "not readable, as in most virtual machines"),
    ]
    if hasattr(os, "sched_getscheduler"):
        policy = os.sched_getscheduler(0)
        name = next((name for name in _POLICIES if getattr(os, name, None) == policy), str(policy))
        group = {"1": "on", "0": "off"}.get(_read("/proc/sys/kernel/sched_autogroup_enabled"), "not there")
        lines.append(
            f"scheduling: {name}, nice {os.getpriority(os.PRIO_PROCESS, 0)}; autogroup {group}"
            + (f" ({_read('/proc/self/autogroup')})" if group == "on" else "")
        )
    return lines


def _read(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8").strip()
    except OSError:
        return ""


@dataclass(frozen=True)
class _Sample:
    at: float
    busy: float
    """Seconds of all cores, those of other guests of the host included."""

    own: float
    """Seconds of this process and all that it has started."""


class Disturbance:
    """Watches what other programs take, turn by turn. Off until `begin`: tests must not depend on the machine."""

    def __init__(self) -> None:
        self._is_on = False
        self._left = 0.0
        self.turns = self.repeated = self.disturbed = 0
        """Turns that count, those that were made in addition, and those that count although they were disturbed."""

    def begin(self, seconds: float) -> None:
        """Watch from now on, and spend at most these seconds on repetitions."""
        self._is_on = (_PROC / "stat").is_file()
        self._left = seconds

    @property
    def is_on(self) -> bool:
        """Return whether turns are watched."""
        return self._is_on

    def sample(self) -> _Sample | None:
        """Return the counters now; None while off."""
        if not self._is_on:
            return None
        return _Sample(time.perf_counter(), _busy_seconds(), own_seconds())

    def share(self, before: _Sample | None) -> float:
        """Return the cores that others used since a sample, beyond what may be an error of the counters."""
        after = self.sample()
        if before is None or after is None:
            return 0.0
        span = after.at - before.at
        others = (after.busy - before.busy) - (after.own - before.own) - _GRANULARITY
        return max(0.0, others) / span if span > 0 else 0.0

    def may_repeat(self, seconds: float) -> bool:
        """Return whether there is time for a repetition of this length, and take it."""
        if self._left < seconds:
            return False
        self._left -= seconds
        return True

    def lines(self) -> list[str]:
        """Return in words how much was disturbed."""
        if not self._is_on:
            return ["other programs were not watched: the system does not tell their processor time"]
        return [
            f"{self.turns} turns of measurements count; {self.repeated} more were made because others used more than "
            f"{MOST_SHARE:g} cores, and the quietest were kept; {self.disturbed} of those that count were disturbed"
        ]


DISTURBANCE = Disturbance()
"""That of this run."""


def _busy_seconds() -> float:
    user, nice, system, _, _, irq, softirq, steal = map(
        int, (_PROC / "stat").read_text().splitlines()[0].split()[1:9]
    )
    return (user + nice + system + irq + softirq + steal) * _TICK


def own_seconds() -> float:
    """Return the processor seconds of this process and of all its descendants, those that have ended included."""
    parents: dict[int, int] = {}
    used: dict[int, float] = {}
    for entry in os.listdir(_PROC):
        if not entry.isdigit():
            continue
        try:
            fields = (_PROC / entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        parents[int(entry)] = int(fields[1])
        used[int(entry)] = sum(map(int, fields[11:15])) * _TICK
    me, total = os.getpid(), 0.0
    for process in parents:
        above = process
        while above in parents and above != me:
            above = parents[above]
        if above == me:
            total += used[process]
    return total
