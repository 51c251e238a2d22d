"""The transport of a process that got a socket from its server: it needs no network, and no other thread.

The variable `SIMX_SOCKET` has the number of the socket. A program that ``simx grade`` runs has no other way out.
"""

from __future__ import annotations

import contextlib
import math
import os
import socket
import time

from simx_client.errors import ConnectionFailed, NoAnswer
from simx_client.protocol.codec import CodecError, decode_welcome, encode
from simx_client.protocol.lane.frames import (
    MEMORY,
    MESSAGE,
    Frames,
    frame,
    place_of,
    receive_with_files,
)
from simx_client.protocol.lane.handed import REQUEST, VARIABLE
from simx_client.protocol.lane.memory import MemoryReader
from simx_client.protocol.messages import OLDEST_PROTOCOL, PROTOCOL_VERSION, Greeting, Welcome

from .lane import VALUES, Lane
from .zenoh_session import client_name, program_name

_MOST = 4096
"""Bytes of a welcome and of the frame behind it."""


def handed_socket() -> int | None:
    """Return the number of the socket that the server gave to this process; None without one.

    Raises:
        ValueError: the variable has something else.
    """
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return None
    if not (text.isascii() and text.isdecimal()):
        raise ValueError(f"{VARIABLE}: {text!r} is not the number of a socket")
    return int(text)


class HandedLane:
    """A `Transport` by a connection that the server hands out."""

    def __init__(self, door: int, port: int) -> None:
        """Prepare a connection; `greet` makes it.

        Args:
            door: number of the socket by which the server hands out connections; it stays open.
            port: the port that the script asked for: connecting to some ports starts the simulation.
        """
        self._door, self._port = door, port
        self._lane: Lane | None = None

    @property
    def is_connected(self) -> bool:
        return self._lane is not None and not self._lane.is_broken

    @property
    def was_lost(self) -> bool:
        return self._lane is not None and self._lane.is_broken

    def greet(self, timeout: float) -> Welcome:
        """Ask for a connection and greet by it; see `Transport.greet`."""
        deadline = time.monotonic() + timeout
        self.close()
        try:
            with contextlib.ExitStack() as stack:
                connected = stack.enter_context(self._ask(timeout))
                greeting = Greeting(
                    OLDEST_PROTOCOL, client_name(), program_name(), self._port, PROTOCOL_VERSION
                )
                connected.sendall(frame(encode(greeting)))
                welcome, values = _read_answer(connected, deadline)
                connected.settimeout(None)
                self._lane = Lane(connected, values)
                stack.pop_all()
        except TimeoutError:
            raise NoAnswer("the server that started this program does not answer") from None
        except (OSError, CodecError, ValueError) as problem:
            raise ConnectionFailed(f"the server that started this program has ended ({problem})") from None
        self.send, self.receive = self._lane.send, self._lane.receive
        return welcome

    def _ask(self, timeout: float) -> socket.socket:
        """Return a new connection. Raises OSError."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET, 0, fileno=os.dup(self._door)) as door:
            door.settimeout(timeout)
            door.send(REQUEST)
            data, files = receive_with_files(door, len(REQUEST))
        if data != REQUEST or len(files) != 1:
            raise ConnectionError("it handed out no connection")
        connected = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM, 0, fileno=files[0])
        connected.settimeout(timeout)
        return connected

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        """Send a batch; see `Transport.send`. `greet` replaces this."""
        raise ConnectionFailed("no connection was made yet")

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        """Return the next delivery; see `Transport.receive`. `greet` replaces this."""
        return None

    def is_still(self) -> bool:
        return self._lane is not None and self._lane.is_still()

    def newest(self) -> bytes | None:
        return None if self._lane is None else self._lane.newest()

    def images(self) -> list[bytes]:
        return [] if self._lane is None else self._lane.images()

    def close(self) -> None:
        if self._lane is not None:
            self._lane.close()


def _read_answer(connected: socket.socket, deadline: float) -> tuple[Welcome, MemoryReader]:
    """Return the welcome, and the memory of the values behind it. Raises OSError, CodecError, ValueError."""
    frames, files = Frames(_MOST), list[int]()
    welcome: Welcome | None = None
    try:
        while True:
            connected.settimeout(max(0.01, deadline - time.monotonic()))
            # One frame at a time: replies may follow.
            data, more = receive_with_files(connected, frames.missing or 5)
            files += more
            if not data:
                raise ConnectionError("it closed the connection")
            frames.add(data)
            for kind, payload in frames.whole:
                if welcome is None and kind == MESSAGE:
                    welcome = decode_welcome(payload)
                    if welcome.refusal:
                        raise ConnectionFailed(f"the server refused the connection: {welcome.refusal}")
                elif welcome is not None and kind == MEMORY and place_of(payload) == VALUES and files:
                    return welcome, MemoryReader(files[0])
                else:
                    raise ConnectionError("it did not answer as expected")
            frames.whole.clear()
    finally:
        for each in files:
            os.close(each)
