"""The process that forks the 3-D views of a class: they share the libraries, so a view takes a third of the memory.

It has one thread. It reads requests of the page's process from a socket, and ends with it. A view is the web viewer as
``python -m simx_server.viewer`` is, with a socket that listens already and a token of the page's choice.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import selectors
import signal
import socket
import sys
from functools import partial
from typing import Any

from simx_client.protocol.cli.exit_codes import DONE
from simx_client.protocol.zenoh import link
from simx_server.classroom import channel
from simx_server.processes import log_format
from simx_server.processes.children import become, ending_signals, expendable, fork
from simx_server.sensors.opengl.mujoco_import import import_mujoco

NICE = 5
"""Niceness of views, as that of the seats' servers."""

EXPENDABLE = 600
"""By how much of 1000 the system prefers to end a view when memory runs out: the student still has the images."""

_CHUNK = 4096


def main() -> int:
    """Fork views until the page ends. Returns the exit code."""
    log_format.configure("error", sys.argv[2], several=True)
    page = socket.socket(fileno=int(sys.argv[1]))
    import_mujoco()
    for name in ("command", "composition", "quiet_viser"):
        importlib.import_module(f"simx_server.viewer.page.{name}")
    link.import_zenoh(link.RUNTIME)
    gc.collect()
    gc.freeze()  # see supervisor.py
    with ending_signals() as signals:
        Nursery(page, signals).serve()
    return DONE


class Nursery:
    """The views. Used by the only thread."""

    def __init__(self, page: socket.socket, signals: int) -> None:
        self._page, self._signals = page, signals
        self._deaths: dict[int, int] = {}
        """By the number of a seat: the descriptor of the view's process (pidfd)."""

        self._lifeline = os.pipe()
        self._selector = selectors.DefaultSelector()
        self._is_over = False

    def serve(self) -> None:
        """Do what the page asks for, until it ends."""
        self._selector.register(self._signals, selectors.EVENT_READ, self._end)
        self._selector.register(self._page, selectors.EVENT_READ, self._read)
        while not self._is_over:
            for key, _ in self._selector.select():
                key.data()
        os.close(self._lifeline[1])  # so the views end

    def _end(self) -> None:
        self._is_over = True

    def _read(self) -> None:
        data, files, _, _ = socket.recv_fds(self._page, _CHUNK, 1)
        if not data:
            self._is_over = True
            return
        asked = channel.unpacked(data).fields
        if files:
            self._begin(asked, socket.socket(fileno=files[0]))
        elif (death := self._deaths.get(asked["end"])) is not None:
            with contextlib.suppress(ProcessLookupError):
                signal.pidfd_send_signal(death, signal.SIGKILL)  # it has nothing to lose

    def _begin(self, asked: dict[str, Any], listener: socket.socket) -> None:
        """Fork a view. Returns in the parent only."""
        with listener:
            process_id = fork()
            if process_id == 0:
                become(partial(self._view, asked, listener), self._lifeline)
        seat = asked["seat"]
        self._deaths[seat] = death = os.pidfd_open(process_id)
        self._selector.register(death, selectors.EVENT_READ, partial(self._bury, seat, process_id))

    def _view(self, asked: dict[str, Any], listener: socket.socket) -> int:
        """Serve a view in its process. Returns the exit code."""
        from simx_server.viewer.page.command import serve_view

        self._page.close()
        self._selector.close()
        for death in self._deaths.values():
            os.close(death)
        expendable(os.getpid(), NICE, EXPENDABLE)
        os.environ["SIMX_LOGIN"] = asked["login"]
        serve_view(listener, asked["server"], asked["token"])
        return DONE

    def _bury(self, seat: int, process_id: int) -> None:
        os.waitpid(process_id, 0)
        death = self._deaths.pop(seat)
        self._selector.unregister(death)
        os.close(death)
        with contextlib.suppress(OSError):
            self._page.send(channel.packed({"gone": seat}))


if __name__ == "__main__":
    sys.exit(main())
