"""A call that a message or a request of ROS 2 becomes."""

from __future__ import annotations

from typing import Any, NamedTuple


class Call(NamedTuple):
    """A call of the remote API's table."""

    command: str
    """Such as ``simxSetJointTargetPosition``."""

    arguments: list[Any]
