"""The socket for clients of the same user on this host, which the physics thread reads while it waits.

A client greets over Zenoh and gets an offer in its welcome. With its token it connects here. It leaves when its
connection ends, as it does when its link over Zenoh ends.
"""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import socket
import threading
import time
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING

from simx_client.protocol.codec import MAX_BATCH
from simx_client.protocol.lane.frames import MESSAGE, BadFrame, Frames
from simx_client.protocol.lane.offer import Offer, is_same_user, made_folder, new_name, new_token, path_of
from simx_server.gateways.outsider_log import OutsiderLog
from simx_server.service.clients.admission.unfinished import Unfinished

from .link import LocalLink

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import Link
    from simx_server.service.server_loop import ServerLoop

logger = logging.getLogger(__name__)

MOST_STRANGERS = 64
"""Connections that have not shown a token yet; of more, the one that came first is closed."""

SILENCE = 10.0
"""Seconds that a connection has for its token."""

BACKLOG = 128
"""Connections that the system keeps until they are accepted."""

RETRY = 1.0
"""Seconds until the socket accepts again when no file descriptor was free."""

TOKEN_FRAME = 64
"""Maximum size of the first message in bytes."""

_AT_ONCE = int(getattr(socket, "MSG_DONTWAIT", 0))
_READ, _MOST_READ = 1 << 16, 1 << 20
"""Minimum and maximum number of bytes to read at a time: the physics thread does other things in between."""


