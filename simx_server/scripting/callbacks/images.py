"""How a script waits for a picture: the render thread makes it, and other clients are answered meanwhile."""

from __future__ import annotations

import time
from concurrent import futures
from concurrent.futures import Future
from typing import TYPE_CHECKING, TypeVar

from simx_server.errors import CommandError

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation

_T = TypeVar("_T")

PATIENCE = 10.0
"""Seconds; the first picture of a server may have to wait for a back end to be tried out."""

_GLANCE = 0.01
"""Seconds between two looks at what other clients want."""


def wait_for(sim: Simulation, future: Future[_T]) -> _T:
    """The result; other clients are answered until it is there. Raises CommandError after `PATIENCE`."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if futures.wait([future], _GLANCE).done:
            return future.result()
        sim.interruptions.serve_others()
    raise CommandError(f"the picture was not ready within {PATIENCE:.0f} s; try it again later")
