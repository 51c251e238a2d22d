"""What each command of the table does: one module per family, collected here by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from . import collisions, files, joints, parameters, scripts, sensors, session, signals, simulation, vision
from .objects import groups, object_parameters, objects, poses
from .registry import Handler, handler, handlers_of
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
"""Command name to handler; a command that is not in it is not available."""

__all__ = ["HANDLERS", "Handler", "handler"]
