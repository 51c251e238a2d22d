"""Connections of the lane as they are read: what arrives becomes batches, in bounds.

The gateway knows to whom a connection belongs, and reads its first frame.
"""

from __future__ import annotations

import logging
import socket
import threading
import time
from abc import abstractmethod
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_client.protocol.codec import MAX_BATCH
from simx_client.protocol.lane.frames import MESSAGE, BadFrame, Frames
from simx_server.gateways.listening import READ, Listening, part
from simx_server.service.calls.work import BatchWork
from simx_server.service.clients.admission.unfinished import Unfinished

from .link import EitherLink, LaneLink

if TYPE_CHECKING:
    from collections.abc import Sequence

    from simx_server.service.service import Service

FIRST_FRAME = 64
"""Maximum size of the first message in bytes, unless a gateway takes longer ones."""

_AT_ONCE = int(getattr(socket, "MSG_DONTWAIT", 0))


class LanePeers(Listening["LanePeer"]):
    """Reads the connections of a lane. Physics thread, except where a method says so."""

    path: str
    """Name of the lane in its log."""

    first_frame: int = FIRST_FRAME
    """Maximum size of the first message in bytes."""

    def __init__(self, service: Service, listeners: Sequence[socket.socket], log: logging.Logger) -> None:
        self._reading = threading.Lock()
        """Lock of the connections' frames: another thread reads them while the physics thread is busy."""

        super().__init__(service, listeners, log)

    @abstractmethod
    def _introduce(self, peer: LanePeer) -> None:
        """Take the first frame of a connection: start it, or set its problem."""

    def _admit(self, connected: socket.socket, listener: socket.socket, address: Any) -> LanePeer:
        peer = LanePeer(connected, self._service.unfinished, self.first_frame)
        self._listen_to(peer)
        return peer

    def _cut(self, peer: LanePeer, why: str) -> None:
        peer.problem = why
        self._settle(peer)

    def _say_closed(self, why: str) -> None:
        self._log.say(logging.WARNING, "a connection at %s is closed: %s", self.path, why)

    def _listen_to(self, peer: LanePeer) -> None:
        peer.is_resting = False
        self._service.queue.open_sockets().add(peer.socket, partial(self._read, peer))

    def _read(self, peer: LanePeer) -> None:
        """Read some of what has arrived, and queue it."""
        if peer not in self._peers:  # another connection's message has ended it meanwhile
            return
        with self._reading:
            peer.receive()
            if peer.is_used and (whole := peer.frames.whole):
                kind, payload = whole[0]
                if kind == MESSAGE and self._service.queue.hand_over(peer.client, BatchWork(payload)):
                    whole.popleft()
                if whole:
                    self._queue(peer)
        if peer.frames.whole and not peer.is_used:
            self._begin(peer)
        if peer.problem or peer.has_ended or peer.frames.whole:
            self._settle(peer)

    def _begin(self, peer: LanePeer) -> None:
        """Take the token, or the first batch, of a connection."""
        if peer.link is None:
            self._introduce(peer)
        if peer.link is not None and peer.frames.whole:
            self._use(peer, peer.link)
            if peer.is_used:
                with self._reading:
                    self._queue(peer)

    def _queue(self, peer: LanePeer) -> None:
        """Queue complete batches for the physics thread, unless too many wait. Any thread, under the lock."""
        whole = peer.frames.whole
        while whole and not self._service.queue.has_much(peer.client):
            kind, payload = whole.popleft()
            if kind != MESSAGE:
                peer.problem = "it sends memory or files"
                return
            self._service.queue.submit(peer.client, BatchWork(payload))

    def _settle(self, peer: LanePeer) -> None:
        """Close a connection that has ended; let one rest whose client has much waiting."""
        if peer.problem or (peer.has_ended and not peer.frames.whole):
            if peer.problem:
                self._say_closed(peer.problem)
            self._end(peer)
        elif peer.frames.whole and not peer.is_resting:
            peer.is_resting = True
            self._service.queue.open_sockets().remove(peer.socket)
            self._service.queue.put_last(peer.client, partial(self._go_on, peer))

    def _go_on(self, peer: LanePeer) -> None:
        """Read on, after the batches that were waiting are executed."""
        if peer in self._peers:
            self._listen_to(peer)
            self._read(peer)

    def _use(self, peer: LanePeer, link: LaneLink) -> None:
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

    def _end(self, peer: LanePeer) -> None:
        """Close a connection; its client leaves after everything that it has sent is executed."""
        link = peer.link
        if link is None:
            self._forget(peer)
            peer.socket.close()
            return
        if peer.is_used:
            self._service.clients.depart(peer.client)
        link.close()

    def _forget(self, peer: LanePeer) -> None:
        """Read a connection no more, which is about to be closed."""
        del self._peers[peer]
        if not peer.is_resting:
            self._service.queue.open_sockets().remove(peer.socket)
        with self._reading:
            peer.end()


class LanePeer:
    """A connection as it is read."""

    def __init__(self, connected: socket.socket, unfinished: Unfinished, first_frame: int) -> None:
        self.socket = connected
        self.frames = Frames(first_frame)
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
        frames, account = self.frames, self._unfinished
        try:
            missing = frames.missing
            data = self.socket.recv(part(missing) if missing else READ, _AT_ONCE)
            self.has_ended = not data
            count = frames.count
            frames.add(data)
            if (held := frames.held) or account.size:
                account.hold(held, is_new=frames.count > count)
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
