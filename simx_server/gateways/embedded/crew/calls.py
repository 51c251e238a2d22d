"""The calls of a plan, as those of one world."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from simx_client.errors import ConnectionFailed
from simx_client.protocol.commands import ANSWERED, TRIGGER, Command
from simx_client.protocol.kinds import INT
from simx_client.protocol.messages import STATUS_OK, Reply, of_fields
from simx_client.transport.direct import Noted, Refusal
from simx_server.service.answers.answers import Answer
from simx_server.service.calls.direct import DirectCall

if TYPE_CHECKING:
    from .lent import Lent

_TRIGGER = ANSWERED[TRIGGER]


class Calls(NamedTuple):
    """The calls of one world in a step, and at the start of an episode; see `simx_client.transport.direct.Plan`."""

    starts: Noted | None
    writes: Noted
    reads: Noted
    steps: int


class Caller:
    """Makes calls for the client of a world, within a turn of it."""

    def __init__(self, place: int, lent: Lent) -> None:
        self._place = place
        self._direct: Callable[[Command], DirectCall] = lambda command: lent.direct(lent.session, command)
        self.trigger = self._direct(_TRIGGER)

    def direct(self, command: Command) -> DirectCall:
        """Return a command, prepared for calls."""
        return self._direct(command)

    def answer(self, call: DirectCall, arguments: list[Any]) -> Answer:
        """Make a call.

        Raises:
            ConnectionFailed: it is answered later.
        """
        answer = call.execute(arguments)
        if answer.__class__ is not tuple:
            raise ConnectionFailed("a call of a crew has to be answered at once")
        return cast("Answer", answer)

    def refused(self, command: Command, arguments: list[Any], answer: Answer) -> list[Refusal]:
        """Return what an answer refuses, if it does."""
        status, values = answer
        if status == STATUS_OK:
            return []
        return [Refusal(self._place, command, arguments, of_fields(Reply, (0, status, 0, values)))]

    def trigger_refused(self, answer: Answer) -> list[Refusal]:
        """Return what the answer to a trigger refuses, if it does."""
        return self.refused(_TRIGGER, [], answer)


def filled(calls: Noted, values: Sequence[float]) -> Iterator[tuple[Command, list[Any]]]:
    """Yield calls with these numbers as their last arguments."""
    place = 0
    for command, arguments in calls:
        last = arguments[-1]
        width = _width(last)
        numbers = values[place : place + width]
        place += width
        if isinstance(last, list):
            yield command, [*arguments[:-1], list(numbers)]
        else:
            is_integer = command.arguments[-1].kind is INT
            yield command, [*arguments[:-1], int(numbers[0]) if is_integer else numbers[0]]


def width_of(calls: Noted) -> int:
    """Return how many numbers calls have as their last arguments."""
    return sum(_width(arguments[-1]) for _, arguments in calls)


def _width(argument: Any) -> int:
    return len(cast("list[Any]", argument)) if isinstance(argument, list) else 1
