"""The socket for clients of the same user on this host, which the physics thread reads while it waits.

A client greets over Zenoh and gets an offer in its welcome. With its token it connects here. It leaves when its
connection ends, as it does when its link over Zenoh ends.
"""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import threading
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simx_client.protocol.codec import MAX_BATCH
from simx_client.protocol.lane.frames import FILE, MESSAGE, BadFrame, Frames
from simx_client.protocol.lane.offer import (
    Offer,
    is_possible,
    is_same_user,
    made_folder,
    new_name,
    new_token,
    path_of,
)
from simx_server.gateways.listening import Listening, part
from simx_server.gateways.zenoh.offers import Offers
from simx_server.service.calls.work import BatchWork
from simx_server.service.clients.admission.unfinished import Unfinished

from .link import EitherLink, LaneLink

if TYPE_CHECKING:
    from simx_server.gateways.gateway import Opening
    from simx_server.service.answers.link import Link, PackingLink
    from simx_server.service.server_loop import ServerLoop

logger = logging.getLogger(__name__)

MOST_STRANGERS = 64
"""Connections that have not shown a token yet; of more, the one that came first is closed."""

SILENCE = 10.0
"""Seconds that a connection has for its token."""

BACKLOG = 128
"""Connections that the system keeps until they are accepted."""

TOKEN_FRAME = 64
"""Maximum size of the first message in bytes."""

_AT_ONCE = int(getattr(socket, "MSG_DONTWAIT", 0))


def open_lane(opening: Opening) -> LaneGateway | None:
    """Open the lane, unless a configuration of Zenoh may have rules that it would pass by."""
    settings = opening.settings
    if not settings.local or settings.config is not None or not is_possible():
        return None
    try:
        return LaneGateway(opening.loop)
    except OSError as problem:
        logger.warning("clients on this host use Zenoh alone: no socket could be made: %s", problem)
        return None


class LaneGateway(Listening["_Peer"], Offers):
    """Serves clients that the Zenoh gateway has accepted."""

    silence = SILENCE
    unsaid = "it has sent no token"
    crowded = "it has no token yet, and others need its place"

    def __init__(self, loop: ServerLoop) -> None:
        """Listen. Raises OSError: no socket can be made."""
        folder = made_folder()
        _remove_dead(folder)
        self._name = new_name()
        self.path = path_of(folder, self._name)
        self._guests: dict[str, EitherLink] = {}
        """The links of the clients that have an offer, by token."""

        self._reading = threading.Lock()
        """Lock of the connections' frames: another thread reads them while the physics thread is busy."""

        super().__init__(loop, [_listen(folder, self.path)], logger)

    # --- greetings: Offers -------------------------------------------------------------------------

    def invite(self, client: str, link: PackingLink) -> Link:
        """Make an offer for a client that joins; return its link, which goes over to the lane with its first batch."""
        token = new_token()
        guest = EitherLink(client, token, link, partial(self._guests.pop, token, None))
        self._guests[token] = guest
        return guest

    def offer_to(self, client: str) -> str:
        """Return the offer in a client's welcome; empty for a client that has not joined."""
        guest = self._guest(client)
        return "" if guest is None else str(Offer(guest.token, self._name))

    def serves(self, client: str) -> bool:
        """Return whether a client uses its offer."""
        guest = self._guest(client)
        return guest is not None and guest.lane is not None

    def _guest(self, client: str) -> EitherLink | None:
        """Return the link of a client with an offer."""
        session = self._loop.sessions.get(client)
        return session.link if session is not None and isinstance(session.link, EitherLink) else None

    # --- connections -----------------------------------------------------------------------------

    def close(self) -> None:
        """Close the connections and the socket. Idempotent."""
        super().close()
        with contextlib.suppress(OSError):
            os.unlink(self.path)

    def _objection(self, connected: socket.socket) -> bool:
        if is_same_user(connected):
            return False
        self._say_closed("it comes from another user")
        return True

    def _crowd(self, host: str) -> Sequence[_Peer]:
        strangers = [each for each in self._peers if each.is_stranger]
        return strangers if len(strangers) >= MOST_STRANGERS else ()

    def _admit(self, connected: socket.socket, listener: socket.socket, address: Any) -> _Peer:
        peer = _Peer(connected, self._loop.unfinished)
        self._listen_to(peer)
        return peer

    def _cut(self, peer: _Peer, why: str) -> None:
        peer.problem = why
        self._settle(peer)

    def _say_closed(self, why: str) -> None:
        self._log.say(logging.WARNING, "a connection at %s is closed: %s", self.path, why)

    def _listen_to(self, peer: _Peer) -> None:
        peer.is_resting = False
        self._loop.sockets.add(peer.socket, partial(self._read, peer))

    def _read(self, peer: _Peer) -> None:
        """Read some of what has arrived, and queue it."""
        if peer not in self._peers:  # another connection's message has ended it meanwhile
            return
        with self._reading:
            peer.receive()
            if peer.is_used and peer.frames.whole:
                kind, payload = peer.frames.whole[0]
                if kind == MESSAGE and self._loop.hand_over(peer.client, BatchWork(payload)):
                    peer.frames.whole.popleft()
                self._queue(peer)
        if peer.frames.whole and not peer.is_used:
            self._begin(peer)
        if peer.problem or peer.has_ended or peer.frames.whole:
            self._settle(peer)

    def _begin(self, peer: _Peer) -> None:
        """Take the token, or the first batch, of a connection."""
        if peer.link is None:
            self._introduce(peer)
        if peer.link is not None and peer.frames.whole:
            self._use(peer, peer.link)
            if peer.is_used:
                with self._reading:
                    self._queue(peer)

    def _queue(self, peer: _Peer) -> None:
        """Queue complete batches for the physics thread, unless too many wait. Any thread, under the lock."""
        whole = peer.frames.whole
        while whole and not self._loop.has_much_waiting(peer.client):
            kind, payload = whole.popleft()
            if kind != MESSAGE:
                peer.problem = "it sends memory or files"
                return
            self._loop.submit(peer.client, BatchWork(payload))

    def _settle(self, peer: _Peer) -> None:
        """Close a connection that has ended; let one rest whose client has much waiting."""
        if peer.problem or (peer.has_ended and not peer.frames.whole):
            if peer.problem:
                self._say_closed(peer.problem)
            self._end(peer)
        elif peer.frames.whole and not peer.is_resting:
            peer.is_resting = True
            self._loop.sockets.remove(peer.socket)
            self._loop.post_behind(peer.client, partial(self._go_on, peer))

    def _go_on(self, peer: _Peer) -> None:
        """Read on, after the batches that were waiting are executed."""
        if peer in self._peers:
            self._listen_to(peer)
            self._read(peer)

    def _introduce(self, peer: _Peer) -> None:
        """Recognise a client by its token, and send it the memory of its values."""
        kind, token = peer.frames.whole.popleft()
        guest = self._guests.get(token.decode("ascii", "replace"))
        if guest is None:
            peer.problem = "it has no valid token"
            return
        forget = partial(self._forget, peer)
        try:
            link = LaneLink(
                self._loop, guest.client, peer.socket, guest.first, forget, takes_files=kind == FILE
            )
        except OSError as problem:
            peer.problem = f"there is no memory for its client: {problem}"
        else:
            peer.begin(guest, link)

    def _use(self, peer: _Peer, link: LaneLink) -> None:
        """Have the client's link go over to this connection, which the client has chosen with its first batch."""
        peer.is_used = peer.guest is not None and peer.guest.use(link)
        if not peer.is_used:
            peer.problem = "its client has left, or uses another connection"

    def read_while_busy(self) -> None:
        """Queue what has arrived while the physics thread is busy, so that the calls can be refused in time.

        Another thread; the physics thread closes connections itself, later.
        """
        for peer in list(self._peers):
            if peer.is_used and not peer.is_resting:
                with self._reading:
                    peer.receive()
                    self._queue(peer)

    def look(self) -> None:
        """Close connections without a token and those that have ended; accept again."""
        super().look()
        for peer in list(self._peers):
            if peer.problem or peer.has_ended:
                self._settle(peer)

    def _end(self, peer: _Peer) -> None:
        """Close a connection; its client leaves after everything that it has sent is executed."""
        link = peer.link
        if link is None:
            self._forget(peer)
            peer.socket.close()
            return
        if peer.is_used:
            self._loop.clients.depart(peer.client)
        link.close()

    def _forget(self, peer: _Peer) -> None:
        """Read a connection no more, which is about to be closed."""
        del self._peers[peer]
        if not peer.is_resting:
            self._loop.sockets.remove(peer.socket)
        with self._reading:
            peer.end()


