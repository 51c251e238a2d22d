"""The seam between a connection and the outside world, and its real implementation over Zenoh.

A second, in-process implementation lives with the server (``simx_server/gateways/loopback.py``).
"""

from __future__ import annotations

import contextlib
import itertools
import math
import os
import sys
import threading
import time
from collections.abc import Sequence
from typing import Any, Protocol

from simx_client.connection.endpoints import Place
from simx_client.errors import ConnectionFailed, NoAnswer
from simx_client.protocol import keys, link
from simx_client.protocol.codec import CodecError, decode_welcome, encode
from simx_client.protocol.messages import (
    OLDEST_PROTOCOL,
    PROTOCOL_VERSION,
    Greeting,
    Welcome,
    no_common_version,
)

from .busy_wait import Spinning
from .diagnosis import busy_server, diagnose
from .time_limit import Alarm
from .writer import Writer
from .zenoh_session import client_name, living_realms, open_session

GREETING_TIMEOUT = 1.0
"""Seconds to wait for the answer to one greeting."""

ASKING = 0.8
"""Of the time for a greeting; the rest is for finding out why nobody answered."""

OPENING = 0.8
"""Of the time for opening a session; the rest is for finding out why none could be had."""

OPENING_PAUSE = 0.05
"""Seconds between two attempts."""

LEAST_ATTEMPT = 0.1
"""Seconds; with less left there is no further attempt."""

CLOSE_TIMEOUT = 1.0
"""Seconds that leaving a server may hold up a program; what is left to be done then, a thread does."""

SMALL = 4096
"""Bytes of a message that is sent from the caller's thread. As many of these as may be unanswered fit into Zenoh's
queue, so sending them never waits; larger ones may find it full for a second, whatever the caller's time-out."""

REPLIES_HELD = 1_000_000
"""Deliveries that may wait for the script to make its next call; more would hold up the whole session."""

NAMES_SHOWN = 8
"""Realms that a message lists."""

SHARED_MEMORY_SESSIONS = 100
"""Sessions of a process that may use shared memory, the fastest way for pictures. Each leaves a file descriptor
behind when it is closed (Zenoh 1.10), and a program that connects anew for every episode would run out of them."""

_sessions_before = itertools.count()


class Transport(Protocol):
    """Bytes to one server and back. Used by one connection, under its lock."""

    @property
    def is_connected(self) -> bool:
        """Whether a server is there to be greeted."""
        ...

    @property
    def was_lost(self) -> bool:
        """Whether the server went away since the last greeting, even if another is back already."""
        ...

    def greet(self, timeout: float) -> Welcome:
        """Open the conversation, or open it again with a server that came back.

        Raises:
            ConnectionFailed: no server answered in time, or it refused.
        """
        ...

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        """Send a batch; batches arrive in order.

        Where nothing is taken any more this waits, until a deadline on the monotonic clock; what is not sent by then
        still goes out when it can.
        """
        ...

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        """The next delivery, waiting at most ``timeout`` seconds; None when there is none.

        Returns early with None when the server goes away.

        Args:
            is_soon: it should not take longer than a message there and back.
        """
        ...

    def newest(self) -> bytes | None:
        """The newest values of the small streams, if there are any not taken yet."""
        ...

    def pictures(self) -> list[bytes]:
        """The newest picture of each picture stream, those not taken yet."""
        ...

    def close(self) -> None:
        """Leave the server. Idempotent."""
        ...


