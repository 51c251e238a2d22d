"""Waiting of a script for an image: the render thread makes it, and the server answers other clients meanwhile."""

from __future__ import annotations

import time
from concurrent.futures import Future, TimeoutError
from contextlib import suppress
from typing import TYPE_CHECKING, TypeVar

from simx_server.errors import CommandError

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

_T = TypeVar("_T")

TIMEOUT = 60.0
"""Time-out in seconds; the first image of a server may have to wait until a back end has been tried."""

_GLANCE = 0.01
"""Seconds between two checks for requests of other clients."""


def wait_for(sim: Simulation, future: Future[_T]) -> _T:
    """Return the result; the server answers other clients until it is available. The wait does not count against the
    time limit of a script.

    Raises:
        CommandError: the time-out passed without a result.
    """
    if future.done():
        return future.result()
    end, began = time.monotonic() + TIMEOUT, time.thread_time()
    try:
        while time.monotonic() < end:
            with suppress(TimeoutError):
                future.exception(_GLANCE)
            if future.done():
                return future.result()
            sim.interruptions.serve_others()
        raise CommandError(f"the picture was not ready within {TIMEOUT:.0f} s; try it again later")
    finally:
        sim.interruptions.waited += time.thread_time() - began
