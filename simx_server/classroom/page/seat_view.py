"""A seat as the page sees it: its last report and images, requested over its channel only when a browser asks.

Requests of many browsers share one answer for a moment, so no number of them costs a seat more than a few images a
second. A seat that does not answer keeps its last report, with the time since then.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import logging
import socket
import time
from dataclasses import dataclass
from typing import Any

from simx_server.classroom import channel

logger = logging.getLogger(__name__)

REPORT_AGE = 0.7
"""Seconds for which a report is new enough."""

IMAGE_AGE = {"small": 0.4, "large": 0.2}
"""The same for an image, by size."""

ANSWERS_WITHIN = 5.0
"""Seconds that an answer may take; the first image of a seat takes longest, since its renderer starts."""

SHORT_WAIT = 0.4
"""Seconds that a list of all seats waits for the report of one of them."""

BUSY_AFTER = 2.0
"""Seconds without an answer after which a seat counts as busy."""

REST = 3.0
"""Seconds without a request for an image after one that was not answered in time; they double up to `MOST_REST`."""

MOST_REST = 60.0

_numbers = itertools.count(time.monotonic_ns())
"""Numbers of requests; a page that is started again must not take answers to the page before for its own."""


class NoImage(Exception):
    """No image can be had now; the text has the reason."""


@dataclass
class _Kept:
    """The newest image of one size."""

    at: float = -1e9
    jpeg: bytes = b""
    task: asyncio.Task[bytes] | None = None


class SeatView:
    """One seat. Used by the event loop's thread."""

    def __init__(self, number: int, gate: asyncio.Semaphore) -> None:
        """Make a seat that has not started.

        Args:
            gate: bounds the images that all seats make at the same time.
        """
        self.number = number
        self._gate = gate
        self._channel: socket.socket | None = None
        self._is_ready = False
        self._note, self._note_at = "", -1e9
        self._report: dict[str, Any] = {}
        self._report_at = -1e9
        self._asked_at: float | None = None
        """When the report that is under way was requested."""

        self._reporting: asyncio.Task[None] | None = None
        self._kept = {size: _Kept() for size in IMAGE_AGE}
        self._problem = ""
        """Why the last image could not be made."""

        self._rest, self._rests_until, self._has_drawn = REST, -1e9, False
        self._answers: dict[int, asyncio.Future[channel.Message]] = {}

    # --- what the supervisor tells ---------------------------------------------------------------

    def started(self, seat: socket.socket, *, is_ready: bool) -> None:
        """Take the channel of the seat's new process."""
        self._drop()
        seat.setblocking(False)
        self._channel, self._is_ready = seat, is_ready
        self._report, self._report_at, self._asked_at = {}, -1e9, None
        self._kept = {size: _Kept() for size in IMAGE_AGE}
        self._problem, self._rest, self._rests_until, self._has_drawn = "", REST, -1e9, False
        asyncio.get_running_loop().add_reader(seat, self._read)

    def ready(self) -> None:
        self._is_ready = True

    def gone(self, reason: str) -> None:
        """Note that the seat's process has ended."""
        self._drop()
        self._note, self._note_at = reason, time.monotonic()

    def _drop(self) -> None:
        if self._channel is not None:
            asyncio.get_running_loop().remove_reader(self._channel)
            self._channel.close()
        self._channel, self._is_ready = None, False
        for answer in self._answers.values():
            answer.cancel()
        self._answers.clear()

    # --- the channel -----------------------------------------------------------------------------

    def _read(self) -> None:
        if self._channel is None:
            return
        try:
            data = self._channel.recv(channel.MOST_BYTES + 4096)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        if not data:  # it ends; the supervisor tells the reason
            asyncio.get_running_loop().remove_reader(self._channel)
            return
        try:
            message = channel.unpacked(data)
        except ValueError as problem:
            logger.warning("seat %d sent something unreadable: %s", self.number, problem)
            return
        number = message.fields.get("id")
        answer = self._answers.pop(number, None) if isinstance(number, int) else None
        if answer is not None and not answer.done():
            answer.set_result(message)

    async def let_in(self, door: socket.socket) -> None:
        """Have the seat serve a program at the other end of this socket, which stays open here.

        Raises:
            TimeoutError, OSError: the seat does not answer.
        """
        await self._ask(door)

    async def _ask(self, file: socket.socket | None = None, **fields: Any) -> channel.Message:
        """Send a request and return its answer.

        Args:
            file: goes with the request.

        Raises:
            TimeoutError, OSError: there is none.
        """
        if self._channel is None or not self._is_ready:
            raise ConnectionError("the seat is not ready")
        number = next(_numbers)
        answer: asyncio.Future[channel.Message] = asyncio.get_running_loop().create_future()
        self._answers[number] = answer
        try:
            files = [] if file is None else [file.fileno()]
            socket.send_fds(self._channel, [channel.packed({"id": number, **fields})], files)
            async with asyncio.timeout(ANSWERS_WITHIN):
                return await answer
        except asyncio.CancelledError:
            if answer.cancelled():  # the seat's process has ended
                raise ConnectionError("the seat ended") from None
            raise
        finally:
            self._answers.pop(number, None)

    # --- for browsers ----------------------------------------------------------------------------

    async def state(self) -> dict[str, Any]:
        """Return the state of the seat, at most about a second old unless the seat is busy."""
        if self._is_ready and self._reporting is None and time.monotonic() - self._report_at > REPORT_AGE:
            self._reporting = asyncio.create_task(self._renew())
            self._reporting.add_done_callback(self._renewed)
        if self._reporting is not None:
            await asyncio.wait([self._reporting], timeout=SHORT_WAIT)
        return self._described()

    async def _renew(self) -> None:
        self._asked_at = self._asked_at or time.monotonic()
        with contextlib.suppress(TimeoutError, OSError):
            self._report = (await self._ask()).fields.get("report", {})
            self._report_at, self._asked_at = time.monotonic(), None

    def _renewed(self, _: asyncio.Task[None]) -> None:
        self._reporting = None

    def _described(self) -> dict[str, Any]:
        now, report = time.monotonic(), self._report
        silent = 0.0 if self._asked_at is None else now - self._asked_at
        state: str = "starting" if not self._is_ready else report.get("state", "starting")
        if self._is_ready and silent > BUSY_AFTER:
            state = "busy"
        error, ago = report.get("error", ""), report.get("error_ago")
        return {
            "number": self.number,
            "state": state,
            "silent": silent,
            "scene": report.get("scene", ""),
            "time": report.get("time", 0.0),
            "clients": report.get("clients", []),
            "connected": report.get("connected", 0),
            "error": error,
            "error_ago": None if ago is None else ago + now - self._report_at,
            "problem": self._problem,
            "note": self._note,
            "note_ago": now - self._note_at if self._note else None,
        }

    async def image(self, size: str) -> bytes:
        """Return the seat's newest image of one size as JPEG.

        Raises:
            NoImage: there is none; the text has the reason.
        """
        kept = self._kept[size]
        if time.monotonic() - kept.at <= IMAGE_AGE[size]:
            return kept.jpeg
        if kept.task is None:
            kept.task = asyncio.create_task(self._draw(kept, size))
            kept.task.add_done_callback(lambda task: _done(kept, task))
        return await asyncio.shield(kept.task)

    async def _draw(self, kept: _Kept, size: str) -> bytes:
        now = time.monotonic()
        is_busy = self._asked_at is not None and now - self._asked_at > BUSY_AFTER
        if is_busy or now < self._rests_until:  # it must not keep the images of other seats waiting
            raise NoImage(self._problem or "the seat is busy")
        try:
            async with self._gate:
                answer = await self._ask(size=size)
        except TimeoutError:
            self._rest_a_while()
            raise NoImage(self._problem or "the renderer of the seat starts") from None
        except OSError as problem:
            raise NoImage(str(problem)) from None
        if not answer.image:
            self._problem = str(answer.fields.get("problem", "no image could be made"))
            raise NoImage(self._problem)
        self._problem, self._rest, self._has_drawn = "", REST, True
        kept.at, kept.jpeg = time.monotonic(), answer.image
        return answer.image

    def _rest_a_while(self) -> None:
        """Request no image for a while, after one that was not answered in time; the first may take longer."""
        if self._has_drawn or self._rest > REST:
            self._problem = f"an image takes more than {ANSWERS_WITHIN:g} s"
        self._rests_until = time.monotonic() + self._rest
        self._rest = min(2 * self._rest, MOST_REST)


def _done(kept: _Kept, task: asyncio.Task[bytes]) -> None:
    kept.task = None
    if not task.cancelled():
        task.exception()  # the caller has it, if there is one still
