"""Count what a server does: simulation steps, calls, failures and images, and how long each took.

The counters are cheap enough to be always on: a command costs two clock readings and one count in a list, about 0.3 us.
Everything belongs to the physics thread, except where it says otherwise. `report.py` makes reports from the counters.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Container, Generator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from simx_client.protocol.commands import ANSWERED, Command
from simx_server.durations import MAX_TEXT, Histogram, ImageTimes
from simx_server.service.clock import Pacer
from simx_server.service.watcher import Watcher

INTERVAL = 1.0
"""Seconds between two samples."""

SAMPLES = 6
"""Samples kept, so that recent figures cover five to six seconds."""

UNKNOWN = "(unknown)"
"""The name for all unknown commands: names that clients invent must not fill the memory."""


class Failures:
    """Calls of one command that ended in an error. Images fail on the render thread."""

    __slots__ = ("failed", "internal", "last", "silent")

    def __init__(self) -> None:
        self.failed = 0
        """With a text for the caller."""

        self.silent = 0
        """Without one: there is nothing to read yet, or any more."""

        self.internal = 0
        """The part of the failed calls with an internal error of the server."""

        self.last = ""


class Sample(NamedTuple):
    """All counters at one instant."""

    wall: float
    processor: float
    steps: int
    simulated: float
    calls: int
    failed: int
    step_times: list[int]
    command_times: dict[str, list[int]]
    image_times: dict[str, list[int]]
    client_calls: dict[str, int]
    warnings: int
    errors: int
    images_failed: int
    lost: float


class LogCount(logging.Handler):
    """Counts what is logged as a warning or worse, on any thread; `handle` holds the handler's lock."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.warnings = 0
        self.errors = 0
        self.last_warning = ""
        self.last_error = ""
        self.error_at = -math.inf
        """When the last error was logged, on the monotonic clock."""

    @contextmanager
    def attached(self) -> Generator[None]:
        """Count what this package and the client log within the block."""
        loggers = [logging.getLogger(name) for name in ("simx_server", "simx_client")]
        for each in loggers:
            each.addHandler(self)
        try:
            yield
        finally:
            for each in loggers:
                each.removeHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()[:MAX_TEXT]
        if record.levelno >= logging.ERROR:
            self.errors, self.last_error, self.error_at = self.errors + 1, text, time.monotonic()
        else:
            self.warnings, self.last_warning = self.warnings + 1, text


