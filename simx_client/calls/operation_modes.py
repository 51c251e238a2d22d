"""Operation modes: which calls are sent, and where a result is taken from.

The original's rules, with its words:

============  =====================================================================================
oneshot       send; the result is that of an *earlier* execution, or novalue
blocking      send and wait; the entry of the inbox is removed, a stream of this key ends
streaming     arm a stream; the result is the newest value that has arrived, or novalue
buffer        send nothing; the newest value
discontinue   end the stream; the last value once more, then (after the echo) novalue
remove        forget the value; 0 if there was one
split         as oneshot and streaming: pieces were a matter of the original's transport
============  =====================================================================================

A key (function and identifying arguments) has at most one inbox entry and one stream. Streams outlive the loss of a
connection that may be taken up again: the server that comes back is asked for them. In the original they did not.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from simx_client.protocol import constants as c
from simx_client.protocol.messages import NOT_AWAITED_MS, STATUS_OK, Call, Operation, Pace, Reply, of_fields

from .marshalling import Key, Marshal

MODE_MASK = ~0xFFFF
_BUFFER, _NO_VALUE = c.simx_opmode_buffer, c.simx_return_novalue_flag
_LAST_ID = 0x7FFF_FFFF
_STREAMING = (c.simx_opmode_streaming, c.simx_opmode_streaming_split)


MAX_UNREAD_TEXTS = 50
"""Maximum number of unread error texts in a stream; the oldest are dropped first, as in the server."""


class Stream(NamedTuple):
    """An active stream: its id and its call."""

    call_id: int
    arguments: list[Any]
    delay_ms: int


class Modes:
    """Inbox, streams and outbox of one client, without transport or waiting.

    ``outbox`` collects calls; the owner of this object sends them. ``absorb`` stores what came back.
    """

    def __init__(self) -> None:
        self.inbox: dict[Key, Reply] = {}
        self.last_command_time_ms = 0
        self._next_call_id = 1
        self._streams: dict[Key, Stream] = {}
        self._asked: dict[int, tuple[Key, Marshal]] = {}
        """Calls without a reply yet, and streams: id to key."""

        self._cancels: dict[int, Key] = {}
        self._ended: dict[int, int] = {}
        """Cancelled streams whose data must not be lost: id of the cancelling call to id of the stream."""

        self.has_kept: set[str] = set()
        """The functions that have had a stream, or a reply in the inbox: the others have no entry of any key."""

        self.outbox: dict[Any, Call] = {}
        self._awaited: int | None = None
        self._awaited_key: Key = ()
        self._answer: Reply | None = None

    # --- sending ---------------------------------------------------------------------------------

    def take_outbox(self) -> list[Call]:
        """Return the calls to send now, in order, and empty the outbox."""
        calls = list(self.outbox.values())
        self.outbox.clear()
        return calls

    def _queue(
        self, marshal: Marshal, key: Key, operation: Operation, arguments: list[Any], delay_ms: int = 0
    ) -> int:
        """Put a call into the outbox. An unsent call with the same key is replaced: the last one remains, at
        the end if it carries a value, in its old position if it reads."""
        call, outbox = self._make(marshal, key, operation, arguments, delay_ms), self.outbox
        slot: Any = call.call_id if marshal.command.keeps_every_call else key
        if slot in outbox:
            unsent = outbox.pop(slot) if marshal.is_set else outbox[slot]
            self._asked.pop(unsent.call_id, None)
            if self._cancels.pop(unsent.call_id, None) is not None and (stream_id := unsent.arguments[0]):
                outbox["cancel", stream_id] = unsent._replace(call_id=0)  # it ends the stream all the same
        outbox[slot] = call
        return call.call_id

    def _make(
        self, marshal: Marshal, key: Key, operation: Operation, arguments: list[Any], delay_ms: int
    ) -> Call:
        """Make a call with a new id, whose reply is expected."""
        call_id = self._next_call_id  # as `new_call_id`, which takes as long as the rest
        self._next_call_id = call_id + 1 if call_id < _LAST_ID else 1
        self._asked[call_id] = (key, marshal)
        return of_fields(Call, (call_id, operation, delay_ms, key[0], arguments))

    def new_call_id(self) -> int:
        """Return an id that no other call of this client has."""
        call_id = self._next_call_id
        self._next_call_id = call_id + 1 if call_id < _LAST_ID else 1
        return call_id

    def _end_stream(self, key: Key) -> None:
        """Forget a stream and cancel it at the server, ahead of the call that replaces it."""
        stream = self._streams.pop(key, None)
        if stream is not None:
            cancel_id = 0  # without an answer
            _, marshal = self._asked[stream.call_id]
            if marshal.command.takes_what_it_reads:
                cancel_id = self.new_call_id()
                self._ended[cancel_id] = stream.call_id
            else:
                del self._asked[stream.call_id]
            self.outbox.pop(key, None)
            self.outbox["cancel", stream.call_id] = Call(
                cancel_id, Operation.CANCEL, 0, str(key[0]), [stream.call_id]
            )

    def ask(
        self, marshal: Marshal, arguments: list[Any], pace: Pace = Pace.FREE, *, is_held: bool = False
    ) -> list[Call]:
        """Start a blocking call: make it and remember which reply to wait for.

        Args:
            is_held: nothing can be sent now, so the call goes into the outbox.

        Returns:
            The calls to send now, in order: those of the outbox, then this one.
        """
        self._awaited_key = key = marshal.key(arguments)
        self.has_kept.add(key[0])  # its reply may be late
        if key in self._streams:
            self._end_stream(key)
        self._answer = None
        if is_held or self.outbox:
            self._awaited = self._queue(marshal, key, marshal.operation, arguments, pace)
            return [] if is_held else self.take_outbox()
        call = self._make(marshal, key, marshal.operation, arguments, pace)
        self._awaited = call.call_id
        return [call]

    def answer(self, marshal: Marshal) -> Any:
        """Finish a blocking call: return its result and remove the entry of its key.

        Without a reply the code is timeout, with novalue unless an older reply was in the inbox. The reply
        may still come: it then waits in the inbox for a later call in buffer mode.
        """
        older = self.inbox.pop(self._awaited_key, None)
        reply, self._answer, self._awaited = self._answer, None, None
        if reply is None:
            flags = c.simx_return_timeout_flag | (c.simx_return_novalue_flag if older is None else 0)
            return marshal.failure(flags)
        if (
            older is not None
            and marshal.command.takes_what_it_reads
            and not older.status
            and not reply.status
        ):
            reply = reply._replace(values=[_together(older.values[0], reply.values[0])])
        return self._result(marshal, reply)

    def is_answered(self) -> bool:
        """Return whether the reply to the blocking call is here."""
        return self._answer is not None

    def call(self, marshal: Marshal, arguments: list[Any], mode: int) -> Any:
        """Make a call in a mode other than blocking: update the outbox, return the present result."""
        base, low = mode & MODE_MASK, mode & ~MODE_MASK
        key = marshal.key(arguments)
        self.has_kept.add(key[0])
        if mode == _BUFFER and marshal.only_newest:  # what most calls of a loop do
            reply = self.inbox.get(key)
            if reply is None:
                return marshal.failure(_NO_VALUE)
            _, status, self.last_command_time_ms, values = reply
            return marshal.failure(status) if status else marshal.success(values)
        if mode == c.simx_opmode_remove:
            return marshal.failure(
                c.simx_return_novalue_flag if self.inbox.pop(key, None) is None else c.simx_return_ok
            )
        result = self._fetch(marshal, key, mode)
        if base == _BUFFER:
            return result
        if base == c.simx_opmode_discontinue:
            self._discontinue(marshal, key)
        elif base in _STREAMING:
            self._arm(marshal, key, arguments, low if base == c.simx_opmode_streaming else 0)
        else:
            if key in self._streams:
                self._end_stream(key)
            if not (marshal.command.gives_image and self._is_on_the_way(key)):
                self._queue(marshal, key, Operation.EXECUTE, arguments, NOT_AWAITED_MS)
        return result

    def _is_on_the_way(self, key: Key) -> bool:
        """Return whether a reply will come. Images may be requested faster than they are made, and would
        queue up."""
        return any(asked == key for asked, _ in self._asked.values())

    def _arm(self, marshal: Marshal, key: Key, arguments: list[Any], delay_ms: int) -> None:
        stream = self._streams.get(key)
        if stream is not None and stream.arguments == arguments and stream.delay_ms == delay_ms:
            return  # it runs already; scripts that read with streaming each time cost nothing
        self._end_stream(key)
        call_id = self._queue(marshal, key, Operation.STREAM, arguments, delay_ms)
        self._streams[key] = Stream(call_id, arguments, delay_ms)

    def _discontinue(self, marshal: Marshal, key: Key) -> None:
        stream = self._streams.pop(key, None)
        stream_id = 0
        if stream is not None:
            stream_id = stream.call_id
            self._asked.pop(stream_id, None)
        call_id = self._queue(marshal, key, Operation.CANCEL, [stream_id])
        del self._asked[call_id]
        self._cancels[call_id] = key

    # --- executed in this process ----------------------------------------------------------------

    def free_slot(self, marshal: Marshal, arguments: list[Any], mode: int) -> Key | None:
        """Return the key of a call that can be executed without a message: nothing waits to be sent, its key has no
        stream, and its reply comes at once.
        """
        if self.outbox or not (
            marshal.is_plain if mode == c.simx_opmode_blocking else marshal.is_plain_oneshot
        ):
            return None
        key = marshal.key(arguments)
        return None if key in self._streams else key

    def stream_id(self, key: Key) -> int | None:
        """Return the id of the stream of a key; None if it has none, or is of arguments that need marshalling."""
        try:
            stream = self._streams.get(key)
        except TypeError:  # an array, for example
            return None
        return None if stream is None else stream[0]

    def note_time(self, time_ms: int) -> None:
        """Note the simulation time of a result that did not come through these modes."""
        self.last_command_time_ms = time_ms

    def answered_directly(self, marshal: Marshal, key: Key, reply: Reply | None) -> Any:
        """Finish a blocking call that was executed without a message; None is a reply that did not come in time."""
        older = self.inbox.pop(key, None) if self.inbox else None
        if reply is None:
            flags = c.simx_return_timeout_flag | (c.simx_return_novalue_flag if older is None else 0)
            return marshal.failure(flags)
        _, status, self.last_command_time_ms, values = reply
        return marshal.failure(status) if status else marshal.success(values)

    def sent_directly(self, marshal: Marshal, key: Key, reply: Reply | None) -> Any:
        """Finish a oneshot call that was executed without a message: return the result of the one before."""
        self.has_kept.add(key[0])
        result = self._fetch(marshal, key, c.simx_opmode_oneshot)
        if reply is not None:
            self.inbox[key] = reply
        return result

    def set_directly(self, key: Key, time_ms: int) -> int:
        """Do as `sent_directly` for a command without results that has succeeded."""
        self.has_kept.add(key[0])
        before = self.inbox.get(key)
        self.inbox[key] = of_fields(Reply, (0, STATUS_OK, time_ms, []))
        if before is None:
            return _NO_VALUE
        self.last_command_time_ms = before.time_ms
        return before.status

    # --- receiving -------------------------------------------------------------------------------

    def absorb_replies(self, replies: list[Reply]) -> None:
        """Store what came back. Replies that no call waits for are dropped."""
        for reply in replies:
            call_id = reply.call_id
            asked = self._asked.get(call_id)
            if asked is None:
                self._absorb_end(call_id)
                continue
            if call_id == self._awaited:
                self._answer = reply
                del self._asked[call_id]
                continue
            key, marshal = asked
            if marshal.gives_nothing and reply.values and not reply.status:
                self._absorb_done(reply)
                continue
            stream = self._streams.get(key)
            if stream is None or stream.call_id != call_id:  # it is the last of this id
                if call_id not in self._ended.values():
                    del self._asked[call_id]
                elif not reply.status and not reply.values[0]:
                    continue  # an ended stream still hands over what it took, but it took nothing
            if marshal.only_newest:
                self.inbox[key] = reply
            else:
                self._store(marshal, key, reply)

    def _absorb_done(self, reply: Reply) -> None:
        """Store one answer to several calls with consecutive ids, up to the first that it cannot answer."""
        call_id, status, time_ms, (count, *_) = reply
        done = of_fields(Reply, (call_id, status, time_ms, []))
        for call_id in range(reply.call_id, reply.call_id + count if type(count) is int else 0):
            asked = self._asked.get(call_id)
            if asked is None or not asked[1].gives_nothing or call_id == self._awaited:
                return
            stream = self._streams.get(asked[0])
            if stream is not None and stream.call_id == call_id:
                return
            del self._asked[call_id]
            self.inbox[asked[0]] = done

    def _absorb_end(self, call_id: int) -> None:
        """Store the end of a stream, if that call ended it; drop other answers that no call waits for."""
        cancelled = self._cancels.pop(call_id, None)
        if cancelled is None:
            ended = self._ended.pop(call_id, None)
            if ended is not None:
                self._asked.pop(ended, None)
        elif cancelled not in self._streams:
            self.inbox.pop(cancelled, None)

    def _store(self, marshal: Marshal, key: Key, reply: Reply) -> None:
        if marshal.command.takes_what_it_reads and not reply.status:
            unread = self.inbox.get(key)
            if unread is not None and not unread.status:
                reply = reply._replace(values=[_together(unread.values[0], reply.values[0])])
        elif not reply.status and marshal.command.is_hit(reply.values):
            stream = self._streams.get(key)
            if stream is not None and stream.call_id == reply.call_id:
                del self._streams[key]
                self._asked.pop(stream.call_id, None)
        self.inbox[key] = reply

    def _fetch(self, marshal: Marshal, key: Key, mode: int) -> Any:
        reply = self.inbox.get(key)
        if reply is None:
            return marshal.failure(_NO_VALUE)
        if marshal.gives_nothing and marshal.only_newest:
            self.last_command_time_ms = reply.time_ms
            return reply.status
        if not (marshal.only_newest or reply.status):
            if marshal.command.takes_what_it_reads:
                # A stream continues: no news means empty data, not novalue.
                self.inbox[key] = reply._replace(values=[reply.values[0][:0]])
                if key not in self._streams:
                    del self.inbox[key]
            elif mode == c.simx_opmode_buffer and marshal.command.is_hit(reply.values):
                del self.inbox[key]
        return self._result(marshal, reply)

    def _result(self, marshal: Marshal, reply: Reply) -> Any:
        self.last_command_time_ms = reply.time_ms
        return marshal.failure(reply.status) if reply.status else marshal.success(reply.values)

    def lose(self, *, arms_again: bool) -> None:
        """Handle the loss of the connection: drop everything stored or on the way; keep the counters.

        Args:
            arms_again: queue the streams again, in their order, for a server that comes back.
        """
        streams = [(self._asked[stream.call_id], stream) for stream in self._streams.values()]
        self.inbox.clear()
        self._streams.clear()
        self._asked.clear()
        self._cancels.clear()
        self._ended.clear()
        self.outbox.clear()
        self._awaited = self._answer = None
        if arms_again:
            for (key, marshal), stream in streams:
                self._arm(marshal, key, stream.arguments, stream.delay_ms)


def _together(unread: Any, new: Any) -> Any:
    """Join unread and new values of a command that takes what it reads: bytes, or texts."""
    both = unread + new
    return both if type(both) is bytes else both[-MAX_UNREAD_TEXTS:]
