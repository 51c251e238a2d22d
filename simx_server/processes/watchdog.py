"""End a process that was told to end but does not: a small process beside it, which no call can block.

Python runs a signal's handler only between two of its instructions. So a call into C that does not return (MuJoCo
compiles, a driver waits) keeps the handler from running; a call that holds the interpreter lock also stops every
other thread. But the interpreter writes the signal's number to a descriptor at once (`signal.set_wakeup_fd`), and a
child reads it there. The child is forked before anything large is imported, so it shares nearly all its memory with
its parent.

the first SIGTERM or SIGINT    the process has `GRACE` seconds, then it is killed
the second                     it is killed at once

Windows has no fork: there a thread replaces the child. It runs during a call that releases the interpreter lock.
During a call that holds the lock only the task manager ends the process.
"""

from __future__ import annotations

import contextlib
import gc
import logging
import math
import mmap
import os
import select
import signal
import socket
import threading
import time
from collections.abc import Callable, Collection, Generator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from typing import NoReturn

from simx_client.protocol.cli.exit_codes import INTERRUPTED
from simx_client.protocol.python.light_dataclass import dataclass

from .lifeline import end_with

logger = logging.getLogger(__name__)

GRACE = 4.7
"""Seconds for an orderly end; with the time that the system takes, the process is gone within five.

Closing Zenoh takes four seconds beside a client that does not read.
"""

AT_ONCE = 0.25
"""Seconds after a second signal: a handler that can run ends the process itself, with its own exit code."""

_LEFT = b"\0"
"""The byte written when the process has done its work: no signal has this number."""

_ID_BYTES = 4
"""Size of the id that each process writes first."""

_USUAL_DESCRIPTORS = 64
_MOST_DESCRIPTORS = 1 << 16
"""Maximum number of descriptors: the system's limit may be 2**63, and some systems close them one by one."""
_ENDING = (signal.SIGINT, signal.SIGTERM)
_CHUNK = 4096


class EndRequests:
    """Which processes were told to end by a signal: memory that watchdogs write, and that all forks share."""

    def __init__(self, processes: int) -> None:
        self._memory = mmap.mmap(-1, processes)

    def note(self, number: int) -> None:
        """Note that a process was told to end."""
        self._memory[number] = 1

    def has(self, number: int) -> bool:
        """Return whether a process was told to end, also if it did not, and was killed or crashed."""
        return bool(self._memory[number])


class Watchdog:
    """The watchdog as seen by the processes that it watches: this one, and its later forks (a fleet's servers)."""

    def __init__(
        self,
        members: int = 0,
        lifeline: int | None = None,
        grace: float = GRACE,
        requests: tuple[EndRequests, int] | None = None,
    ) -> None:
        """Start to watch this process. Call it in the main thread, before there are others.

        Args:
            members: number of processes that will be forked and watched too, see `watch`.
            lifeline: a descriptor; when it is closed, this process is to end as well, see `lifeline.end_with`.
            grace: seconds from then until it is killed.
            requests: where to note that this process was told to end, and its number there; its members follow.
        """
        self.requests, self._first = requests or (EndRequests(members + 1), 0)
        self._before = -1
        self._writers: list[int] = []
        if hasattr(os, "fork"):
            self._fork(members, lifeline, grace)
        else:
            if lifeline is not None:
                end_with(lifeline, grace)
            self._here, there = socket.socketpair()
            self._here.setblocking(False)
            threading.Thread(
                target=_watch_from_thread, args=(there,), name="simx-watchdog", daemon=True
            ).start()
            self._before = signal.set_wakeup_fd(self._here.fileno(), warn_on_full_buffer=False)

    def _fork(self, members: int, lifeline: int | None, grace: float) -> None:
        with _room_for(2 * members):
            pipes = [os.pipe() for _ in range(members + 1)]
            readers, self._writers = [list(ends) for ends in zip(*pipes, strict=True)]
            # A signal to the whole group must not reach the child before it ignores it.
            masked = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
            try:
                if os.fork() == 0:
                    _become_watchdog(readers, lifeline, grace, partial(self._note, readers))
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, masked)
            for reader in readers:
                os.close(reader)
        self._announce(0)

    def _note(self, readers: Sequence[int], reader: int) -> None:
        """Note, in the watchdog's process, that a process was told to end."""
        self.requests.note(self._first + readers.index(reader))

    def _announce(self, number: int) -> None:
        writer = self._writers[number]
        with contextlib.suppress(BrokenPipeError):  # the watchdog was killed
            os.write(writer, os.getpid().to_bytes(_ID_BYTES, "little"))
        os.set_blocking(writer, False)
        self._before = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)

    def watch(self, number: int) -> None:
        """Watch this process, a fork of the first one; call it in the fork. Members count from 1."""
        for other, writer in enumerate(self._writers):
            if other != number and writer >= 0:
                os.close(writer)
        if self._writers:
            self._announce(number)

    def forked(self, number: int) -> None:
        """Close the member's descriptor in the parent, so that the member's end is noticed."""
        if self._writers:
            os.close(self._writers[number])
            self._writers[number] = -1

    def leave(self) -> None:
        """Note that this process's work is done.

        The watchdog ignores the next signal, but not one that has come already: for that the descriptor stays open
        until the process ends.
        """
        signal.set_wakeup_fd(self._before)
        if not self._writers:
            self._here.send(_LEFT)
            return
        with contextlib.suppress(BrokenPipeError):
            os.write(self._writers[0], _LEFT)


