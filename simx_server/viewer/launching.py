"""``--view``: start the web viewer's process with the server, and end it with the server."""

from __future__ import annotations

import importlib.util
import ipaddress
import logging
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Generator, Sequence
from contextlib import contextmanager

from simx_client.protocol.cli.installing import extra_line

logger = logging.getLogger(__name__)

NEEDED = ("viser", "mjviser")
_END_TIMEOUT = 3.0
"""Time-out in seconds; the watchdog of a hanging viewer kills it earlier, and the server has no more than five."""
_ELSEWHERE = ("SIMX_CONNECT", "SIMX_REALM", "SIMX_REDIRECT", "SIMX_ROLE")
"""Variables that would lead the viewer to another server, or hide the simulation from it."""


def missing() -> str | None:
    """Return what to install before the web viewer can run; None when nothing is missing."""
    absent = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    return f"--view needs {' and '.join(absent)}; install with: {extra_line('viewer')}" if absent else None


def listen(address: str, flag: str) -> socket.socket:
    """Return a socket that listens at ``HOST:PORT``, for the web viewer.

    The server opens it before it is ready, and the viewer inherits it: a taken port is reported at once, and a browser
    that comes before the viewer is up waits for it.

    Args:
        flag: the flag that gave `address`, for the error text.

    Raises:
        OSError: it cannot be used; the text gives the reason and the next step.
    """
    host, _, port = address.rpartition(":")
    host = host.strip("[]")
    try:
        found = socket.getaddrinfo(host, int(port), type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, place = found[0]
        return socket.create_server(place[:2], family=family)
    except OSError as error:
        # The text of create_server itself repeats the address.
        reason = error.strerror if isinstance(error, socket.gaierror) else os.strerror(error.errno or 0)
        raise OSError(
            f"no page at {address}: {reason}; choose another port with {flag} PORT, 0 for a free one, "
            f"or an address of this machine with {flag} HOST:PORT"
        ) from None


def browser_address(listener: socket.socket) -> str:
    """Return the address of the web viewer; empty if others can reach it, because its address then has a token."""
    host, port = listener.getsockname()[:2]
    if not ipaddress.ip_address(host).is_loopback:
        return ""
    return f"http://{f'[{host}]' if ':' in host else host}:{port}/"


@contextmanager
def page(
    listener: socket.socket, ports: Sequence[int], temporary_port: int, teleop: str | None = None
) -> Generator[None]:
    """Run the web viewer within the block. It prints its address on stdout; a failure is logged.

    Args:
        listener: from `listen`; the function closes it.
        ports: where this server answers on 127.0.0.1.
        temporary_port: a connection there would start the simulation, so the viewer takes another if there is one.
        teleop: an operator drives this arm, or the first one if it is empty.
    """
    server = f"127.0.0.1:{next((each for each in ports if each != temporary_port), ports[0])}"
    host, port = listener.getsockname()[:2]
    command = [
        "-m",
        "simx_server.viewer",
        server,
        "--at",
        f"[{host}]:{port}" if ":" in host else f"{host}:{port}",
        *(() if teleop is None else (f"--teleop={teleop}",)),
    ]
    # Not on Windows, where processes do not inherit sockets; there the viewer opens a socket at the same address.
    inherited = () if os.name == "nt" else (listener.fileno(),)
    with listener:
        if not inherited:
            listener.close()
        # The viewer reads its stdin, and exits when that is closed, also after this process was killed. Ctrl-C in a
        # terminal is for this process alone.
        process = subprocess.Popen(
            [sys.executable, *command, "--until-eof", *(f"--listener={each}" for each in inherited)],
            stdin=subprocess.PIPE,
            pass_fds=inherited,
            process_group=None if os.name == "nt" else 0,
            env={name: value for name, value in os.environ.items() if name not in _ELSEWHERE},
        )
    is_over = threading.Event()
    again = f"python {' '.join(command)}"
    watcher = threading.Thread(target=_watch, args=(process, is_over, again), name="simx-page", daemon=True)
    watcher.start()
    try:
        yield
    finally:
        is_over.set()
        assert process.stdin is not None
        process.stdin.close()
        try:
            process.wait(_END_TIMEOUT)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _watch(process: subprocess.Popen[bytes], is_over: threading.Event, again: str) -> None:
    code = process.wait()
    if not is_over.is_set():
        logger.error(
            "the web viewer has ended (exit code %d); the simulation goes on; for another page: %s",
            code,
            again,
        )
