"""Keep the commands of a client and the replies to it: equal commands, streams, message ids.

Commands wait here until the server loop takes them, which is at once unless much of this client is under way. Meanwhile
the original's rules hold: a new command takes the place of an equal one that waits. A stream is one of the server loop.

A client waits for a blocking call until a message comes whose id is at least that of the message with the call. So the
id of a reply is below those of the messages whose blocking calls are not answered yet.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from simx_client.protocol.commands import Command
from simx_client.protocol.messages import (
    NOT_AWAITED_MS,
    STATUS_OK,
    Batch,
    Call,
    Delivery,
    Operation,
    Pace,
    Reply,
)
from simx_client.protocol.table.original_wire import Wire
from simx_server.limits import Limits

from . import messages as m
from .messages import Head, Key, Message, Request
from .splitting import Incoming, Outgoing
from .translation import UNKNOWN, Translated, command_of, payload, translate

MOST_UNDER_WAY = 8
"""Batches that are not answered yet, above which commands wait here. Images and steps do not count."""

MUCH_WAITING, MUCH_WAITING_BYTES = 1000, 8 << 20
"""Waiting commands and their bytes above which the client gets no reply, and so sends nothing, until some are taken."""

_LARGEST_CALL_ID = 0x7FFF_FFFF


class _Asked(NamedTuple):
    """A command that is under way, or a stream."""

    request: Request
    wire: Wire
    command: Command
    batch: int

    @property
    def comes_soon(self) -> bool:
        """Return whether its answer comes before those to later batches."""
        return self.command.answers_soon


class _Value(NamedTuple):
    """The newest result of a stream, until it is sent."""

    asked: _Asked
    reply: Reply


class Containers:
    """The commands and replies of one connection. One thread at a time."""

    def __init__(self, limits: Callable[[], Limits], pace: Pace = Pace.FREE) -> None:
        """Start without commands.

        Args:
            limits: returns the present limits.
            pace: of blocking calls while the simulation runs.
        """
        self._limits, self._pace = limits, pace
        self._waiting: list[Request] = []
        """The commands that the server loop has not taken."""

        self._places: dict[Key, int] = {}
        """The place of the first command of each key in `_waiting`."""

        self._waiting_bytes = 0
        self._incoming = Incoming(limits().message)
        self._outgoing = Outgoing()
        self._streams: dict[Key, int] = {}
        """The call ids of the streams."""

        self._asked: dict[int, _Asked] = {}
        self._batches: dict[int, set[int]] = {}
        """The calls of each batch that are not answered yet, without those whose answers may come late."""

        self._blocking: dict[int, int] = {}
        """Message ids of blocking calls that are not answered yet, by call id; by ``-1 - place`` while they wait."""

        self._next_call_id, self._batch = 1, 0
        self._newest_message, self._client_time = m.NOTHING_EXECUTED, 0
        self._head = Head()
        self._replies: list[bytes] = []
        self._values: dict[Key, _Value] = {}

    # --- what comes from the client --------------------------------------------------------------

    def receive(self, message: Message) -> None:
        """Add the commands of a message to those that wait."""
        self._newest_message, self._client_time = message.message_id, message.client_time
        for each in message.requests:
            request = self._incoming.add(each) if each.is_piece else each
            if request is not None:
                self._add(request, message.message_id)

    def _add(self, request: Request, message_id: int) -> None:
        place = self._places.get(request.key)
        if place is None or request.keeps_equal:
            place = len(self._waiting)
            self._places.setdefault(request.key, place)
            self._waiting.append(request)
        else:
            old = self._waiting[place]
            if old.mode == request.mode == m.ONESHOT_SPLIT:
                return
            self._waiting_bytes -= len(old.payload)
            self._waiting[place] = request
            self._blocking.pop(-1 - place, None)
        self._waiting_bytes += len(request.payload)
        if request.mode == m.BLOCKING:
            self._blocking[-1 - place] = message_id

    @property
    def incomplete(self) -> int:
        """Return the bytes of commands of which pieces are missing."""
        return self._incoming.size

    @property
    def is_full(self) -> bool:
        """Return whether so much waits that the client must be slowed down."""
        return len(self._waiting) > MUCH_WAITING or self._waiting_bytes > MUCH_WAITING_BYTES

    @property
    def is_waited_for(self) -> bool:
        """Return whether the client waits for a blocking call."""
        return bool(self._blocking)

    def take_batch(self) -> Batch | None:
        """Return the waiting commands as a batch for the server loop; None without any, or if much is under way."""
        if not self._waiting or len(self._batches) >= MOST_UNDER_WAY:
            return None
        waiting, self._waiting = self._waiting, []
        self._places.clear()
        self._waiting_bytes = 0
        self._batch += 1
        calls: list[Call] = []
        for place, request in enumerate(waiting):
            blocking = self._blocking.pop(-1 - place, None)
            made = self._calls(request, translate(request))
            calls += made
            if blocking is not None and made:
                self._blocking[made[-1].call_id] = blocking
        return Batch(self._batch, self._client_time, calls) if calls else None

    def _calls(self, request: Request, translated: Translated) -> list[Call]:
        """Return the calls that execute a command, the last of which is answered."""
        is_stream = request.mode in (m.STREAMING, m.STREAMING_SPLIT)
        if is_stream and self._runs(request):
            return []
        calls = self._end_stream(request.key)
        if request.mode == m.DISCONTINUE:
            self._replies.append(m.command(request, b""))
            return calls
        if is_stream and len(self._streams) >= self._limits().streams:
            self._replies.append(m.command(request, b"", has_failed=True))
            return calls
        call_id = self._next_call_id
        self._next_call_id = call_id + 1 if call_id < _LARGEST_CALL_ID else 1
        asked = _Asked(request, translated.wire, command_of(translated.wire), self._batch)
        self._asked[call_id] = asked
        if is_stream:
            self._streams[request.key] = call_id
        elif asked.comes_soon:
            self._batches.setdefault(self._batch, set()).add(call_id)
        operation = Operation.STREAM if is_stream else Operation.EXECUTE
        calls.append(Call(call_id, operation, self._delay(request), translated.name, translated.arguments))
        return calls

    def _delay(self, request: Request) -> int:
        if request.mode == m.BLOCKING:
            return self._pace
        if request.mode == m.STREAMING:
            return request.low
        return 0 if request.mode == m.STREAMING_SPLIT else NOT_AWAITED_MS

    def _runs(self, request: Request) -> bool:
        """Return whether this stream runs already: programs that read with streaming each time start it once."""
        stream = self._asked.get(self._streams.get(request.key, 0))
        return stream is not None and stream.request == request

    def _end_stream(self, key: Key) -> list[Call]:
        """Forget a stream; return the call that ends it."""
        self._outgoing.drop(key)
        self._values.pop(key, None)
        call_id = self._streams.pop(key, None)
        if call_id is None:
            return []
        stream = self._asked.pop(call_id)
        return [Call(0, Operation.CANCEL, 0, stream.wire.command, [call_id])]

    # --- what comes from the server loop ---------------------------------------------------------

    def absorb(self, delivery: Delivery, *, is_reliable: bool = True) -> None:
        """Store the replies of a delivery.

        Args:
            is_reliable: it comes in order with others, so that earlier batches are answered, or were dropped.
        """
        self._head = Head(
            client_time=delivery.client_time,
            server_time=delivery.server_time,
            scene_id=delivery.scene_id,
            server_state=delivery.server_state,
        )
        for reply in delivery.replies:
            for call_id in self._answered_by(reply):
                asked = self._asked.get(call_id)
                if asked is not None:
                    self._absorb_one(call_id, asked, reply)
        if is_reliable:
            self._end_dropped(delivery.message_id)

    def _answered_by(self, reply: Reply) -> Iterable[int]:
        """Return the calls that a reply answers: several, where a command without results was called often."""
        asked, values = self._asked.get(reply.call_id), reply.values
        if asked is None or asked.command.results or reply.status != STATUS_OK or not values:
            return (reply.call_id,)
        return range(reply.call_id, reply.call_id + values[0])

    def _absorb_one(self, call_id: int, asked: _Asked, reply: Reply) -> None:
        is_stream = self._streams.get(asked.request.key) == call_id
        if not asked.command.results:
            reply = reply._replace(values=[])  # it may count several
        if not is_stream:
            self._answered(call_id)
            self._reply(asked, reply)
            return
        if asked.request.mode == m.STREAMING_SPLIT:
            self._reply(asked, reply)
        else:
            self._values[asked.request.key] = _Value(asked, self._with_unsent(asked, reply))
        if reply.status == STATUS_OK and asked.command.is_hit(reply.values):
            del self._streams[asked.request.key], self._asked[call_id]

    def _with_unsent(self, asked: _Asked, reply: Reply) -> Reply:
        """Return a reply together with the unsent one of the same stream, if each value is given once."""
        unsent = self._values.get(asked.request.key)
        if unsent is None or not asked.command.takes_what_it_reads or unsent.reply.status or reply.status:
            return reply
        return reply._replace(values=[unsent.reply.values[0] + reply.values[0]])

    def _answered(self, call_id: int) -> None:
        asked = self._asked.pop(call_id)
        self._blocking.pop(call_id, None)
        if (unanswered := self._batches.get(asked.batch)) is not None:
            unanswered.discard(call_id)
            if not unanswered:
                del self._batches[asked.batch]

    def _reply(self, asked: _Asked, reply: Reply) -> None:
        """Put a reply into the next message, or into pieces."""
        if asked.request.mode in m.SPLIT_MODES:
            self._outgoing.put(asked.request, _content(asked, reply) or b"", reply.time_ms)
        else:
            self._replies.append(_packed(asked, reply))

    def _end_dropped(self, batch: int) -> None:
        """Answer the calls of batches before this one with an error: the server loop has dropped them."""
        for number in [each for each in self._batches if each < batch]:
            for call_id in self._batches[number].copy():
                asked = self._asked[call_id]
                self._answered(call_id)
                self._replies.append(m.command(asked.request, b"", has_failed=True))

    # --- what goes to the client -----------------------------------------------------------------

    def message(self) -> bytes:
        """Return the next message to the client, with everything that there is to send."""
        replies = [*self._replies, *(_packed(*value) for value in self._values.values())]
        self._replies.clear()
        self._values.clear()
        head = self._head
        if replies:
            unanswered = min(self._blocking.values(), default=None)
            newest = self._newest_message if unanswered is None else max(m.NOTHING_EXECUTED, unanswered - 1)
            head = head._replace(message_id=newest)
        return m.message(head, b"".join((*replies, *self._outgoing.take())))


def _content(asked: _Asked, reply: Reply) -> bytes | None:
    """Return the payload of a reply; None if the command has failed, or its result does not fit the protocol."""
    if reply.status != STATUS_OK:
        return None
    try:
        return payload(asked.wire, reply.values)
    except ValueError:
        return None


def _packed(asked: _Asked, reply: Reply) -> bytes:
    """Return the bytes of a complete reply; an unknown command gets its own payload back, as from the original."""
    content = _content(asked, reply)
    if content is None:
        refused = asked.request.payload if asked.wire is UNKNOWN else b""
        return m.command(asked.request, refused, time_ms=reply.time_ms, has_failed=True)
    return m.command(asked.request, content, time_ms=reply.time_ms)
