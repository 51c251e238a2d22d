"""Streams: calls that are executed again after each simulation step, until cancelled.

Each distinct question is computed once per simulation step, however many clients ask it. Its answer is packed once and
put behind the id that it has for each client. All small values of one client leave together in one message, so they
belong to one instant; a value that is not due this time is repeated from before. Images travel separately when they are
rendered.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Container, Hashable, Sequence
from concurrent.futures import Future
from dataclasses import field
from typing import TYPE_CHECKING, Any

from simx_client.protocol.codec import encode_delivery
from simx_client.protocol.commands import Command
from simx_client.protocol.messages import Delivery
from simx_client.protocol.python.light_dataclass import dataclass

from .answers import Answer

if TYPE_CHECKING:
    from .positions import Positions

REPEAT = 0.25
"""Seconds after which unchanged stream values are sent once more, in case a message was dropped."""

Question = tuple[Any, ...]
"""Command and arguments."""

StepAnswers = dict[Question, Answer | Future[Answer]]
"""The answers of one simulation step by question: equal questions are computed once."""


@dataclass(slots=True, eq=False)
class Value:
    """The newest answer of a stream."""

    command: Command
    answer: Answer
    time_ms: int
    """Its simulated time in milliseconds."""

    packed: bytes | None = None
    """The answer as bytes; None before a client of this project's own protocol needs it."""


@dataclass(slots=True, weakref_slot=True, eq=False, kw_only=True)
class Shared(Value):
    """A question that any number of streams ask after each simulation step, and its newest answer."""

    question: Question
    arguments: list[Any]
    work: Callable[[], Any] | None
    """The handler with its arguments, if it only reads and needs no client."""

    round: int = -1
    """The round of the last answer."""


@dataclass(eq=False)
class Stream:
    """One armed stream of one client."""

    stream_id: int
    command: Command
    arguments: list[Any]
    delay: float
    """Least wall time between two executions, seconds."""

    head: bytes
    """The packed start of its answers."""

    shared: Shared | None = None
    """Set if the stream is due each time and small, and others may ask the same."""

    next_due: float = 0.0
    last: Value | None = None
    """The newest answer of a stream that is not shared."""

    pending: Future[Any] | None = None
    """Done when the image that is being rendered has been sent: until then, no other is requested."""

    sent_version: Hashable = None
    """Version of the scene of which a client that steps has the image."""

    @property
    def value(self) -> Value | None:
        """Return the newest answer; None before it comes, and if it travels alone."""
        if self.shared is not None:
            return self.shared
        return None if self.command.takes_what_it_reads else self.last

    def question(self) -> Question | None:
        """Return the key that equal streams share; None when the answer belongs to one client only."""
        if self.command.takes_what_it_reads or self.command.stream_ends_with_hit or not self.command.key:
            return None
        if len(self.command.key) != len(self.command.arguments):
            return None  # it sets something: each client's own call counts
        return (self.command.name, *self.arguments)

    def is_due(self, now: float, *, every_image: bool) -> bool:
        """Return whether to execute it now. `every_image`: the client steps and waits for each, so none is left out."""
        is_behind = self.pending is not None and not self.pending.done() and not every_image
        if now < self.next_due or is_behind:
            return False
        self.next_due = now + self.delay
        return True


