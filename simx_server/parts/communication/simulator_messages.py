"""Messages of the simulator that scripts read one by one: the selection changed, a model was loaded.

Each script reads the messages that come after its first call; at most 64 unread ones are kept, as in V-REP.
"""

from __future__ import annotations

from collections import deque

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.simulation.part import Part

MAX_UNREAD = 64

SELECTION_CHANGED = c.sim_message_object_selection_changed
MODEL_LOADED = c.sim_message_model_loaded


@dataclass(frozen=True)
class Message:
    """One message; `values` are its four numbers."""

    number: int
    kind: int
    values: tuple[int, int, int, int]


class SimulatorMessages(Part):
    """The latest messages, and what each script has read."""

    def __init__(self) -> None:
        self._latest: deque[Message] = deque(maxlen=MAX_UNREAD)
        self._next = 0
        self._read: dict[int, int] = {}
        """Script's handle to the number of its next message."""

    def scene_changed(self) -> None:
        self._latest.clear()
        self._read.clear()

    def post(self, kind: int, first: int = 0) -> None:
        """Add a message of a kind with its first number."""
        self._latest.append(Message(self._next, kind, (first, 0, 0, 0)))
        self._next += 1

    def take(self, script: int) -> Message | None:
        """Return a script's oldest unread message; None without one."""
        start = self._read.setdefault(script, self._next)
        for message in self._latest:
            if message.number >= start:
                self._read[script] = message.number + 1
                return message
        return None