class LocalGateway:
    """Serves clients that the Zenoh gateway has accepted. Physics thread, except `read_while_busy`."""

    def __init__(self, loop: ServerLoop) -> None:
        """Listen. Raises OSError: no socket can be made."""
        self._loop = loop
        self._log = OutsiderLog(logger)
        folder = made_folder()
        _remove_dead(folder)
        self._name = new_name()
        self.path = path_of(folder, self._name)
        self._listener = _listen(folder, self.path)
        self._offers: dict[str, tuple[str, Link]] = {}
        """Client and its link over Zenoh, by token."""

        self._tokens: dict[str, str] = {}
        """Token by client."""

        self._peers: set[_Peer] = set()
        self._reading = threading.Lock()
        """Lock of the connections' frames: another thread reads them while the physics thread is busy."""

        self._accepts_at = 0.0
        """When to accept again; 0 while it accepts."""

        loop.sockets.add(self._listener, self._accept)
        loop.watches.append(self._look)
        loop.readers_while_busy.append(self.read_while_busy)

    # --- greetings, see gateways/zenoh.py ----------------------------------------------------------

    def offer(self, client: str, link: Link) -> None:
        """Make an offer for a client that joins.

        Args:
            link: its link over Zenoh.
        """
        for gone in [each for each in self._tokens if each not in self._loop.sessions]:
            del self._offers[self._tokens.pop(gone)]
        self._revoke(client)
        token = self._tokens[client] = new_token()
        self._offers[token] = client, link

    def offer_to(self, client: str) -> str:
        """Return the offer in a client's welcome; empty for a client that has not joined."""
        token = self._tokens.get(client)
        return "" if token is None else str(Offer(token, self._name))

    def serves(self, client: str) -> bool:
        """Return whether a client uses its offer."""
        session = self._loop.sessions.get(client)
        return session is not None and isinstance(session.link, LocalLink)

    def _revoke(self, client: str) -> None:
        if (token := self._tokens.pop(client, None)) is not None:
            del self._offers[token]

    # --- connections -----------------------------------------------------------------------------

    def close(self) -> None:
        """Close the connections and the socket. Idempotent."""
        for peer in list(self._peers):
            self._drop(peer)
        if self._listener.fileno() == -1:
            return
        if not self._accepts_at:
            self._loop.sockets.remove(self._listener)
        self._listener.close()
        with contextlib.suppress(OSError):
            os.unlink(self.path)
        self._loop.watches.remove(self._look)
        self._loop.readers_while_busy.remove(self.read_while_busy)

    def _accept(self) -> None:
        try:
            connected, _ = self._listener.accept()
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE):
                self._accepts_at = time.monotonic() + RETRY
                self._loop.sockets.remove(self._listener)
            return
        try:
            if not is_same_user(connected):
                problem = "it comes from another user"
                self._log.say(logging.WARNING, "a connection at %s is closed: %s", self.path, problem)
                connected.close()
                return
        except OSError:  # it has left already
            connected.close()
            return
        strangers = [each for each in self._peers if each.link is None]
        if len(strangers) >= MOST_STRANGERS:
            longest = min(strangers, key=attrgetter("since"))
            longest.problem = "it has no token yet, and others need its place"
            self._settle(longest)
        peer = _Peer(connected, self._loop.unfinished)
        self._peers.add(peer)
        self._listen_to(peer)

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
                if kind == MESSAGE and self._loop.hand_over(peer.client, payload):
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
                peer.problem = "it sends memory"
                return
            self._loop.submit(peer.client, payload)

    def _settle(self, peer: _Peer) -> None:
        """Close a connection that has ended; let one rest whose client has much waiting."""
        if peer.problem or (peer.has_ended and not peer.frames.whole):
            if peer.problem:
                self._log.say(logging.WARNING, "a connection at %s is closed: %s", self.path, peer.problem)
            self._drop(peer)
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
        _, token = peer.frames.whole.popleft()
        client, zenoh = self._offers.get(token.decode("ascii", "replace"), ("", None))
        if zenoh is None or client not in self._loop.sessions:
            peer.problem = "it has no valid token"
            return
        try:
            link = LocalLink(self._loop, client, peer.socket, zenoh, partial(self._forget, peer))
        except OSError as problem:
            peer.problem = f"there is no memory for its client: {problem}"
        else:
            peer.begin(client, link)

    def _use(self, peer: _Peer, link: LocalLink) -> None:
        """Make this the only link to a client, which has chosen it with its first batch."""
        session = self._loop.sessions.get(peer.client)
        if session is None or isinstance(session.link, LocalLink):
            peer.problem = "its client has left, or uses another connection"
        else:
            session.link = link
            peer.is_used = link.is_used = True

    def read_while_busy(self) -> None:
        """Queue what has arrived while the physics thread is busy, so that the calls can be refused in time.

        Another thread; the physics thread closes connections itself, later.
        """
        for peer in list(self._peers):
            if peer.is_used and not peer.is_resting:
                with self._reading:
                    peer.receive()
                    self._queue(peer)

    def _look(self) -> None:
        """Close connections without a token and those that have ended; accept again."""
        now = time.monotonic()
        for peer in list(self._peers):
            if peer.link is None and now > peer.since + SILENCE:
                peer.problem = f"it has sent no token within {SILENCE:g} s"
            if peer.problem or peer.has_ended:
                self._settle(peer)
        if self._accepts_at and now >= self._accepts_at:
            self._accepts_at = 0.0
            self._loop.sockets.add(self._listener, self._accept)

    def _drop(self, peer: _Peer) -> None:
        """Close a connection; its client leaves after everything that it has sent is executed."""
        link = peer.link
        if link is None:
            self._forget(peer)
            peer.socket.close()
            return
        if peer.is_used:
            self._loop.depart(peer.client)
        link.close()

    def _forget(self, peer: _Peer) -> None:
        """Read a connection no more, which is about to be closed."""
        self._peers.remove(peer)
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
        self.link: LocalLink | None = None
        """None before a valid token."""

        self.is_used = False
        """Its client has sent a batch by it."""

        self.problem = ""
        """Why to close it."""

        self.has_ended = False
        self.is_resting = False
        """It is not read, because much of its client waits."""

    def begin(self, client: str, link: LocalLink) -> None:
        """Read batches of a client from now on."""
        self.client, self.link = client, link
        self.frames.longest = MAX_BATCH

    def receive(self) -> None:
        """Read some of what has arrived. Under the gateway's lock."""
        if self.has_ended or self.problem:
            return
        missing = self.frames.missing
        try:
            data = self.socket.recv(min(missing, _MOST_READ) if missing > _READ else _READ, _AT_ONCE)
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
        self.link = None


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
