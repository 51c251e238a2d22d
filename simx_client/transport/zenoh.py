"""Messages to and from one server over Zenoh."""

from __future__ import annotations

import contextlib
import itertools
import math
import os
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

from simx_client.errors import ConnectionFailed, NoAnswer
from simx_client.protocol.codec import CodecError, decode_welcome, encode
from simx_client.protocol.messages import (
    OLDEST_PROTOCOL,
    PROTOCOL_VERSION,
    Greeting,
    Welcome,
    no_common_version,
)
from simx_client.protocol.zenoh import keys, link
from simx_client.protocol.zenoh.connections import Connection, close_at_once

from .busy_wait import BusyWait
from .diagnosis import busy_server, diagnose
from .endpoints import ServerAddress
from .time_limit import Alarm
from .writer import Writer
from .zenoh_session import client_role, living_realms, open_session, program_name

GREETING_TIMEOUT = 1.0
"""Time-out for the answer to one greeting in seconds."""

ASKING = 0.8
"""Share of a greeting's time-out for the request; the rest is for the diagnosis."""

OPENING = 0.8
"""Share of the time-out for opening a session; the rest is for the diagnosis."""

OPENING_PAUSE = 0.05
"""Seconds between two attempts."""

LEAST_ATTEMPT = 0.1
"""Minimum duration of an attempt in seconds; with less time left no attempt is made."""

DISCONNECTED_WITHIN = 5.0
"""Seconds until Zenoh has disconnected a server after a full queue, see `FULL_QUEUE_US`."""

CLOSE_TIMEOUT = 1.0
"""Seconds that closing may block a program; a thread does the remaining work."""

SMALL = 4096
"""Maximum size in bytes of a message that the caller's thread sends. Zenoh's queue has room for as many of
these as may be unanswered, so sending them never waits; larger messages may wait a second for room, whatever
the caller's time-out."""

REPLIES_HELD = 1_000_000
"""Maximum number of deliveries that wait for the script's next call; more would block the whole session."""

NAMES_SHOWN = 8
"""Number of realms that a message lists."""

SHARED_MEMORY_SESSIONS = 100
"""Sessions of a process that may use shared memory, the fastest way for images. Each leaves a file descriptor
open after it is closed (Zenoh 1.10); a program that connects again for every episode would run out of
descriptors."""

_sessions_before = itertools.count()


LOOK_AGAIN = 1.0
"""Seconds between two requests whether a lost server is there again."""


