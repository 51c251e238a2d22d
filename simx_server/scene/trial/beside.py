"""Work beside the physics thread: MuJoCo lets other threads run while it parses and compiles, so others are served."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

Result = TypeVar("Result")

_GLANCE = 0.002
"""Seconds between two looks at what others have sent."""


class TookTooLong(Exception):
    """The work was not done in its time, or is not wanted any more; it may still go on."""


def beside(
    work: Callable[[], Result],
    serve_others: Callable[[], object],
    is_wanted: Callable[[], bool],
    seconds: float | None = None,
) -> Result:
    """Do something in a thread of its own, and return or raise what it does; the caller serves others meanwhile.

    Raises:
        TookTooLong: `seconds` are over, or it is not wanted any more.
    """
    done: Future[Result] = Future()

    def run() -> None:
        try:
            done.set_result(work())
        except BaseException as error:
            done.set_exception(error)

    came = threading.Event()
    done.add_done_callback(lambda _: came.set())
    end = None if seconds is None else time.monotonic() + seconds
    threading.Thread(target=run, name="simx-load", daemon=True).start()
    while not came.wait(_GLANCE):
        serve_others()
        if not is_wanted() or (end is not None and time.monotonic() > end):
            raise TookTooLong
    return done.result()
