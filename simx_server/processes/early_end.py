"""SIGTERM to a program that has not started its work."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Generator
from contextlib import contextmanager
from types import FrameType

from simx_client.protocol.cli.exit_codes import INTERRUPTED


@contextmanager
def ended_by_sigterm() -> Generator[None]:
    """Have SIGTERM end the process with `INTERRUPTED` within the block, unless it has another effect already.

    It ends at once, as it would without a handler: an exception in the middle of an import of compiled modules may
    arrive as any other error. Child processes end when their pipes close.
    """
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGTERM) != signal.SIG_DFL
    ):
        yield
        return

    def on_signal(number: int, frame: FrameType | None) -> None:
        os._exit(INTERRUPTED)

    signal.signal(signal.SIGTERM, on_signal)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
