"""Read many values with one message: request the values that a function read the last time before calling it
again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

from simx_client.calls.answers import Answer
from simx_client.calls.strict import Strict

from .channel import Channel, Reads

T = TypeVar("T")


class Watch(Strict, Generic[T]):
    """A function that reads, with its answers fetched together.

    All values are of one instant. From the second call on they take one message; a value that is read for the
    first time takes a separate message.
    """

    __slots__ = ("_channel", "_read", "_reads")

    def __init__(self, channel: Channel, read: Callable[[], T]) -> None:
        self._channel, self._read = channel, read
        self._reads: Reads = {}

    def __repr__(self) -> str:
        return f"<Watch {self._channel.state}, {len(self._reads)} calls in its message>"

    def __call__(self) -> T:
        """Return the function's result of now. Raises the errors of reading."""
        self.fetch()
        return self.look()

    def fetch(self, before: Sequence[Answer[Any]] = ()) -> None:
        """Make the calls `before`, and after them those that the function will make; all in one message."""
        self._channel.exchange([*before, *self._reads.values()])

    def look(self) -> T:
        """Call the function with the fetched answers."""
        value, self._reads = self._channel.look(self._read, self._reads)
        return value