class ZenohTransport:
    """One Zenoh session to one server. Zenoh's threads only store what arrives."""

    def __init__(
        self,
        server: ServerAddress,
        *,
        connect_timeout: float,
        retry: bool,
        asked_port: int | None = None,
        lost: Callable[[], object] = bool,
    ) -> None:
        """Open a session to a server's port, or to a router that reaches the server.

        Args:
            server: the server's address.
            connect_timeout: time-out in seconds for opening and its diagnosis; 0: the duration of one
                attempt.
            retry: repeat attempts until the time-out; otherwise make one attempt, and further ones only while
                something listens that does not answer yet.
            asked_port: the port that the script requested, if it was redirected; without it, the port of the
                address.
            lost: called by a thread of Zenoh when the server is lost.

        Raises:
            ConnectionFailed: nothing that speaks Zenoh listens there.
        """
        zenoh = link.import_zenoh()
        self._zenoh = zenoh
        self._address = server
        at_port = server.host_and_port[1] if server.host_and_port else 0
        self._asked_port = at_port if asked_port is None else asked_port
        self._secret = os.urandom(16)
        """Proves to the server that a message in this client's name is from this client; other clients may
        learn the name."""

        self.new_images: dict[str, Any] = {}
        """Newest image of each stream, by key."""

        self._tell_lost: Callable[[], object] = lost
        self._alive = False
        self._lost = False
        self._next_look = 0.0
        self._realm: str | None = None
        self._closed = False
        role = client_role()
        self._session = self._open(connect_timeout, retry)
        self.client = f"{role}{self._session.info.zid()}"
        """The server finds the link of a client by the name of its Zenoh session."""

        self._alarm = Alarm(self._wake)
        self._busy_wait = BusyWait()
        self._writer = Writer(self._put)

    def _open(self, timeout: float, retry: bool) -> Any:
        deadline = time.monotonic() + timeout if timeout else math.inf
        options: dict[str, Any] = {
            "mode": "client",
            "connect/endpoints": list(self._address.endpoints),
            # One attempt each time: with a time-out Zenoh repeats only the first endpoint.
            "connect/timeout_ms": 0,
            "connect/retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 1.5},
        }
        if next(_sessions_before) >= SHARED_MEMORY_SESSIONS:
            options["transport/shared_memory/enabled"] = False
        while True:
            left = deadline - time.monotonic()
            for_each = min(
                link.OPEN_TIMEOUT_MS, 1000 * max(0.05, left * OPENING / len(self._address.endpoints))
            )
            defaults = {**link.CLIENT, "transport/unicast/open_timeout": int(for_each)}
            try:
                return open_session(self._zenoh, options, defaults)
            except self._zenoh.ZError:
                is_last = not timeout or time.monotonic() + OPENING_PAUSE + LEAST_ATTEMPT >= deadline
                if is_last or not retry:
                    failure = diagnose(self._address, deadline)
                    if is_last or not isinstance(failure, NoAnswer):
                        raise failure from None
            time.sleep(OPENING_PAUSE)

    @property
    def is_connected(self) -> bool:
        if self._lost and not self._alive and time.monotonic() >= self._next_look:
            self._next_look = time.monotonic() + LOOK_AGAIN
            self._look_again()
        return self._alive

    def _look_again(self) -> None:
        """Request the token of a server that was lost, without waiting: its return may have been missed, if it came
        before the end of the server that it replaces was noticed."""

        def found(_reply: Any) -> None:
            if self._lost:
                self._alive = True

        with contextlib.suppress(self._zenoh.ZError):  # the session was closed meanwhile
            self._session.liveliness().get(
                keys.alive(self._realm or ""),
                self._zenoh.handlers.Callback(found, indirect=False),
                timeout=LOOK_AGAIN,
            )

    @property
    def was_lost(self) -> bool:
        return self._lost

    def greet(self, timeout: float) -> Welcome:
        self._lost = False
        deadline = time.monotonic() + timeout * ASKING
        until = deadline + timeout * (1 - ASKING)
        greeting = encode(
            Greeting(OLDEST_PROTOCOL, self.client, program_name(), self._asked_port, PROTOCOL_VERSION)
        )
        if self._realm is None:
            self._declare(self._address.realm or self._only_realm(deadline, until))
        assert self._realm is not None
        # The request before only found the realm. The server can reach this client by now: greet it.
        welcomes = self._ask(keys.hello(self._realm), greeting, deadline, until)
        if len(welcomes) > 1:
            raise ConnectionFailed(
                f"{len(welcomes)} simulators at {self._address} are called {self._realm}, and both would do what one "
                "is told; give each a name of its own: simx-server --realm NAME"
            )
        chosen = welcomes[0].protocol
        if not OLDEST_PROTOCOL <= chosen <= PROTOCOL_VERSION:  # a server that has not noticed
            raise ConnectionFailed(no_common_version((OLDEST_PROTOCOL, PROTOCOL_VERSION), (chosen, chosen)))
        links = (Connection.of(each) for each in self._session.info.links())
        close_at_once([each for each in links if each is not None])
        return welcomes[0]

    def _only_realm(self, deadline: float, until: float) -> str:
        """Return the realm at a server's port; through a router only if it is the only realm there."""
        realms = sorted({welcome.realm for welcome in self._ask(keys.ANY_HELLO, None, deadline, until)})
        if len(realms) > 1:
            raise ConnectionFailed(
                f"several simulators are at {self._address}: {_listed(realms)}; say which: "
                f"simxStart('{realms[0]}@ROUTER', PORT, ...), or SIMX_REALM={realms[0]}"
            )
        return realms[0]

    def _ask(self, key: str, greeting: bytes | None, deadline: float, until: float) -> list[Welcome]:
        """Request until servers answer: right after connecting, their keys may be unknown here.

        Args:
            until: after the deadline, for the diagnosis of a missing answer.
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
                f"the program at {self._address} answered with something else than a greeting ({error}); "
                "is it a simx-server of this version?"
            ) from None
        if welcome.refusal:
            raise ConnectionFailed(
                f"the program at {self._address} refused the connection: {welcome.refusal}"
            )
        return welcome

    def _silence(self, timeout: float) -> ConnectionFailed:
        """Return why no server answered, as far as it can be found out within the time-out in seconds, and
        what to do."""
        wanted = self._address.realm or self._realm
        realms = living_realms(self._session, time.monotonic() + timeout)
        if realms if wanted is None else wanted in realms:
            return NoAnswer(
                f"the simulator of {self._address} is there but does not answer; it may be frozen or overloaded, "
                "or its access rules do not let this user in so (who may only read: SIMX_ROLE=viewer)"
            )
        if wanted is None:
            if busy := busy_server(self._address):
                return NoAnswer(busy)
            return ConnectionFailed(
                f"the program at {self._address} speaks Zenoh but no simx-server answered there; "
                "start one with 'simx-server', or ask for its port"
            )
        import difflib  # it takes 2 ms, and every script imports this module

        near = difflib.get_close_matches(wanted, realms, NAMES_SHOWN)
        there = _listed(near + [realm for realm in realms if realm not in near]) or "none at all"
        return ConnectionFailed(
            f"no simulator of that name answered at {self._address}; there: {there}; check the name, "
            f"or start one: simx-server --realm {wanted} --connect {self._address.endpoints[0]}"
        )

    def _declare(self, realm: str) -> None:
        """Declare everything of this client that the server must find before it answers the second greeting."""
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
        self._image_streams = session.declare_subscriber(
            keys.image(realm, self.client), direct(self._on_image, indirect=False)
        )
        self._server = session.liveliness().declare_subscriber(
            keys.alive(realm), direct(self._on_server, indirect=False), history=True
        )
        # A publisher would save two of a call's 130 microseconds, but the server would keep 3 kB for each one
        # that ever existed: Zenoh 1.10 does not free them.
        self._calls = session.declare_keyexpr(keys.call(realm, self.client))
        self._block = zenoh.CongestionControl.BLOCK

    def _wake(self) -> None:
        """End a wait in ``receive`` from the alarm's thread, with an empty message to this client."""
        with contextlib.suppress(
            self._zenoh.ZError
        ):  # the session was closed meanwhile, which ends the wait too
            self._bell.put(b"")

    def _on_image(self, sample: Any) -> None:
        self.new_images[str(sample.key_expr)] = sample

    def _on_server(self, sample: Any) -> None:
        if sample.kind == self._zenoh.SampleKind.DELETE:
            self._alive = False
            self._next_look = time.monotonic() + LOOK_AGAIN
            self._lost = True
            self._tell_lost()
            self._alarm.set(0.0)  # wakes a blocking call
        else:
            self._alive = True

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        if len(payload) <= SMALL and not self._writer.unsent:
            self._session.put(self._calls, payload, congestion_control=self._block, attachment=self._secret)
        else:
            self._writer.send(payload, deadline)

    def _put(self, payload: bytes) -> None:
        with contextlib.suppress(self._zenoh.ZError):  # closed meanwhile
            self._session.put(self._calls, payload, congestion_control=self._block, attachment=self._secret)

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        try:
            if timeout > 0:
                sample = self._busy_wait.poll(self._replies.try_recv) if is_soon else None
                if sample is None:
                    self._alarm.set(time.monotonic() + timeout)
                    # In this order: a loss after this check sets the flag and ends the wait.
                    sample = None if self._lost else self._replies.recv()
                    self._alarm.clear()
            else:
                sample = self._replies.try_recv()
        except self._zenoh.ZError:  # the session was closed by another thread
            return None
        return None if sample is None else sample.payload.to_bytes() or None

    def is_still(self) -> bool:
        return False  # to know it takes as long as to look

    def newest(self) -> bytes | None:
        sample = self._streams.try_recv()
        return None if sample is None else sample.payload.to_bytes()

    def images(self) -> list[bytes]:
        payloads: list[bytes] = []
        while self.new_images:  # popitem is atomic: images that arrive meanwhile are taken too, or stay
            payloads.append(self.new_images.popitem()[1].payload.to_bytes())
        return payloads

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self._alive = False
            self._alarm.close()
            closing = threading.Thread(target=self._close_session, name="simx-close")
            try:
                closing.start()
            except RuntimeError:  # at exit no thread can be started
                self._close_session()
            else:
                closing.join(CLOSE_TIMEOUT)

    def _close_session(self) -> None:
        """Close the session; takes ten seconds while a large message is on its way to a server that reads
        nothing."""
        is_stuck = bool(self._writer.unsent)
        self._writer.close()
        if is_stuck:
            self._await_disconnection()
        with contextlib.suppress(self._zenoh.ZError):  # Zenoh's time-out
            self._session.close()

    def _await_disconnection(self) -> None:
        """Wait until Zenoh has disconnected a server that reads nothing, or the server reads again.

        A session that is closed while Zenoh does that may deadlock with it, and with it all sessions of the process.
        """
        end = time.monotonic() + DISCONNECTED_WITHIN
        while self._session.info.transports() and time.monotonic() < end:
            time.sleep(0.02)


def _listed(names: Sequence[str]) -> str:
    more = len(names) - NAMES_SHOWN
    return ", ".join(names[:NAMES_SHOWN]) + (f" and {more} more" if more > 0 else "")
