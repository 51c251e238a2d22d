"""Zenoh routers for tests, a wire to one that can be cut, and connections that say nothing."""

from __future__ import annotations

import contextlib
import math
import selectors
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import cast

from processes import ROOT, read_line, running


def free_port() -> int:
    return free_ports(1)[0]


def free_ports(count: int) -> list[int]:
    """Different ports: one that was closed may be given again."""
    with contextlib.ExitStack() as stack:
        probes = [stack.enter_context(socket.socket()) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [probe.getsockname()[1] for probe in probes]


@contextlib.contextmanager
def router(port: int, *config: Path) -> Iterator[subprocess.Popen[str]]:
    """A Zenoh router in a separate process on this loopback port."""
    process = subprocess.Popen(
        [
            sys.executable,
            str(ROOT / "tests" / "support" / "programs" / "zenoh_router.py"),
            f"tcp/127.0.0.1:{port}",
            *map(str, config),
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    with running(process):
        assert process.stdin is not None
        with process.stdin:
            assert read_line(process) == "ready\n"
            yield process


@contextlib.contextmanager
def silent(port: int, count: int, opening: bytes = b"", timeout: float = 20.0) -> Iterator[None]:
    """Hold this many connections at a loopback port within the block; they say nothing after their opening."""
    with contextlib.ExitStack() as stack:
        for _ in range(count):
            made = stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=timeout))
            made.sendall(opening)
        yield


class Wire:
    """Passes TCP on from a free port to another one, until it is cut; after the repair it takes new connections."""

    def __init__(self, to_port: int, most: float = math.inf) -> None:
        """`most`: bytes that it passes to the port; then it reads no more there, and the connection stays."""
        self._left = most
        self._to = ("127.0.0.1", to_port)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self._is_cut = threading.Event()
        self._is_closed = threading.Event()
        self._lock = threading.Lock()
        self._ends: dict[socket.socket, socket.socket] = {}
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def cut(self) -> None:
        self._is_cut.set()
        with self._lock:
            self._drop_all()

    def mend(self) -> None:
        self._is_cut.clear()

    def close(self) -> None:
        self._is_closed.set()
        self._thread.join()
        self.cut()
        self._selector.close()
        self._listener.close()

    def __enter__(self) -> Wire:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        while not self._is_closed.is_set():
            for key, _ in self._selector.select(0.05):
                with self._lock:
                    if key.fileobj is self._listener:
                        self._accept()
                    elif key.fileobj in self._ends:
                        self._pass_on(cast(socket.socket, key.fileobj))

    def _accept(self) -> None:
        near, _ = self._listener.accept()
        if self._is_cut.is_set():
            near.close()
            return
        far = socket.create_connection(self._to)
        self._ends |= {near: far, far: near}
        for end in (near, far):
            self._selector.register(end, selectors.EVENT_READ)

    def _pass_on(self, end: socket.socket) -> None:
        with contextlib.suppress(OSError):
            if data := end.recv(1 << 16):
                self._ends[end].sendall(data)
                if self._ends[end].getpeername() == self._to:
                    self._left -= len(data)
                    if self._left < 0:
                        self._selector.unregister(end)
                return
        self._drop_all()

    def _drop_all(self) -> None:
        for end in self._ends:
            if end in self._selector.get_map():
                self._selector.unregister(end)
            end.close()
        self._ends.clear()
