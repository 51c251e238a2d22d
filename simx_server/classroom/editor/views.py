"""The 3-D views of the seats: a web viewer for each seat that a browser shows, with its own port and token.

A view starts when a browser asks for it, and ends some time after the last browser has left. The processes are forked
by `nursery.py`, which starts with the first one.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import secrets
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, field

from simx_server.classroom import channel
from simx_server.classroom.addresses import AddressError, in_url, listen
from simx_server.classroom.plan import ClassPlan, Seat

from .plan import EditorPlan

KEPT = 60.0
"""Seconds without a browser after which a view ends."""

_ELSEWHERE = ("SIMX_CONNECT", "SIMX_REALM", "SIMX_REDIRECT", "SIMX_ROLE", "SIMX_CONFIG", "SIMX_SOCKET")
"""Variables that would lead a view to another server."""


class NoView(Exception):
    """A 3-D view cannot be had now; the message gives the reason."""


@dataclass
class _View:
    """A view that runs."""

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(16))
    seen: float = field(default_factory=time.monotonic)


class Views:
    """All views. Used by the event loop's thread."""

    def __init__(self, plan: ClassPlan, editor: EditorPlan) -> None:
        """Start none."""
        self._plan, self._editor = plan, editor
        self._views: dict[int, _View] = {}
        self._nursery: subprocess.Popen[bytes] | None = None
        self._channel: socket.socket | None = None

    def port_of(self, seat: int) -> int | None:
        """Return the port of a seat's view; None if the class has no views."""
        return self._editor.view_ports[seat - 1] if self._editor.view_ports else None

    def open(self, seat: Seat) -> dict[str, object]:
        """Return where a browser finds the view of a seat, which is started if need be.

        Raises:
            NoView: there are too many, or it cannot be started.
        """
        port = self.port_of(seat.number)
        if port is None:
            raise NoView("this class has no 3-D views")
        view = self._views.get(seat.number)
        if view is None:
            self._end_unseen()
            if len(self._views) >= self._editor.views:
                raise NoView(
                    f"{len(self._views)} seats show their 3-D view, and this class has no more of them"
                )
            view = self._start(seat, port)
        view.seen = time.monotonic()
        return {"port": view.port, "token": view.token}

    def look(self, seat: int) -> bool:
        """Keep the view of a seat, since a browser shows it. Returns whether it runs."""
        view = self._views.get(seat)
        if view is not None:
            view.seen = time.monotonic()
        return view is not None

    async def end_unseen(self) -> None:
        """End views that no browser shows, again and again."""
        while True:
            await asyncio.sleep(KEPT / 4)
            self._end_unseen()

    def close(self) -> None:
        """End all."""
        if self._channel is not None:
            asyncio.get_running_loop().remove_reader(self._channel)
            self._channel.close()
        if self._nursery is not None:
            self._nursery.wait()
        self._nursery = self._channel = None
        self._views.clear()

    def _start(self, seat: Seat, port: int) -> _View:
        host = self._editor.host
        reached = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
        view = _View(port)
        try:
            with listen(host, port, "--view-port") as listener:
                fields = {
                    "seat": seat.number,
                    "server": f"{seat.user}@{in_url(reached)}:{seat.port}",
                    "login": f"{seat.user}:{seat.token}",
                    "token": view.token,
                }
                socket.send_fds(self._open_channel(), [channel.packed(fields)], [listener.fileno()])
        except (AddressError, OSError) as problem:
            raise NoView(f"the 3-D view cannot be started: {problem}") from None
        self._views[seat.number] = view
        return view

    def _open_channel(self) -> socket.socket:
        """Return the channel to the nursery, which is started if there is none. Raises OSError."""
        if self._channel is None:
            here, there = channel.pair()
            there.setblocking(True)
            with there:
                self._nursery = subprocess.Popen(
                    [
                        sys.executable,
                        "-m",
                        "simx_server.classroom.editor.nursery",
                        str(there.fileno()),
                        "text",
                    ],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    pass_fds=(there.fileno(),),
                    start_new_session=True,
                    env={name: value for name, value in os.environ.items() if name not in _ELSEWHERE},
                )
            self._channel = here
            asyncio.get_running_loop().add_reader(here, self._hear, here)
        return self._channel

    def _hear(self, nursery: socket.socket) -> None:
        try:
            data = nursery.recv(4096)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        if data:
            self._views.pop(channel.unpacked(data).fields["gone"], None)
            return
        self.close()  # with it all views have ended; the next request starts it again

    def _end_unseen(self) -> None:
        late = time.monotonic() - KEPT
        for seat, view in list(self._views.items()):
            if view.seen < late and self._channel is not None:
                with contextlib.suppress(OSError):
                    self._channel.send(channel.packed({"end": seat}))
