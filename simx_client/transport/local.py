"""The short way to a server on this host, see `simx_client.protocol.local`: the client's side.

The caller's thread reads and writes the socket itself, so a call needs no other thread of this process.
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import select
import socket
import stat
import time

from simx_client.protocol.local import READY, BadFrame, Frames, ValuesReader, frame

from .busy_wait import BusyWait
from .writer import Writer

logger = logging.getLogger(__name__)

VARIABLE = "SIMX_LOCAL"
"""0 leaves everything to Zenoh."""

CONNECT_TIMEOUT = 0.5
"""Time-out in seconds for the server to answer at the socket; after that calls travel over Zenoh."""

_READ, _MOST_READ = 1 << 16, 1 << 22
"""Least and most bytes to read at a time."""


class LocalLink:
    """A socket to the server, and the memory with the newest values of the streams."""

    def __init__(self, connected: socket.socket, values: ValuesReader) -> None:
        self._socket = connected
        self._values = values
        self._frames = Frames()
        self._poll = select.poll()
        self._poll.register(connected, select.POLLIN)
        self._busy_wait = BusyWait()
        self._writer = Writer(self._send_rest)
        self._is_broken = False

    @property
    def is_broken(self) -> bool:
        """Return whether the server has closed the connection, or `break_off` was called."""
        return self._is_broken or self._values.has_ended

    @classmethod
    def open(cls, path: str, token: str) -> LocalLink | None:
        """Connect to a server's socket; return None where that is not possible or not safe.

        Args:
            path: the socket, in a folder of this user alone.
            token: from the welcome, proves who connects.
        """
        if (
            not hasattr(socket, "AF_UNIX")
            or os.environ.get(VARIABLE, "").strip() == "0"
            or not _is_ours(path)
        ):
            return None
        connected = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            connected.settimeout(CONNECT_TIMEOUT)
            connected.connect(path)
            connected.sendall(frame(token.encode()))
            expected = frame(READY)
            data, files, _, _ = socket.recv_fds(connected, len(expected), 1)
            try:
                if data != expected or not files:
                    raise OSError("the server did not answer as expected")
                values = ValuesReader(files[0])
            finally:
                for each in files:
                    os.close(each)
            connected.settimeout(None)
        except (OSError, ValueError) as problem:
            logger.debug("calls travel over Zenoh, as the socket %s cannot be used: %s", path, problem)
            connected.close()
            return None
        return cls(connected, values)

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        """Send a batch, in order; wait for room until a deadline on the monotonic clock, and send the rest later."""
        data = frame(payload)
        if self._writer.is_idle:
            try:
                sent = self._socket.send(data, socket.MSG_DONTWAIT)
            except BlockingIOError:
                sent = 0
            except OSError:
                self._is_broken = True
                return
            if sent == len(data):
                return
            data = data[sent:]
        self._writer.send(data, deadline)

    def _send_rest(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except OSError:
            self._is_broken = True

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        """Return the next delivery, waiting at most `timeout` seconds; see `Transport.receive`."""
        whole = self._frames.whole
        if not whole:
            if timeout <= 0 and self._values.sent == self._frames.count:
                return None
            self._take_in()
            if not whole and timeout > 0 and not self.is_broken:
                found = self._busy_wait.poll(self._taken_in) if is_soon else None
                if found is None:
                    self._sleep(timeout)
        return whole.popleft() if whole else None

    def _sleep(self, timeout: float) -> None:
        deadline = time.monotonic() + timeout
        while not self._frames.whole and not self.is_broken:
            left = deadline - time.monotonic()
            if left <= 0:
                return
            self._poll.poll(math.ceil(left * 1000))
            self._take_in()

    def _taken_in(self) -> bool | None:
        self._take_in()
        return True if self._frames.whole or self.is_broken else None

    def _take_in(self) -> None:
        """Read what has arrived, up to the end of a frame that has begun."""
        while True:
            missing = self._frames.missing
            try:
                data = self._socket.recv(min(max(missing, _READ), _MOST_READ), socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if not data:
                self._is_broken = True
                return
            try:
                self._frames.add(data)
            except BadFrame as problem:
                logger.error("the server sent something unreadable: %s", problem)
                self._is_broken = True
                return
            if not self._frames.missing:
                return

    def newest(self) -> bytes | None:
        """Return the newest values of the small streams; None if they were taken already."""
        return self._values.newest()

    def break_off(self) -> None:
        """End a wait in another thread: the server is lost. Any thread."""
        self._is_broken = True
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Close the socket. Idempotent."""
        self.break_off()
        self._writer.close()
        self._socket.close()
        # Its memory stays until this object goes: another thread may be reading it.


def _is_ours(path: str) -> bool:
    """Return whether a socket is in a folder that belongs to this user, and is closed to all others."""
    try:
        folder = os.stat(os.path.dirname(path))
    except OSError:
        return False
    return folder.st_uid == os.getuid() and stat.S_IMODE(folder.st_mode) == 0o700
