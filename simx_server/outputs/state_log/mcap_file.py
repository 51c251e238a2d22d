"""The file of a state log: MCAP, written by a thread of its own.

A chunk is closed twice a second, so a kill costs at most the last second. Such a file lacks the index at its end, and
is read from its beginning.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from simx_server.outputs.packages import NewFile, package

from .messages import Messages, plain

logger = logging.getLogger(__name__)

PERIOD = 0.5
"""Seconds of the wall clock between two chunks."""

MOST_TOPICS = 1000
"""Clients invent names of signals; viewers list them all."""

_LONGEST_WAIT = 30.0


class McapWriter:
    """Writes messages in the order in which they are put. `put` is for any thread and never raises."""

    def __init__(self, path: Path) -> None:
        """Begin a log. Raises OutputError."""
        self.path = path
        self.messages = Messages()
        mcap = package("mcap.writer", "--state-log", "log")
        self._file = NewFile(path, "--state-log")
        self._writer: Any = mcap.Writer(self._file, compression=mcap.CompressionType.ZSTD)
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}
        """By topic and schema: signals of two kinds may have one name."""

        self._queue: SimpleQueue[tuple[str, str, int, Callable[[], bytes]] | None] = SimpleQueue()
        self.written = 0
        """Messages."""

        self.left_out = 0
        """Messages of topics beyond MOST_TOPICS."""

        self.has_failed = False
        self._thread = threading.Thread(target=self._run, name="simx-state-log", daemon=True)
        self._thread.start()

    @property
    def waiting(self) -> int:
        """Messages that are not written yet."""
        return self._queue.qsize()

    def put(self, topic: str, schema: str, time_ns: int, make: Callable[[], bytes]) -> None:
        """A message; `make` serialises it, on the writing thread."""
        if not self.has_failed:
            self._queue.put((topic, schema, time_ns, make))

    def close(self) -> None:
        """Write what waits, and the index."""
        self._queue.put(None)
        self._thread.join(_LONGEST_WAIT)
        if self._thread.is_alive():
            logger.error("the state log '%s' could not be ended within %.0f s", self.path, _LONGEST_WAIT)

    # From here on: the thread of the log.

    def _run(self) -> None:
        try:
            self._writer.start(profile="", library="simx")
            self._write_all()
            self._writer.finish()
        except OSError as error:
            self._fail(error.strerror or str(error))
        except Exception as error:
            logger.exception("the state log could not be written")
            self._fail(str(error))
        finally:
            self._file.close()

    def _write_all(self) -> None:
        due, is_open = time.monotonic() + PERIOD, False
        while True:
            try:
                item = self._queue.get(timeout=PERIOD)
            except Empty:
                pass
            else:
                if item is None:
                    return
                self._write(*item)
                is_open = True
            if is_open and time.monotonic() >= due:
                self._writer.flush()
                due, is_open = time.monotonic() + PERIOD, False

    def _write(self, topic: str, schema: str, time_ns: int, make: Callable[[], bytes]) -> None:
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

    def _fail(self, why: str) -> None:
        self.has_failed = True
        logger.error(
            "the state log '%s' ends here: %s; what is in it can be read from its beginning, and the server goes on",
            self.path,
            why,
        )
        while not self._queue.empty():
            self._queue.get()
