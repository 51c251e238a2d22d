"""A message of API 2 as work of the server loop."""

from __future__ import annotations

from dataclasses import dataclass

from simx_server.sim_api.effects import Effect
from simx_server.sim_api.object_model.dispatch import methods

from ..zmq.wire.messages import WireError
from ..zmq.work import MOST_READ, MessageWork
from .messages import CALL, Message, read_message

STOP = "simulation.stop"
_STOP_MARK = STOP.encode()

_LONG = frozenset(("visitTree", "checkSensor", "getImage", "getDepth", "saveToBuffer", "saveModelToBuffer"))
"""Methods that only read, but wait, run functions or take long."""

_CLASSES = ("path", "scene", "app")


def _effect_of(name: str) -> Effect | None:
    """Return what methods of a name do, of whatever class."""
    found = (methods(kind).get(name) for kind in _CLASSES)
    return next((each.effect for each in found if each is not None), None)


@dataclass(slots=True, init=False)
class ModelWork(MessageWork):
    """One message of a connection."""

    def waits_for_scripts(self) -> bool:
        message = self._message()
        if message is not None and message.kind != CALL:
            return False
        return message is None or message.function in _LONG or _effect_of(message.function) != "reads"

    def stops(self) -> bool:
        if _STOP_MARK not in self.payload:
            return False
        message = self._message()
        return message is not None and message.kind == CALL and message.function == STOP

    def _message(self) -> Message | None:
        """Return the message; None if it is unreadable or too long to be read twice."""
        if len(self.payload) > MOST_READ:
            return None
        try:
            return read_message(self.payload)
        except WireError:
            return None
