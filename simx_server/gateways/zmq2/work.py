"""A message of API 2 as work of the server loop."""

from __future__ import annotations

from dataclasses import dataclass

from simx_server.sim_api.effects import Effect
from simx_server.sim_api.object_model.dispatch import methods

from ..zmq.work import MessageWork
from .messages import CALL, function_of, kind_of

STOP = "simulation.stop"

_LONG = frozenset(("visitTree", "checkSensor", "getImage", "getDepth", "saveToBuffer", "saveModelToBuffer"))
"""Methods that only read, but wait, run functions or take long."""

_CLASSES = ("path", "scene", "app")


def _effect_of(name: str) -> Effect | None:
    """Return what methods of a name do, of whatever class."""
    found = (methods(kind).get(name) for kind in _CLASSES)
    return next((each.effect for each in found if each is not None), None)


@dataclass(slots=True)
class ModelWork(MessageWork):
    """One message of a connection."""

    def waits_for_scripts(self) -> bool:
        if kind_of(self.payload) != CALL:
            return False
        name = function_of(self.payload)
        return name in _LONG or _effect_of(name) != "reads"

    def stops(self) -> bool:
        return STOP.encode() in self.payload and function_of(self.payload) == STOP
