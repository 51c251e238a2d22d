"""The interface between a connection and a server in the same process, which the server's package implements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from simx_client.protocol.commands import Command
from simx_client.protocol.messages import Delivery, Reply

from .transport import Transport

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

DirectFunction = Callable[[list[Any], float], Reply | None]
"""Executes one command: marshalled arguments and a time-out in seconds to the reply, with the id 0. The result is None
if the call takes longer.
"""


ShortWay = Callable[[Sequence[Any]], Any]
"""Makes a call without marshalling: takes the arguments as the script gave them, and returns the result of the legacy
function in blocking mode. The result is None if the call has to be made in the normal way; nothing has happened then.
"""


StreamWay = Callable[[Sequence[Any], int], tuple[int, Any] | None]
"""Reads the newest value of a stream: takes the arguments as the script gave them, and the stream's id; returns the
simulated time of the value in ms and the result of the legacy function. None: the values have to be taken.
"""


Noted = Sequence[tuple[Command, list[Any]]]
"""Commands with their marshalled arguments."""


class Plan(NamedTuple):
    """The calls of several worlds in each step of their crew, and at the start of an episode, by world.

    The numbers among the arguments of writes are replaced by those of each step: numbers of a list one by one.
    """

    starts: Sequence[Noted] | None
    """Writes at the start of an episode, right after the start of the simulation; None: also others are made then."""

    writes: Sequence[Noted]
    """Writes before the simulation steps."""

    steps: int
    """Number of simulation steps."""

    reads: Sequence[Noted]
    """Reads after them; each returns numbers only."""


class Refusal(NamedTuple):
    """A call of a crew's step that failed."""

    place: int
    command: Command
    arguments: list[Any]
    reply: Reply


class Crew(Protocol):
    """Worlds of this process that step together, in threads."""

    widths: tuple[int, int, Sequence[int]]
    """Numbers of the starts and of the writes of a world, and of each of its reads."""

    def reason_against(self, place: int) -> str | None:
        """Return why threads cannot make the physics of a world now; None: they can. Call it in an episode."""
        ...

    def physics_seconds(self, place: int) -> float:
        """Return how long the physics of the last simulation step of a world took."""
        ...

    @property
    def is_whole(self) -> bool:
        """Return whether compiled code does everything of a step of all worlds, as far as is known now."""
        ...

    def started(self, places: NDArray[np.intp], results: NDArray[np.float64]) -> None:
        """Note that calls have started an episode in some worlds, with the starts of the plan; read their state.

        Args:
            places: indexes of the worlds.
            results: receives the numbers of the reads, worlds × numbers.
        """
        ...

    def give_back(self, places: Sequence[int] | None = None) -> None:
        """Prepare worlds, or all, for calls: those would be slower otherwise. The next step needs no preparation."""
        ...

    def restart(
        self, places: NDArray[np.intp], values: NDArray[np.float64], results: NDArray[np.float64]
    ) -> NDArray[np.intp]:
        """Start another episode in some worlds.

        Args:
            places: indexes of the worlds, rising.
            values: numbers of the starts, worlds × numbers.
            results: receives the numbers of the reads, worlds × numbers.

        Returns:
            Places where nothing was done: calls have to start the episode.
        """
        ...

    def step(
        self, places: NDArray[np.intp], values: NDArray[np.float64], results: NDArray[np.float64]
    ) -> list[Refusal]:
        """Write, make the simulation steps and read, in some worlds.

        Args:
            places: indexes of the worlds, rising.
            values: numbers of the writes, worlds × numbers.
            results: receives the numbers of the reads, worlds × numbers.

        Returns:
            The calls that failed; the other worlds have made the step.
        """
        ...

    def close(self) -> None:
        """End the threads, and give the worlds back. Idempotent."""
        ...


class DirectTransport(Transport, Protocol):
    """A link that can also execute a call in the caller's thread, without a message."""

    is_direct: bool
    """Whether calls may be direct now; otherwise calls are sent as messages."""

    replied_at_ms: int
    """Simulation time in ms of the newest reply by a `ShortWay`."""

    @property
    def is_running_freely(self) -> bool:
        """Return whether simulation steps follow the wall clock, so that paced calls wait for them."""
        ...

    def prepare(self, command: Command) -> DirectFunction:
        """Return a function that executes a command directly, for many calls."""
        ...

    def short_way(self, command: Command, report: Callable[[str], object]) -> ShortWay | None:
        """Return the short way of a command; None if it has none.

        Args:
            report: is called with the reason when a call is refused.
        """
        ...

    def execute_together(
        self, calls: Sequence[tuple[Command, list[Any]]], timeout: float
    ) -> list[Reply] | None:
        """Execute calls one after the other, with nothing in between unless one of them has to wait.

        Args:
            calls: commands with their marshalled arguments.
            timeout: time-out of all together in seconds.

        Returns:
            The replies, with the id 0; fewer after a time-out. None if calls are impossible: this thread is within
            a simulation step.
        """
        ...

    @property
    def has_messages(self) -> bool:
        """Return whether replies or images have arrived as messages."""
        ...

    def take_values(self) -> list[Reply]:
        """Return the newest values of the small streams; empty if they were taken already."""
        ...

    def stream_way(self, command: Command, seen: Callable[[], object]) -> StreamWay | None:
        """Return how the newest value of a command's stream is read without taking the others; None if it cannot be.

        Args:
            seen: is called when the first of the newest values is read in this way.
        """
        ...

    @property
    def scene_id(self) -> int | None:
        """Return the number of the scene in `header`, without making it."""
        ...

    def crew_of(self, links: Sequence[DirectTransport], plan: Plan, threads: int) -> Crew:
        """Return what steps the worlds of several links together, each of which has no other client.

        Args:
            links: those of the worlds; this one is among them.
            plan: what they do in each step.
            threads: number of threads, with that of the caller.

        Raises:
            ConnectionFailed: the worlds of this server cannot step in threads; the text gives the reason.
        """
        ...

    def header(self, message_id: int, client_time: int) -> Delivery | None:
        """Return a delivery without replies for the newest direct reply, or values of streams; None before them."""
        ...


class Library(Protocol):
    """The functions of scripts, which a program in the server's process calls; it steps every run."""

    def call(self, function: str, arguments: list[Any]) -> tuple[Any, ...]:
        """Call a function by its full name (``sim.getObjectHandle``) with plain values; return its results.

        Raises:
            Exception: the server refuses the call; the text gives the reason.
        """
        ...

    def step(self, *, if_running: bool) -> None:
        """Make one simulation step if the simulation runs, and `if_running`; else let scripts do regular work.

        Raises:
            Exception: the run could not go on; the text gives the reason.
        """
        ...

    def close(self) -> None:
        """Leave the server. Idempotent."""
        ...


class EmbeddedServer(Protocol):
    """A server in this process."""

    ports: tuple[int, ...]
    """Ports on this host by which other processes can connect; empty unless the settings name one."""

    view_address: str
    """Address of the web viewer for a browser on this host; empty unless the settings ask for it."""

    def connect(self, client: str, name: str, port: int) -> DirectTransport:
        """Return a link for a new client.

        Args:
            client: id of the client, which also gives its role.
            name: name of the client, for logs.
            port: the port that the script asked for: connecting to some ports starts the simulation.
        """
        ...

    def library(self, client: str, name: str) -> Library:
        """Return the functions of scripts for the program of this process, as a new client."""
        ...

    def close(self) -> None:
        """End the server. Idempotent."""
        ...
