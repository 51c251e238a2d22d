"""The socket of the ZeroMQ remote API, which the physics thread reads while it waits.

A ROUTER socket serves the REQ sockets of all clients, and lets an answer wait until a simulation step is over. ZeroMQ's
own thread receives and sends; its descriptor announces news once only, so everything is read before a wait.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import socket
import time
from typing import TYPE_CHECKING, Any

from simx_client.protocol.cli.installing import extra_line

from ..errors import GatewayError
from ..exposure import is_loopback
from .clients import ZmqClients
from .peer import NUMBER_BYTES, Peer
from .peers import Peers
from .wire import MAX_MESSAGE, packer, uuid_of

if TYPE_CHECKING:
    from simx_server.runtime.server_loop import ServerLoop

logger = logging.getLogger(__name__)

MISSING = (
    "--zmq needs the packages pyzmq and cbor2, and {missing} is missing; install them with: {line}, or start "
    "without --zmq"
)

MOST_UNANSWERED = 16
"""Messages of one connection that wait for an answer. A correct client sends the next after an answer; a connection
with more is closed.
"""

MOST_CONNECTIONS = 1024
"""A client with many calls at a time has one connection for each; further ones are closed."""

FAREWELL = 500
"""Milliseconds for the last answers when the server ends."""

_LARGE = 1 << 16
"""Bytes from which a message may meet a limit: of smaller ones, too few can wait for an answer."""

_BUFFERED = 4
"""Messages that ZeroMQ keeps for a connection each way; a correct client has one."""

_HEARING = 0.05
"""Seconds between two looks at the monitor while the server does not wait."""

_AT_A_TIME = 1000
"""Most messages to read before the physics thread does something else; it comes back before it waits."""

_UUID = re.compile(r"[A-Za-z0-9_.{}-]+")

_OLD = {
    "success": False,
    "error": "this client speaks the first version of the ZeroMQ remote API, and the server the second: "
    "upgrade its package, coppeliasim-zmqremoteapi-client, with pip",
}


def missing() -> str:
    """Return what to install, if a package is missing; else an empty text."""
    for name in ("zmq", "cbor2"):
        try:
            __import__(name)
        except ImportError:
            return MISSING.format(missing={"zmq": "pyzmq"}.get(name, name), line=extra_line("zmq"))
    return ""


class ZmqGateway:
    """Serves one server loop to clients of the ZeroMQ remote API."""

    def __init__(self, loop: ServerLoop, address: str) -> None:
        """Listen, and have the server loop read. Physics thread, or before it runs.

        Args:
            address: ``HOST:PORT``; port 0 is a free one.

        Raises:
            GatewayError: a package is missing, or the address cannot be used.
        """
        if problem := missing():
            raise GatewayError(problem)
        import zmq

        self._zmq, self._loop = zmq, loop
        self._pack = packer()
        self._context = zmq.Context()
        self._socket = self._bound(address)
        host, _, port = self._socket.getsockopt_string(zmq.LAST_ENDPOINT).rpartition(":")
        self.port = int(port)
        self.endpoint = f"zmq/{host.rpartition('/')[2]}:{port}"
        if not is_loopback(host.rpartition("/")[2].strip("[]")):
            logger.warning(
                "everyone who reaches %s can do all that a client can, unasked: the ZeroMQ remote API has no password "
                "and no certificate; listen on 127.0.0.1 and let others in through an SSH tunnel (docs/zmq.md)",
                self.endpoint,
            )
        self._monitor = self._socket.get_monitor_socket(zmq.Event.ACCEPTED | zmq.Event.DISCONNECTED)
        self._peers = Peers()
        self._by_identity: dict[bytes, Peer] = {}
        self._by_number: dict[int, Peer] = {}
        self._of_client: dict[str, set[int]] = {}
        """Numbers of the open connections of a client."""

        self._next_number = 1
        self._clients = ZmqClients(loop, self.port, self._by_number, self.answer)
        loop.simulation.attach(self._clients)
        self._files = (self._socket.FD, self._monitor.FD)
        self._next_hearing = 0.0
        """When the monitor is read, on the monotonic clock."""

        loop.sockets.add(zip(self._files, (lambda: None, self._hear), strict=True), self._fetch)

    def _bound(self, address: str) -> Any:
        zmq = self._zmq
        host, _, port = address.rpartition(":")
        bound = self._context.socket(zmq.ROUTER)
        limit = min(MAX_MESSAGE, self._loop.simulation.limits.message)
        options = {
            zmq.MAXMSGSIZE: limit,
            zmq.LINGER: FAREWELL,
            zmq.RCVHWM: _BUFFERED,  # ZeroMQ reads no further from a connection with that much unread
            zmq.SNDHWM: _BUFFERED,  # answers beyond are dropped: their client does not read
            zmq.TCP_KEEPALIVE: 1,  # finds out that a machine has gone without a word
            zmq.TCP_KEEPALIVE_IDLE: 10,
            zmq.TCP_KEEPALIVE_INTVL: 5,
            zmq.TCP_KEEPALIVE_CNT: 3,
            zmq.IPV6: int(":" in host),
        }
        for option, value in options.items():
            bound.setsockopt(option, value)
        try:
            bound.bind(f"tcp://{host}:{port}")
        except zmq.ZMQError as error:
            bound.close()
            self._context.term()
            advice = "perhaps by a CoppeliaSim; " if error.errno == zmq.EADDRINUSE else ""
            raise GatewayError(
                f"--zmq cannot listen on {address} ({error.strerror}), {advice}choose another port with --zmq N "
                "(0 finds a free one)"
            ) from None
        return bound

    def answer(self, peer: Peer, value: Any) -> None:
        """Send a message to a connection, if it is still open. Raises what writing the value raises."""
        payload = self._pack(value)
        if peer.is_gone or self._socket.closed:
            return
        peer.unanswered = max(0, peer.unanswered - 1)
        with contextlib.suppress(self._zmq.ZMQError):  # it has just gone
            self._socket.send_multipart((peer.identity, b"", payload), self._zmq.NOBLOCK)

    def close(self) -> None:
        """Answer the calls that wait, and stop listening. No thread runs the server loop meanwhile."""
        for peer in list(self._by_identity.values()):
            if peer.unanswered:
                self.answer(peer, {"err": "the server ends"})
        self._loop.sockets.remove(self._files, self._fetch)
        self._loop.simulation.detach(self._clients)
        self._socket.disable_monitor()
        self._monitor.close(0)
        self._socket.close()
        self._context.term()

    # --- reading ---------------------------------------------------------------------------------

    def _fetch(self, everything: bool) -> None:
        """Read what has arrived, and queue it behind the other messages of each client."""
        if (now := time.monotonic()) > self._next_hearing:
            self._next_hearing = now + _HEARING
            self._hear()
        for _ in range(_AT_A_TIME if everything else 1):
            taken = self._take()
            if taken is None:
                # After the messages: those of a closed connection are read by now.
                for identity in self._peers.gone():
                    self._lose(identity)
                return
            self._sort(*taken)

    def _hear(self) -> None:
        """Read what the monitor reports."""
        while self._monitor.get(self._zmq.EVENTS) & self._zmq.POLLIN:
            event, _ = self._monitor.recv_multipart(self._zmq.NOBLOCK)
            kind, descriptor = int.from_bytes(event[:2], "little"), int.from_bytes(event[2:6], "little")
            if kind == self._zmq.Event.ACCEPTED:
                self._peers.accepted(descriptor)
                if len(self._peers.open) > MOST_CONNECTIONS:
                    self._cut(descriptor, f"at most {MOST_CONNECTIONS} connections are served")
            elif kind == self._zmq.Event.DISCONNECTED:
                self._peers.disconnected(descriptor)

    def _take(self) -> tuple[Peer, list[bytes]] | None:
        """Return the frames of the next message and their sender; None if there is none."""
        zmq, bound = self._zmq, self._socket
        if not bound.get(zmq.EVENTS) & zmq.POLLIN:
            return None
        identity = bound.recv(zmq.NOBLOCK)
        peer = self._by_identity.get(identity) or self._meet(identity)
        frame = bound.recv(zmq.NOBLOCK, copy=False)
        frames = [frame.bytes]
        is_first = peer.descriptor is None
        if is_first:
            peer.descriptor = frame.get(zmq.SRCFD)
        while frame.more:
            frame = bound.recv(zmq.NOBLOCK, copy=False)
            frames.append(frame.bytes)
        peer.unanswered += 1
        if is_first:
            self._hear()  # the report of its acceptance comes before its first message
            self._peers.seen(frame.get(zmq.SRCFD), identity)
        return peer, frames

    def _meet(self, identity: bytes) -> Peer:
        """Return a connection that sends its first message."""
        peer = Peer(identity, self._next_number)
        self._next_number += 1
        self._by_identity[identity] = self._by_number[peer.number] = peer
        return peer

    def _sort(self, peer: Peer, frames: list[bytes]) -> None:
        """Queue a message where it is waited for, unless its sender breaks the rules."""
        if peer.is_cut:
            return
        if len(frames) != 2 or frames[0]:
            peer.is_cut = True
            self._cut(peer.descriptor, "a message has other frames than a client's")
        elif peer.unanswered > MOST_UNANSWERED:
            peer.is_cut = True
            self._cut(peer.descriptor, "a client sends on without reading answers")
        elif peer.nested is not None:
            peer.nested.append(frames[1])
        else:
            self._deliver(peer, frames[1])

    def _deliver(self, peer: Peer, payload: bytes) -> None:
        """Queue a message for the physics thread, behind the others of its client."""
        if not peer.key:
            uuid = uuid_of(payload)
            if not uuid:
                self.answer(peer, _OLD)
                return
            if not _UUID.fullmatch(uuid):
                self.answer(peer, {"err": "uuid must be letters, digits, dots and dashes"})
                return
            peer.key = f"zmq-{uuid}"
            self._of_client.setdefault(peer.key, set()).add(peer.number)
        if refusal := self._clients.welcome(peer.key, payload):
            self.answer(peer, refusal)
            return
        numbered = peer.number.to_bytes(NUMBER_BYTES, "big") + payload
        is_large = len(numbered) > _LARGE
        if is_large and (problem := self._loop.limit_reached(peer.key, len(numbered))):
            self.answer(peer, {"err": problem})
        else:
            self._loop.submit(peer.key, numbered)

    def _lose(self, identity: bytes) -> None:
        """Forget a connection that is closed; its client leaves with its last one."""
        peer = self._by_identity.pop(identity, None)
        if peer is None:
            return
        self._by_number.pop(peer.number, None)
        peer.is_gone = True
        if (nested := peer.nested) is not None:
            nested.append(None)
        numbers = self._of_client.get(peer.key)
        if numbers is not None:
            numbers.discard(peer.number)
            if not numbers:
                del self._of_client[peer.key]
                self._clients.part_from(peer.key)

    def _cut(self, descriptor: int | None, why: str) -> None:
        """Close a connection; ZeroMQ itself has no call for that."""
        if descriptor is None:
            return
        logger.info("a connection of the ZeroMQ remote API is closed: %s", why)
        with contextlib.suppress(OSError), socket.socket(fileno=os.dup(descriptor)) as twin:
            if twin.getsockname()[1] == self.port:
                twin.shutdown(socket.SHUT_RDWR)
