"""The file of a bag: MCAP with ROS 2's schemas, written by a separate thread."""

from __future__ import annotations

from collections.abc import Mapping
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


class BagWriter(McapThread[tuple[str, str, Qos, int, bytes]]):
    """Writes messages in the order in which they are put."""

    KIND, FLAG, PROFILE = "bag", "--rosbag", "ros2"
    MESSAGES, SCHEMAS = "cdr", "ros2msg"

    def __init__(self, path: Path) -> None:
        """Start a bag. Raises OutputError: the file cannot be written, or a package is missing."""
        super().__init__(path)
        self._start()

    def put(self, topic: str, kind: str, qos: Qos, time_ns: int, payload: bytes) -> None:
        """Write CDR of a message. For any thread."""
        self._put((topic, kind, qos, time_ns, payload))

    # From here on: the thread of the file.

    def _definition(self, schema: str) -> bytes:
        return definition(BY_NAME[schema].layout).encode()

    def _write(self, item: tuple[str, str, Qos, int, bytes]) -> None:
        topic, kind, qos, time_ns, payload = item
        channel = self._channels.get((topic, kind))
        if channel is None:
            channel = self._channels[topic, kind] = self._register(topic, kind, _metadata(qos, kind))
        self._add(channel, time_ns, payload)


def _metadata(qos: Qos, kind: str) -> Mapping[str, str]:
    return {
        "offered_qos_profiles": _QOS.format(
            depth=qos.depth,
            reliability=1 if qos.is_reliable else 2,
            durability=1 if qos.is_transient_local else 2,
        ),
        "topic_type_hash": BY_NAME[kind].hash,
    }
