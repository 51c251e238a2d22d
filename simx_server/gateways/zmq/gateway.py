"""The port of the ZeroMQ remote API. The physics thread accepts its connections and reads them while it waits.

A client sends a message and waits for its answer, which may have to wait for a simulation step.
"""

from __future__ import annotations

import errno
import logging
import re
import socket
import time
from collections.abc import Mapping, Sequence
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from simx_client.protocol.cli.installing import extra_line
from simx_client.protocol.zenoh.keys import VIEWER
from simx_server.service.clients.admission.places import is_elsewhere
from simx_server.service.clients.sessions import FROZEN
from simx_server.service.queue.sockets import LOOK

from ..errors import GatewayError
from ..exposure import is_loopback
from ..listening import RETRY, Listening
from .clients import FIRST_HANDLE, ZmqClients
from .peer import Peer, SocketPeer
from .wire.messages import MAX_MESSAGE, packer, uuid_of
from .wire.zmtp import BadPeer

if TYPE_CHECKING:
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

MISSING = (
    "--{flag} needs the package cbor2, which is missing; install it with: {line}, or start without --{flag}"
)

MOST_UNANSWERED = 16
"""Messages of one connection that wait for an answer. A correct client sends the next after an answer; a connection
with more is closed.
"""

MOST_CONNECTIONS = 1024
"""A client with many calls at a time has one connection for each; of more, the longest one without a client goes."""

MOST_OF_ONE = 256
"""Connections from one other machine."""

BACKLOG = 100
"""Connections that the system keeps until they are accepted."""

SILENCE = 30.0
"""Seconds that a peer has for what comes before its first message."""

FAREWELL = 0.5
"""Seconds for the last answers when the server ends."""

QUIET = 0.15
"""Seconds without a message after which a peer that has come to the successor of a crashed server waits for an answer
of that one.
"""

VIEWERS = 500_000
"""The handles of viewers are so much higher than those of other clients."""

_LARGE = 1 << 16
"""Bytes from which a message may meet a limit: of smaller ones, too few can wait for an answer."""

_KEEPALIVE = {"TCP_KEEPIDLE": 10, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 3}
"""Seconds and counts after which the system notices that a machine has gone without a word, where it knows these."""

_UUID = re.compile(r"[A-Za-z0-9_.{}-]+")

_API_2 = {
    "msg": "result",
    "id": 1,
    "error": True,
    "result": "this port serves the ZeroMQ remote API of CoppeliaSim 4.3 to 4.10; for API 2 start the server with "
    "--zmq2, and connect to that port (24020)",
}
"""The first answer to a client of API 2, whose first message has the number 1."""

_OLD = {
    "success": False,
    "error": "this client speaks the first version of the ZeroMQ remote API, and the server the second: install "
    "coppeliasim-zmqremoteapi-client with pip, and remove the program's own copy of the client (zmqRemoteApi) or "
    "start the program with simx-run, which replaces it",
}


def missing(flag: str = "zmq") -> str:
    """Return what to install, if the package that a flag needs is missing; else an empty text."""
    try:
        __import__("cbor2")
    except ImportError:
        return MISSING.format(line=extra_line("zmq"), flag=flag)
    return ""


