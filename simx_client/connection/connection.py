"""One clientID: its link, the order of its calls, pause and flush, liveness, time-outs."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from simx_client.errors import ConnectionFailed, NoAnswer
from simx_client.legacy.marshalling import Shape
from simx_client.legacy.operation_modes import MODE_MASK, Modes
from simx_client.protocol import constants as c
from simx_client.protocol.codec import CodecError, decode_delivery, encode
from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.messages import Batch, Call, Delivery, Operation, Pace, Reply, Welcome
from simx_client.transport.zenoh import Transport

from .background import Attempts
from .message_header import client_time
from .timeouts import DEFAULT_TIMEOUT, FLUSH_TIMEOUT, LAST_LOOK, MAX_UNANSWERED, RETRY_PAUSE, WELCOME_TIMEOUT
from .trigger_batching import Hold

logger = logging.getLogger(__name__)

MESSAGE_ID_MASK = 0x7FFF_FFFF

_ECHO = Shape(replace(BY_NAME["simxGetPingTime"], gives={}), Operation.CANCEL)
"""Asks for nothing but an answer, by ending no stream."""

_NO_STREAM = 0

_STEPPED_MODE = BY_NAME["simxSynchronous"]


class Connection:
    """A client's conversation with one server. Calls of several threads are taken one at a time."""

    def __init__(
        self,
        open_transport: Callable[[], Transport],
        *,
        where: str,
        timeout: float = DEFAULT_TIMEOUT,
        may_reconnect: bool = True,
        pace: Pace = Pace.FREE,
    ) -> None:
        """Prepare a connection; ``connect`` makes it.

        Args:
            open_transport: makes the link to the server; raises ConnectionFailed.
            where: the address for messages.
            timeout: of blocking calls, seconds.
            may_reconnect: greet a server again that went away and came back.
            pace: of the blocking legacy functions.
        """
        self.where = where
        self.timeout = timeout
        self.message_id = 0
        self._executed = 0
        """The newest batch that the server is known to have executed."""

        self._header: Delivery | None = None
        """The newest delivery with replies."""

        self._open_transport = open_transport
        self._may_reconnect = may_reconnect
        self._pace = pace
        self._may_connect = True
        """There may be a connection later, if there is none."""

        self._connecting: Attempts | None = None
        self._transport: Transport | None = None
        self._modes = Modes()
        self._takers: dict[int, Callable[[Reply], None]] = {}
        """Who gets the reply to a call that was sent past the operation modes, by call id."""

        self._lock = threading.RLock()
        self._pauses = 0
        self._hold = Hold(self._modes, self._drain_and_flush, self._send_held)
        self._connection_id = -1
        self._connections = 0
        self._next_greeting = 0.0
        self._logged: set[str] = set()
        self._closed = False

    # --- life ------------------------------------------------------------------------------------

    def connect(self, timeout: float) -> None:
        """Open the link and greet the server, both within a time-out.

        Raises:
            ConnectionFailed: with the reason and what to do.
        """
        deadline = time.monotonic() + timeout
        try:
            transport = self._open_transport()
            try:
                welcome = self._greet(transport, deadline)
            except BaseException:
                transport.close()
                raise
        except BaseException:
            self._may_connect = self._may_reconnect
            raise
        with self._lock:
            if self._closed:
                transport.close()
                raise ConnectionFailed("simxFinish closed it before it was made")
            self._transport = transport
            self._count_connection()
        logger.info("connected to %s (realm %s, scene %s)", self.where, welcome.realm, welcome.scene)

    @staticmethod
    def _greet(transport: Transport, deadline: float) -> Welcome:
        """Greet the server, again if it is there and only slow, as long as the deadline allows."""
        while True:
            try:
                return transport.greet(min(WELCOME_TIMEOUT, deadline - time.monotonic()))
            except NoAnswer:
                if time.monotonic() + RETRY_PAUSE >= deadline:
                    raise

    def connect_in_background(self) -> None:
        """As ``connect``, again and again until it succeeds; once if there is to be one attempt only."""
        self._connecting = Attempts(
            self.connect, lambda: self._closed, where=self.where, is_only_one=not self._may_reconnect
        )

    def _count_connection(self) -> None:
        """There is a connection, the first or a new one: what was called before it came goes out."""
        self._executed = self.message_id  # no batch has this id: what still comes of an earlier one is older
        self._count_message()
        self._connections += 1
        self._connection_id = self._connections
        if not self._pauses:
            self._flush()

    def close(self, flush_timeout: float = FLUSH_TIMEOUT) -> None:
        """Let everything sent so far be executed, then leave. Idempotent. A call that waits in another thread ends."""
        is_free = self._lock.acquire(timeout=flush_timeout)
        try:
            if is_free and not self._closed and self._check_link():
                self._pauses = 0
                self.ping(flush_timeout)
        finally:
            self._closed = True
            self._connection_id = -1
            if self._transport is not None:
                self._transport.close()
            self._hold.close()
            if is_free:
                self._lock.release()
        if self._connecting is not None:
            self._connecting.join()

    @property
    def connection_id(self) -> int:
        """-1 while not connected; counts reconnections. Takes up again with a server that came back."""
        with self._lock:
            self._check_link()
            return self._connection_id

    def _check_link(self, deadline: float = math.inf) -> bool:
        """Notice a server that went away, greet one that came back. True when calls can be sent.

        Args:
            deadline: on the monotonic clock; a greeting is given up then.
        """
        transport = self._transport
        if transport is None or self._closed:
            return False
        if transport.was_lost and self._connection_id != -1:
            self._connection_id = -1
            self._hold.is_on = False
            self._modes.lose(arms_again=self._may_reconnect)
            self._takers.clear()
            self._header = None
            logger.warning(
                "the server at %s went away%s",
                self.where,
                "; waiting for it to come back" if self._may_reconnect else "",
            )
            self._may_connect = self._may_reconnect
            if not self._may_connect:
                transport.close()
        if self._connection_id == -1:
            if not (self._may_connect and transport.is_connected and time.monotonic() >= self._next_greeting):
                return False
            try:
                transport.greet(min(RETRY_PAUSE, deadline - time.monotonic()))
            except ConnectionFailed as error:
                self._next_greeting = time.monotonic() + RETRY_PAUSE
                logger.debug("no greeting yet: %s", error)
                return False
            self._count_connection()
            logger.warning("connected to %s again; its streams are armed again", self.where)
        return True

    # --- calls -----------------------------------------------------------------------------------

    def invoke(self, shape: Shape, arguments: tuple[Any, ...], mode: int) -> Any:
        """One legacy call in one operation mode; returns what the legacy function returns."""
        values = shape.coerce(arguments)
        if mode.__class__ is not int:
            mode = shape.mode(mode)
        if mode & MODE_MASK == c.simx_opmode_blocking:
            if shape.command.never_blocking and mode == c.simx_opmode_blocking:
                return shape.failure(c.simx_return_illegal_opmode_flag)
            return self.blocking(shape, values, pace=self._pace)
        with self._lock:
            if not self._check_link() or self._pauses:
                return self._modes.call(shape, values, mode)
            if self._hold.is_on and mode == c.simx_opmode_oneshot and shape.is_set:
                return self._hold.call(shape, values, mode)
            self._drain()
            result = self._modes.call(shape, values, mode)
            if mode != c.simx_opmode_buffer:  # that adds nothing, and what is held may wait
                self._flush()
            return result

    def _drain_and_flush(self) -> None:
        self._drain()
        self._flush()

    def _send_held(self) -> None:
        """The alarm's thread: no trigger came."""
        with self._lock:
            if self._check_link() and not self._pauses:
                self._flush()

    def blocking(
        self, shape: Shape, values: list[Any], timeout: float | None = None, pace: Pace = Pace.FREE
    ) -> Any:
        """Send and wait for the reply. Also waits, within the time-out, for a connection that may come."""
        deadline = time.monotonic() + (self.timeout if timeout is None else timeout)
        while True:
            # Another thread's call may have the lock for all of its own time-out.
            if not self._lock.acquire(timeout=max(0.0, deadline - time.monotonic())):
                return shape.failure(c.simx_return_timeout_flag | c.simx_return_novalue_flag)
            try:
                if (
                    self._check_link(deadline)
                    or self._pauses
                    or not self._may_connect
                    or time.monotonic() >= deadline
                ):
                    return self._ask(shape, values, deadline, pace)
            finally:
                self._lock.release()
            # Without the lock: the first connection may be being made in the background.
            time.sleep(min(0.02, max(0.0, deadline - time.monotonic())))

    def ping(self, timeout: float | None = None) -> int:
        """Wait until everything sent before has been executed; 0, or the flags of a time-out."""
        return self.blocking(_ECHO, [_NO_STREAM], timeout)

    def paced_ping(self) -> int:
        """As ``ping``, at the pace of blocking calls."""
        return self.blocking(_ECHO, [_NO_STREAM], pace=self._pace)

    def _ask(self, shape: Shape, values: list[Any], deadline: float, pace: Pace) -> Any:
        is_held = self._pauses > 0 or self._connection_id == -1
        calls = self._modes.ask(shape, values, pace, is_held=is_held)
        if self._pauses:
            logger.warning(
                "%s was called in blocking mode while communication is paused, so no reply can come; "
                "resume first with simxPauseCommunication(clientID, False)",
                shape.command.name,
            )
        elif not is_held:
            self._send(calls, deadline)
            shape.prepare()
            is_soon = shape.command.answers_soon and pace is not Pace.EVERY
            self._receive_until(lambda: self._modes.is_answered, deadline, is_soon=is_soon)
            if shape.command is _STEPPED_MODE and self._modes.is_answered:
                self._hold.switch(bool(values[0]))
        return self._modes.answer(shape)

    def _receive_until(
        self, is_enough: Callable[[], bool], deadline: float, *, is_soon: bool = False
    ) -> None:
        """Take in replies; ends early when the server is lost. What has come by the deadline is still taken in, but
        whoever goes on sending is not listened to for long."""
        transport = self._transport
        assert transport is not None
        while not is_enough():
            payload = transport.receive(deadline - time.monotonic(), is_soon=is_soon)
            if payload is not None:
                self._absorb(payload)
                if time.monotonic() >= deadline + LAST_LOOK:
                    return
            elif transport.was_lost or self._closed or time.monotonic() >= deadline:
                return

    @property
    def _unanswered(self) -> int:
        return (self.message_id - 1 - self._executed) & MESSAGE_ID_MASK

    def _drain(self) -> None:
        """Take in everything that has arrived."""
        transport = self._transport
        assert transport is not None
        # Taken first, stored last: the answer that armed a stream came before its values, and must not follow them.
        newest = transport.newest()
        while (payload := transport.receive(0)) is not None:
            self._absorb(payload)
        if newest is not None:
            self._absorb(newest)
        for payload in transport.pictures():
            self._absorb(payload)

    def _absorb(self, payload: bytes) -> None:
        try:
            delivery = decode_delivery(payload)
        except CodecError as error:
            logger.error("the server at %s sent something unreadable: %s", self.where, error)
            return
        # What comes by another way, a stream's values, may have been overtaken by the answer to a later call.
        age = (self._executed - delivery.message_id) & MESSAGE_ID_MASK
        if age == 0 or age > MESSAGE_ID_MASK // 2:
            self._executed = delivery.message_id
            if delivery.replies:
                self._header = delivery
        self._modes.absorb(delivery)
        for reply in delivery.replies:
            if self._takers and (take := self._takers.pop(reply.call_id, None)):
                take(reply)
            elif reply.status and reply.values:
                self._log_once(str(reply.values[0]))

    def _log_once(self, text: str) -> None:
        """The reason behind a remote error, once: loops would repeat it for ever."""
        if text not in self._logged and len(self._logged) < 1000:
            self._logged.add(text)
            logger.warning("%s", text)

    def _flush(self) -> None:
        calls = self._modes.take_outbox()
        if calls:
            self._send(calls)

    def _send(self, calls: list[Call], deadline: float | None = None) -> None:
        """Send a message. What does not wait for its answer waits for a slow server or network all the same, for at
        most the time-out."""
        assert self._transport is not None
        payload = encode(Batch(self.message_id, client_time(), calls))
        if deadline is None:
            deadline = time.monotonic() + self.timeout
        self._transport.send(payload, deadline)
        self._count_message()
        if self._unanswered > MAX_UNANSWERED:
            self._receive_until(lambda: self._unanswered <= MAX_UNANSWERED, deadline)

    def _count_message(self) -> None:
        self.message_id = (self.message_id + 1) & MESSAGE_ID_MASK

    # --- past the operation modes: many calls, one message -----------------------------------------

    def send_together(self, calls: Iterable[tuple[Shape, list[Any], Callable[[Reply], None]]]) -> list[int]:
        """Send calls as one message; each one's reply goes to its last item, whenever it is received.

        Returns:
            An id for each, for `forget`; none when there is no connection, or communication is paused.
        """
        with self._lock:
            if not self._check_link() or self._pauses:
                return []
            self._drain()
            sent: list[Call] = []
            for shape, values, take in calls:
                call_id = self._modes.new_call_id()
                self._takers[call_id] = take
                sent.append(Call(call_id, Operation.EXECUTE, 0, shape.command.name, values))
            self._send([*self._modes.take_outbox(), *sent])  # what is held was called before these
            return [call.call_id for call in sent]

    def forget(self, call_ids: Iterable[int]) -> None:
        """No replies to these calls are waited for any more; what still comes is dropped."""
        with self._lock:
            for call_id in call_ids:
                self._takers.pop(call_id, None)

    def receive_until(self, is_enough: Callable[[], bool], deadline: float, *, is_soon: bool) -> None:
        """Take in what comes until there is enough, the server is lost or it is too late (monotonic clock)."""
        with self._lock:
            if self._transport is not None:
                self._receive_until(is_enough, deadline, is_soon=is_soon)
                if not self._closed:
                    self._drain()

    # --- what the local functions need -----------------------------------------------------------

    def pause(self, enable: bool) -> None:
        """Hold calls back, or send what was held back. Pauses nest.

        What has arrived by its beginning is taken in, and nothing meanwhile: what is read during a pause is of one
        instant, as in the original, and of the newest also where a script reads in pauses only.
        """
        with self._lock:
            if enable:
                if not self._pauses and self._check_link():
                    self._flush()  # what was held for a trigger was called before the pause
                    self._drain()
                self._pauses += 1
            elif self._pauses:
                self._pauses -= 1
                if not self._pauses and self._check_link():
                    self._flush()

    @property
    def last_command_time_ms(self) -> int:
        return self._modes.last_command_time_ms

    @property
    def condition(self) -> str:
        """What is known of it, in words: takes no lock, sends nothing, and so never waits."""
        if self._closed:
            return "closed"
        if self._transport is not None and self._transport.was_lost:
            return "server gone"
        return "connected" if self._connection_id != -1 else "not connected"

    @property
    def last_header(self) -> Delivery | None:
        """As ``newest_header``, of what has been taken in already; never waits."""
        return self._header

    def newest_header(self) -> Delivery | None:
        """The newest delivery with replies, None before there is one."""
        with self._lock:
            if self._check_link() and not self._pauses:
                self._drain()
            return self._header
