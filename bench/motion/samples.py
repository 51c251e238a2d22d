"""V-REP's own files: whether they run, what still moves at the end, and which physics step they have."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from bench.motion.opened import running
from bench.motion.rest import jitter
from simx_server.errors import CommandError

SECONDS = 30.0


@dataclass(frozen=True)
class Sample:
    """A run of one file."""

    name: str
    physics_step: float
    """Seconds."""
    fastest: float
    """Greatest speed of any part in the last two seconds, m/s."""
    stopped: int
    """Number of scripts that an error has stopped."""
    ran: bool
    """Whether the simulation ran to the end."""
    share: float


class _Stops(logging.Handler):
    """Counts scripts that are stopped."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += " is stopped" in record.getMessage()


def run_sample(file: Path) -> Sample:
    """Run a file for half a minute."""
    stops = _Stops()
    logging.getLogger().addHandler(stops)
    try:
        with running(str(file)) as one:
            fastest = jitter(one, settle=SECONDS - 2.0, watch=2.0)
            return Sample(
                name=file.stem,
                physics_step=float(one.model.opt.timestep),
                fastest=fastest,
                stopped=stops.count,
                ran=one.world.simulation.is_running,
                share=one.share,
            )
    finally:
        logging.getLogger().removeHandler(stops)


def samples(folder: Path) -> Iterator[Sample]:
    """Yield the runs of all files below a folder."""
    for file in sorted(folder.rglob("*.tt[mt]"), key=lambda each: each.stem.lower()):
        try:
            yield run_sample(file)
        except CommandError as error:
            logging.getLogger("bench").warning("%s: %s", file.name, error)