class _Peer:
    """A connection as it is read."""

    def __init__(self, connected: socket.socket, unfinished: Unfinished) -> None:
        self.socket = connected
        self.frames = Frames(TOKEN_FRAME)
        self._unfinished = unfinished.holder(self.break_off)
        self.since = time.monotonic()
        self.client = ""
        self.guest: EitherLink | None = None
        self.link: LaneLink | None = None
        """None before a valid token, as the guest is."""

        self.is_used = False
        """Its client has sent a batch by it."""

        self.problem = ""
        """Why to close it."""

        self.has_ended = False
        self.is_resting = False
        """It is not read, because much of its client waits."""

    @property
    def is_stranger(self) -> bool:
        return self.link is None

    def begin(self, guest: EitherLink, link: LaneLink) -> None:
        """Read batches of a client from now on."""
        self.guest, self.client, self.link = guest, guest.client, link
        self.frames.longest = MAX_BATCH

    def receive(self) -> None:
        """Read some of what has arrived. Under the gateway's lock."""
        if self.has_ended or self.problem:
            return
        try:
            data = self.socket.recv(part(self.frames.missing), _AT_ONCE)
            self.has_ended = not data
            count = self.frames.count
            self.frames.add(data)
            self._unfinished.hold(self.frames.held, is_new=self.frames.count > count)
        except BlockingIOError:
            pass
        except BadFrame as problem:
            self.problem = str(problem)
        except OSError:
            self.has_ended = True

    def break_off(self, problem: str) -> None:
        """Have the physics thread close the connection, for a reason. Any thread."""
        self.problem = problem

    def end(self) -> None:
        """Keep nothing of a connection that is about to be closed: its link refers to it, and it to its link."""
        self._unfinished.end()
        self.has_ended = True
        self.frames = Frames()
        self.guest = self.link = None


def _listen(folder: Path, path: str) -> socket.socket:
    """Return a listening socket. It gets its name when it listens, so that no other server takes it for a dead one."""
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    early = str(folder / new_name())
    try:
        listener.setblocking(False)
        listener.bind(early)
        os.chmod(early, 0o600)
        listener.listen(BACKLOG)
        os.rename(early, path)
    except BaseException:
        listener.close()
        with contextlib.suppress(OSError):
            os.unlink(early)
        raise
    return listener


def _remove_dead(folder: Path) -> None:
    """Remove the sockets of servers that were killed."""
    for path in folder.glob("*.sock"):
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
            probe.setblocking(False)
            try:
                probe.connect(str(path))
            except ConnectionRefusedError:
                path.unlink()
