"""The replies to the calls of a batch, and the messages that they travel in.

Replies to sets that no client waits for are put together into one. Each message carries the state of the simulation in
its head.
"""

from __future__ import annotations

import math
import time
from typing import Any

from simx_client.protocol.codec import encode, encode_delivery
from simx_client.protocol.messages import STATUS_OK, Delivery, Reply, of_fields
from simx_server.world.simulation import Simulation, SimulationState

from .clock import Pacer
from .sessions import ClientSession

_STATE_BITS = {
    SimulationState.STOPPED: 0b000,
    SimulationState.RUNNING: 0b001,
    SimulationState.PAUSED: 0b011,
}
_REAL_TIME_BIT = 0b100

_SCENE_ID_MASK = 0xFFFF
"""The message header has two bytes for it."""


class Replies:
    """In the order of their calls."""

    __slots__ = ("_count", "_next_id", "_time_ms", "is_awaited", "made")

    def __init__(self, earlier: list[Reply]) -> None:
        """Begin with those that are there already."""
        self.made = earlier
        self.is_awaited = bool(earlier)
        """Somebody may wait for one of them. What was read, or why it was not, counts as such: it may be megabytes, of
        which no message shall hold many times as many."""

        self._count = [0]
        """The values of the last reply that ``done`` made."""

        self._next_id: int | None = None
        """Of a call that it may count as well, at this time."""

        self._time_ms = 0

    def add(self, call_id: int, status: int, time_ms: int, values: list[Any]) -> None:
        """Reply to a call whose answer says something, or is waited for."""
        self.is_awaited = True
        self.made.append(of_fields(Reply, (call_id, status, time_ms, values)))

    def done(self, call_id: int, time_ms: int) -> None:
        """A call that nobody waits for was executed, and gave nothing."""
        if call_id == self._next_id and time_ms == self._time_ms:
            self._count[0] += 1
        else:
            self._count, self._time_ms = [1], time_ms
            self.made.append(Reply(call_id, STATUS_OK, time_ms, self._count))
        self._next_id = call_id + 1


class Messages:
    """Packs replies into messages. Any thread."""

    def __init__(self, simulation: Simulation, pacer: Pacer) -> None:
        self._simulation = simulation
        self._pacer = pacer

    def time_ms(self) -> int:
        """Return the simulated time that replies carry."""
        return int(self._simulation.time * 1000 + 1e-6)  # 0.15 s is 149.99... as a float

    def pack(self, session: ClientSession, replies: list[Reply]) -> bytes:
        """Return a message with these replies."""
        return encode(self._delivery(session, replies))

    def pack_parts(self, session: ClientSession, parts: bytes, count: int) -> bytes:
        """Return a message with as many replies that are packed already."""
        return encode_delivery(self._delivery(session, []), parts, count)

    def _delivery(self, session: ClientSession, replies: list[Reply]) -> Delivery:
        state = _STATE_BITS[self._simulation.state] | (
            _REAL_TIME_BIT if math.isfinite(self._pacer.speed) else 0
        )
        return Delivery(
            session.message_id,
            session.client_time,
            int(time.monotonic() * 1000) & 0x7FFF_FFFF,
            self._simulation.scene_id & _SCENE_ID_MASK,
            state,
            replies,
        )
