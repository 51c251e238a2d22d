"""A client id: its link, the order of its calls, pause and flush, liveness, time-outs."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, ClassVar

from simx_client.calls.marshalling import Marshal
from simx_client.calls.operation_modes import MODE_MASK, Modes
from simx_client.errors import ConnectionFailed, NoAnswer
from simx_client.protocol import constants as c
from simx_client.protocol.codec import MAX_BATCH, CodecError, decode_delivery, encode
from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.messages import (
    STATUS_REMOTE_ERROR,
    Batch,
    Call,
    Delivery,
    Operation,
    Pace,
    Reply,
    Welcome,
    of_fields,
)
from simx_client.transport.transport import Transport

from .background import Attempts
from .message_header import client_time
from .timeouts import (
    DEFAULT_TIMEOUT,
    FLUSH_TIMEOUT,
    LAST_LOOK,
    LONGEST_RETRY,
    MAX_UNANSWERED,
    RETRY_PAUSE,
    WELCOME_TIMEOUT,
)
from .trigger_batching import TriggerBatching

logger = logging.getLogger(__name__)

MESSAGE_ID_MASK = 0x7FFF_FFFF

_ECHO = Marshal(replace(BY_NAME["simxGetPingTime"], gives={}), Operation.CANCEL)
"""Requests an answer without any other effect: it ends no stream."""

_NO_STREAM = 0

_BUFFER, _ONESHOT = c.simx_opmode_buffer, c.simx_opmode_oneshot

_STEPPED_MODE = BY_NAME["simxSynchronous"]


class Connection:
    """A client's connection to one server. A lock serialises the calls of several threads."""

    works_after_fork: ClassVar[bool] = False
    """Whether a process may make one after its parent made another; Zenoh's threads do not exist in a child."""

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
            timeout: time-out of blocking calls in seconds.
            may_reconnect: connect again to a server that was lost and came back.
            pace: pace of the blocking legacy functions.
        """
        self.where = where
        self.timeout = timeout
        self.message_id = 0
        self._executed = 0
        """Newest batch that the server is known to have executed."""

        self._header: Delivery | None = None
        """Newest delivery with replies."""

        self._open_transport = open_transport
        self._may_reconnect = may_reconnect
        self._pace = pace
        self._may_connect = True
        """The connection may be made later, if it does not exist."""

        self._connecting: Attempts | None = None
        self._transport: Transport | None = None
        self._modes = Modes()
        self._takers: dict[int, Callable[[Reply], None]] = {}
        """Receivers of the replies to calls that were sent without an operation mode, by call id."""

        self._lock = threading.RLock()
        self._pauses = 0
        self._batching = TriggerBatching(self._modes, self._drain_and_flush, self._send_batched)
        self._connection_id = -1
        self._connections = 0
        self._next_greeting = 0.0
        self._greeting_time = RETRY_PAUSE
        """Time-out in seconds of the next greeting of a server that came back; it doubles until an answer comes."""

        self._logged: set[str] = set()
        self._closed = False

    # --- life ------------------------------------------------------------------------------------

    def connect(self, timeout: float) -> None:
        """Open the link and greet the server, both within a time-out in seconds.

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
        """Greet the server; repeat if it is only slow, until the deadline."""
        while True:
            try:
                return transport.greet(min(WELCOME_TIMEOUT, deadline - time.monotonic()))
            except NoAnswer:
                if time.monotonic() + RETRY_PAUSE >= deadline:
                    raise

    def connect_in_background(self) -> None:
        """Connect in a thread that tries until it succeeds, or once if only one attempt is allowed."""
        self._connecting = Attempts(
            self.connect, lambda: self._closed, where=self.where, is_only_one=not self._may_reconnect
        )

    def _count_connection(self) -> None:
        """Count the connection, the first or a new one, and send the calls made before it."""
        self._executed = self.message_id  # no batch has this id: deliveries for earlier batches are older
        self._count_message()
        self._connections += 1
        self._connection_id = self._connections
        if not self._pauses:
            self._flush()

    def close(self, flush_timeout: float = FLUSH_TIMEOUT) -> None:
        """Wait until the server has executed everything sent so far, then close. Idempotent. Ends calls of
        other threads."""
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
            self._batching.close()
            if is_free:
                self._lock.release()
        if self._connecting is not None:
            self._connecting.join()

    @property
    def connection_id(self) -> int:
        """Return -1 while not connected, else the number of connections. Connects again to a server that came
        back."""
        with self._lock:
            self._check_link()
            return self._connection_id

    def _check_link(self, deadline: float = math.inf) -> bool:
        """Detect a lost server; greet one that came back. Return whether calls can be sent.

        Args:
            deadline: time-out of a greeting, on the monotonic clock.
        """
        transport = self._transport
        if transport is None or self._closed:
            return False
        if transport.was_lost and self._connection_id != -1:
            self._connection_id = -1
            self._batching.is_on = False
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
                transport.greet(min(self._greeting_time, deadline - time.monotonic()))
            except ConnectionFailed as error:
                self._next_greeting = time.monotonic() + RETRY_PAUSE
                self._greeting_time = min(2 * self._greeting_time, LONGEST_RETRY)
                logger.debug("no greeting yet: %s", error)
                return False
            self._greeting_time = RETRY_PAUSE
            self._count_connection()
            logger.warning("connected to %s again; its streams are armed again", self.where)
        return True

    # --- calls -----------------------------------------------------------------------------------

    def invoke(self, marshal: Marshal, arguments: tuple[Any, ...], mode: int) -> Any:
        """Make one legacy call in one operation mode; return the result of the legacy function."""
        values = marshal.coerce(arguments)
        if mode.__class__ is not int:
            mode = marshal.mode(mode)
        if mode & MODE_MASK == c.simx_opmode_blocking:
            if marshal.command.never_blocking and mode == c.simx_opmode_blocking:
                return marshal.failure(c.simx_return_illegal_opmode_flag)
            return self.blocking(marshal, values, pace=self._pace)
        with self._lock:
            if mode == _BUFFER and self._is_still():
                return self._modes.call(marshal, values, mode)
            if not self._check_link() or self._pauses:
                return self._modes.call(marshal, values, mode)
            if self._batching.is_on and mode == _ONESHOT and marshal.is_set:
                return self._batching.call(marshal, values, mode)
            self._drain()
            result = self._modes.call(marshal, values, mode)
            if mode != _BUFFER:  # buffer mode adds no call, and batched calls may wait
                self._flush()
            return result

    def _is_still(self) -> bool:
        """Return whether the link is there, and nothing has come by it, if this is known at once."""
        transport = self._transport
        return (
            not (transport is None or self._connection_id == -1 or self._pauses or self._closed)
            and transport.is_still()
        )

    def _drain_and_flush(self) -> None:
        self._drain()
        self._flush()

    def _send_batched(self) -> None:
        """Send the batched calls from the alarm's thread: no trigger came."""
        with self._lock:
            if self._check_link() and not self._pauses:
                self._flush()

    def blocking(
        self, marshal: Marshal, values: list[Any], timeout: float | None = None, pace: Pace = Pace.FREE
    ) -> Any:
        """Send and wait for the reply. Within the time-out, also wait for a connection in the making."""
        deadline = time.monotonic() + (self.timeout if timeout is None else timeout)
        while True:
            # A call of another thread may hold the lock for its whole time-out.
            if not self._lock.acquire(timeout=max(0.0, deadline - time.monotonic())):
                return marshal.failure(c.simx_return_timeout_flag | c.simx_return_novalue_flag)
            try:
                if (
                    self._check_link(deadline)
                    or self._pauses
                    or not self._may_connect
                    or time.monotonic() >= deadline
                ):
                    return self._ask(marshal, values, deadline, pace)
            finally:
                self._lock.release()
            # Release the lock: the background thread may need it to make the first connection.
            time.sleep(min(0.02, max(0.0, deadline - time.monotonic())))

    def ping(self, timeout: float | None = None) -> int:
        """Wait until the server has executed everything sent before; return 0, or the flags of a time-out."""
        return self.blocking(_ECHO, [_NO_STREAM], timeout)

    def paced_ping(self) -> int:
        """Ping at the pace of blocking calls."""
        return self.blocking(_ECHO, [_NO_STREAM], pace=self._pace)

    def _ask(self, marshal: Marshal, values: list[Any], deadline: float, pace: Pace) -> Any:
        is_held = self._pauses > 0 or self._connection_id == -1
        calls = self._modes.ask(marshal, values, pace, is_held=is_held)
        if self._pauses:
            logger.warning(
                "%s was called in blocking mode while communication is paused, so no reply can come; "
                "resume first with simxPauseCommunication(clientID, False)",
                marshal.command.name,
            )
        elif not is_held:
            self._send(calls, deadline)
            if marshal.command.gives_image:
                marshal.prepare()
            is_soon = marshal.command.answers_soon and pace is not Pace.EVERY
            self._receive_until(self._modes.is_answered, deadline, is_soon=is_soon)
            if marshal.command is _STEPPED_MODE and self._modes.is_answered():
                self._batching.switch(bool(values[0]))
        return self._modes.answer(marshal)

    def _receive_until(
        self, is_enough: Callable[[], bool], deadline: float, *, is_soon: bool = False
    ) -> None:
        """Receive until there is enough, the deadline passes or the server is lost.

        Messages that arrived by the deadline are still processed, but for `LAST_LOOK` seconds at most.
        """
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
        """Process everything that has arrived."""
        transport = self._transport
        assert transport is not None
        # Taken first, stored last: the reply that started a stream came before its values, and must not
        # replace them.
        newest = transport.newest()
        while (payload := transport.receive(0)) is not None:
            self._absorb(payload)
        if newest is not None:
            self._absorb(newest)
        for payload in transport.images():
            self._absorb(payload)

    def _absorb(self, payload: bytes) -> None:
        try:
            delivery = decode_delivery(payload)
        except CodecError as error:
            logger.error("the server at %s sent something unreadable: %s", self.where, error)
            return
        # Values of a stream come by another way: the reply to a later call may have overtaken them.
        age = (self._executed - delivery.message_id) & MESSAGE_ID_MASK
        if age == 0 or age > MESSAGE_ID_MASK // 2:
            self._executed = delivery.message_id
            if delivery.replies:
                self._header = delivery
        self._take(delivery.replies)

    def _take(self, replies: list[Reply]) -> None:
        self._modes.absorb_replies(replies)
        for reply in replies:
            if self._takers and (take := self._takers.pop(reply.call_id, None)):
                take(reply)
            elif reply.status and reply.values:
                self._log_once(str(reply.values[0]))

    def _log_once(self, text: str) -> None:
        """Log the reason of a remote error once: a loop would repeat it in every turn."""
        if text not in self._logged and len(self._logged) < 1000:
            self._logged.add(text)
            logger.warning("%s", text)

    def _flush(self) -> None:
        calls = self._modes.take_outbox()
        if calls:
            self._send(calls)

    def _send(self, calls: list[Call], deadline: float | None = None) -> None:
        """Send a message; wait for a slow server or network at most for the time-out."""
        assert self._transport is not None
        payload = encode(of_fields(Batch, (self.message_id, client_time(), calls)))
        if len(payload) > MAX_BATCH:  # the server would close the connection
            text = f"a message of {len(payload)} bytes was not sent: at most {MAX_BATCH} are; send less at a time"
            self._take([Reply(call.call_id, STATUS_REMOTE_ERROR, 0, [text]) for call in calls])
            return
        if deadline is None:
            deadline = time.monotonic() + self.timeout
        self._transport.send(payload, deadline)
        self._count_message()
        if self._unanswered > MAX_UNANSWERED:
            self._receive_until(lambda: self._unanswered <= MAX_UNANSWERED, deadline)

    def _count_message(self) -> None:
        self.message_id = (self.message_id + 1) & MESSAGE_ID_MASK

    # --- past the operation modes: many calls, one message -----------------------------------------

    def send_together(self, calls: Iterable[tuple[Marshal, list[Any], Callable[[Reply], None]]]) -> list[int]:
        """Send calls as one message; pass each reply to the call's last item, whenever it is received.

        Returns:
            An id for each call, for `forget`; none without a connection or while communication is paused.
        """
        with self._lock:
            if not self._check_link() or self._pauses:
                return []
            self._drain()
            sent: list[Call] = []
            for marshal, values, take in calls:
                call_id = self._modes.new_call_id()
                self._takers[call_id] = take
                sent.append(Call(call_id, Operation.EXECUTE, 0, marshal.command.name, values))
            self._send([*self._modes.take_outbox(), *sent])  # the script made the batched calls before these
            return [call.call_id for call in sent]

    def forget(self, call_ids: Iterable[int]) -> None:
        """Drop replies to these calls that are still to come."""
        with self._lock:
            for call_id in call_ids:
                self._takers.pop(call_id, None)

    def receive_until(self, is_enough: Callable[[], bool], deadline: float, *, is_soon: bool) -> None:
        """Receive until there is enough, the server is lost or the deadline (monotonic clock) has passed."""
        with self._lock:
            if self._transport is not None:
                self._receive_until(is_enough, deadline, is_soon=is_soon)
                if not self._closed:
                    self._drain()

    # --- what the local functions need -----------------------------------------------------------

    def pause(self, enable: bool) -> None:
        """Batch calls, or send the batched calls. Pauses nest.

        The connection processes what has arrived before the pause, and nothing during it. So values read
        during a pause are of one instant, as in the original, also for a script that reads only in pauses.
        """
        with self._lock:
            if enable:
                if not self._pauses and self._check_link():
                    self._flush()  # the script made the calls batched for a trigger before the pause
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
        """Describe the state of the connection in words. Takes no lock, sends nothing, and so never waits."""
        if self._closed:
            return "closed"
        if self._transport is not None and self._transport.was_lost:
            return "server gone"
        return "connected" if self._connection_id != -1 else "not connected"

    @property
    def why_gone(self) -> str:
        """Return the reason for calls without an answer when the connection has ended."""
        return "the server went away"

    @property
    def last_header(self) -> Delivery | None:
        """Return the newest delivery processed so far; never waits."""
        return self._header

    def newest_scene(self) -> int | None:
        """Return the scene's number in the newest header; None before the first."""
        header = self.newest_header()
        return None if header is None else header.scene_id

    def newest_header(self) -> Delivery | None:
        """Return the newest delivery with replies, None before the first."""
        with self._lock:
            if self._check_link() and not self._pauses:
                self._drain()
            return self._header
