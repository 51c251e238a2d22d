"""Reading much with one message: what a function read the last time is asked for before it is called again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

from simx_client.connection.answers import Answer
from simx_client.connection.strict import Strict

from .channel import Channel, Reads

T = TypeVar("T")


class Watch(Strict, Generic[T]):
    """A function that reads, with its answers fetched together: all of one instant, and one message from the second
    time on. What it reads for the first time costs a message of its own."""

    __slots__ = ("_channel", "_read", "_reads")

    def __init__(self, channel: Channel, read: Callable[[], T]) -> None:
        self._channel, self._read = channel, read
        self._reads: Reads = {}

    def __repr__(self) -> str:
        return f"<Watch {self._channel.state}, {len(self._reads)} calls in its message>"

    def __call__(self) -> T:
        """What the function returns now. Raises what reading raises."""
        self.fetch()
        return self.look()

    def fetch(self, before: Sequence[Answer[Any]] = ()) -> None:
        """Make calls, and after them those that the function will; all in one message."""
        self._channel.exchange([*before, *self._reads.values()])

    def look(self) -> T:
        """Call the function with what was fetched."""
        value, self._reads = self._channel.look(self._read, self._reads)
        return value
