"""The short way in for clients of the same user on this host, see `simx_client.protocol.local`: the server's side.

A client comes over Zenoh and gets a token in its welcome. With it, it connects to a UNIX socket in a folder of this
user alone, which the physics thread reads itself: a call then needs one change of threads in each process, not three.
Liveliness, images of streams, and everything for other hosts stay with Zenoh.
"""

from __future__ import annotations

import contextlib
import logging
import os
import secrets
import shutil
import socket
import tempfile
import threading
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from simx_client.protocol.local import MAX_FRAME, READY, VALUES_SIZE, BadFrame, Frames, ValuesWriter, frame
from simx_server.runtime.sockets import LOOK

from .outsider_log import OutsiderLog
from .posting import MUCH_UNSENT

if TYPE_CHECKING:
    from simx_server.runtime.server_loop import ServerLoop
    from simx_server.runtime.sessions import Link

logger = logging.getLogger(__name__)

MOST_STRANGERS = 64
"""Connections that have not shown a token yet; further ones are closed."""

SILENCE = 10.0
"""Seconds that a connection has for its token."""

BACKLOG = 64
"""Connections that the system keeps until they are accepted."""

_READ, _MOST_READ = 1 << 16, 1 << 20
"""Least and most bytes to read at a time: the physics thread does other things in between."""

_TOKEN_BYTES = 16


def is_possible() -> bool:
    """Return whether this system has what the short way needs."""
    return hasattr(socket, "AF_UNIX") and hasattr(socket, "send_fds")


class LocalGateway:
    """Listens at a socket of the file system and serves clients that the Zenoh gateway has let in. Physics thread."""

    def __init__(self, loop: ServerLoop) -> None:
        """Make the folder and listen. Raises OSError."""
        self._loop = loop
        self._log = OutsiderLog(logger)
        _clean_up()
        self._folder = Path(
            tempfile.mkdtemp(prefix=f"simx-{os.getpid()}-", dir=_base())
        )  # for this user alone
        self.path = self._folder / "calls"
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.setblocking(False)
        self._listener.bind(str(self.path))
        self._listener.listen(BACKLOG)
        self._offers: dict[str, tuple[str, Link]] = {}
        """Client and its link over Zenoh, by token."""

        self._tokens: dict[str, str] = {}
        """Token by client."""

        self._peers: set[_Peer] = set()
        loop.sockets.add(self._listener, self._accept)
        loop.watches.append(self._look)

    def offer(self, client: str, link: Link) -> None:
        """Let a client connect that has joined, with a token of its own.

        Args:
            link: its link over Zenoh.
        """
        for gone in [each for each in self._tokens if each != client and each not in self._loop.sessions]:
            del self._offers[self._tokens.pop(gone)]
        token = self._tokens.get(client)
        if token is None:
            token = self._tokens[client] = secrets.token_hex(_TOKEN_BYTES)
        self._offers[token] = client, link

    def offered(self, client: str) -> str:
        """Return what a client's welcome says of this way, ``TOKEN@PATH``; empty if it has not joined."""
        token = self._tokens.get(client)
        return "" if token is None else f"{token}@{self.path}"

    def close(self) -> None:
        """Close the socket and remove the folder. Idempotent."""
        for peer in list(self._peers):
            self._drop(peer)
        with contextlib.suppress(KeyError, ValueError):
            self._loop.sockets.remove(self._listener)
        self._listener.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    # --- connections -----------------------------------------------------------------------------

    def _accept(self) -> None:
        try:
            connected, _ = self._listener.accept()
        except OSError:
            return
        if sum(peer.link is None for peer in self._peers) >= MOST_STRANGERS:
            connected.close()
            self._log.say(
                logging.WARNING, "more than %d connections without a token at %s", MOST_STRANGERS, self.path
            )
            return
        connected.setblocking(False)
        peer = _Peer(connected)
        self._peers.add(peer)
        self._loop.sockets.add(connected, partial(self._read, peer))

    def _read(self, peer: _Peer) -> None:
        """Read some of what has arrived."""
        missing = peer.frames.missing
        try:
            data = peer.socket.recv(min(max(missing, _READ), _MOST_READ))
            if not data:
                raise ConnectionResetError
            peer.frames.add(data)
        except BlockingIOError:
            return
        except BadFrame as problem:
            self._log.say(logging.WARNING, "a connection at %s is closed: %s", self.path, problem)
            self._drop(peer)
            return
        except OSError:
            self._drop(peer)
            return
        self._take(peer)

    def _take(self, peer: _Peer) -> None:
        """Queue the complete frames as batches of the client, as far as it may have more waiting."""
        whole = peer.frames.whole
        while whole:
            if peer.link is None:
                if not self._introduce(peer, whole.popleft()):
                    self._drop(peer)
                    return
                continue
            session = self._loop.sessions.get(peer.client)
            if session is None:
                self._drop(peer)
                return
            if session.link is not peer.link:
                session.link = peer.link  # the client has chosen this way with its first batch
            if self._loop.has_too_much_waiting(peer.client, len(whole[0])):
                self._rest(peer)
                return
            self._loop.submit(peer.client, whole.popleft())

    def _introduce(self, peer: _Peer, token: bytes) -> bool:
        """Recognise a client by its token, and give it its memory; return whether it may stay."""
        client, link = self._offers.get(token.decode("ascii", "replace"), ("", None))
        if link is None:
            self._log.say(logging.WARNING, "a connection at %s has no valid token", self.path)
            return False
        with tempfile.TemporaryFile(dir=self._folder) as memory:
            memory.truncate(VALUES_SIZE)
            values = ValuesWriter(memory.fileno())
            try:
                socket.send_fds(peer.socket, [frame(READY)], [memory.fileno()])
            except OSError:
                return False
        peer.client = client
        peer.link = LocalLink(self._loop, peer.socket, values, link, partial(self._read, peer), client)
        return True

    def _rest(self, peer: _Peer) -> None:
        """Read no more of a client for a moment: what it sends waits in its socket."""
        if not peer.is_resting:
            peer.is_resting = True
            self._loop.sockets.remove(peer.socket)

    def _look(self) -> None:
        """Read again from clients that had to rest; close connections without a token."""
        now = time.monotonic()
        for peer in list(self._peers):
            if peer.link is not None and peer.link.is_closed:
                self._peers.discard(peer)
            elif peer.is_resting:
                peer.is_resting = False
                self._loop.sockets.add(peer.socket, partial(self._read, peer))
                if peer.link is not None:
                    peer.link.send_when_possible()
                self._take(peer)
            elif peer.link is None and now > peer.since + SILENCE:
                self._drop(peer)

    def _drop(self, peer: _Peer) -> None:
        """Close a connection; its client leaves after everything that it has sent is executed."""
        if peer not in self._peers:
            return
        self._peers.remove(peer)
        if not peer.is_resting:
            with contextlib.suppress(KeyError, ValueError):
                self._loop.sockets.remove(peer.socket)
        if peer.link is not None:
            session = self._loop.sessions.get(peer.client)
            if session is not None and session.link is peer.link:
                self._loop.depart(peer.client)
            peer.link.close_socket()
        else:
            peer.socket.close()


