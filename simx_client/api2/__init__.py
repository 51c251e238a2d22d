"""CoppeliaSim's package `sim` of API 2, for programs outside: `sim.scene.getObject('/box').position`.

Programs set ``sim.Object._callMethod = ZMQRemoteAPI({'port': port}).call``. One that does not is connected at its first
call, to port 24020 of this machine, or to ``SIMX_ZMQ2_PORT``. `simx-run` gives this package to programs as `sim`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from simx_client.protocol.api2.objects import (
    HANDLE_APP,
    HANDLE_SCENE,
    HANDLE_SELF,
    Object,
    PropertyGroup,
    connect_by,
)

from . import const

__all__ = ["IK", "Object", "Path", "PropertyGroup", "app", "const", "scene", "self"]

version = 2

app, scene = Object(HANDLE_APP), Object(HANDLE_SCENE)
self = Object(HANDLE_SELF)


class Path:
    """A path through configurations, which the server has: `Path(points)` returns a reference to it."""

    def __new__(cls, points: Any = None, options: dict[str, Any] | None = None) -> Any:
        """Make a path of control points, the columns of a matrix; the options are those of CoppeliaSim."""
        return app.callMethod("Path", points, options or {})

    @staticmethod
    def fromObject(target: Object, options: dict[str, Any] | None = None) -> Any:
        """Make an empty path of an object's poses."""
        return app.callMethod("Path.fromObject", target.handle, options or {})

    @staticmethod
    def fromJoints(tip: Object, base: Object | None = None, options: dict[str, Any] | None = None) -> Any:
        """Make an empty path of the joints between an object and its base."""
        return app.callMethod(
            "Path.fromJoints", tip.handle, None if base is None else base.handle, options or {}
        )

    @staticmethod
    def fromBuffer(content: bytes, objects: dict[str, Any] | None = None) -> Any:
        """Make a path of what `toBuffer` has returned."""
        return app.callMethod("Path.fromBuffer", content, objects or {})


class IK:
    """A world of inverse kinematics, which the server has: `IK()` returns a reference to it."""

    constraint_x, constraint_y, constraint_z, constraint_position = 1, 2, 4, 7
    constraint_alphabeta, constraint_gamma, constraint_orientation, constraint_pose = 8, 16, 24, 31

    def __new__(cls) -> Any:
        """Make an empty world."""
        return app.callMethod("IK")


def _connected() -> Callable[..., Any]:
    from .zmqremoteapi import connect

    return connect().call


connect_by(_connected)
