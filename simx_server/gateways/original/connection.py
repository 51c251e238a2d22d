"""One client of the original's protocol, from its first message to its end.

Its thread reads a message, hands the commands to the server loop, and answers with what is ready: strictly in turns, as
the original does. The server loop puts its deliveries here and never waits. While the client waits for a blocking call,
its answer is held for a moment, so that the result travels with it and not a cycle of the client later.
"""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
import time
import uuid
from collections import deque
from functools import partial
from logging import INFO, WARNING

from simx_client.protocol.messages import Delivery, Pace, Reply
from simx_server.gateways.outsider_log import OutsiderLog
from simx_server.limits import LimitReached
from simx_server.service.answers.answers import size_of
from simx_server.service.answers.link import Link
from simx_server.service.answers.streams import NewestValues
from simx_server.service.calls.work import CallsWork
from simx_server.service.clients.admission.entrance import Entrance
from simx_server.service.clients.sessions import FROZEN
from simx_server.service.service import Service

from . import messages
from .containers import Containers
from .packets import BadPeer, packets, read_message

logger = logging.getLogger(__name__)

SILENCE = 10.0
"""Seconds without a message after which a client is dropped, as by the original. A client that is alive sends one in
every cycle, even if it has nothing to say; before that it loses its stepped mode (`FROZEN`)."""

STALL = 2.0
"""Seconds for the rest of a message that has started, or for a client to take more of an answer."""

HELD = 0.02
"""Most seconds that an answer is held for the result of a blocking call; another message of the client asks again."""

LEAST_CYCLE = 0.0005
"""Seconds between two answers with nothing in them, for clients with a cycle of 0."""

PAUSE = 0.002
"""Seconds to wait after a message that the server loop takes only slowly."""

MUCH_WORK = 0.002
"""Seconds of this thread for one message, above which it sleeps as long: the physics thread needs the interpreter."""

MOST_UNREAD = 64 << 20
"""Bytes for a client that takes nothing, above which it is dropped."""

GATEWAY = "legacy"
"""Clients of all these ports share their places."""

READ, MOST_READ = 1 << 16, 1 << 20
"""Least and most bytes to read from the socket at once."""

LOOK = 0.5
"""Seconds after which a waiting thread checks whether the connection has ended."""


class Gone(Exception):
    """The connection has ended; the text says why, and is empty if the client has left in good order."""


