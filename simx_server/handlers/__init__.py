"""The handlers of all commands: one module per family, collected here by command name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from simx_server.service.calls.registry import Handler, handler, handlers_of

from . import (
    collisions,
    files,
    joints,
    numbers,
    parameters,
    scripts,
    sensors,
    session,
    signals,
    simulation,
    vision,
)
from .objects import groups, object_parameters, objects, poses
from .user_interface import consoles, custom_uis, dialogs

HANDLERS: Mapping[str, Handler] = MappingProxyType(
    handlers_of(
        collisions,
        consoles,
        custom_uis,
        dialogs,
        files,
        groups,
        joints,
        numbers,
        object_parameters,
        objects,
        parameters,
        poses,
        scripts,
        sensors,
        session,
        signals,
        simulation,
        vision,
    )
)
"""Handlers by command name; a command without an entry is not available."""

__all__ = ["HANDLERS", "Handler", "handler"]
