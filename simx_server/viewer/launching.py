"""``--view``: the page's process beside the server's, which begins and ends with it."""

from __future__ import annotations

import importlib.util
import logging
import os
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

logger = logging.getLogger(__name__)

NEEDED = ("viser", "mjviser")
INSTALL = "pip install 'simx-vrep[viewer]'"
_END_TIMEOUT = 5.0


def missing() -> str | None:
    """What to install before there can be a page; None when all is there."""
    absent = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    return f"--view needs {' and '.join(absent)}; install with: {INSTALL}" if absent else None


@contextmanager
def page(address: str, ports: Sequence[int], temporary_port: int) -> Iterator[None]:
    """Within the block there is a page at ``HOST:PORT``. It tells where on stdout; when it fails, that is logged.

    Args:
        ports: where this server answers on 127.0.0.1.
        temporary_port: a connection there would start the simulation, so the page takes another if there is one.
    """
    port = next((each for each in ports if each != temporary_port), ports[0])
    # The page reads its stdin, and leaves when that is closed: also when this process was killed.
    process = subprocess.Popen(
        [sys.executable, "-m", "simx_server.viewer", f"127.0.0.1:{port}", "--at", address, "--until-eof"],
        stdin=subprocess.PIPE,
        env={name: value for name, value in os.environ.items() if name != "SIMX_REDIRECT"},
    )
    is_over = threading.Event()
    watcher = threading.Thread(target=_watch, args=(process, is_over), name="simx-page", daemon=True)
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


def _watch(process: subprocess.Popen[bytes], is_over: threading.Event) -> None:
    code = process.wait()
    if not is_over.is_set():
        logger.error("the page in the browser has ended (exit code %d); the simulation goes on", code)