class ZmqGateway(Listening[SocketPeer]):
    """Serves one server loop to clients of the ZeroMQ remote API."""

    flag = "zmq"
    """The setting that opens it, and with which the names of its endpoints start."""

    silence = SILENCE
    unsaid = "it has not started"
    crowded = "others need its place"

    def __init__(self, service: Service, address: str, *, may_only_read: bool = False) -> None:
        """Listen, and have the server loop read. Physics thread, or before it runs.

        Args:
            address: ``HOST:PORT``; port 0 is a free one.
            may_only_read: its clients are viewers.

        Raises:
            GatewayError: a package is missing, or the address cannot be used.
        """
        if problem := missing(self.flag):
            raise GatewayError(problem)
        self._prefix = VIEWER if may_only_read else ""
        self._pack = packer()
        listener = _listen(address, self.flag)
        host, self.port = listener.getsockname()[:2]
        name = f"{self.flag}-viewers" if may_only_read else self.flag
        endpoint = f"{name}/{f'[{host}]' if ':' in host else host}:{self.port}"
        self.endpoints = (endpoint,)
        if not is_loopback(host):
            logger.warning(
                "everyone who reaches %s can %s, unasked: the ZeroMQ remote API has no password "
                "and no certificate; listen on 127.0.0.1 and let others in through an SSH tunnel (docs/zmq.md)",
                endpoint,
                "read everything" if may_only_read else "do all that a client can",
            )
        self._by_number: dict[int, SocketPeer] = {}
        """The open connections by number."""

        self._of_client: dict[str, set[int]] = {}
        """Numbers of the open connections of a client."""

        self._next_number = 1
        self._clients = self._make_clients(service, endpoint, may_only_read=may_only_read)
        self._farewell_ends = 0.0
        super().__init__(service, [listener], logger, endpoint)

    def _make_clients(self, service: Service, endpoint: str, *, may_only_read: bool) -> ZmqClients:
        """Return the empty list of the clients."""
        return ZmqClients(
            service,
            self._by_number,
            self.answer,
            first_handle=FIRST_HANDLE + may_only_read * VIEWERS,
            gateway=endpoint,
        )

    def answer(self, to: Peer, value: Any) -> None:
        """Send a message to a connection, if it is still open. Raises what writing the value raises."""
        payload = self._pack(value)
        peer = self._by_number.get(to.number)
        if peer is None:
            return
        peer.count_answered()
        peer.send(payload)
        peer.answered = time.perf_counter()
        if peer.is_quick:
            self._service.queue.open_sockets().expect()
        if peer.unsent:
            self._await_reader(peer)

    def close(self) -> None:
        """Answer the calls that wait, and stop listening. No thread runs the server loop meanwhile."""
        if not self._is_open:
            return
        for peer in list(self._peers):
            if peer.unanswered:
                self.answer(peer, self._farewell(peer))
        self._farewell_ends = time.monotonic() + FAREWELL
        super().close()
        self._service.watchers.remove(self._clients)

    def _farewell(self, peer: SocketPeer) -> Mapping[str, Any]:
        """Return the answer to the calls that wait when the server ends."""
        return {"err": "the server ends"}

    # --- connections -----------------------------------------------------------------------------

    def _admit(self, connected: socket.socket, listener: socket.socket, address: Any) -> SocketPeer:
        _set_up(connected)
        longest = min(MAX_MESSAGE, self._service.simulation.limits.message)
        peer = SocketPeer(connected, self._next_number, longest, self._service.unfinished)
        self._next_number += 1
        self._by_number[peer.number] = peer
        self._service.queue.open_sockets().add(connected, partial(self._read, peer))
        if peer.unsent:
            self._await_reader(peer)
        return peer

    def _refuse(self, listener: socket.socket, address: Any) -> None:
        text = (
            "a connection of the ZeroMQ remote API is refused: at most %d are served, and %d of one machine"
        )
        self._log.say(logging.INFO, text, MOST_CONNECTIONS, MOST_OF_ONE)

    def _crowd(self, host: str) -> Sequence[SocketPeer]:
        if is_elsewhere(host):
            of_one = [peer for peer in self._peers if peer.address == host]
            if len(of_one) >= MOST_OF_ONE:
                return of_one
        return list(self._peers) if len(self._peers) >= MOST_CONNECTIONS else ()

    def _dispensable(self, crowd: Sequence[SocketPeer]) -> SocketPeer | None:
        """Return an idle connection of the client with most."""
        numbers = max((self._of_client[peer.key] for peer in crowd), key=len)
        idle = [self._by_number[number] for number in numbers if not self._by_number[number].unanswered]
        return min(idle, key=attrgetter("answered")) if idle and len(numbers) > 1 else None

    def look(self) -> None:
        """Check connections and clients; answer the calls that a crash has lost."""
        super().look()
        if (returning := self._service.returning).is_early:
            self._answer_lost_calls(returning.text, time.monotonic() - QUIET)

    def _check(self, now: float) -> None:
        super()._check(now)
        for key in self._clients.steppers():
            self._look_for_life(key)

    def _is_silent(self, peer: SocketPeer) -> bool:
        return not peer.is_ready

    def _answer_lost_calls(self, text: str, before: float) -> None:
        """Send an error to the peers that have been here since before a time and have sent nothing.

        A socket of ZeroMQ reconnects automatically, but it never repeats a request whose answer is lost: its program
        would wait for ever. A socket that does not wait drops the answer when it sends its next request, so all
        silent peers get one: which of them had a call is not known, as its first call may have crashed the server.
        """
        for peer in list(self._peers):
            if peer.is_ready and not peer.key and not peer.was_told and peer.since < before:
                peer.was_told = True
                self.answer(peer, {"err": text})

    def _look_for_life(self, key: str) -> None:
        """Ping a client for which the simulation waits; end its stepped mode if it does not answer."""
        peers = [self._by_number[number] for number in self._of_client.get(key, ())]
        for peer in peers:
            peer.silent_looks += 1
        if all(peer.answers_pings and peer.silent_looks > FROZEN / RETRY for peer in peers):
            self._service.clients.end_stepping(key, f"nothing was heard of it for {FROZEN:g} s")
            return
        for peer in peers:
            if peer.answers_pings and peer.silent_looks > 1:
                was_idle = not peer.unsent
                try:
                    peer.ping()
                except OSError:
                    self._lose(peer)
                else:
                    if peer.unsent and was_idle:
                        self._await_reader(peer)

    def _read(self, peer: SocketPeer) -> None:
        """Queue the messages that have arrived at a connection."""
        try:
            for payload in peer.receive():
                self._sort(peer, payload)
            if peer.unsent:
                self._await_reader(peer)
        except BadPeer as problem:
            self._cut(peer, str(problem))
        except OSError:
            self._lose(peer)

    def _await_reader(self, peer: SocketPeer) -> None:
        """Read nothing of a peer until it has taken what is left for it."""
        if not peer.is_gone:
            self._service.queue.open_sockets().change(
                peer.socket, partial(self._go_on_sending, peer), to_send=True
            )

    def _go_on_sending(self, peer: SocketPeer) -> None:
        try:
            peer.flush()
        except OSError:
            self._lose(peer)
            return
        if not peer.unsent:
            self._service.queue.open_sockets().change(peer.socket, partial(self._read, peer), to_send=False)

    def _cut(self, peer: SocketPeer, why: str) -> None:
        """Close a connection whose peer breaks the rules."""
        peer.problem = why
        self._lose(peer)

    def _lose(self, peer: SocketPeer) -> None:
        """Forget a connection that has ended; its client leaves with its last one."""
        if peer.problem:
            self._log.say(logging.INFO, "a connection of the ZeroMQ remote API is closed: %s", peer.problem)
        self._forget(peer)
        if (nested := peer.nested) is not None:
            nested.append(None)
        numbers = self._of_client.get(peer.key)
        if numbers is not None:
            numbers.discard(peer.number)
            if not numbers:
                del self._of_client[peer.key]
                self._clients.part_from(peer.key)

    def _end(self, peer: SocketPeer) -> None:
        peer.finish(self._farewell_ends)
        self._forget(peer)

    def _forget(self, peer: SocketPeer) -> None:
        peer.is_gone = True
        del self._peers[peer], self._by_number[peer.number]
        self._service.queue.open_sockets().remove(peer.socket)
        peer.end()

    # --- messages --------------------------------------------------------------------------------

    def _sort(self, peer: SocketPeer, payload: bytes) -> None:
        """Put a message where it is waited for. Raises BadPeer: there are too many."""
        peer.unanswered += 1
        peer.is_quick = time.perf_counter() - peer.answered < LOOK
        if peer.unanswered > MOST_UNANSWERED:
            raise BadPeer("a client sends on without reading answers")
        if peer.nested is not None:
            peer.nested.append(payload)
        else:
            self._deliver(peer, payload)

    def _deliver(self, peer: SocketPeer, payload: bytes) -> None:
        """Queue a message for the physics thread, behind the others of its client."""
        if not peer.key:
            if peer.sends_alone:
                self.answer(peer, _API_2)
                return
            uuid = uuid_of(payload)
            if not uuid:
                self.answer(peer, _OLD)
                return
            if not _UUID.fullmatch(uuid):
                self.answer(peer, {"err": "uuid must be letters, digits, dots and dashes"})
                return
            peer.key = f"{self._prefix}zmq/{uuid}"
            self._of_client.setdefault(peer.key, set()).add(peer.number)
        self._submit(peer, payload)

    def _submit(self, peer: SocketPeer, payload: bytes) -> None:
        """Queue a message of a peer that has a client, or answer that it cannot be queued."""
        if refusal := self._clients.welcome(peer, payload, self.port):
            self.answer(peer, self._refusal(payload, refusal))
            return
        work, queue = self._clients.work(peer.number, payload), self._service.queue
        if queue.hand_over(peer.key, work):
            return
        if work.size > _LARGE and (reached := queue.limit_reached(peer.key, work.size)):
            limits = self._service.simulation.limits
            text = str(limits.reached(reached, "wait for answers now and then"))
            self.answer(peer, self._refusal(payload, {"err": text}))
        else:
            queue.submit(peer.key, work)

    def _refusal(self, payload: bytes, text: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return the answer that refuses a message."""
        return text


def _listen(address: str, flag: str) -> socket.socket:
    """Return a socket that listens and does not block. Raises GatewayError."""
    host, _, port = address.rpartition(":")
    host = host.strip("[]")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, int(port)), family=family, backlog=BACKLOG)
    except OSError as error:
        advice = "perhaps by a CoppeliaSim; " if error.errno == errno.EADDRINUSE else ""
        raise GatewayError(
            f"--{flag} cannot listen on {address} ({error.strerror}), {advice}choose another port with --{flag} N "
            "(0 finds a free one)"
        ) from None


def _set_up(connected: socket.socket) -> None:
    """Set the options of a connection. Raises OSError: the peer has left."""
    connected.setblocking(False)
    connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _KEEPALIVE.items():
        if (option := getattr(socket, name, None)) is not None:
            connected.setsockopt(socket.IPPROTO_TCP, option, value)
