"""Check the ports that scripts use, and a Zenoh connection on this machine."""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Iterable, Iterator
from pathlib import Path

from .child import ProbeFailed, run_probe
from .findings import OK, PROBLEM, WARNING, Finding

LOOPBACK = "127.0.0.1"
ZENOH_TIMEOUT = 30.0
"""Time-out in seconds; without problems it takes less than one."""


def check_ports(ports: Iterable[int]) -> Iterator[Finding]:
    """Check whether each port is free or taken."""
    for port in ports:
        if not port:
            continue
        trouble = _trouble_with(port)
        if trouble is None:
            yield Finding(OK, "port", f"{port} is free")
        elif trouble.errno == errno.EADDRINUSE:
            holder = _holder(port)
            text = f"{port} is taken" + (f" by {holder}" if holder else "")
            yield Finding(
                WARNING, "port", text, "if that is no simx-server of yours: end it, or --port 0 and simx-run"
            )
        else:
            text = f"{port} cannot be listened on ({trouble.strerror})"
            yield Finding(PROBLEM, "port", text, "use a port above 1023 with --port, or --port 0")


def _trouble_with(port: int) -> OSError | None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        if os.name == "posix":  # on Windows it would find every port free
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((LOOPBACK, port))
            listener.listen(1)
        except OSError as error:
            return error
    return None


def _holder(port: int) -> str:
    """Return the process that listens on a port, if the system shows it (Linux, own processes); else an empty text."""
    inode = _listening_inode(port)
    if inode is None:
        return ""
    for descriptor in Path("/proc").glob("[0-9]*/fd/*"):
        try:
            if descriptor.readlink().name != f"socket:[{inode}]":
                continue
            process = descriptor.parents[1]
            words = (process / "cmdline").read_bytes().decode("utf-8", "replace").split("\0")
        except OSError:  # another user's, or it has ended
            continue
        return f"process {process.name} ({' '.join(words).strip()[:80]})"
    return "a process of another user"


def _listening_inode(port: int) -> str | None:
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        try:
            rows = Path(table).read_text(encoding="ascii").splitlines()[1:]
        except OSError:
            continue
        for row in map(str.split, rows):
            if row[3] == "0A" and int(row[1].rpartition(":")[2], 16) == port:  # 0A: listening
                return row[9]
    return None


def check_zenoh() -> Finding:
    """Open one session that listens and another that sends it a query."""
    try:
        found = run_probe("simx_server.app.doctor.zenoh_probe", timeout=ZENOH_TIMEOUT)
    except ProbeFailed as error:
        text = f"two sessions on {LOOPBACK} could not talk: {error}"
        return Finding(
            PROBLEM, "zenoh", text, "allow TCP on the loopback interface, or reinstall eclipse-zenoh"
        )
    return Finding(
        OK, "zenoh", f"talks to itself on {LOOPBACK}, {found['milliseconds']:.2f} ms there and back"
    )
