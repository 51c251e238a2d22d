"""The points at which a long computation on the physics thread serves other clients, and the time of its waits."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager

from simx_client.protocol.python.light_dataclass import dataclass


def nothing() -> None:
    """Do nothing."""


def never() -> bool:
    """Return False."""
    return False


@dataclass(slots=True)
class Interruptions:
    """The server, a recording or a replay replace these functions; alone, a simulation interrupts nothing."""

    serve_others: Callable[[], object] = nothing
    """Serves other clients during long computations."""

    is_end_wanted: Callable[[], bool] = never
    """Returns whether the server is to end or a client waits for the run to stop: a long computation then gives up."""

    script_point: Callable[[], object] = nothing
    """Called before each call of a script into the API and after each call into a script.

    A script cannot tell at which time between two of these points something changed.
    """

    waited: float = 0.0
    """Processor seconds of the waits for images so far, with the calls that were served meanwhile. No script has to
    answer for them.
    """

    edited: float = 0.0
    """Processor seconds of `unasked_edit` so far; see there."""

    physics_point: Callable[[], object] | None = None
    """As `script_point`, between pieces of a simulation step's physics, which then have a fixed length."""

    def serve(self, serve_others: Callable[[], object], is_end_wanted: Callable[[], bool] = never) -> None:
        """Have other clients served during long computations, which give up when that is wanted."""
        self.serve_others, self.is_end_wanted = serve_others, is_end_wanted

    def count(self, script_point: Callable[[], object], physics_point: Callable[[], object] | None) -> None:
        """Have the points counted at which something may be done for other clients."""
        self.script_point, self.physics_point = script_point, physics_point

    @contextmanager
    def unasked_edit(self) -> Generator[None]:
        """Edit the scene within a call for another purpose. A script has no more to answer for the time than for that
        of an edit that it asks for.
        """
        began = time.thread_time()
        try:
            yield
        finally:
            self.edited += time.thread_time() - began

    def may_go_on(self) -> bool:
        """Serve others; return whether a long computation may continue."""
        self.serve_others()
        return not self.is_end_wanted()
