"""End this process when the process that started it has ended.

The parent holds the other end of a pipe and writes nothing to it. When it ends, even by SIGKILL, the system closes
the pipe.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time

from simx_client.protocol.cli.exit_codes import FAILURE

GRACE = 1.5
"""Seconds for an orderly end of this process."""


def end_with(descriptor: int, grace: float = GRACE) -> None:
    """Watch a file descriptor on a separate thread; when it is closed, end this process as SIGTERM does.

    Bytes read before that are ignored.

    Args:
        descriptor: open for reading; a descriptor that cannot be read counts as closed.
        grace: seconds after which a process that still runs is killed.
    """
    threading.Thread(target=_watch, args=(descriptor, grace), name="simx-lifeline", daemon=True).start()


def _watch(descriptor: int, grace: float) -> None:
    try:
        while os.read(descriptor, 4096):
            pass
    except OSError:
        pass
    if sys.platform == "win32":
        signal.raise_signal(signal.SIGTERM)  # `os.kill` would end the process at once, with no handler
    else:
        os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(grace)
    os._exit(FAILURE)
