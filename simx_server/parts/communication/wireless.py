"""Wireless communication of V-REP 3: a script sends a message from an antenna, other scripts near it receive it.

A message can be received within a distance of the antenna and two opening angles, for a span of simulated time. Each
script receives a message once, and never its own.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import field
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import IDENTITY, Pose, conjugate, rotate, subtract
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

MAX_MESSAGES = 4096
"""Most messages in the air; the oldest are dropped."""

MAX_BYTES = 16 << 20
"""Most bytes in the air; the oldest messages are dropped."""

NO_ANTENNA = -1
"""In place of an antenna: the origin of the world."""

_WHOLE_TURN = 1e-3
"""Radians by which an opening angle may be too small and still be everywhere: scripts write 3.1415."""

_ROUNDING = 1e-9
"""Rounding must not end a message a simulation step too early."""


@dataclass(frozen=True)
class Address:
    """Kind of a message, and who may receive it."""

    header: int
    name: str
    receivers: frozenset[int] | None
    """Handles of the scripts that may receive it; None: all."""


@dataclass(frozen=True)
class Area:
    """Where a message can be received, seen from the antenna."""

    radius: float
    """Metres."""
    vertical: float = math.pi
    """Opening angle about the antenna's xy plane, 0..pi; pi is everywhere."""
    horizontal: float = 2 * math.pi
    """Opening angle about the antenna's x axis in its xy plane, 0..2 pi; 2 pi is everywhere."""

    def holds(self, antenna: Pose, point: tuple[float, float, float]) -> bool:
        """Return whether a point (world frame, m) is in the area of an antenna with this pose."""
        x, y, z = rotate(conjugate(antenna[1]), subtract(point, antenna[0]))
        if math.hypot(x, y, z) > self.radius:
            return False
        elevation, azimuth = math.atan2(z, math.hypot(x, y)), math.atan2(y, x)
        return (
            2 * abs(elevation) <= self.vertical + _WHOLE_TURN
            and 2 * abs(azimuth) <= self.horizontal + _WHOLE_TURN
        )


@dataclass(eq=False)
class Message:
    """A message in the air."""

    sender: int
    """Handle of the sending script."""
    address: Address
    data: bytes
    antenna: Pose
    """Pose of the antenna when it sent the message, in the world."""
    area: Area
    until: float
    """Simulated time of its end."""
    received_by: set[int] = field(default_factory=set[int])


class Wireless(Part):
    """All messages in the air; start and stop of a run clear them."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._messages: deque[Message] = deque()

    def run_started(self) -> None:
        self._messages.clear()

    def run_stopped(self) -> None:
        self._messages.clear()

    def scene_changed(self) -> None:
        self._messages.clear()

    def send(
        self, sender: int, address: Address, data: bytes, antenna: int, area: Area, seconds: float
    ) -> None:
        """Send a message.

        Args:
            sender: handle of the script.
            address: its kind and receivers.
            data: its content.
            antenna: handle of the object that sends, NO_ANTENNA for the world's origin.
            area: where it can be received.
            seconds: simulated time for which it can be received; 0 means 1.5 simulation steps.

        Raises UnknownHandle.
        """
        self._forget_old()
        lasting = seconds if seconds > 0 else 1.5 * self._sim.time_step
        message = Message(sender, address, data, self._pose(antenna), area, self._sim.time + lasting)
        self._messages.append(message)
        total = sum(len(each.data) for each in self._messages)
        while len(self._messages) > MAX_MESSAGES or total > MAX_BYTES:
            total -= len(self._messages.popleft().data)

    def receive(
        self, receiver: int, header: int | None, name: str | None, antenna: int, index: int | None
    ) -> Message | None:
        """Return a message that a script can receive, the oldest first; None without one.

        Args:
            receiver: handle of the script.
            header, name: of the message; None for any.
            antenna: handle of the object that receives, NO_ANTENNA for the world's origin.
            index: among the messages that fit, from 0; they stay. None: the first, which this script does not receive
                again.

        Raises UnknownHandle.
        """
        self._forget_old()
        place = self._pose(antenna)[0]
        for number, message in enumerate(self._fitting(receiver, header, name, place)):
            if index is None:
                message.received_by.add(receiver)
                return message
            if number == index:
                return message
        return None

    def _fitting(
        self, receiver: int, header: int | None, name: str | None, place: tuple[float, float, float]
    ) -> Iterator[Message]:
        for message in self._messages:
            address = message.address
            if (
                message.sender != receiver
                and receiver not in message.received_by
                and (address.receivers is None or receiver in address.receivers)
                and header in (None, address.header)
                and name in (None, address.name)
                and message.area.holds(message.antenna, place)
            ):
                yield message

    def _pose(self, antenna: int) -> Pose:
        return IDENTITY if antenna == NO_ANTENNA else frames.get_pose(self._sim, antenna)

    def _forget_old(self) -> None:
        now = self._sim.time - _ROUNDING
        if any(each.until < now for each in self._messages):
            self._messages = deque(each for each in self._messages if each.until >= now)
