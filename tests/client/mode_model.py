"""The rules of the operation modes, written down a second time and more simply: a client and a server as plain data.

Made from the rules of the original (keys, one inbox entry and one stream per key, what replaces what), not from
``simx_client/calls/operation_modes.py``: the property test runs both on the same calls and compares what they return.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

Key = tuple[Any, ...]
Result = tuple[int, Any]
"""Status and value of one execution."""

OK, NOVALUE, TIMEOUT, ILLEGAL = 0, 1, 2, 4


@dataclass(frozen=True)
class Question:
    """One call: what is executed, and what it is the same command as."""

    key: Key
    execute: Callable[[ModelServer], Result]
    default: Any
    """The value slot without data; None for a function that returns only the code."""
    value: Any = None
    """What a set-function carries; it is no part of the key."""
    carries_value: bool = False
    every_call_counts: bool = False
    takes: bool = False
    """simxReadStringStream: a read empties the inbox, unread data is put together."""
    ends_with_hit: bool = False
    """simxGetAndClearStringSignal."""


@dataclass
class ModelServer:
    """The numbers of the plain world, and the streams in the order they were armed."""

    joints: dict[int, float] = field(default_factory=dict)
    strings: dict[str, bytes] = field(default_factory=dict)
    log: list[tuple[str, int, float]] = field(default_factory=list)
    """Every set in the order of execution."""
    streams: dict[int, Question] = field(default_factory=dict)


@dataclass
class Sent:
    """A call on its way: to execute, to arm as a stream, or to end a stream."""

    kind: str
    question: Question
    number: int
    """Replies carry it; a stream goes by it."""
    ends: int = 0


@dataclass
class Model:
    """One client, its server, and what lies between them."""

    server: ModelServer = field(default_factory=ModelServer)
    inbox: dict[Key, Result] = field(default_factory=dict)
    streams: dict[Key, tuple[int, Question]] = field(default_factory=dict)
    """Armed by the client: the number and what was asked."""
    outbox: list[Sent] = field(default_factory=list)
    on_the_way: list[Sent] = field(default_factory=list)
    replies: list[tuple[Sent, Result | None]] = field(default_factory=list)
    """Executed, echoed (None) or taken by a stream; every one arrives."""
    newest: dict[int, tuple[Question, Result]] = field(default_factory=dict)
    """The values of all streams after the last pass; only the last such message is there."""
    replaced: set[int] = field(default_factory=set)
    """Streams that something else took the place of: what they took of a string stream is not lost."""
    is_paused: bool = False
    is_lost: bool = False
    last_number: int = 0

    # --- the client --------------------------------------------------------------------------------

    def call(self, question: Question, mode: str) -> Any:
        if mode == "blocking":
            return self._blocking(question)
        if not self.is_paused and not self.is_lost:
            self._receive()
        key = question.key
        if mode == "remove":
            return self._shown(question, OK if self.inbox.pop(key, None) else NOVALUE)
        result = self._fetch(question, mode)
        if mode == "discontinue":
            number, _ = self.streams.pop(key, (0, None))
            self._queue(Sent("echo", question, self._number(), ends=number))
        elif mode == "streaming":
            armed = self.streams.get(key)
            if armed is None or armed[1].value != question.value:
                self._forget_stream(key)
                self._arm(question)
        elif mode == "oneshot":
            self._forget_stream(key)
            self._queue(Sent("once", question, self._number()))
        self._send()
        return result

    def _blocking(self, question: Question) -> Any:
        if question.takes:
            return self._shown(question, ILLEGAL)
        self._forget_stream(question.key)
        sent = Sent("once", question, self._number())
        self._queue(sent)
        if self.is_paused:
            older = self.inbox.pop(question.key, None)
            return self._shown(question, TIMEOUT | (NOVALUE if older is None else 0))
        self._send()
        self.turn()
        answer: Result | None = None
        arrived, self.replies = self.replies, []
        for index, (each, result) in enumerate(arrived):
            if each.number == sent.number:
                answer = result
                self.replies = arrived[index + 1 :] + self.replies
                break
            self._take_in(each, result)
        assert answer is not None
        self.inbox.pop(question.key, None)
        return self._shown(question, *answer)

    def pause(self) -> None:
        self._receive()  # the original's thread had taken it in before
        self.is_paused = True

    def resume(self) -> None:
        self.is_paused = False
        self._send()

    def lose(self) -> None:
        """The connection breaks: what the server has is still executed, everything else is gone, on both sides.

        The client remembers what it streamed, as if it had asked for it again at once.
        """
        self._execute()
        self.server.streams.clear()
        streamed = [question for _, question in self.streams.values()]
        for store in (self.inbox, self.streams, self.outbox, self.on_the_way, self.replies, self.newest):
            store.clear()
        self.replaced.clear()
        self.is_lost = True
        for question in streamed:
            self._arm(question)

    def find(self) -> None:
        """A server is there again."""
        self.is_lost = False
        self._send()

    def _arm(self, question: Question) -> None:
        sent = Sent("stream", question, self._number())
        self._queue(sent)
        self.streams[question.key] = (sent.number, question)

    def _number(self) -> int:
        self.last_number += 1
        return self.last_number

    def _queue(self, sent: Sent) -> None:
        """Of unsent calls with one key only the last survives: a set moves behind the others, a question stays."""
        if not sent.question.every_call_counts:
            for index, other in enumerate(self.outbox):
                if other.question.key == sent.question.key and other.kind != "end":
                    # A call that takes the place of a discontinuing one still ends the stream.
                    ends = [Sent("end", other.question, 0, ends=other.ends)] if other.ends else []
                    if not sent.question.carries_value:
                        self.outbox[index : index + 1] = [*ends, sent]
                        return
                    self.outbox[index : index + 1] = ends
                    break
        self.outbox.append(sent)

    def _forget_stream(self, key: Key) -> None:
        armed = self.streams.pop(key, None)
        if armed is not None:
            self.replaced.add(armed[0])
            self.outbox = [s for s in self.outbox if s.question.key != key or s.question.every_call_counts]
            self.outbox.append(Sent("end", armed[1], 0, ends=armed[0]))

    def _send(self) -> None:
        if self.is_paused or self.is_lost:
            return
        self.on_the_way += self.outbox
        self.outbox = []

    def _receive(self) -> None:
        replies, self.replies = self.replies, []
        for sent, result in replies:
            self._take_in(sent, result)
        newest, self.newest = self.newest, {}
        for number, (question, result) in newest.items():
            armed = self.streams.get(question.key)
            if armed is not None and armed[0] == number:
                self._store(question, result, number)

    def _take_in(self, sent: Sent, result: Result | None) -> None:
        key = sent.question.key
        if result is None:
            if key not in self.streams:
                self.inbox.pop(key, None)
        elif (
            sent.kind == "once"
            or self.streams.get(key, (0,))[0] == sent.number
            or (sent.question.takes and sent.number in self.replaced and result[1])
        ):
            self._store(sent.question, result, sent.number)

    def _store(self, question: Question, result: Result, number: int) -> None:
        key = question.key
        if question.takes and key in self.inbox and self.inbox[key][0] == OK:
            result = (OK, self.inbox[key][1] + result[1])
        if question.ends_with_hit and result[0] == OK and self.streams.get(key, (0,))[0] == number:
            del self.streams[key]
        self.inbox[key] = result

    def _fetch(self, question: Question, mode: str) -> Any:
        key = question.key
        if key not in self.inbox:
            return self._shown(question, NOVALUE)
        status, value = self.inbox[key]
        if status == OK and question.takes:
            if key in self.streams:
                self.inbox[key] = (OK, b"")
            else:
                del self.inbox[key]
        if status == OK and question.ends_with_hit and mode == "buffer":
            del self.inbox[key]
        return self._shown(question, status, value)

    @staticmethod
    def _shown(question: Question, status: int, value: Any = None) -> Any:
        if question.default is None:
            return status
        shown = value if status == OK and value is not None else question.default
        return status, bytearray(shown) if isinstance(shown, bytes) else shown

    # --- the server --------------------------------------------------------------------------------

    def turn(self) -> None:
        """Everything that has arrived is executed, then every stream once."""
        self._execute()
        self._round()

    def _execute(self) -> None:
        server = self.server
        calls, self.on_the_way = self.on_the_way, []
        for sent in calls:
            server.streams.pop(sent.ends, None)
            if sent.kind == "echo":
                self.replies.append((sent, None))
            elif sent.kind != "end":
                result = sent.question.execute(server)
                self.replies.append((sent, result))
                if sent.kind == "stream" and not (sent.question.ends_with_hit and result[0] == OK):
                    server.streams[sent.number] = sent.question

    def _round(self) -> None:
        server = self.server
        snapshot: dict[int, tuple[Question, Result]] = {}
        for number, question in list(server.streams.items()):
            result = question.execute(server)
            if question.takes:
                if result[1]:
                    self.replies.append((Sent("stream", question, number), result))
            elif question.ends_with_hit and result[0] == OK:
                del server.streams[number]
                self.replies.append((Sent("stream", question, number), result))
            else:
                snapshot[number] = (question, result)
        if snapshot:
            self.newest = snapshot