class _Peer:
    """A connection as it is read. Physics thread."""

    def __init__(self, connected: socket.socket) -> None:
        self.socket = connected
        self.frames = Frames(MAX_FRAME)
        self.since = time.monotonic()
        self.client = ""
        self.link: LocalLink | None = None
        """None before a valid token."""

        self.is_resting = False


class LocalLink:
    """The link back to one client: replies by the socket, values by memory, images by Zenoh."""

    def __init__(
        self,
        loop: ServerLoop,
        connected: socket.socket,
        values: ValuesWriter,
        zenoh: Link,
        read: partial[None],
        client: str,
    ) -> None:
        self._loop, self._socket, self._values, self._zenoh = loop, connected, values, zenoh
        self._read, self._client = read, client
        self._lock = threading.Lock()
        """For `_unsent` and the end: images finish on another thread."""

        self._unsent = bytearray()
        self._is_behind = False
        self.is_closed = False
        self._answered = 0.0

    def deliver(self, payload: bytes) -> None:
        data = frame(payload)
        with self._lock:
            if self.is_closed:
                return
            self._values.count_frame()
            if self._unsent:
                self._unsent += data
                self._fall_behind(len(self._unsent) > MUCH_UNSENT)
                return
            try:
                sent = self._socket.send(data, socket.MSG_DONTWAIT)
            except BlockingIOError:
                sent = 0
            except OSError:  # it has just gone; reading tells
                return
            if sent < len(data):
                self._unsent += data[sent:]
                self._loop.post(self.send_when_possible)
                return
        now = time.perf_counter()
        if now < self._answered + 2 * LOOK:  # a client in a loop calls again at once
            self._loop.sockets.expect()
        self._answered = now

    def publish(self, payload: bytes) -> None:
        if not self.is_closed and not self._values.write(payload):
            self._zenoh.publish(payload)

    def publish_picture(self, stream_id: int, payload: bytes) -> None:
        self._zenoh.publish_picture(stream_id, payload)

    def close(self) -> None:
        self.close_socket()
        self._zenoh.close()

    def close_socket(self) -> None:
        """Close the socket and the memory. Idempotent. Physics thread."""
        with self._lock:
            if self.is_closed:
                return
            self.is_closed = True
            with contextlib.suppress(KeyError, ValueError):
                self._loop.sockets.remove(self._socket)
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            self._socket.close()
            self._values.close()

    def _fall_behind(self, is_behind: bool) -> None:
        if is_behind != self._is_behind:
            self._is_behind = is_behind
            self._loop.suspend(self._client, is_behind)

    def send_when_possible(self) -> None:
        """Send the rest when the client has read. Physics thread."""
        with self._lock:
            if not self.is_closed and self._unsent:
                with contextlib.suppress(KeyError, ValueError):  # it rests
                    self._loop.sockets.change(self._socket, self._send_rest, to_send=True)

    def _send_rest(self) -> None:
        with self._lock:
            if self.is_closed:
                return
            try:
                del self._unsent[: self._socket.send(self._unsent, socket.MSG_DONTWAIT)]
            except BlockingIOError:
                return
            except OSError:
                self._unsent.clear()
            self._fall_behind(len(self._unsent) > MUCH_UNSENT // 2 and self._is_behind)
            if not self._unsent:
                self._loop.sockets.change(self._socket, self._read, to_send=False)


def _base() -> str | None:
    """Return the user's folder for sockets; None for the system's folder for temporary files."""
    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    return runtime if runtime and os.access(runtime, os.W_OK) else None


def _clean_up() -> None:
    """Remove the folders of servers of this user that were killed."""
    for folder in Path(_base() or tempfile.gettempdir()).glob("simx-*-*"):
        process = folder.name.split("-")[1]
        with contextlib.suppress(OSError):
            if process.isdecimal() and folder.stat().st_uid == os.getuid() and not _lives(int(process)):
                shutil.rmtree(folder, ignore_errors=True)


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    return True