class Connection(Link):
    """One connected client, and the link of its session."""

    def __init__(
        self,
        service: Service,
        connected: socket.socket,
        peer: str,
        port: int,
        pace: Pace = Pace.FREE,
        *,
        log: OutsiderLog,
    ) -> None:
        """Make a connection that ``run`` serves.

        Args:
            connected: a socket that an original client has connected to; it belongs to the connection from now on.
            peer: the address of the client, for messages.
            port: the port that it came by.
            pace: of its blocking calls.
            log: says why it is dropped.
        """
        self.client = f"legacy/{uuid.uuid4().hex}"
        self.name = f"legacy {peer}"
        self._service, self._socket, self._port, self._log = service, connected, port, log
        self._entrance = Entrance(GATEWAY, peer.rpartition(":")[0])
        self._containers = Containers(lambda: service.simulation.limits, pace)
        self._arrived = bytearray()
        """Bytes that were read from the socket and not used."""

        self._message_size = 0
        """Bytes that were read of the message that is arriving."""

        self._began = 0.0
        """When its first bytes were read, on the monotonic clock."""

        self._unfinished, self._pieces = (service.unfinished.holder(self.break_off) for _ in range(2))
        """Accounts of that message, and of commands that come in pieces."""

        self._problem = ""
        """Why another connection, or the server, has closed this one."""

        self._timeout = 0.0
        """The time-out of the socket."""

        self._last_empty = 0.0
        """The time of the last answer without replies."""

        self.since = time.monotonic()
        self.has_joined = False
        self._is_closed = False
        self._news = threading.Event()
        self._lock = threading.Lock()
        """Lock of the deliveries."""

        self._deliveries: deque[Delivery] = deque()
        self._unread = 0
        """Their bytes, about."""

        self._stream: Delivery | None = None
        self._images: dict[int, Delivery] = {}

    @property
    def is_stranger(self) -> bool:
        """Return whether it has sent nothing yet."""
        return not self.has_joined

    # --- the thread of the connection ------------------------------------------------------------

    def run(self) -> None:
        """Serve the client until it leaves or breaks the rules."""
        with self._socket:
            try:
                self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                while self._exchange():
                    pass
            except (BadPeer, messages.Malformed, LimitReached) as problem:
                self._log.say(WARNING, "%s at port %d is dropped: %s", self.name, self._port, problem)
            except Gone as problem:
                if str(problem):
                    self._log.say(INFO, "%s at port %d is dropped: %s", self.name, self._port, problem)
            except OSError as error:
                logger.debug("%s at port %d: %s", self.name, self._port, error)
            except Exception:
                logger.exception("%s at port %d is dropped because of a fault", self.name, self._port)
            finally:
                self._is_closed = True
                self._unfinished.end()
                self._pieces.end()
                if self.has_joined:
                    self._service.clients.depart(self.client)

    def _exchange(self) -> bool:
        """Read a message and answer it; return False after the last one."""
        limits = self._service.simulation.limits
        self._message_size, self._began = len(self._arrived), time.monotonic()
        began = time.thread_time()
        data = read_message(self._receive, limits.message)
        self._unfinished.hold(0)
        message = messages.read(data, limits.calls)
        if not self.has_joined:
            self._join()
        self._containers.receive(message)
        self._pieces.hold(self._containers.incomplete)
        is_slow = self._submit()
        self._wait_for_results()
        answer = self._containers.message()
        self._send(answer)
        self._rest(time.thread_time() - began, is_slow, is_empty=len(answer) == messages.HEADER.size)
        return not message.is_last

    def _receive(self, size: int) -> bytes:
        """Return exactly this number of bytes. Raises Gone."""
        if len(self._arrived) < size:
            self._fill(size)
        data = bytes(self._arrived[:size])
        del self._arrived[:size]
        return data

    def _fill(self, size: int) -> None:
        """Read until this number of bytes has arrived. Raises Gone."""
        most = self._service.simulation.limits.message_seconds
        while (have := len(self._arrived)) < size:
            is_silent = not self._message_size
            try:
                part = self._read_first() if is_silent else self._read(max(READ, min(size - have, MOST_READ)))
            except TimeoutError:
                raise Gone(
                    f"it has sent nothing for {SILENCE:g} s"
                    if is_silent
                    else "a message of it does not go on"
                ) from None
            if not part:
                raise Gone(self._problem or ("" if is_silent else "it has left within a message"))
            if is_silent:
                self._began = time.monotonic()
            elif time.monotonic() > self._began + most:
                raise Gone(f"its message has not arrived within {most} s (limit 'message_seconds')")
            self._arrived += part
            self._message_size += len(part)
            self._unfinished.hold(self._message_size)

    def _read_first(self) -> bytes:
        """Return the first bytes of a message; end the stepped mode of a client that is silent for long."""
        self._set_timeout(min(FROZEN, SILENCE))
        try:
            return self._socket.recv(READ)
        except TimeoutError:
            why = f"nothing was heard of it for {FROZEN:g} s"
            self._service.queue.post(partial(self._service.clients.end_stepping, self.client, why))
        self._set_timeout(max(LEAST_CYCLE, SILENCE - FROZEN))
        return self._socket.recv(READ)

    def _read(self, size: int) -> bytes:
        """Return the next bytes of a message, at most this many."""
        self._set_timeout(STALL)
        return self._socket.recv(size)

    def _set_timeout(self, seconds: float) -> None:
        """Set the time-out of the socket, which is a system call, if it is another one."""
        if seconds != self._timeout:
            self._socket.settimeout(seconds)
            self._timeout = seconds

    def _join(self) -> None:
        """Join the server loop. Raises LimitReached, or Gone: the server ends."""
        joined = threading.Event()
        refusals: list[LimitReached] = []

        def join() -> None:
            try:
                if not self._is_closed:
                    self._service.clients.join(
                        self.client, self.name, self._port, self, entrance=self._entrance
                    )
            except LimitReached as problem:
                refusals.append(problem)
            finally:
                joined.set()

        self.has_joined = True
        self._service.queue.post(join)
        while not joined.wait(LOOK):
            self._check_open()
        if refusals:
            raise refusals[0]
        self._check_open()

    def _check_open(self) -> None:
        if self._is_closed or self._service.ending.has_come:
            raise Gone("the server ends the connection")

    def _submit(self) -> bool:
        """Hand waiting commands to the server loop; return whether it asks for fewer."""
        is_slow = False
        while (batch := self._containers.take_batch()) is not None:
            is_slow = not self._service.queue.submit(self.client, CallsWork(batch))
        return is_slow

    def _wait_for_results(self) -> None:
        """Absorb what has come; wait for a moment for blocking calls, and for space for more commands."""
        end = time.monotonic() + HELD
        while True:
            self._news.clear()
            self._absorb()
            self._submit()
            if self._containers.is_full:
                self._check_open()
                self._news.wait(LOOK)
                continue
            left = end - time.monotonic()
            if not self._containers.is_waited_for or left <= 0:
                return
            self._news.wait(left)

    def _absorb(self) -> None:
        with self._lock:
            deliveries, self._deliveries = self._deliveries, deque()
            stream, self._stream = self._stream, None
            images, self._images = self._images, {}
            self._unread = 0
        if stream is not None:
            self._containers.absorb_values(stream)
        for each in deliveries:
            self._containers.absorb(each)
        for each in images.values():
            self._containers.absorb(each, is_reliable=False)

    def _send(self, message: bytes) -> None:
        self._set_timeout(STALL)
        try:
            self._socket.sendall(b"".join(packets(message)))
        except TimeoutError:
            raise Gone("it does not read its answers") from None

    def _rest(self, worked: float, is_slow: bool, *, is_empty: bool) -> None:
        """Leave the interpreter to the physics thread, if the client sends very often or very much.

        Args:
            worked: seconds of processor time that this exchange has taken.
            is_slow: the server loop asks for fewer messages.
            is_empty: the answer has no replies.
        """
        now = time.monotonic()
        pause = worked if worked > MUCH_WORK else 0.0
        if is_slow:
            pause = max(pause, PAUSE)
        elif is_empty:
            pause = max(pause, self._last_empty + LEAST_CYCLE - now)
            self._last_empty = now + max(0.0, pause)
        if pause > 0:
            time.sleep(pause)

    # --- any thread: the link --------------------------------------------------------------------

    def deliver(self, delivery: Delivery) -> None:
        """Keep replies for the client's next message."""
        size = sum(size_of(value) for reply in delivery.replies for value in reply.values)
        with self._lock:
            self._deliveries.append(delivery)
            self._unread += size
            is_too_much = self._unread > MOST_UNREAD and len(self._deliveries) > 1
        if is_too_much:
            self._log.say(WARNING, "%s is dropped: it does not take its answers", self.name)
            self.close()
        self._news.set()

    def publish(self, values: NewestValues) -> None:
        """Keep the newest values of the small streams."""
        replies = [
            Reply(each, value.answer[0], value.time_ms, value.answer[1])
            for each, value in values.of_streams()
        ]
        stream = values.head._replace(replies=replies)
        with self._lock:
            self._stream = stream

    def publish_image(self, stream_id: int, delivery: Delivery, *, in_order: bool) -> None:
        """Keep the newest image of a stream."""
        with self._lock:
            self._images[stream_id] = delivery

    def break_off(self, problem: str) -> None:
        """End the connection for a reason."""
        self._problem = problem
        self.close()

    def close(self) -> None:
        """End the connection; the thread notices it at once."""
        self._is_closed = True
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._news.set()
