"""The file of a bag: MCAP with ROS 2's schemas, written by a separate thread."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from simx_server.outputs.file_thread import FileThread
from simx_server.outputs.packages import NewFile, package
from simx_server.ros2_messages import BY_NAME

from ..wire.qos import Qos
from .schemas import definition

logger = logging.getLogger(__name__)

_QOS = """\
- history: 1
  depth: {depth}
  reliability: {reliability}
  durability: {durability}
  deadline: {{sec: 0, nsec: 0}}
  lifespan: {{sec: 0, nsec: 0}}
  liveliness: 1
  liveliness_lease_duration: {{sec: 0, nsec: 0}}
  avoid_ros_namespace_conventions: false
"""
"""A profile as `ros2 bag` writes it, so that it plays static transforms for late nodes."""


class BagWriter(FileThread[tuple[str, str, Qos, int, bytes]]):
    """Writes messages in the order in which they are put."""

    KIND, REMAINS = "bag", "read from its beginning"

    def __init__(self, path: Path) -> None:
        """Start a bag. Raises OutputError: the file cannot be written, or a package is missing."""
        mcap = package("mcap.writer", "--rosbag", "log")
        super().__init__(NewFile(path, "--rosbag"))
        self._writer: Any = mcap.Writer(self._file, compression=mcap.CompressionType.ZSTD)
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}
        self.written = self._flushed = 0
        """Messages: all, and those in closed chunks."""

        self._start()

    def put(self, topic: str, kind: str, qos: Qos, time_ns: int, payload: bytes) -> None:
        """Write CDR of a message. For any thread."""
        self._put((topic, kind, qos, time_ns, payload))

    # From here on: the thread of the file.

    def _begin(self) -> None:
        self._writer.start(profile="ros2", library="simx")

    def _flush(self) -> None:
        if self.written > self._flushed:
            self._writer.flush()
            self._flushed = self.written

    def _finish(self) -> None:
        self._writer.finish()

    def _write(self, item: tuple[str, str, Qos, int, bytes]) -> None:
        topic, kind, qos, time_ns, payload = item
        channel = self._channels.get((topic, kind))
        if channel is None:
            channel = self._channels[topic, kind] = self._writer.register_channel(
                topic=topic,
                message_encoding="cdr",
                schema_id=self._schema(kind),
                metadata=_metadata(qos, kind),
            )
        self._writer.add_message(channel, time_ns, payload, time_ns)
        self.written += 1

    def _schema(self, kind: str) -> int:
        if kind not in self._schemas:
            text = definition(BY_NAME[kind].layout)
            self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", text.encode())
        return self._schemas[kind]


def _metadata(qos: Qos, kind: str) -> Mapping[str, str]:
    return {
        "offered_qos_profiles": _QOS.format(
            depth=qos.depth,
            reliability=1 if qos.is_reliable else 2,
            durability=1 if qos.is_transient_local else 2,
        ),
        "topic_type_hash": BY_NAME[kind].hash,
    }
