"""A server of a fleet: a Ray actor whose process runs ``simx-server``.

Actor and server end together, in both directions. So Ray, which restarts actors on any host that is left, restarts
servers too.
"""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from typing import IO, Any, NamedTuple

from .ray import load_ray

KEPT_LINES = 1000
"""Number of the newest log lines that `Member.log` returns at most."""

ENDS_WITHIN = 5.0
"""Time-out in seconds for the end of a server, after which it is killed."""

RESTART_PAUSE = 0.5
"""Seconds before a restarted server that could not start makes room for the next attempt."""


class Order(NamedTuple):
    """The server to start; a restarted actor gets it again."""

    scene: str
    realm: str
    endpoints: tuple[str, ...]
    """Zenoh routers to join."""

    flags: tuple[str, ...]
    """Further flags of ``simx-server``."""

    ready_within: float
    """Time-out in seconds for its start."""


class Member:
    """A server and the log of its process."""

    def __init__(self, order: Order) -> None:
        """Start the server and wait until it is ready.

        Raises:
            RuntimeError: it cannot start; the text contains its last log lines. A restarted actor ends instead, and Ray
                tries again: the name of a server that was lost is free only after the lease of its session.
        """
        self._realm, self._routers = order.realm, list(order.endpoints)
        self._started_at = time.time()
        self._is_ending = False
        self._lines: deque[str] = deque(maxlen=KEPT_LINES)
        connect = [word for each in order.endpoints for word in ("--connect", each)]
        # -P: the working folder is the server's workspace, in which clients may put modules.
        command = [sys.executable, "-P", "-m", "simx_server", order.scene, "--port", "0"]
        self._process = subprocess.Popen(
            [*command, "--realm", order.realm, *connect, "--supervised", *order.flags, "--until-eof"],
            stdin=subprocess.PIPE,  # closes with this process, and the server ends
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._ready = threading.Event()
        self._ports: list[int] = []
        for stream, take in (
            (self._process.stdout, self._take_ready),
            (self._process.stderr, self._take_log),
        ):
            threading.Thread(target=self._read, args=(stream, take), daemon=True).start()
        threading.Thread(target=self._end_with_server, daemon=True).start()
        if not self._ready.wait(order.ready_within) or not self._ports:
            self._fail(order)

    def describe(self) -> dict[str, Any]:
        """Return realm, routers, host, Ray's node, process id, ports on the host, and age in seconds."""
        context = load_ray().get_runtime_context()
        return {
            "realm": self._realm,
            "routers": self._routers,
            "host": socket.gethostname(),
            "node": context.get_node_id(),
            "pid": self._process.pid,
            "ports": self._ports,
            "age": time.time() - self._started_at,
            "restarted": context.was_current_actor_reconstructed,
        }

    def log(self, lines: int) -> list[str]:
        """Return the newest lines of the server's log since its last start."""
        return list(self._lines)[-lines:] if lines > 0 else []

    def end(self) -> None:
        """End the server; the actor stays until it is killed."""
        self._is_ending = True
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            self._process.kill()

    def _fail(self, order: Order) -> None:
        self._is_ending = True
        self._process.kill()
        self._process.wait()
        reason = "\n".join(self.log(5)) or f"it was not ready within {order.ready_within:g} s"
        if load_ray().get_runtime_context().was_current_actor_reconstructed:
            sys.stderr.write(f"{order.realm} cannot start yet: {reason}\n")
            sys.stderr.flush()
            time.sleep(RESTART_PAUSE)
            os._exit(1)
        raise RuntimeError(f"the server {order.realm} cannot start: {reason}")

    def _read(self, stream: IO[str], take: Any) -> None:
        for line in stream:
            take(line.rstrip("\n"))
        self._ready.set()

    def _take_ready(self, line: str) -> None:
        if line.startswith("ready "):
            self._ports = [int(port) for port in re.findall(r"127\.0\.0\.1:(\d+)", line)]
            self._ready.set()

    def _take_log(self, line: str) -> None:
        self._lines.append(line)
        sys.stderr.write(f"{self._realm}: {line}\n")  # Ray keeps it in the files of its session

    def _end_with_server(self) -> None:
        code = self._process.wait()
        if self._ready.is_set() and self._ports and not self._is_ending:
            sys.stderr.write(f"{self._realm}: the server has ended with exit code {code}\n")
            sys.stderr.flush()
            os._exit(1)
