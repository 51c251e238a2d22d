"""Messages of ROS with default values, as tables: what `simROS2.createInterface` returns.

The layouts are those of the gateway for ROS 2, `gateways/ros2/messages`, which are read when a script first asks.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from simx_server.ros2_messages import MessageType


def supported_messages() -> list[str]:
    """Return the types of all messages, as ROS 2 names them."""
    return sorted(name for name in _known() if "/msg/" in name)


def default_message(kind: str) -> dict[str, Any] | None:
    """Return a message with default values; None for an unknown type. `kind`: `std_msgs/msg/Bool`, `std_msgs::Bool`."""
    found = _find(kind)
    return None if found is None else found.default()


def constants(kind: str) -> dict[str, int]:
    """Return the numbers that the definition of a message names; empty for an unknown type."""
    found = _find(kind)
    return {} if found is None else dict(found.constants)


def _find(kind: str) -> MessageType | None:
    package, _, name = kind.replace("::", "/").replace("/msg/", "/").partition("/")
    return _known().get(f"{package}/msg/{name}")


def _known() -> Mapping[str, MessageType]:
    from simx_server.ros2_messages import BY_NAME

    return BY_NAME
