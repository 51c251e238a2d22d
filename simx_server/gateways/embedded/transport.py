"""The link between a client and a server in one process.

Most calls are executed directly: the caller's thread runs the handler and returns its values. Batches, paced calls and
recordings take the form of messages, so that they behave, and are recorded, as those of other clients.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import Future
from threading import get_ident
from typing import cast

from simx_client.errors import ConnectionFailed
from simx_client.protocol.commands import Command
from simx_client.protocol.messages import PROTOCOL_VERSION, STATUS_OK, Delivery, Reply, Welcome, of_fields
from simx_client.protocol.precision import Values, through_message
from simx_client.transport.direct import DirectFunction
from simx_server.service.answers.answers import Answer
from simx_server.service.answers.replies import Instant
from simx_server.service.answers.streams import Stream
from simx_server.service.calls.direct import DirectCall
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.server_loop import ServerLoop

from .turns import Turns

_MOST_WAITED = 0.05
"""Seconds after which a thread that waits for an answer checks again whether it has to make a step itself."""


class EmbeddedTransport:
    """A ``simx_client.transport.direct.DirectTransport`` to a server loop in this process."""

    def __init__(self, loop: ServerLoop, turns: Turns, client: str, name: str, port: int) -> None:
        """Make a link; ``greet`` joins the server.

        Args:
            client: the client's id, which also gives its role.
            name: the client's name, for logs and lists.
            port: the port that the script asked for; some ports start the simulation.
        """
        self.client = client
        self._loop, self._turns = loop, turns
        self._name, self._port = name, port
        self._session: ClientSession | None = None
        self.is_direct = False
        """Whether calls may be direct: the client has joined, and no recording needs messages."""

        self._deliveries: deque[bytes] = deque()
        self._came = threading.Event()
        self._values: list[Reply] = []
        self._computed: Instant | None = None
        """When these values were computed."""

        self._replied: Instant | None = None
        """When the client took the newest values, or got its newest direct reply."""

        self._stream: deque[bytes] = deque(maxlen=1)
        self._pictures: dict[int, bytes] = {}
        self._received: dict[str, Callable[[Values], Values]] = {}
        self._prepared: dict[str, DirectCall] = {}

    # --- the client's side: messages -------------------------------------------------------------

    @property
    def is_connected(self) -> bool:
        return self._session is not None

    @property
    def was_lost(self) -> bool:
        return self._session is None or self._loop.is_ending

    def greet(self, timeout: float) -> Welcome:
        if self._loop.is_ending:
            raise ConnectionFailed("this embedded simulation has ended")
        if not self._turns.begin(time.monotonic() + timeout):
            raise ConnectionFailed("the embedded simulation does not answer: another thread keeps it busy")
        try:
            self._session = self._loop.join(self.client, self._name, self._port, self)
            self._session.direct = self
            self.is_direct = self._loop.recorder is None
            self._turns.note_change()
        finally:
            self._turns.end()
        return Welcome(PROTOCOL_VERSION, "", "embedded", "", self._loop.simulation.scene.name)

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        if not self._turns.begin():  # within a step of this very thread
            self._loop.submit(self.client, payload)
            return
        try:
            self._loop.execute(self.client, payload)
            self._turns.note_change()
        finally:
            self._turns.end()

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        if self._deliveries:
            return self._deliveries.popleft()
        if timeout <= 0.0:
            return None
        deadline = time.monotonic() + timeout
        while True:
            if self._deliveries:
                return self._deliveries.popleft()
            left = deadline - time.monotonic()
            if left <= 0.0 or self.was_lost:
                return None
            self._came.clear()
            wait = self._turn(deadline)
            if not self._deliveries:
                self._came.wait(max(0.0, min(left, wait)))

    def _turn(self, deadline: float) -> float:
        """Do what is due, such as the step that a trigger allows; return the seconds until there is more to do."""
        if not self._turns.begin(deadline):
            return 0.0
        try:
            self._loop.turn()
            return min(_MOST_WAITED, self._loop.seconds_until_turn())
        finally:
            self._turns.end()

    def newest(self) -> bytes | None:
        return self._stream.pop() if self._stream else None

    def images(self) -> list[bytes]:
        if not self._pictures:
            return []
        pictures, self._pictures = self._pictures, {}
        return list(pictures.values())

    def close(self) -> None:
        """Leave the server, or have it end this session after the piece of work in which this is called."""
        if self._session is None:
            return
        self._session, self.is_direct = None, False
        self._loop.depart(self.client)
        if self._turns.begin():
            try:
                self._loop.turn()
            finally:
                self._turns.end()

    # --- the client's side: direct calls ---------------------------------------------------------

    @property
    def is_running_freely(self) -> bool:
        """Return whether simulation steps follow the wall clock, so that paced calls wait for them."""
        return self._loop.is_running_freely

    def prepare(self, command: Command) -> DirectFunction:
        """Return a function that executes a command directly, for many calls."""
        if self._session is None:
            raise ConnectionFailed("the client has not joined")
        loop, turns, messages = self._loop, self._turns, self._loop.messages
        lock, direct = turns.lock, loop.direct_call(self._session, command)
        execute, received, may_change_pace = direct.execute, direct.received, direct.may_change_pace

        def call(arguments: Values, timeout: float) -> Reply | None:
            if not lock.acquire(False) and not turns.wait(time.monotonic() + timeout):
                return None
            turns.owner = get_ident()
            try:
                answer = execute(arguments)
                time_ms = messages.time_ms()
                self._replied = messages.instant()
                if may_change_pace:
                    if isinstance(answer, Future) and not answer.done():
                        loop.turn()  # the step that this call has triggered
                    turns.note_change()
            finally:
                turns.owner = 0
                lock.release()
            if answer.__class__ is not tuple:
                assert isinstance(answer, Future)
                if (outcome := self._await(answer, time.monotonic() + timeout)) is None:
                    return None
                answer = outcome
            status, values = cast(Answer, answer)
            return of_fields(Reply, (0, status, time_ms, values if status else received(values)))

        return call

    def execute_together(self, calls: Sequence[tuple[Command, Values]], timeout: float) -> list[Reply] | None:
        if self._session is None:
            raise ConnectionFailed("the client has not joined")
        turns, messages, deadline = self._turns, self._loop.messages, time.monotonic() + timeout
        replies: list[Reply] = []
        if turns.owner == get_ident():
            return None
        if not turns.begin(deadline):
            return replies
        has_turn = True
        try:
            for command, arguments in calls:
                call = self._prepared.get(command.name)
                if call is None:
                    call = self._prepared[command.name] = self._loop.direct_call(self._session, command)
                answer = call.execute(arguments)
                if call.may_change_pace:
                    if isinstance(answer, Future) and not answer.done():
                        self._loop.turn()  # the step that this call has triggered
                    turns.note_change()
                if answer.__class__ is not tuple:
                    assert isinstance(answer, Future)
                    turns.end()
                    has_turn = False
                    outcome = self._await(answer, deadline)
                    if outcome is None or not turns.begin(deadline):
                        return replies
                    answer, has_turn = outcome, True
                status, values = cast(Answer, answer)
                values = values if status else call.received(values)
                replies.append(of_fields(Reply, (0, status, messages.time_ms(), values)))
            self._replied = messages.instant()
        finally:
            if has_turn:
                turns.end()
        return replies

    def _conversion(self, command: Command) -> Callable[[Values], Values]:
        found = self._received.get(command.name)
        if found is None:
            found = through_message([result.kind for result in command.results])
            self._received[command.name] = found
        return found

    def _await(self, answer: Future[Answer], deadline: float) -> Answer | None:
        """Wait for an image, or for the step that other clients delay; make due steps meanwhile."""
        while not answer.done():
            left = deadline - time.monotonic()
            if left <= 0.0 or self.was_lost:
                return None
            wait = self._turn(deadline)
            try:
                return answer.result(max(0.0, min(left, wait)))
            except TimeoutError:
                continue
        return answer.result()

    def take_values(self) -> list[Reply]:
        """Return the newest values of the streams that came since the last call; refresh them if that is due."""
        if not self._values and self._session is not None and self._loop.are_streams_due():
            self._turn(math.inf)
        values, self._values = self._values, []
        if values:
            self._replied = self._computed
        return values

    def header(self, message_id: int, client_time: int) -> Delivery | None:
        """Return the newest direct reply, or values of streams, in the form of a message's header."""
        at = self._replied
        return None if at is None else self._loop.messages.header(at, message_id, client_time)

    # --- the server's side: sessions.Link and sessions.DirectLink --------------------------------

    def deliver(self, payload: bytes) -> None:
        self._deliveries.append(payload)
        self._came.set()

    def publish(self, payload: bytes) -> None:
        self._stream.append(payload)

    def publish_image(self, stream_id: int, payload: bytes) -> None:
        self._pictures[stream_id] = payload
        self._came.set()

    def publish_values(self, streams: Collection[Stream]) -> None:
        """Take the newest values of the streams, as messages would bring them."""
        newest: list[Reply] = []
        for stream in streams:
            share = stream.shared
            if share is None:
                continue
            status, values = share.answer
            if status == STATUS_OK:
                values = self._conversion(share.command)(values)
            newest.append(of_fields(Reply, (stream.stream_id, status, share.time_ms, values)))
        self._values, self._computed = newest, self._loop.messages.instant()
