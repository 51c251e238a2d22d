"""MCAP files, which their own thread writes; state logs and bags of ROS 2 are such files.

A chunk is closed twice per second, so a kill costs at most the last second. Such a file lacks the index at its end, and
readers start at its first byte.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, TypeVar

from .file_thread import FileThread
from .packages import NewFile, package

_Item = TypeVar("_Item")

_NO_METADATA: Mapping[str, str] = MappingProxyType({})


class McapThread(FileThread[_Item]):
    """Writes one MCAP file. A format gives the class variables and `_definition`, and its `_write` calls `_add`."""

    REMAINS = "read from its beginning"

    FLAG: ClassVar[str]
    """The flag that names the file, in messages."""

    PROFILE: ClassVar[str] = ""
    MESSAGES: ClassVar[str]
    """The encoding of messages."""

    SCHEMAS: ClassVar[str]
    """The encoding of schemas."""

    def __init__(self, path: Path) -> None:
        """Start a file. Raises OutputError: it cannot be written, or a package is missing."""
        mcap = package("mcap.writer", self.FLAG, "log")
        super().__init__(NewFile(path, self.FLAG))
        self._writer: Any = mcap.Writer(self._file, compression=mcap.CompressionType.ZSTD)
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}
        """By topic and schema: signals of two kinds may have one name."""

        self.written = self._flushed = 0
        """Messages: all, and those in closed chunks."""

    # From here on: the thread of the file.

    def _definition(self, schema: str) -> bytes:
        """Return the definition of a schema."""
        raise NotImplementedError

    def _begin(self) -> None:
        self._writer.start(profile=self.PROFILE, library="simx")

    def _flush(self) -> None:
        if self.written > self._flushed:
            self._writer.flush()
            self._flushed = self.written

    def _finish(self) -> None:
        self._writer.finish()

    def _register(self, topic: str, schema: str, metadata: Mapping[str, str] = _NO_METADATA) -> int:
        """Register a topic, and its schema if it is new; return the channel."""
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(
                schema, self.SCHEMAS, self._definition(schema)
            )
        return self._writer.register_channel(
            topic=topic,
            message_encoding=self.MESSAGES,
            schema_id=self._schemas[schema],
            metadata=dict(metadata),
        )

    def _add(self, channel: int, time_ns: int, data: bytes) -> None:
        self._writer.add_message(channel, time_ns, data, time_ns)
        self.written += 1
