"""Messages of ROS with default values, as tables: what `simROS2.createInterface` returns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from simx_server.ros2_messages import KnownTypes, MessageType


def supported_messages(types: KnownTypes) -> list[str]:
    """Return the types of all messages, as ROS 2 names them."""
    return sorted(name for name in types.newer.messages if "/msg/" in name)


def default_message(types: KnownTypes, kind: str) -> dict[str, Any] | None:
    """Return a message with default values; None for an unknown type. `kind`: `std_msgs/msg/Bool`, `std_msgs::Bool`."""
    found = _find(types, kind)
    return None if found is None else found.default()


def constants(types: KnownTypes, kind: str) -> dict[str, Any]:
    """Return the values that the definition of a message names; empty for an unknown type."""
    found = _find(types, kind)
    return {} if found is None else dict(found.constants)


def _find(types: KnownTypes, kind: str) -> MessageType | None:
    package, _, name = kind.replace("::", "/").replace("/msg/", "/").partition("/")
    return types.newer.messages.get(f"{package}/msg/{name}")
