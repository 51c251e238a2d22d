"""The newest values of the streams of one client, as they were after a simulation step, until the client takes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from simx_client.protocol.messages import STATUS_OK, Reply, of_fields
from simx_client.protocol.precision import Values, as_single
from simx_server.joints.joints import position_in

if TYPE_CHECKING:
    from simx_client.protocol.commands import Command
    from simx_server.service.answers.answers import Answer
    from simx_server.service.answers.positions import Place
    from simx_server.service.answers.streams import NewestValues
    from simx_server.simulation.simulation import SimulationState


class Published:
    """Values that are not written any more. Their form is not yet that of a message."""

    __slots__ = ("_others", "at", "is_seen", "numbers", "places", "time_ms")

    def __init__(self, values: NewestValues, at: tuple[float, SimulationState, int]) -> None:
        """Keep what is published.

        Args:
            at: the present instant, see `replies.Instant`.
        """
        self.at, self.time_ms = at, values.time_ms
        self.is_seen = False
        """Whether the client has read one of them."""

        self.numbers = values.numbers
        self.places: Mapping[int, Place] = {} if values.positions is None else values.positions.places
        """Of the positions in `numbers`, by the joint's handle."""

        self._others: Sequence[tuple[int, Command, Answer, int]] = ()
        if others := values.of_streams():
            self._others = [(each, one.command, one.answer, one.time_ms) for each, one in others]

    def position(self, handle: int) -> tuple[int, float] | None:
        """Return the id of the stream of a joint's position, and the position; None if it has to be taken."""
        place = self.places.get(handle)
        if place is None or self.numbers is None:
            return None
        stream_id, position = place
        return stream_id, as_single(position_in(self.numbers, position))

    def replies(self, received: Callable[[Command, Values], Values]) -> list[Reply]:
        """Return them as messages would bring them.

        Args:
            received: gives the results of a command that form.
        """
        replies: list[Reply] = []
        for handle in self.places:
            if (found := self.position(handle)) is not None:
                replies.append(of_fields(Reply, (found[0], STATUS_OK, self.time_ms, [found[1]])))
        for stream_id, command, (status, results), time_ms in self._others:
            if status == STATUS_OK:
                results = received(command, results)
            replies.append(of_fields(Reply, (stream_id, status, time_ms, results)))
        return replies
