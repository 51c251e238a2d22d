"""Collect the replies to the calls of a batch, and put them into deliveries.

Replies to sets that no client waits for are combined into one. Each delivery carries the state of the simulation in its
header.
"""

from __future__ import annotations

import math
import time
from typing import Any, NamedTuple

from simx_client.protocol.messages import STATUS_OK, Delivery, Reply, of_fields
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.clock import Pacer
from simx_server.simulation.simulation import Simulation, SimulationState

_RUNNING_BITS, _PAUSED_BITS = 0b001, 0b011
_REAL_TIME_BIT = 0b100

_SCENE_ID_MASK = 0xFFFF
"""The message header has two bytes for it."""


class Replies:
    """Replies in the order of their calls."""

    __slots__ = ("_count", "_next_id", "_time_ms", "is_awaited", "made")

    def __init__(self, earlier: list[Reply]) -> None:
        """Start with the replies that are present already."""
        self.made = earlier
        self.is_awaited = bool(earlier)
        """A client may wait for one of them. Results of reading, and the reasons for failures, count as awaited: they
        may have megabytes, and a message must not contain a multiple of that.
        """

        self._count = [0]
        """The values of the last reply that ``done`` made."""

        self._next_id: int | None = None
        """The id and time of a call that the last reply may count as well."""

        self._time_ms = 0

    def add(self, call_id: int, status: int, time_ms: int, values: list[Any]) -> None:
        """Reply to a call whose answer has values, or is awaited."""
        self.is_awaited = True
        self.made.append(of_fields(Reply, (call_id, status, time_ms, values)))

    def done(self, call_id: int, time_ms: int) -> None:
        """Record that a call that no client waits for was executed, without a result."""
        if call_id == self._next_id and time_ms == self._time_ms:
            self._count[0] += 1
        else:
            self._count, self._time_ms = [1], time_ms
            self.made.append(Reply(call_id, STATUS_OK, time_ms, self._count))
        self._next_id = call_id + 1


class Instant(NamedTuple):
    """The part of a message's header that changes with time."""

    seconds: float
    """On the monotonic clock."""

    state: SimulationState
    scene_id: int


class Messages:
    """Puts replies into deliveries. Any thread."""

    def __init__(self, simulation: Simulation, pacer: Pacer) -> None:
        self._simulation = simulation
        self._pacer = pacer

    def time_ms(self) -> int:
        """Return the simulated time that replies carry, in milliseconds."""
        return int(self._simulation.time * 1000 + 1e-6)  # 0.15 s is 149.99... as a float

    def instant(self) -> Instant:
        """Return what a header says of now."""
        simulation = self._simulation
        return of_fields(Instant, (time.monotonic(), simulation.state, simulation.scene_id))

    @staticmethod
    def scene_id(number: int) -> int:
        """Return the form that a header has of a scene's number."""
        return number & _SCENE_ID_MASK

    def header(self, at: Instant, message_id: int, client_time: int) -> Delivery:
        """Return a delivery without replies that was sent at an instant."""
        return self._delivery(*at, message_id, client_time, [])

    def delivery(self, session: ClientSession, replies: list[Reply]) -> Delivery:
        """Return a delivery with these replies, sent now."""
        simulation = self._simulation
        state, scene = simulation.state, simulation.scene_id
        return self._delivery(
            time.monotonic(), state, scene, session.message_id, session.client_time, replies
        )

    def _delivery(
        self,
        seconds: float,
        state: SimulationState,
        scene: int,
        message_id: int,
        client_time: int,
        replies: list[Reply],
    ) -> Delivery:
        # Without a table by state: the hash of an enumeration's member takes longer than the rest.
        bits = _RUNNING_BITS if state is SimulationState.RUNNING else 0
        if state is SimulationState.PAUSED:
            bits = _PAUSED_BITS
        if math.isfinite(self._pacer.speed):
            bits |= _REAL_TIME_BIT
        time_ms = int(seconds * 1000) & 0x7FFF_FFFF
        return of_fields(Delivery, (message_id, client_time, time_ms, scene & _SCENE_ID_MASK, bits, replies))
