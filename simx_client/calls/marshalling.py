"""Marshalling: convert arguments and replies, and make the results of legacy functions, also without a reply.

One ``Marshal`` per command, made from the table: argument coercion, the key, the result tuple.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Any, cast

from simx_client.protocol.commands import Command
from simx_client.protocol.kinds import DEPTHS, Kind, apply, to_int32
from simx_client.protocol.messages import Operation

from .images import DepthBuffer, VisionImage

Key = tuple[Any, ...]


class Marshal:
    """The client's view of one command."""

    __slots__ = (
        "_arguments",
        "_coercions",
        "_fresh",
        "_fresh_one",
        "_identifying",
        "_is_scalar",
        "_results",
        "command",
        "gives_nothing",
        "is_plain",
        "is_plain_oneshot",
        "is_set",
        "only_newest",
        "operation",
    )

    def __init__(self, command: Command, operation: Operation = Operation.EXECUTE) -> None:
        self.command = command
        self.operation = operation
        """Operation that the server executes in blocking mode."""

        self._arguments = tuple((argument.name, argument.kind.coerce) for argument in command.arguments)
        self._coercions = tuple(argument.kind.coerce for argument in command.arguments)
        self._identifying = _picked(command.key_positions)
        self._results = tuple(result.kind for result in command.results)
        self._fresh = tuple(result.kind.fresh for result in command.results)
        self._fresh_one = self._fresh[0] if len(self._fresh) == 1 else None
        """How the only result is copied for the caller."""

        self._is_scalar = self._fresh == (None,)
        """The result is one value that cannot be changed in place."""

        self.is_set = len(command.arguments) > len(command.key)
        self.gives_nothing = not command.results
        self.is_plain = not (command.takes_what_it_reads or command.never_blocking)
        """A blocking call does nothing but return its reply."""

        self.is_plain_oneshot = not (command.takes_what_it_reads or command.makes_image)
        """A oneshot call is executed at once, and its reply replaces the one before."""

        self.only_newest = not (command.takes_what_it_reads or command.stream_ends_with_hit)
        """A reply replaces the one before and has no other effect."""

    def coerce(self, arguments: tuple[Any, ...]) -> list[Any]:
        """Convert arguments to the types of a message.

        Raises:
            TypeError, IndexError: naming the function and the argument.
        """
        try:
            return list(map(apply, self._coercions, arguments))
        except (TypeError, IndexError):
            for (name, coerce), value in zip(self._arguments, arguments, strict=True):
                try:
                    coerce(value)
                except (TypeError, IndexError) as error:
                    raise type(error)(f"{self.command.name}: {name} {error}") from None
            raise

    def mode(self, value: Any) -> int:
        """Return an operation mode given as another type than int: NumPy's integers, bool. Raises TypeError
        for others."""
        try:
            return to_int32(value)
        except TypeError as error:
            raise TypeError(f"{self.command.name}: operationMode {error}") from None

    def key(self, arguments: Sequence[Any]) -> Key:
        """Return the key, which makes two calls the same command: the function and its identifying arguments."""
        return self.command.name, self._identifying(arguments)

    def prepare(self) -> None:
        """Prepare what an image takes long for and does not depend on it, while it is awaited."""
        (DepthBuffer if self._results[1] is DEPTHS else VisionImage).prepare()

    def failure(self, code: int) -> Any:
        """Return the result without data: the code, and defaults."""
        if not self._results:
            return code
        return (code, *[kind.default() for kind in self._results])

    def success(self, values: list[Any]) -> Any:
        """Return the result made of a reply. Lists are new each time: scripts change them in place."""
        if self._is_scalar:
            return 0, values[0]
        if self._fresh_one is not None:
            return 0, self._fresh_one(values[0])
        if not self._results:
            return 0
        if self.command.gives_image:
            return _image(self._results[1], values)
        return (
            0,
            *[
                value if fresh is None else fresh(value)
                for value, fresh in zip(values, self._fresh, strict=True)
            ],
        )


def _picked(positions: tuple[int, ...]) -> Callable[[Sequence[Any]], Any]:
    """Return a function that picks the items at these positions: none, one, or a tuple of several."""
    return cast(Callable[[Sequence[Any]], Any], itemgetter(*positions)) if positions else lambda _: None


def _image(kind: Kind, values: list[Any]) -> tuple[int, list[int], Any]:
    (width, height), data = values
    if kind is DEPTHS:
        return 0, [width, height], DepthBuffer.from_bytes(data, width, height)
    return (
        0,
        [width, height],
        VisionImage.from_bytes(data, width, height, len(data) // max(1, width * height)),
    )