class ZenohTransport:
    """One Zenoh session to one server. Zenoh's threads only store what arrives."""

    def __init__(
        self, place: Place, *, connect_timeout: float, retry: bool, asked_port: int | None = None
    ) -> None:
        """Open a session to a server's port, or to a router through which it is reached.

        Args:
            connect_timeout: seconds that opening may take, and finding out why it failed; 0: as long as one attempt
                takes.
            retry: keep trying for so long; otherwise one attempt is made, and further ones only where something
                is there that does not answer yet.
            asked_port: the port the script asked for, when it was sent here instead; without it, that of the place.

        Raises:
            ConnectionFailed: nothing there that speaks Zenoh.
        """
        zenoh = link.import_zenoh()
        self._zenoh = zenoh
        self._place = place
        at_port = place.host_and_port[1] if place.host_and_port else 0
        self._asked_port = at_port if asked_port is None else asked_port
        self.client = client_name()
        self._secret = os.urandom(16)
        """Tells the server that a message in this client's name is from it; others may learn the name."""

        self._pictures: dict[str, Any] = {}
        """The newest of each stream, by key."""

        self._alive = False
        self._lost = False
        self._realm: str | None = None
        self._closed = False
        self._session = self._open(connect_timeout, retry)
        self._alarm = Alarm(self._wake)
        self._spinning = Spinning()
        self._writer = Writer(self._put)

    def _open(self, patience: float, retry: bool) -> Any:
        deadline = time.monotonic() + patience if patience else math.inf
        options: dict[str, Any] = {
            "mode": "client",
            "connect/endpoints": list(self._place.endpoints),
            # One attempt each time: with a time-out Zenoh tries only the first of the endpoints, again and again.
            "connect/timeout_ms": 0,
            "connect/retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 1.5},
        }
        if next(_sessions_before) >= SHARED_MEMORY_SESSIONS:
            options["transport/shared_memory/enabled"] = False
        while True:
            left = deadline - time.monotonic()
            for_each = min(
                link.OPEN_TIMEOUT_MS, 1000 * max(0.05, left * OPENING / len(self._place.endpoints))
            )
            defaults = {**link.CLIENT, "transport/unicast/open_timeout": int(for_each)}
            try:
                return open_session(self._zenoh, options, defaults)
            except self._zenoh.ZError:
                is_last = not patience or time.monotonic() + OPENING_PAUSE + LEAST_ATTEMPT >= deadline
                if is_last or not retry:
                    failure = diagnose(self._place, deadline)
                    if is_last or not isinstance(failure, NoAnswer):
                        raise failure from None
            time.sleep(OPENING_PAUSE)

    @property
    def is_connected(self) -> bool:
        return self._alive

    @property
    def was_lost(self) -> bool:
        return self._lost

    def greet(self, timeout: float) -> Welcome:
        self._lost = False
        deadline = time.monotonic() + timeout * ASKING
        until = deadline + timeout * (1 - ASKING)
        name = f"{os.path.basename(sys.argv[0] or 'python')} (pid {os.getpid()})"
        greeting = encode(Greeting(OLDEST_PROTOCOL, self.client, name, self._asked_port, PROTOCOL_VERSION))
        if self._realm is None:
            self._declare(self._place.realm or self._only_realm(deadline, until))
        assert self._realm is not None
        # What was asked before only found the realm. By now the server can reach this client: say hello.
        welcomes = self._ask(keys.hello(self._realm), greeting, deadline, until)
        if len(welcomes) > 1:
            raise ConnectionFailed(
                f"{len(welcomes)} simulators at {self._place} are called {self._realm}, and both would do what one "
                "is told; give each a name of its own: simx-server --realm NAME"
            )
        chosen = welcomes[0].protocol
        if not OLDEST_PROTOCOL <= chosen <= PROTOCOL_VERSION:  # a server that has not noticed
            raise ConnectionFailed(no_common_version((OLDEST_PROTOCOL, PROTOCOL_VERSION), (chosen, chosen)))
        return welcomes[0]

    def _only_realm(self, deadline: float, until: float) -> str:
        """The realm of a server's port; through a router only if it is the only one there."""
        realms = sorted({welcome.realm for welcome in self._ask(keys.ANY_HELLO, None, deadline, until)})
        if len(realms) > 1:
            raise ConnectionFailed(
                f"several simulators are at {self._place}: {_listed(realms)}; say which: "
                f"simxStart('{realms[0]}@ROUTER', PORT, ...), or SIMX_REALM={realms[0]}"
            )
        return realms[0]

    def _ask(self, key: str, greeting: bytes | None, deadline: float, until: float) -> list[Welcome]:
        """Ask until servers answer: right after a connection their keys may not be known here yet.

        Args:
            until: after the deadline, for finding out why nobody answered.
        """
        while True:
            remaining = deadline - time.monotonic()
            replies = self._session.get(
                key,
                payload=greeting,
                attachment=None if greeting is None else self._secret,
                timeout=max(0.01, min(GREETING_TIMEOUT, remaining)),
                target=self._zenoh.QueryTarget.ALL,
                consolidation=self._zenoh.ConsolidationMode.NONE,
            )
            welcomes = [self._read(reply.ok.payload.to_bytes()) for reply in replies if reply.ok is not None]
            if welcomes:
                return welcomes
            if time.monotonic() >= deadline:
                raise self._silence(until - time.monotonic())
            time.sleep(0.005)

    def _read(self, payload: bytes) -> Welcome:
        try:
            welcome = decode_welcome(payload)
        except CodecError as error:
            raise ConnectionFailed(
                f"the program at {self._place} answered with something else than a greeting ({error}); "
                "is it a simx-server of this version?"
            ) from None
        if welcome.refusal:
            raise ConnectionFailed(f"the program at {self._place} refused the connection: {welcome.refusal}")
        return welcome

    def _silence(self, patience: float) -> ConnectionFailed:
        """Return why nobody answered, as far as it can be found out in so many seconds, and what to do."""
        wanted = self._place.realm or self._realm
        realms = living_realms(self._session, time.monotonic() + patience)
        if realms if wanted is None else wanted in realms:
            return NoAnswer(
                f"the simulator of {self._place} is there but does not answer; it may be frozen or overloaded, or its "
                "access rules do not let this user in so (who may only read: SIMX_ROLE=viewer)"
            )
        if wanted is None:
            if busy := busy_server(self._place):
                return NoAnswer(busy)
            return ConnectionFailed(
                f"the program at {self._place} speaks Zenoh but no simx-server answered there; "
                "start one with 'simx-server', or ask for its port"
            )
        import difflib  # it takes 2 ms, and every script imports this module

        near = difflib.get_close_matches(wanted, realms, NAMES_SHOWN)
        there = _listed(near + [realm for realm in realms if realm not in near]) or "none at all"
        return ConnectionFailed(
            f"no simulator of that name answered at {self._place}; there: {there}; check the name, "
            f"or start one: simx-server --realm {wanted} --connect {self._place.endpoints[0]}"
        )

    def _declare(self, realm: str) -> None:
        """Everything of this client that the server must find before it answers the second greeting."""
        zenoh, session = self._zenoh, self._session
        direct = zenoh.handlers.Callback
        self._realm = keys.check_chunk(realm)
        self._token = session.liveliness().declare_token(keys.client(realm, self.client))
        self._replies = session.declare_subscriber(
            keys.reply(realm, self.client), zenoh.handlers.FifoChannel(REPLIES_HELD)
        )
        self._bell = session.declare_publisher(
            keys.reply(realm, self.client), allowed_destination=zenoh.Locality.SESSION_LOCAL
        )
        self._streams = session.declare_subscriber(
            keys.stream(realm, self.client), zenoh.handlers.RingChannel(1)
        )
        self._picture_streams = session.declare_subscriber(
            keys.picture(realm, self.client), direct(self._on_picture, indirect=False)
        )
        self._server = session.liveliness().declare_subscriber(
            keys.alive(realm), direct(self._on_server, indirect=False), history=True
        )
        # A publisher would save two of a call's 130 microseconds, but the server would keep 3 kB of each that there
        # ever was: Zenoh 1.10 does not let go of them.
        self._calls = session.declare_keyexpr(keys.call(realm, self.client))
        self._block = zenoh.CongestionControl.BLOCK

    def _wake(self) -> None:
        """End a wait in ``receive`` from the alarm's thread: an empty message from us to ourselves."""
        with contextlib.suppress(
            self._zenoh.ZError
        ):  # the session was closed meanwhile, which ends the wait too
            self._bell.put(b"")

    def _on_picture(self, sample: Any) -> None:
        self._pictures[str(sample.key_expr)] = sample

    def _on_server(self, sample: Any) -> None:
        if sample.kind == self._zenoh.SampleKind.DELETE:
            self._alive = False
            self._lost = True
            self._alarm.set(0.0)  # wakes a blocking call
        else:
            self._alive = True

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        if len(payload) <= SMALL and self._writer.is_idle:
            self._session.put(self._calls, payload, congestion_control=self._block, attachment=self._secret)
        else:
            self._writer.send(payload, deadline)

    def _put(self, payload: bytes) -> None:
        with contextlib.suppress(self._zenoh.ZError):  # closed meanwhile
            self._session.put(self._calls, payload, congestion_control=self._block, attachment=self._secret)

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        try:
            if timeout > 0:
                sample = self._spinning.look(self._replies.try_recv) if is_soon else None
                if sample is None:
                    self._alarm.set(time.monotonic() + timeout)
                    # In this order: a loss after the look at it rings the bell.
                    sample = None if self._lost else self._replies.recv()
                    self._alarm.clear()
            else:
                sample = self._replies.try_recv()
        except self._zenoh.ZError:  # the session was closed by another thread
            return None
        return None if sample is None else sample.payload.to_bytes() or None

    def newest(self) -> bytes | None:
        sample = self._streams.try_recv()
        return None if sample is None else sample.payload.to_bytes()

    def pictures(self) -> list[bytes]:
        payloads: list[bytes] = []
        while self._pictures:  # popitem is atomic: what arrives meanwhile is taken too, or stays
            payloads.append(self._pictures.popitem()[1].payload.to_bytes())
        return payloads

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self._alive = False
            self._alarm.close()
            closing = threading.Thread(target=self._close_session, name="simx-close")
            try:
                closing.start()
            except RuntimeError:  # at exit no thread can be started any more
                self._close_session()
            else:
                closing.join(CLOSE_TIMEOUT)

    def _close_session(self) -> None:
        """Takes ten seconds while a large message is on its way to a server that takes nothing any more."""
        self._writer.close()
        with contextlib.suppress(self._zenoh.ZError):  # it gave up
            self._session.close()


def _listed(names: Sequence[str]) -> str:
    more = len(names) - NAMES_SHOWN
    return ", ".join(names[:NAMES_SHOWN]) + (f" and {more} more" if more > 0 else "")
