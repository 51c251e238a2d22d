"""One process of a class as its supervisor sees it: running, ending, or waiting for its next start."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import socket
import time
from pathlib import Path

from simx_server.history.succession import Succession

STEADY = 10.0
"""Seconds after which a process that ends is started again at once."""

PAUSES = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0)
"""Seconds until the next start, by the number of starts in a row that were not steady."""

GRACE = 2.0
"""Seconds that a process has to end; then it is killed."""


class Member:
    """A seat's server or the page's process; it has at most one process at a time. Used by one thread."""

    def __init__(self, number: int, succession: Succession | None = None) -> None:
        """Make a member that is to be started.

        Args:
            number: of the seat, from 1; 0 is the page.
            succession: decides how it continues after a crash; None: it always starts with the scene of the class.
        """
        self.number = number
        self._succession = succession
        self.inheritance = None if succession is None else succession.first()
        """The moments from which the next process continues."""

        self.process_id = 0
        """0 before a start and after an end."""

        self.death = -1
        """Descriptor of the process (pidfd): readable when it has ended."""

        self.reader = -1
        """Pipe in which the process reports that it is ready."""

        self.channel: socket.socket | None = None
        """The end that is not the process's: of a seat the page's end, of the page the supervisor's."""

        self.is_ready = False
        """Set by `note_ready`."""

        self.start_at = 0.0
        """When to start it next, on the monotonic clock; counts while none runs."""

        self.kill_at = math.inf
        """When to kill it, on the monotonic clock."""

        self.reason = ""
        """Why it was ended: for the page; empty after an end that was not asked for."""

        self._began = 0.0
        self._hasty = 0

    @property
    def is_running(self) -> bool:
        return self.process_id != 0

    @property
    def age(self) -> float:
        """Return the seconds since the process was started."""
        return time.monotonic() - self._began

    def begin(self, process_id: int, reader: int, channel: socket.socket) -> None:
        """Take a process that was started."""
        self.process_id, self.reader, self.channel = process_id, reader, channel
        self.death = os.pidfd_open(process_id)
        self.is_ready, self.kill_at, self.reason = False, math.inf, ""
        self._began = time.monotonic()

    def note_ready(self) -> None:
        """Note that the process is ready."""
        self.is_ready = True
        if self._succession is not None:
            self._succession.is_ready()

    def end(self, reason: str) -> None:
        """Request the end of the process, and kill it after `GRACE`; the first reason counts.

        Without a process, end the pause before the next start.
        """
        self.start_at = min(self.start_at, time.monotonic())
        if self.is_running and self.kill_at == math.inf:
            self.reason, self.kill_at = reason, time.monotonic() + GRACE
            self._signal(signal.SIGTERM)

    def kill(self, reason: str = "") -> None:
        """Kill the process."""
        self.reason, self.kill_at = self.reason or reason, time.monotonic() + GRACE
        self._signal(signal.SIGKILL)

    def bury(self) -> int:
        """Close what belonged to the process, which has ended. Returns its exit code, negative for a signal."""
        _, status = os.waitpid(self.process_id, 0)
        for descriptor in (self.death, self.reader):
            os.close(descriptor)
        if self.channel is not None:
            self.channel.close()
        exit_code = os.waitstatus_to_exitcode(status)
        now = time.monotonic()
        continues = self._continues(exit_code)
        is_hasty = not self.reason and not continues and now - self._began < STEADY
        self._hasty = min(self._hasty + 1, len(PAUSES) - 1) if is_hasty else 0
        self.process_id, self.death, self.reader, self.channel = 0, -1, -1, None
        self.start_at, self.kill_at = now + PAUSES[self._hasty], math.inf
        return exit_code

    def _continues(self, exit_code: int) -> bool:
        """Decide how the next process starts; return whether it continues where this one has crashed.

        After a requested end, and after several crashes at the same moment, it starts with the scene of the class.
        """
        if self._succession is None:
            return False
        self.inheritance = None if self.reason else self._succession.next(exit_code)
        if self.inheritance is None:
            self.inheritance = self._succession.first()
        return bool(self.inheritance.ended) and not self.inheritance.back and self.is_ready

    def close(self) -> None:
        """Release the kept moments after the last process."""
        if self._succession is not None:
            self._succession.close()

    def close_in_child(self) -> None:
        """Close this member's descriptors in another member's process."""
        self.close()
        if self.is_running:
            for descriptor in (self.death, self.reader):
                os.close(descriptor)
            if self.channel is not None:
                self.channel.close()

    def memory(self) -> int:
        """Return the bytes of memory that are not files, including pages that it shares with its parent."""
        with contextlib.suppress(OSError, ValueError):
            for line in Path(f"/proc/{self.process_id}/status").read_text(encoding="ascii").splitlines():
                if line.startswith("RssAnon:"):
                    return int(line.split()[1]) << 10
        return 0

    def _signal(self, number: signal.Signals) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.process_id, number)
