"""The file of a state log: MCAP with Foxglove's schemas, written by a separate thread."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path

from simx_server.outputs.mcap_thread import McapThread

from .messages import Messages, plain

logger = logging.getLogger(__name__)

MOST_TOPICS = 1000
"""Clients invent names of signals; viewers list them all."""


class McapWriter(McapThread[tuple[str, str, int, Callable[[], bytes]]]):
    """Writes messages in the order in which they are put."""

    KIND, FLAG = "state log", "--state-log"
    MESSAGES = SCHEMAS = "protobuf"

    def __init__(self, path: Path) -> None:
        """Start a log. Raises OutputError."""
        self.messages = Messages()
        super().__init__(path)
        self.left_out = 0
        """Messages of topics beyond MOST_TOPICS."""

        self._start()

    def put(self, topic: str, schema: str, time_ns: int, make: Callable[[], bytes]) -> None:
        """Write a message; `make` serialises it, on the writing thread. For any thread."""
        self._put((topic, schema, time_ns, make))

    # From here on: the thread of the log.

    def _definition(self, schema: str) -> bytes:
        return self.messages.schema(schema)

    def _write(self, item: tuple[str, str, int, Callable[[], bytes]]) -> None:
        topic, schema, time_ns, make = item
        channel = self._channels.get((topic, schema))
        if channel is None:
            if len(self._channels) >= MOST_TOPICS:
                self._leave_out()
                return
            channel = self._channels[topic, schema] = self._register(plain(topic), schema)
        self._add(channel, time_ns, make())

    def _leave_out(self) -> None:
        if not self.left_out:
            logger.warning(
                "the state log holds no more than %d topics; further signals are left out", MOST_TOPICS
            )
        self.left_out += 1
