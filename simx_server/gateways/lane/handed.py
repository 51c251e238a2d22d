"""Connections of the lane that are handed to one process, which needs neither a network nor a path for them.

The process has one end of a socket pair. For each request there it gets a connection, greets by it, and calls as any
client. So a program can be confined to a simulation: it has this socket, and can open no other one.
"""

from __future__ import annotations

import logging
import socket
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from simx_client.protocol.codec import CodecError, decode_greeting, encode
from simx_client.protocol.lane.frames import frame, send_with_file
from simx_client.protocol.lane.handed import REQUEST
from simx_client.protocol.messages import (
    OLDEST_PROTOCOL,
    PROTOCOL_VERSION,
    Welcome,
    choose_version,
    no_common_version,
)
from simx_server import __version__
from simx_server.limits import LimitReached
from simx_server.service.answers.link import Link

from .link import EitherLink, LaneLink
from .peers import LanePeer, LanePeers

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

MOST_AT_ONCE = 8
"""Connections of a process at the same time."""

SILENCE = 10.0
"""Seconds that a connection has for its greeting."""

_AT_ONCE = int(getattr(socket, "MSG_DONTWAIT", 0))


class HandedLanes(LanePeers):
    """Hands connections to the process at the other end of a socket."""

    silence = SILENCE
    unsaid = "it has sent no greeting"
    crowded = "it has not greeted yet, and another one needs its place"
    first_frame = 4096

    def __init__(
        self,
        service: Service,
        door: socket.socket,
        name: str,
        joined: Callable[[ClientSession], object] = lambda _session: None,
    ) -> None:
        """Hand out connections from now on.

        Args:
            door: this end of a pair of sockets that keep messages apart (``SOCK_SEQPACKET``).
            name: clients are called by it and a number, whatever they greet with.
            joined: called with each new client before its first call.
        """
        self._door, self._name, self._joined = door, name, joined
        self._greeted = 0
        self.path = f"the socket of {name}"
        super().__init__(service, (), logger)
        door.setblocking(False)
        service.queue.open_sockets().add(door, self._hand_out)

    def close(self) -> None:
        """Close the connections and the socket. Idempotent."""
        if self._is_open:
            self._close_door()
        super().close()

    def _close_door(self) -> None:
        if self._door.fileno() >= 0:
            self._service.queue.open_sockets().remove(self._door)
            self._door.close()

    def _hand_out(self) -> None:
        """Answer a request with one end of a new connection."""
        try:
            request = self._door.recv(len(REQUEST) + 1)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            request = b""
        if not request:  # the process has ended
            self._close_door()
            return
        if request != REQUEST or not self._has_room(""):
            self._say_closed("it asks for too many connections, or for something else")
            return
        try:
            here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        except OSError as problem:
            self._say_closed(f"no connection could be made: {problem}")
            return
        with there:
            self._peers[self._admit(here, self._door, None)] = None
            try:
                send_with_file(self._door, REQUEST, there.fileno(), _AT_ONCE)
            except OSError:  # the process does not read; its end closes, and so this one is forgotten
                logger.debug("%s takes no connection", self._name)

    def _crowd(self, host: str) -> Sequence[LanePeer]:
        return list(self._peers) if len(self._peers) >= MOST_AT_ONCE else ()

    def _introduce(self, peer: LanePeer) -> None:
        """Take the greeting of a connection, and answer it."""
        _, payload = peer.frames.whole.popleft()
        try:
            greeting = decode_greeting(payload)
        except CodecError as problem:
            peer.problem = f"its greeting cannot be read: {problem}"
            return
        spoken_there, spoken_here = (greeting.protocol, greeting.newest), (OLDEST_PROTOCOL, PROTOCOL_VERSION)
        version = choose_version(spoken_there, spoken_here)
        if version is None:
            self._answer(peer, PROTOCOL_VERSION, no_common_version(spoken_there, spoken_here))
            return
        self._greeted += 1
        client = f"{self._name}-{self._greeted}"
        guest = EitherLink(client, "", Link(), bool)  # replies follow calls, which come by the lane
        try:
            session = self._service.clients.join(client, greeting.name, greeting.port, guest)
        except LimitReached as problem:
            self._answer(peer, version, str(problem))
            return
        self._joined(session)
        self._answer(peer, version, "")
        forget = partial(self._forget, peer)
        try:
            link = LaneLink(self._service, client, peer.socket, guest.first, forget, takes_files=True)
        except OSError as problem:
            peer.problem = f"there is no memory for its client: {problem}"
            self._service.clients.depart(client)
        else:
            peer.begin(guest, link)

    def _answer(self, peer: LanePeer, version: int, refusal: str) -> None:
        scene = self._service.simulation.scene.name
        welcome = encode(Welcome(version, refusal, self._name, scene, __version__, ""))
        try:
            peer.socket.send(frame(welcome), _AT_ONCE)
        except OSError:
            peer.problem = "it does not read"
        if refusal:
            peer.problem = refusal
