"""The file of a state log: MCAP, written by a separate thread.

A chunk is closed twice per second, so a kill costs at most the last second. Such a file lacks the index at its end, and
readers start at its first byte.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

from simx_server.outputs.file_thread import FileThread
from simx_server.outputs.packages import NewFile, package

from .messages import Messages, plain

logger = logging.getLogger(__name__)

MOST_TOPICS = 1000
"""Clients invent names of signals; viewers list them all."""


class McapWriter(FileThread[tuple[str, str, int, Callable[[], bytes]]]):
    """Writes messages in the order in which they are put."""

    KIND, REMAINS = "state log", "read from its beginning"

    def __init__(self, path: Path) -> None:
        """Start a log. Raises OutputError."""
        self.messages = Messages()
        mcap = package("mcap.writer", "--state-log", "log")
        super().__init__(NewFile(path, "--state-log"))
        self._writer: Any = mcap.Writer(self._file, compression=mcap.CompressionType.ZSTD)
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}
        """By topic and schema: signals of two kinds may have one name."""

        self.written = self._flushed = 0
        """Messages: all, and those in closed chunks."""

        self.left_out = 0
        """Messages of topics beyond MOST_TOPICS."""

        self._start()

    def put(self, topic: str, schema: str, time_ns: int, make: Callable[[], bytes]) -> None:
        """Write a message; `make` serialises it, on the writing thread. For any thread."""
        self._put((topic, schema, time_ns, make))

    # From here on: the thread of the log.

    def _begin(self) -> None:
        self._writer.start(profile="", library="simx")

    def _flush(self) -> None:
        if self.written > self._flushed:
            self._writer.flush()
            self._flushed = self.written

    def _finish(self) -> None:
        self._writer.finish()

    def _write(self, item: tuple[str, str, int, Callable[[], bytes]]) -> None:
        topic, schema, time_ns, make = item
        channel = self._channels.get((topic, schema))
        if channel is None:
            if len(self._channels) >= MOST_TOPICS:
                self._leave_out()
                return
            channel = self._channels[topic, schema] = self._writer.register_channel(
                topic=plain(topic), message_encoding="protobuf", schema_id=self._schema(schema)
            )
        self._writer.add_message(channel, time_ns, make(), time_ns)
        self.written += 1

    def _schema(self, name: str) -> int:
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(name, "protobuf", self.messages.schema(name))
        return self._schemas[name]

    def _leave_out(self) -> None:
        if not self.left_out:
            logger.warning(
                "the state log holds no more than %d topics; further signals are left out", MOST_TOPICS
            )
        self.left_out += 1
