"""Ends this process when the one that started it is gone.

That one holds the other end of a pipe and writes nothing to it. The system closes that end with it, even after SIGKILL.
"""

from __future__ import annotations

import os
import signal
import threading
import time

from simx_client.protocol.cli.exit_codes import FAILURE

GRACE = 1.5
"""Seconds that this process has to end in good order."""


def end_with(descriptor: int, grace: float = GRACE) -> None:
    """Watch a file descriptor from a thread of its own; at its end, end this process as SIGTERM does.

    What is read before the end is ignored. Windows has no SIGTERM: there the process ends at once.

    Args:
        descriptor: open for reading; one that cannot be read counts as ended.
        grace: seconds after which a process that still runs is ended without its consent.
    """
    threading.Thread(target=_watch, args=(descriptor, grace), name="simx-lifeline", daemon=True).start()


def _watch(descriptor: int, grace: float) -> None:
    try:
        while os.read(descriptor, 4096):
            pass
    except OSError:
        pass
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(grace)
    os._exit(FAILURE)
