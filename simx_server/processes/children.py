"""Fork children that run a part of the program, and end with their parent.

A child must never return into the code of its parent, so it ends by ``os._exit``. A pipe to the parent tells each that
the other has ended, however it ended.
"""

from __future__ import annotations

import contextlib
import logging
import os
import signal
from collections.abc import Callable, Generator
from pathlib import Path
from typing import NoReturn

from simx_client.protocol.cli.exit_codes import FAILURE

from .lifeline import end_with

logger = logging.getLogger(__name__)

ENDS_WITHIN = 4.8
"""Seconds that a child has to end; after that it is killed."""


_ENDING = (signal.SIGINT, signal.SIGTERM)


def fork() -> int:
    """Fork as `os.fork` does, for a child that calls `become`.

    A signal to the child must not reach it while it has the parent's handlers: the parent would take it for its own.
    """
    masked = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
    is_child = False
    try:
        process_id = os.fork()
        is_child = not process_id
        return process_id
    finally:
        if not is_child:
            signal.pthread_sigmask(signal.SIG_SETMASK, masked)


def become(run: Callable[[], int], lifeline: tuple[int, int]) -> NoReturn:
    """Run this process, a fork, and end it with the exit code that the function returns.

    Args:
        run: the child's work. Signals have their usual effect when it starts.
        lifeline: both ends of a pipe into which the parent writes nothing; the child ends when the parent has closed
            its end.
    """
    exit_code = FAILURE
    try:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDING)
        os.setsid()  # Ctrl-C is for the parent, which then ends the children one by one
        os.close(lifeline[1])
        end_with(lifeline[0], ENDS_WITHIN)
        exit_code = run()
    except BaseException:
        logger.exception("the server failed")
    finally:
        logging.shutdown()
        os._exit(exit_code)


@contextlib.contextmanager
def ending_signals() -> Generator[int]:
    """Deliver SIGINT and SIGTERM only to a file descriptor within the block, which it yields."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    before = signal.set_wakeup_fd(writer)
    handlers = {number: signal.signal(number, lambda _number, _frame: None) for number in _ENDING}
    try:
        yield reader
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(before)
        os.close(reader)
        os.close(writer)


def how_it_ended(exit_code: int) -> str:
    """Return in words how a process ended; a negative exit code is the number of a signal."""
    if exit_code >= 0:
        return f"with exit code {exit_code}"
    with contextlib.suppress(ValueError):  # of real-time signals, which have no names
        return f"by signal {-exit_code} ({signal.Signals(-exit_code).name})"
    return f"by signal {-exit_code}"


def expendable(process_id: int, nice: int, score: int) -> None:
    """Have the system prefer other processes to one, for processor time and when memory runs out.

    Args:
        nice: added to the niceness of the process and its later threads.
        score: of 1000, by how much it is preferred when a process has to end.
    """
    with contextlib.suppress(OSError):  # it has ended already
        os.setpriority(os.PRIO_PROCESS, process_id, os.getpriority(os.PRIO_PROCESS, process_id) + nice)
        Path(f"/proc/{process_id}/oom_score_adj").write_text(str(score), encoding="ascii")