@dataclass
class Streams:
    """The streams of one client, in the order they were armed."""

    by_id: dict[int, Stream] = field(default_factory=dict[int, Stream])
    shared: dict[int, Stream] = field(default_factory=dict[int, Stream])
    """Those of them that share their answers."""

    single: dict[int, Stream] = field(default_factory=dict[int, Stream])
    """The others."""

    last_sent: bytes | None = None
    next_repeat: float = 0.0
    is_cut: bool = False
    """Time ran out before all of `shared` were computed in the last round."""

    next_single: int = 0
    """The first of `single` that was left out because time ran out, or 0."""

    positions: Positions | None = None
    """Those of `shared` that were read from a copy in the last round; None after a change of these streams."""

    _shared_values: Sequence[tuple[int, Shared]] | None = None
    """What `shared_values` returns; None after a change of these streams."""

    _parts: list[bytes] = field(default_factory=list[bytes])
    """Their heads and newest answers, alternating."""

    def shared_values(self) -> Sequence[tuple[int, Shared]]:
        """Return the ids of `shared`, and what they share with others, in the order they were armed."""
        if self._shared_values is None:
            both = [(stream, stream.shared) for stream in self.shared.values() if stream.shared is not None]
            self._shared_values = [(stream.stream_id, share) for stream, share in both]
            self._parts = [part for stream, _ in both for part in (stream.head, b"")]
        return self._shared_values

    def shares(self) -> list[Shared]:
        """Return what these streams share with others, in the order they were armed."""
        return [share for _, share in self.shared_values()]

    def parts(self, pack: Callable[[Value], bytes], positions: Positions | None = None) -> list[bytes]:
        """Return the newest answers as they travel, each behind its stream's head.

        Args:
            pack: packs an answer that is not packed yet.
            positions: those of `shared` that travel in another way.
        """
        shares = self.shares() if positions is None else positions.others
        answers = [pack(share) if share.packed is None else share.packed for share in shares]
        if positions is None:
            self._parts[1::2] = answers
            parts = self._parts.copy()
        else:
            parts = [part for both in zip(positions.heads, answers, strict=True) for part in both]
        for stream in self.single.values():
            if (value := stream.value) is not None:
                parts += (stream.head, pack(value) if value.packed is None else value.packed)
        return parts

    def values(self, *, without: Container[int] = ()) -> Sequence[tuple[int, Value]]:
        """Return the id of each stream that has a value, and this value, in the order in which they were armed."""
        if not self.single and not without:
            return self.shared_values()
        values = ((each, stream.value) for each, stream in self.by_id.items() if each not in without)
        return [(stream_id, value) for stream_id, value in values if value is not None]

    def arm(self, stream: Stream) -> None:
        """Add a stream; it was executed once already, as part of the call."""
        stream.next_due = time.monotonic() + stream.delay
        self.cancel(stream.stream_id)
        self.by_id[stream.stream_id] = stream
        (self.single if stream.shared is None else self.shared)[stream.stream_id] = stream
        self._shared_values = self.positions = None

    def single_in_turn(self) -> list[Stream]:
        """Return the streams of `single`, starting with those that had to wait."""
        streams = list(self.single.values())
        if self.next_single:
            first = next((i for i, each in enumerate(streams) if each.stream_id == self.next_single), 0)
            streams, self.next_single = streams[first:] + streams[:first], 0
        return streams

    def separate(self, share: Shared) -> None:
        """Move the streams with this answer to `single`, because the answer comes later."""
        for stream in [each for each in self.shared.values() if each.shared is share]:
            stream.shared = None
            del self.shared[stream.stream_id]
            self.single[stream.stream_id] = stream
        self._shared_values = self.positions = None

    def images_on_the_way(self) -> list[Future[Any]]:
        """Return the images that are requested and not rendered yet."""
        if not self.single:
            return []
        pending = (stream.pending for stream in self.single.values())
        return [image for image in pending if image is not None and not image.done()]

    def cancel(self, stream_id: int) -> None:
        """End a stream; unknown ids are harmless."""
        if self.by_id.pop(stream_id, None) is not None:
            self.shared.pop(stream_id, None)
            self.single.pop(stream_id, None)
            self._shared_values = self.positions = None

    def clear(self) -> None:
        """End all streams."""
        for streams in (self.by_id, self.shared, self.single):
            streams.clear()
        self._shared_values = self.positions = None


class NewestValues:
    """The newest values of the small streams of one client. Physics thread, until the next simulation step."""

    __slots__ = ("_head", "_now", "_packer", "_streams", "numbers", "positions", "time_ms")

    def __init__(
        self,
        streams: Streams,
        now: float,
        time_ms: int,
        head: Callable[[], Delivery],
        packer: Callable[[], Callable[[Value], bytes]],
        positions: Positions | None = None,
        numbers: memoryview[float] | None = None,
    ) -> None:
        """Make them.

        Args:
            streams: those of the client.
            now: the time on the monotonic clock.
            time_ms: the simulated time in milliseconds.
            head: makes the delivery without replies.
            packer: returns a function that packs an answer that is not packed yet.
            positions: the streams that are read from a copy, if the link copies positions.
            numbers: the copy.
        """
        self.time_ms, self.positions, self.numbers = time_ms, positions, numbers
        self._streams, self._now, self._head, self._packer = streams, now, head, packer

    @property
    def head(self) -> Delivery:
        """Return the delivery without replies."""
        return self._head()

    def of_streams(self) -> Sequence[tuple[int, Value]]:
        """Return the id of each stream that has a value, and this value; not of `positions`."""
        positions = self.positions
        if positions is None:
            return self._streams.values()
        return self._streams.values(without=positions.ids) if self._streams.single else positions.values

    def packed(self) -> bytes:
        """Return them as a message, each packed once for all clients; empty if the same was sent a moment ago."""
        streams, positions, numbers = self._streams, self.positions, self.numbers
        if positions is None or numbers is None:
            parts = streams.parts(self._packer())
            replies, count = b"".join(parts), len(parts) // 2
        else:
            replies, count = positions.packed(numbers, self.time_ms), len(positions.places)
            if positions.others or streams.single:
                parts = streams.parts(self._packer(), positions)
                replies, count = b"".join((replies, *parts)), count + len(parts) // 2
        if replies == streams.last_sent and self._now < streams.next_repeat:
            return b""
        streams.last_sent, streams.next_repeat = replies, self._now + REPEAT
        return encode_delivery(self._head(), replies, count)
