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

__all__ = ["Object", "PropertyGroup", "app", "const", "scene", "self"]

version = 2

app, scene = Object(HANDLE_APP), Object(HANDLE_SCENE)
self = Object(HANDLE_SELF)


def _connected() -> Callable[..., Any]:
    from .zmqremoteapi import connect

    return connect().call


connect_by(_connected)
