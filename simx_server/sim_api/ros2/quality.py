"""The quality of service that scripts ask for: a table, or the queue and latch of older versions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.parts.communication.ros2_topics import TopicQuality

MOST_DEPTH = 1000

RELIABILITY: Mapping[str, int] = MappingProxyType({"system_default": 0, "reliable": 1, "best_effort": 2})
DURABILITY: Mapping[str, int] = MappingProxyType({"system_default": 0, "transient_local": 1, "volatile": 2})

_NOT_APPLIED = (
    "history",
    "deadline",
    "lifespan",
    "liveliness",
    "liveliness_lease_duration",
    "avoid_ros_namespace_conventions",
)
"""Keys of the table that have the default whatever a script gives."""

_APPLIED = ("depth", "reliability", "durability")


def read_quality(given: tuple[Any, ...]) -> tuple[TopicQuality, list[str]]:
    """Return the quality of service, and the keys that are not applied.

    Args:
        given: a table of values, or a queue size and whether the last message is kept for late subscribers.

    Raises:
        CommandError: a key or value is not valid.
    """
    first = given[0] if given else None
    if isinstance(first, Mapping):
        table: Mapping[Any, Any] = first  # pyright: ignore[reportUnknownVariableType]
        return _of_table({str(key): value for key, value in table.items()})
    is_latched = len(given) > 1 and given[1] is True
    return TopicQuality(_depth(first), is_transient_local=is_latched), []


def _of_table(table: Mapping[str, Any]) -> tuple[TopicQuality, list[str]]:
    for key in table:
        if key not in (*_APPLIED, *_NOT_APPLIED):
            raise CommandError(
                f"the quality of service has no '{key[:80]}'{did_you_mean(key, [*_APPLIED, *_NOT_APPLIED])}"
            )
    reliability, durability = (table.get(key, 0) for key in ("reliability", "durability"))
    for key, value, known in (
        ("reliability", reliability, RELIABILITY),
        ("durability", durability, DURABILITY),
    ):
        if value not in known.values():
            listed = ", ".join(f"simROS2.qos_{key}_policy.{name}" for name in known)
            raise CommandError(f"{key} of a quality of service is one of {listed}, not {value!r}")
    quality = TopicQuality(
        _depth(table.get("depth")),
        is_reliable=reliability != RELIABILITY["best_effort"],
        is_transient_local=durability == DURABILITY["transient_local"],
    )
    return quality, [key for key in table if key in _NOT_APPLIED]


def _depth(value: Any) -> int:
    if value is None or value == [] or value == 0:
        return TopicQuality().depth
    if not isinstance(value, int | float) or not 1 <= value <= MOST_DEPTH or value != int(value):
        raise CommandError(f"a depth or queue size is a whole number from 1 to {MOST_DEPTH}, not {value!r}")
    return int(value)
