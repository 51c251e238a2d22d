"""Where and with what was measured, and what else the machine did meanwhile."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
import statistics
import time
from pathlib import Path

PACKAGES = ("mujoco", "eclipse-zenoh", "numpy", "msgpack", "opencv-python-headless", "lupa")


LOOK_AT_SPEED = 0.1
"""Seconds that a look at a core's speed takes."""


class Watch:
    """Begins when it is made: the load then, and what the machine's processors do until it is asked."""

    def __init__(self) -> None:
        self._speeds = [_speed()]
        self._load = os.getloadavg()
        self._began = time.monotonic()
        self._busy, self._stolen, self._own = *_processors(), _own_seconds()

    def look(self) -> None:
        """To be called now and then: a core of a shared machine may be half as fast for minutes."""
        self._speeds.append(_speed())

    def lines(self) -> list[str]:
        """What is to be said in the end."""
        self.look()
        median, least, most = (f"{pick(self._speeds):.0f}" for pick in (statistics.median, min, max))
        span = time.monotonic() - self._began
        busy, stolen = (
            now - then for now, then in zip(_processors(), (self._busy, self._stolen), strict=True)
        )
        others = max(0.0, busy - (_own_seconds() - self._own)) / span
        return [
            f"load average at the beginning {_loads(self._load)}, in the end {_loads(os.getloadavg())}",
            f"cores in use by everything else meanwhile, the system's own work for this one included: {others:.2f}; "
            f"taken away by the hypervisor: {stolen / span:.2f}",
            f"a core counted to {median} million in a second meanwhile, at least {least}, at most {most}: on a slower "
            "machine, or at a slower time, figures are larger",
        ]


def description() -> list[str]:
    """Date, processor, memory, system and versions."""
    versions = ", ".join(f"{name} {_version(name)}" for name in PACKAGES)
    system = f"{platform.system()} {'.'.join(platform.release().split('.')[:2])}"
    return [
        f"{datetime.datetime.now(datetime.UTC):%Y-%m-%d %H:%M} UTC; {_processor()}, {os.cpu_count()} cores, "
        f"{_memory_gb():.0f} GB of memory; {system}",
        f"Python {platform.python_version()}, {versions}",
    ]


def _speed() -> float:
    """How far a core counts now, in Python, in millions a second."""
    count, until = 0, time.perf_counter() + LOOK_AT_SPEED
    while time.perf_counter() < until:
        for _ in range(1000):
            count += 1
    return count / LOOK_AT_SPEED / 1e6


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:  # another build of OpenCV does as well
        return "(another build)"


def _loads(loads: tuple[float, float, float]) -> str:
    return " / ".join(f"{load:.1f}" for load in loads)


def _processors() -> tuple[float, float]:
    """Seconds since the start that the processors computed, and that the hypervisor gave to others (proc(5), stat)."""
    user, nice, system, _, _, irq, softirq, steal = _ticks()
    per_second = os.sysconf("SC_CLK_TCK")
    return (user + nice + system + irq + softirq) / per_second, steal / per_second


def _ticks() -> list[int]:
    line = Path("/proc/stat").read_text().splitlines()[0]
    return [int(number) for number in line.split()[1:9]]


def _own_seconds() -> float:
    """Of this process and of all that it started and that have ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _memory_gb() -> float:
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
