"""``/rosout``: the server's log, for ``rqt_console`` and for nodes that collect logs."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Iterable

from ..endpoints import Content, Context, Message, Moment, Offer, Sender, Sent
from ..wire.qos import LOG

TYPE = "rcl_interfaces/msg/Log"

MOST_WAITING = 100
"""Lines that wait for the physics thread; of more the oldest are left out."""

MOST_TEXT = 4000
"""Characters of a line."""

_LEVELS = ((logging.CRITICAL, 50), (logging.ERROR, 40), (logging.WARNING, 30), (logging.INFO, 20))
"""Levels of Python's log, and those of ROS 2."""

_SERVER = "simx_server"


class Rosout(Content):
    """Publishes the lines that the server logs."""

    def __init__(self, context: Context) -> None:
        self._client, self._simulation = context.client, context.world.simulation
        self._sender = Sender()
        self._waiting: deque[logging.LogRecord] = deque(maxlen=MOST_WAITING)
        self._lock = threading.Lock()
        self._is_announced = False
        self._handler = _Handler(self._arrived)
        logging.getLogger(_SERVER).addHandler(self._handler)

    def close(self) -> None:
        logging.getLogger(_SERVER).removeHandler(self._handler)

    def offers(self) -> Iterable[Offer]:
        yield Sent("/rosout", TYPE, self._sender, LOG)

    def _arrived(self, record: logging.LogRecord) -> None:
        """Keep a line until the physics thread has time. Any thread."""
        with self._lock:
            self._waiting.append(record)
            is_news, self._is_announced = not self._is_announced, True
        if is_news:
            self._client.post(self._send)

    def _send(self) -> None:
        with self._lock:
            records, self._is_announced = [*self._waiting], False
            self._waiting.clear()
        stamp = Moment.of(self._simulation.step_count, self._simulation.time_step).stamp
        for record in records:
            self._sender.send(_message(record, stamp))


class _Handler(logging.Handler):
    """Passes lines on."""

    def __init__(self, arrived: Callable[[logging.LogRecord], object]) -> None:
        super().__init__(logging.INFO)
        self._arrived = arrived

    def emit(self, record: logging.LogRecord) -> None:
        self._arrived(record)


def _message(record: logging.LogRecord, stamp: Message) -> Message:
    """Return a ``Log``; its name is the node's, with the part of the server behind it."""
    return {
        "stamp": stamp,
        "level": next((level for least, level in _LEVELS if record.levelno >= least), 10),
        "name": f"simx{record.name.removeprefix(_SERVER)}",
        "msg": record.getMessage()[:MOST_TEXT],
        "file": record.filename,
        "function": record.funcName or "",
        "line": max(record.lineno, 0),
    }