@contextmanager
def _room_for(descriptors: int) -> Generator[None]:
    """Raise the limit of open descriptors within the block: a large fleet needs many for a moment."""
    import resource  # POSIX only

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = descriptors + _USUAL_DESCRIPTORS
    if soft == resource.RLIM_INFINITY or soft >= wanted:
        yield
        return
    resource.setrlimit(
        resource.RLIMIT_NOFILE, (wanted if hard == resource.RLIM_INFINITY else min(wanted, hard), hard)
    )
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@contextmanager
def watched(
    members: int = 0,
    lifeline: int | None = None,
    grace: float = GRACE,
    requests: tuple[EndRequests, int] | None = None,
) -> Generator[Watchdog | None]:
    """Watch this process within the block, see `Watchdog`; yield None where another thread handles signals."""
    if threading.current_thread() is not threading.main_thread():
        if lifeline is not None:
            end_with(lifeline, grace)
        yield None
        return
    watchdog = Watchdog(members, lifeline, grace, requests)
    try:
        yield watchdog
    finally:
        watchdog.leave()


@dataclass
class _Told:
    """The signals that a process received, and when it must have ended."""

    process_id: int = 0
    by: float = math.inf
    """Deadline on the monotonic clock."""

    signals: int = 0
    has_left: bool = False

    def hear(self, said: Collection[int]) -> None:
        """Take in the numbers of received signals."""
        for number in said:
            if number in _ENDING:
                self.signals += 1
                self.give(GRACE if self.signals == 1 else AT_ONCE)
            elif number == _LEFT[0] and self.by == math.inf:
                self.has_left = True

    def give(self, seconds: float) -> None:
        """Set the deadline to this many seconds from now, if it is not earlier already."""
        self.by = min(self.by, time.monotonic() + seconds)

    def seconds_left(self) -> float:
        return self.by - time.monotonic()


def _become_watchdog(
    readers: Sequence[int], lifeline: int | None, grace: float, note: Callable[[int], None]
) -> NoReturn:
    """Run the child: it must never return into the parent's code."""
    try:
        signal.set_wakeup_fd(-1)
        for number in (*_ENDING, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDING)
        gc.disable()  # a collection would write to all the shared memory
        _hold_only((2, *readers, *(() if lifeline is None else (lifeline,))))
        _Keeper(readers, lifeline, grace, note).keep()
    except BaseException:
        logger.exception("the watchdog failed; a server that hangs has to be killed by hand")
    finally:
        os._exit(0)


def _hold_only(kept: Sequence[int]) -> None:
    """Close every other descriptor: a reader of the server's output must see its end."""
    edges = [-1, *sorted(set(kept)), max(_MOST_DESCRIPTORS, *kept)]
    for low, high in pairwise(edges):
        if low + 1 < high:  # Python's closerange(0, 0) closes all
            os.closerange(low + 1, high)


class _Keeper:
    """The watchdog's state of each process, by the descriptor from which it hears it."""

    def __init__(
        self, readers: Sequence[int], lifeline: int | None, grace: float, note: Callable[[int], None]
    ) -> None:
        """Note each descriptor whose process was told to end."""
        self._first, self._note = readers[0], note
        self._lifeline, self._grace = lifeline, grace
        self._told = {reader: _Told() for reader in readers}
        self._poll = select.poll()
        for reader in (*readers, *(() if lifeline is None else (lifeline,))):
            self._poll.register(reader, select.POLLIN)

    def keep(self) -> None:
        """Watch until all have ended."""
        while self._told:
            left = min(told.seconds_left() for told in self._told.values())
            ready = {
                reader
                for reader, _ in self._poll.poll(None if left == math.inf else max(0.0, 1000 * left) + 1)
            }
            for reader in ready - {self._lifeline}:
                self._hear(reader)
            if self._lifeline in ready:
                self._feel(self._lifeline)
            for reader, told in list(self._told.items()):
                if told.seconds_left() <= 0:
                    self._kill(reader, told)

    def _hear(self, reader: int) -> None:
        said, told = os.read(reader, _CHUNK), self._told[reader]
        if told.process_id == 0 and said:
            told.process_id = int.from_bytes(said[:_ID_BYTES], "little")
            said = said[_ID_BYTES:]
        elif not said:  # the process has ended
            told.has_left = True
        told.hear(said)
        if told.signals:
            self._note(reader)
        if told.has_left:
            self._forget(reader)

    def _feel(self, lifeline: int) -> None:
        with contextlib.suppress(OSError):  # an unreadable descriptor counts as ended
            if os.read(lifeline, _CHUNK):
                return
        self._poll.unregister(lifeline)
        if self._first in self._told and not self._told[self._first].process_id:
            self._hear(self._first)  # the id comes at once
        first = self._told.get(self._first)
        if first is None or os.getppid() != first.process_id:
            return
        if not first.signals:  # a second one would keep it from an orderly end
            os.kill(first.process_id, signal.SIGTERM)
        first.give(self._grace)

    def _forget(self, reader: int) -> None:
        self._poll.unregister(reader)
        del self._told[reader]
        if reader == self._first:  # its forks then end automatically, unless they hang (`lifeline`)
            for told in self._told.values():
                told.give(GRACE)

    def _kill(self, reader: int, told: _Told) -> None:
        # After the end of the first process its number may belong to another one.
        if told.process_id and (reader != self._first or os.getppid() == told.process_id):
            logger.error(
                "process %d was told to end and does not, as a call into a library does not return; it is killed",
                told.process_id,
            )
            with contextlib.suppress(ProcessLookupError):
                os.kill(told.process_id, signal.SIGKILL)
        self._forget(reader)


def _watch_from_thread(reader: socket.socket) -> None:
    told = _Told()
    while not told.has_left:
        reader.settimeout(None if told.by == math.inf else max(0.001, told.seconds_left()))
        try:
            told.hear(reader.recv(_CHUNK))
        except TimeoutError:
            logger.error("this process was told to end and does not; it is ended now")
            os._exit(INTERRUPTED)
