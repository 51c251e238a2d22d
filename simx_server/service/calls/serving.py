"""The server loop as the execution of batches sees it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from simx_server.recording import Recorder
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.simulation.simulation import Simulation


class Serving(Protocol):
    """`ServerLoop` implements it."""

    @property
    def simulation(self) -> Simulation: ...

    @property
    def recorder(self) -> Recorder | None: ...

    @property
    def sessions(self) -> Mapping[str, ClientSession]: ...

    @property
    def is_serving(self) -> bool:
        """Return whether others are served while a script runs."""
        ...

    @property
    def is_running_freely(self) -> bool:
        """Return whether simulation steps follow automatically."""
        ...

    @property
    def may_cut_batches(self) -> bool:
        """Return whether others may be served inside a batch."""
        ...

    def must_give_way(self) -> bool:
        """Return whether other clients wait, and may be served inside a batch."""
        ...

    def hold(self, event: Callable[[], object]) -> None:
        """Do something as soon as no script runs."""
        ...

    def post_for(self, client: str, event: Callable[[], object]) -> None:
        """Schedule an event as part of a client's messages, in front of those that wait."""
        ...

    def keep_back(self, client: str, is_kept: bool) -> None:
        """Execute nothing more of a client, or continue."""
        ...
