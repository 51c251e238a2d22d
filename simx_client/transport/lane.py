"""The lane to a server on this host, see `simx_client.protocol.lane`: the client's side.

The caller's thread reads and writes the socket itself, so a call needs no other thread of this process.
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import select
import socket
import time
from collections import deque

from simx_client.protocol.lane.frames import (
    FILE,
    MESSAGE,
    BadFrame,
    Frames,
    frame,
    memory_frame,
    place_of,
    read_file,
    receive_with_files,
    token_frame,
)
from simx_client.protocol.lane.memory import ENDED, HEAD, SENT, MemoryReader
from simx_client.protocol.lane.offer import (
    folders,
    is_possible,
    is_private,
    is_same_user,
    path_of,
    read_offer,
)

from .busy_wait import BusyWait
from .writer import Writer

logger = logging.getLogger(__name__)

VARIABLE = "SIMX_LOCAL"
"""0 leaves everything to Zenoh."""

CONNECT_TIMEOUT = 2.0
"""Time-out in seconds for the server to answer at the socket; after that all messages travel over Zenoh."""

VALUES = 0
"""Place of the newest values of the small streams; the other places have images."""

_AT_ONCE = int(getattr(socket, "MSG_DONTWAIT", 0))
_READ, _MOST_READ = 1 << 16, 1 << 22
"""Minimum and maximum number of bytes to read at a time."""


def open_lane(text: str) -> Lane | None:
    """Connect to the socket that a welcome offers; None if it is not on this host, or cannot be used safely.

    Args:
        text: the offer in the welcome.
    """
    offer = read_offer(text)
    if offer is None or not is_possible() or os.environ.get(VARIABLE, "").strip() == "0":
        return None
    for folder in folders():
        path = path_of(folder, offer.name)
        if is_private(folder) and os.path.exists(path):
            for introduction in (token_frame(offer.token), frame(offer.token.encode())):
                try:
                    return _connect(path, introduction)
                except (OSError, ValueError) as problem:  # a server of version 0.4 takes only the second one
                    logger.debug("%s does not take the introduction: %s", path, problem)
            logger.debug("messages travel over Zenoh, as %s cannot be used", path)
    return None


def _connect(path: str, introduction: bytes) -> Lane:
    """Connect to a socket and take the memory of the values. Raises OSError, ValueError."""
    connected = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        connected.settimeout(CONNECT_TIMEOUT)
        connected.connect(path)
        if not is_same_user(connected):
            raise PermissionError("the server belongs to another user")
        connected.sendall(introduction)
        expected = memory_frame(VALUES)
        data, files = receive_with_files(connected, len(expected))
        try:
            if data != expected or not files:
                raise ConnectionError("the server did not answer as expected")
            values = MemoryReader(files[0])
        finally:
            for each in files:
                os.close(each)
        connected.settimeout(None)
        return Lane(connected, values)
    except BaseException:
        connected.close()
        raise


class Lane:
    """A socket to the server, and the memory with the newest values and images of streams."""

    def __init__(self, connected: socket.socket, values: MemoryReader) -> None:
        """Use a connection whose token the server has accepted."""
        self._socket = connected
        self._memories = {VALUES: values}
        self._values = values
        self._files: deque[int] = deque()
        """Descriptors whose frames are not complete yet."""

        self._frames = Frames()
        self._frames.count = 1  # the one that brought the memory of the values: the server has counted it
        self._deliveries: deque[bytes] = deque()
        self._readable = select.poll()
        self._readable.register(connected, select.POLLIN)
        self._any = select.poll()
        self._any.register(connected, select.POLLIN | select.POLLOUT)
        self._busy_wait = BusyWait()
        self._writer = Writer(self._send_late)
        self._is_broken = False
        self._still = b""
        """Head of the memory of the values while everything was taken; see `is_still`."""

    @property
    def is_broken(self) -> bool:
        """Return whether the server has closed the connection, or `break_off` was called."""
        return self._is_broken or self._values.memory[SENT] == ENDED

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        """Send a batch; see `Transport.send`."""
        data = memoryview(frame(payload))
        if not self._writer.unsent:
            data = data[self._send_now(data) :]
            while data and not self.is_broken:
                left = deadline - time.monotonic()
                if left <= 0:
                    break
                self._any.poll(_milliseconds(left))
                self._take_in()  # the server may wait for this before it reads
                data = data[self._send_now(data) :]
        if data and not self.is_broken:
            self._writer.send(bytes(data), deadline)

    def _send_now(self, data: memoryview) -> int:
        """Return how many bytes the system has taken."""
        try:
            return self._socket.send(data, _AT_ONCE)
        except BlockingIOError:
            return 0
        except OSError:
            self._is_broken = True
            return 0

    def _send_late(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except OSError:
            self._is_broken = True

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        """Return the next delivery; see `Transport.receive`."""
        deliveries = self._deliveries
        if deliveries:
            return deliveries.popleft()
        if timeout <= 0:
            if not self._has_more():
                return None
            self._take_in()
        elif not (is_soon and self._busy_wait.poll(self._taken_in_soon)) and not self._taken_in_soon():
            deadline = time.monotonic() + timeout
            while (left := deadline - time.monotonic()) > 0:
                self._readable.poll(_milliseconds(left))
                if self._taken_in():
                    break
        return deliveries.popleft() if deliveries else None

    def _has_more(self) -> bool:
        """Return whether the server has sent frames that were not read, without a system call."""
        return self._values.sent != self._frames.count

    def _taken_in_soon(self) -> bool | None:
        """Do as `_taken_in`, without a system call while the server has sent nothing."""
        return self._taken_in() if self._values.sent != self._frames.count else None

    def _taken_in(self) -> bool | None:
        """Read what has arrived; return True if a wait is over, else None."""
        self._take_in()
        return True if self._deliveries or self.is_broken else None

    def _take_in(self) -> None:
        """Read what has arrived, and at least the rest of an incomplete frame that has arrived."""
        frames = self._frames
        try:
            while True:
                missing = frames.missing
                if missing > _READ:
                    data = self._socket.recv(min(missing, _MOST_READ), _AT_ONCE)
                else:
                    data, files = receive_with_files(self._socket, _READ, _AT_ONCE)
                    self._files += files
                if not data:
                    self._is_broken = True
                    return
                frames.add(data)
                if frames.whole:
                    self._sort()
                if not frames.missing:
                    return
        except BlockingIOError:
            return
        except OSError:
            self._is_broken = True
        except ValueError as problem:
            logger.error("the server sent something unreadable: %s", problem)
            self._is_broken = True

    def _sort(self) -> None:
        """Keep deliveries for the caller, and map the memories of streams. Raises BadFrame, ValueError, OSError."""
        whole = self._frames.whole
        while whole:
            kind, payload = whole.popleft()
            if kind == MESSAGE:
                self._deliveries.append(payload)
                continue
            if not self._files:
                raise BadFrame("a frame without its file descriptor")
            file = self._files.popleft()
            try:
                if kind == FILE:
                    self._deliveries.append(read_file(payload, file))
                else:
                    self._memories[place_of(payload)] = MemoryReader(file)
                    self._still = b""
            finally:
                os.close(file)
            self._values = self._memories[VALUES]

    def is_still(self) -> bool:
        """Return whether nothing is to be taken; see `Transport.is_still`."""
        if self._deliveries or self._is_broken or len(self._memories) > 1:
            return False
        if (head := self._values.memory[HEAD]) == self._still:
            return True
        if not self._values.is_taken(head, self._frames.count):
            return False
        self._still = head
        return True

    def newest(self) -> bytes | None:
        """Return the newest values of the small streams; see `Transport.newest`."""
        if self._has_more():
            self._take_in()  # there may be a new memory
        return self._values.newest()

    def images(self) -> list[bytes]:
        """Return the newest images; see `Transport.images`."""
        if len(self._memories) == 1:
            return []
        found = (memory.newest() for place, memory in self._memories.items() if place != VALUES)
        return [payload for payload in found if payload is not None]

    def break_off(self) -> None:
        """End a wait in another thread: the server is lost. Any thread."""
        self._is_broken = True
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Close the socket. Idempotent. Another thread may still read the memory, which is freed with this object."""
        self.break_off()
        self._writer.close()
        self._socket.close()
        while self._files:
            os.close(self._files.popleft())


def _milliseconds(seconds: float) -> int:
    """Return a time-out for ``poll``, which waits for at most 24 days."""
    return math.ceil(min(seconds, 1e6) * 1000)
