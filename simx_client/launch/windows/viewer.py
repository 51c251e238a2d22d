"""Windows in the web viewer of the server that the script drives: images go to the server, keys come back.

A separate connection, so that the script's calls keep their order and their pace. ``protocol.windows``
describes the messages.
"""

from __future__ import annotations

import secrets
import threading
from collections.abc import Sequence
from typing import Any

import msgpack

from simx_client.client.channel import Channel
from simx_client.connection.connection import Connection
from simx_client.protocol.add_ons import windows as w
from simx_client.transport.endpoints import find_address
from simx_client.transport.zenoh import ZenohTransport

from ...errors import SimxError
from . import screen as s
from .outbox import Outbox

TIMEOUT = 5.0
"""Time-out in seconds to connect and for each answer: a script of the scene may delay the server."""

EVERY, EVERY_IDLE = 0.1, 1.0
"""Seconds between two exchanges with and without windows: ten images per second, the newest ones."""

LARGEST_SIDE = 1280
"""Pixels; larger images are scaled down."""

_QUALITIES = (90, 60, 30)
"""Qualities of JPEG; the first that is small enough is used."""


class Viewer:
    """The web viewer as a screen."""

    def __init__(self, cv2: Any, where: str, report: s.Report, lost: s.Lost) -> None:
        """Request from a server, given by its address in simxStart, whether it has a web viewer.

        Raises:
            NoScreen: it has none, or does not answer.
        """
        self.name = f"in the web viewer of the server at {where}, tab Cameras; keys are typed there"
        self._cv2, self._report, self._lost = cv2, report, lost
        self._owner = secrets.token_hex(8)
        self._windows: dict[int, dict[str, Any]] = {}
        """Windows as they are sent, by number; the image only until it was sent."""

        self._outbox = Outbox()
        self._is_closed = threading.Event()
        self._connection = _connect(where)
        self._channel = Channel(self._connection, TIMEOUT)
        try:
            answer = self._exchange([])
        except (SimxError, ValueError) as error:
            self._connection.close()
            raise s.NoScreen(f"the server at {where} shows no windows: {error}") from None
        if not answer[w.IS_WATCHED]:
            self._connection.close()
            raise s.NoScreen(f"the server at {where} has no web viewer (--view)")
        self._thread = threading.Thread(target=self._work, name="simx-windows-viewer", daemon=True)
        self._thread.start()

    def tell(self, message: s.Message) -> None:
        """Queue a message; never waits."""
        self._outbox.put(message)

    def close(self) -> None:
        """Close the connection: the server removes the windows."""
        if not self._is_closed.is_set():
            self._is_closed.set()
            self._thread.join(TIMEOUT)

    def forget(self) -> None:
        """Drop the connection in a forked child, in which its threads do not exist."""
        self._is_closed.set()

    # --- the thread ------------------------------------------------------------------------------

    def _work(self) -> None:
        try:
            while not self._is_closed.wait(EVERY if self._windows else 0.0):
                messages = self._outbox.take(0.0 if self._windows else EVERY_IDLE)
                for message in messages:
                    self._do(message)
                for event in self._exchange(list(self._windows.values()))[w.EVENTS]:
                    self._take(event)
            self._exchange([])
        except (SimxError, ValueError) as error:
            if not self._is_closed.is_set():
                self._lost(str(error))
        finally:
            self._connection.close()

    def _do(self, message: s.Message) -> None:
        word, number, *rest = message
        window = self._windows.get(number)
        if word == s.OPEN and window is None:
            self._windows[number] = {
                w.NUMBER: number,
                w.TITLE: rest[0],
                w.TEXT: "",
                w.TRACKBARS: [],
                w.IMAGE: None,
            }
        elif window is None:
            return
        elif word == s.CLOSE:
            del self._windows[number]
        elif word == s.TITLE:
            window[w.TITLE] = rest[0]
        elif word == s.TEXT:
            window[w.TEXT] = rest[0]
        elif word == s.TRACKBAR:
            window[w.TRACKBARS] = [bar for bar in window[w.TRACKBARS] if bar[0] != rest[0]] + [rest]
        elif word == s.SHOW:
            window[w.IMAGE] = self._packed(*rest)

    def _packed(self, width: int, height: int, pixels: bytes) -> bytes:
        """Return the image as JPEG, within the server's limits."""
        import numpy as np

        cv2 = self._cv2
        image = cv2.cvtColor(np.frombuffer(pixels, np.uint8).reshape(height, width, 3), cv2.COLOR_RGB2BGR)
        if (scale := LARGEST_SIDE / max(width, height)) < 1:
            size = max(1, round(width * scale)), max(1, round(height * scale))
            image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        packed = b""
        for quality in _QUALITIES:
            packed = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
            if len(packed) <= w.LARGEST_IMAGE:
                break
        return packed

    def _exchange(self, windows: Sequence[dict[str, Any]]) -> dict[str, Any]:
        """Send all windows and new images to the server; return its reply. Raises SimxError, ValueError."""
        told = msgpack.packb({w.OWNER: self._owner, w.WINDOWS: list(windows)})
        results = self._channel.request(
            lambda calls: calls.simxCallScriptFunction(w.ADD_ON, w.ADD_ON_TYPE, w.EXCHANGE, [], [], [], told)
        )
        for window in windows:
            window[w.IMAGE] = None  # the server has it
        return msgpack.unpackb(bytes(results[3]))

    def _take(self, event: Sequence[Any]) -> None:
        word, number = event[0], event[1]
        if word == s.CLOSED:
            self._windows.pop(number, None)
        elif word == s.DRAGGED and number in self._windows:
            for bar in self._windows[number][w.TRACKBARS]:
                if bar[0] == event[2]:
                    bar[1] = event[3]
        self._report(event)


def _connect(where: str) -> Connection:
    """Connect to the server. Raises NoScreen."""
    host, _, port = where.rpartition(":")
    try:
        place = find_address(host, int(port))
        connection = Connection(
            # Without a port: a client that connects to 19999 starts the simulation.
            lambda: ZenohTransport(place, connect_timeout=TIMEOUT, retry=False, asked_port=0),
            where=where,
            timeout=TIMEOUT,
            may_reconnect=False,
        )
        connection.connect(TIMEOUT)
    except (SimxError, ValueError) as error:
        raise s.NoScreen(f"the server at {where} cannot be asked for its web viewer: {error}") from None
    return connection
