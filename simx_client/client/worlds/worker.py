"""The program's side of a process with some of its worlds: start it, send it calls, end it."""

from __future__ import annotations

import logging
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from multiprocessing.connection import Connection as Pipe
from typing import Any, NamedTuple

from simx_client.calls.marshalling import Shape
from simx_client.errors import ConnectionFailed
from simx_client.protocol.messages import Reply, of_fields

STARTS_WITHIN = 120.0
"""Time-out in seconds for the start of the simulations of one process."""

ENDS_WITHIN = 5.0
"""Time-out in seconds for their end, after which the process is killed."""

Taker = Callable[[Reply], None]


class Order(NamedTuple):
    """The first message to the process."""

    arguments: list[str]
    """Those of ``simx-server``."""

    worlds: int
    """Number of worlds."""

    timeout: float
    """Time-out of calls in seconds."""

    log_level: int


Request = tuple[int, list[tuple[str, list[Any]]]]
"""Index of a world in its process; names of commands with their marshalled arguments."""

Replies = list[tuple[int, list[tuple[Any, ...]]]]
"""For each request the world and the fields of its replies; fewer after a time-out."""


class Worker:
    """A process with some of the worlds."""

    def __init__(self, arguments: list[str], worlds: int, timeout: float) -> None:
        """Start the process; ``wait_until_ready`` waits for its simulations.

        Args:
            arguments: those of ``simx-server``.
            worlds: their number.
            timeout: time-out of their calls in seconds.
        """
        ours, theirs = socket.socketpair()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-m", f"{__package__}.process", str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
            )
        self._pipe = Pipe(ours.detach())
        self._takers: dict[int, list[Taker]] = {}
        self._requests: list[Request] = []
        self.problem = ""
        """Why it does not answer any more."""

        self._send(Order(arguments, worlds, timeout, logging.getLogger().getEffectiveLevel()))

    def wait_until_ready(self) -> None:
        """Wait until the simulations have started.

        Raises:
            ConnectionFailed: with the reason.
        """
        answer = self._receive(time.monotonic() + STARTS_WITHIN)
        if self.problem or answer is not None:
            raise ConnectionFailed(str(answer) if answer is not None else self.problem)

    def add(self, place: int, calls: list[tuple[Shape, list[Any], Taker]]) -> None:
        """Add the calls for one world to the next message."""
        self._takers[place] = [take for _, _, take in calls]
        self._requests.append((place, [(shape.command.name, values) for shape, values, _ in calls]))

    def post(self) -> None:
        """Send the calls for all worlds."""
        requests, self._requests = self._requests, []
        if requests:
            self._send(requests)

    def collect(self, deadline: float) -> None:
        """Receive the replies for all worlds and pass each to its taker."""
        if not self._takers:
            return
        replies: Replies | None = self._receive(deadline)
        takers, self._takers = self._takers, {}
        for place, answers in replies or ():
            for take, fields in zip(takers[place], answers, strict=False):
                take(of_fields(Reply, fields))

    def close(self) -> None:
        """End the simulations and the process. Idempotent."""
        self.problem = self.problem or "it was closed"
        self._pipe.close()
        try:
            self._process.wait(ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _send(self, message: object) -> None:
        if not self.problem:
            try:
                self._pipe.send(message)
            except OSError:
                self._note_end()

    def _receive(self, deadline: float) -> Any:
        if not self.problem:
            try:
                if self._pipe.poll(max(0.0, deadline - time.monotonic())):
                    return self._pipe.recv()
                self.problem = "its process did not answer in time"
            except (EOFError, OSError):
                self._note_end()
        return None

    def _note_end(self) -> None:
        """Note why the process has closed its end."""
        try:
            code = self._process.wait(ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            self.problem = "its process closed the connection"
            return
        reason = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
        self.problem = f"its process (pid {self._process.pid}) ended {reason}"


class WorldConnection:
    """One world of a worker, for `Exchange`."""

    def __init__(self, worker: Worker, place: int, where: str) -> None:
        """Use a world.

        Args:
            worker: its process.
            place: index of the world in that process.
            where: its description for messages.
        """
        self.worker = worker
        self.where = where
        self._place = place

    @property
    def connection_id(self) -> int:
        """Return 1, or -1 when its process does not answer any more."""
        return -1 if self.worker.problem else 1

    @property
    def condition(self) -> str:
        """Describe the state of the connection in words."""
        return self.worker.problem or "connected"

    @property
    def why_gone(self) -> str:
        """Return the reason for calls without an answer when its process does not answer any more."""
        return self.worker.problem

    def send_together(self, calls: Iterable[tuple[Shape, list[Any], Taker]]) -> Sequence[int]:
        """Prepare calls; `Worker.post` sends them. Return an id for each, none if the process has ended."""
        calls = list(calls)
        self.worker.add(self._place, calls)
        return () if self.worker.problem else range(len(calls))

    def receive_until(self, is_enough: Callable[[], bool], deadline: float, *, is_soon: bool) -> None:
        """Receive the replies for all worlds of the process, unless that has been done."""
        if not is_enough():
            self.worker.collect(deadline)

    def forget(self, call_ids: Iterable[int]) -> None:
        """Do nothing: a process that did not answer in time gets no more calls."""
