"""The file of a bag: MCAP with ROS 2's schemas, written by a separate thread."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from simx_server.outputs.mcap_thread import McapThread
from simx_server.ros2_messages import BY_NAME

from ..wire.qos import Qos
from .schemas import definition

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


MOST_WAITING = 5000
"""Messages that may wait for the writing thread."""

MOST_BYTES = 256 << 20
"""Bytes of messages that may wait."""


@dataclass
class Topic:
    """A topic of a bag, with the number of its messages."""

    qos_profiles: str
    """As `ros2 bag` writes them."""

    count: int = 0
    """Messages."""


class BagWriter(McapThread[tuple[str, str, Qos, int, bytes]]):
    """Writes messages in the order in which they are put."""

    KIND, FLAG, PROFILE = "bag", "--rosbag", "ros2"
    MESSAGES, SCHEMAS = "cdr", "ros2msg"

    def __init__(self, path: Path) -> None:
        """Start a bag. Raises OutputError: the file cannot be written, or a package is missing."""
        super().__init__(path)
        self.topics: dict[tuple[str, str], Topic] = {}
        """All topics so far, by name and type; complete once the bag is closed."""

        self.first = self.last = 0
        """Nanoseconds since 1970 of the first and the last message."""

        self._bytes_come = self._bytes_gone = 0
        self._start()

    @property
    def is_full(self) -> bool:
        """Return whether so much waits to be written that no simulation step should be made meanwhile."""
        return self.waiting >= MOST_WAITING or self._bytes_come - self._bytes_gone >= MOST_BYTES

    def put(self, topic: str, kind: str, qos: Qos, time_ns: int, payload: bytes) -> None:
        """Write CDR of a message. For one thread."""
        if not self.has_failed:
            self._bytes_come += len(payload)
            self._put((topic, kind, qos, time_ns, payload))

    # From here on: the thread of the file.

    def _definition(self, schema: str) -> bytes:
        return definition(BY_NAME[schema].layout).encode()

    def _write(self, item: tuple[str, str, Qos, int, bytes]) -> None:
        topic, kind, qos, time_ns, payload = item
        channel = self._channels.get((topic, kind))
        if channel is None:
            self.topics[topic, kind] = Topic(_profile(qos))
            metadata = {"offered_qos_profiles": _profile(qos), "topic_type_hash": BY_NAME[kind].hash}
            channel = self._channels[topic, kind] = self._register(topic, kind, metadata)
        self._add(channel, time_ns, payload)
        self._bytes_gone += len(payload)
        self.topics[topic, kind].count += 1
        self.first, self.last = min(self.first or time_ns, time_ns), max(self.last, time_ns)


def _profile(qos: Qos) -> str:
    return _QOS.format(
        depth=qos.depth,
        reliability=1 if qos.is_reliable else 2,
        durability=1 if qos.is_transient_local else 2,
    )