class Metrics(Watcher):
    """The counters of one server loop."""

    def __init__(
        self,
        pacer: Pacer,
        now: Callable[[], float] = time.monotonic,
        processor: Callable[[], float] = time.process_time,
        images: ImageTimes | None = None,
    ) -> None:
        """Make counters at zero.

        Args:
            now: the wall clock, seconds.
            processor: seconds of processor time of the process.
            images: those of the simulation's render thread; None: it has none.
        """
        self.pacer = pacer
        self._now, self._processor = now, processor
        self.began = now()
        self.steps = 0
        self.simulated = 0.0
        """Seconds."""

        self.step_times = Histogram()
        self.calls = 0
        self.client_calls: dict[str, int] = {}
        """By client, for those that are connected."""

        self.dropped = 0
        """Messages of clients that were not executed, because too many waited."""

        self.command_times: dict[str, Histogram] = {}
        """By command name: time on the physics thread, for calls and streams alike."""

        self._more_commands: Container[str] = ()

        self.failures: dict[str, Failures] = {}
        self.last_failure = ("", -math.inf)
        """Text of the last failed call, and its time on the monotonic clock."""

        self._failing = threading.Lock()
        """For `failed` alone, which the render thread uses too."""

        self.images = images or ImageTimes()

        self.log = LogCount()
        self._samples: deque[Sample] = deque([self.sample()], maxlen=SAMPLES)
        self._next_sample = self.began + INTERVAL

    # --- counting --------------------------------------------------------------------------------

    def executed(self, command: str, seconds: float, times: int = 1) -> None:
        """Record how many seconds a command has kept the physics thread, and how many times."""
        histogram = self.command_times.get(command)
        if histogram is None:
            name = command if command in ANSWERED or command in self._more_commands else UNKNOWN
            histogram = self.command_times.setdefault(name, Histogram())
        histogram.add(seconds, times)

    def called(self, client: str, calls: int) -> None:
        """Record that a client sent this many calls."""
        self.calls += calls
        self.client_calls[client] = self.client_calls.get(client, 0) + calls

    def left(self, client: str) -> None:
        """Forget a client that has left."""
        self.client_calls.pop(client, None)

    def failed(self, command: str, text: str, *, is_internal: bool = False) -> None:
        """Record that a call ended in an error, with an empty text for a silent one. Any thread."""
        name = command if command in ANSWERED or command in self._more_commands else UNKNOWN
        with self._failing:
            failures = self.failures.setdefault(name, Failures())
            if text:
                failures.failed += 1
                failures.internal += is_internal
                failures.last = text[:MAX_TEXT]
                self.last_failure = (failures.last, time.monotonic())
            else:
                failures.silent += 1

    def passed(self, time_step: float, seconds: float, times: int = 1) -> None:
        """Record that a simulation step was made, or several.

        Args:
            time_step: its simulated seconds.
            seconds: the wall time that it took.
            times: number of steps, each of that time.
        """
        self.steps += times
        self.simulated += time_step * times
        self.step_times.add(seconds, times)

    def count_also(self, names: Container[str]) -> None:
        """Count by their names the calls that another protocol brings, beside the table's commands."""
        self._more_commands = names

    def lost(self, messages: int) -> None:
        """Record that messages of a client were not executed, because too many waited."""
        self.dropped += messages

    def look(self) -> None:
        """Take a sample when one is due. Call this at least once per second."""
        if self._now() >= self._next_sample:
            self._samples.append(self.sample())
            self._next_sample = self._samples[-1].wall + INTERVAL

    # --- reading ---------------------------------------------------------------------------------

    @property
    def age(self) -> float:
        """Return the seconds since the server loop was made."""
        return self._now() - self.began

    def recent(self) -> Sample:
        """Return the oldest sample: the counters as they were some seconds ago."""
        return self._samples[0]

    def sample(self) -> Sample:
        """Return the counters now."""
        with self._failing:
            failed = sum(one.failed for one in self.failures.values())
        return Sample(
            self._now(),
            self._processor(),
            self.steps,
            self.simulated,
            self.calls,
            failed,
            list(self.step_times.counts),
            _copies(self.command_times),
            _copies(self.images.by_camera),
            dict(self.client_calls),
            self.log.warnings,
            self.log.errors,
            self.images.failed,
            self.pacer.lost,
        )


class Tally:
    """Counts executions that follow each other.

    Those of one command are counted together, each with the mean of their durations: counting each one separately costs
    as much as reading a value.
    """

    __slots__ = ("_began", "_called", "_metrics", "command", "count")

    def __init__(self, metrics: Metrics, called: dict[str, int] | None = None) -> None:
        self._metrics = metrics
        self._called = called
        """How often a client called each command; None when streams are counted."""

        self._began = 0.0
        self.command: Command | None = None
        self.count = 0
        """Executions of the present command so far; the executor adds them."""

    def turn_to(self, command: Command | None) -> None:
        """Count what was executed, before another command follows."""
        now = time.perf_counter()
        if self.count and self.command is not None:
            name = self.command.name
            self._metrics.executed(name, (now - self._began) / self.count, self.count)
            if self._called is not None:
                self._called[name] = self._called.get(name, 0) + self.count
        self.command, self._began, self.count = command, now, 0

    def end(self) -> None:
        """Count what was executed, when nothing follows for now."""
        self.turn_to(None)


def _copies(histograms: Mapping[str, Histogram]) -> dict[str, list[int]]:
    return {name: list(each.counts) for name, each in list(histograms.items())}
