"""One connected client as the server sees it: its errors, its stepped mode, its way back."""

from __future__ import annotations

import logging
from collections import defaultdict, deque
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

from simx_client.protocol.keys import VIEWER
from simx_client.protocol.messages import Call, Reply
from simx_server.errors import CommandError

from .background import Unfinished
from .pacing import PacedCalls
from .streams import Streams

logger = logging.getLogger(__name__)

MAX_ERRORS = 50
"""Error texts kept for simxGetLastErrors; the oldest go first."""

MAX_LOGGED = 1000
"""Failures of one client that reach the log; what comes after is for simxGetLastErrors alone."""


class Link(Protocol):
    """The way back to one client. May be used from any thread; never blocks for long."""

    def deliver(self, payload: bytes) -> None:
        """Send replies; every one arrives, in order."""
        ...

    def publish(self, payload: bytes) -> None:
        """Send the newest values of all small streams; a slow client may miss some."""
        ...

    def publish_picture(self, stream_id: int, payload: bytes) -> None:
        """Send the newest picture of one stream; a slow client may miss some."""
        ...

    def close(self) -> None: ...


MAX_DEPARTED = 20
"""Clients that have left of which the metrics still tell; the oldest go first."""


@dataclass(frozen=True)
class Departed:
    """What stays known of a client that has left."""

    client: str
    name: str
    port: int
    may_only_read: bool
    calls: int
    called: Mapping[str, int]
    left_at: float
    """Age of the server then, in seconds."""


@dataclass(eq=False)
class Interrupted:
    """A batch of which the rest waits for a pass: what follows a trigger, or a paced call and what follows that."""

    replies: list[Reply]
    """To the calls before."""

    rest: list[Call]
    waits_for_trigger: bool = True
    """Or else for any pass: the first call of the rest is paced."""

    is_slice: bool = False
    """It waits for no pass, but until others were served."""

    call: Unfinished | None = None
    """It waits for no pass, but for a step of this call, which stands in front of the rest."""


@dataclass
class ClientSession:
    """State of one client. Belongs to the physics thread."""

    client: str
    """Its segment of the keys."""

    name: str
    port: int
    link: Link
    errors: deque[str] = field(default_factory=lambda: deque(maxlen=MAX_ERRORS))
    streams: Streams = field(default_factory=Streams)
    is_stepping: bool = False
    lent_files: dict[str, tuple[str, bytes]] = field(default_factory=dict[str, tuple[str, bytes]])
    """Files of the client's side that a loading call will ask for: given path to name and content."""
    called: defaultdict[str, int] = field(default_factory=lambda: defaultdict(int))
    """How often it has called each command."""

    message_id: int = 0
    client_time: int = 0
    interrupted: Interrupted | None = None
    """The batch in whose middle a pass is waited for."""

    paced: PacedCalls = field(default_factory=PacedCalls)
    is_onlooker: bool = False
    """Shows the simulation, as a page in the browser does; nobody waits for it to leave."""

    before_trigger: list[Reply] = field(default_factory=list[Reply])
    """To the calls in front of the last trigger, which come with its answer, or before those to the next batch."""

    _triggers: list[Future[None]] = field(default_factory=list[Future[None]])
    _logged: set[str] = field(default_factory=set[str])

    @cached_property
    def may_only_read(self) -> bool:
        return self.client.startswith(VIEWER)

    def is_news(self, failure: str) -> bool:
        """Whether to log a failure: each once, for scripts poll and stream what is not there yet, or any more."""
        if failure in self._logged or len(self._logged) >= MAX_LOGGED:
            return False
        self._logged.add(failure)
        return True

    def has_lost(self, messages: int, reason: str) -> None:
        """So many of its messages were not executed: its errors say so, and the log once."""
        self.errors.append(f"{messages} messages were not executed: {reason}")
        if self.is_news(reason):
            logger.warning("%d messages of client %s were not executed: %s", messages, self.name, reason)

    def abandon_call(self) -> None:
        """Give up a call of which a step is under way, and the rest of its batch."""
        batch, self.interrupted = self.interrupted, None
        if batch is not None and batch.call is not None:
            batch.call.abandon()

    def set_stepping(self, enable: bool) -> None:
        """Arm or end stepped mode. Ending it lets waiting triggers go."""
        self.is_stepping = enable
        if not enable:
            self.release_triggers()

    def trigger(self, *, is_running: bool) -> Future[None]:
        """Allow one pass; the future is done after it.

        Raises:
            CommandError: stepped mode is off, or no pass can come.
        """
        if not self.is_stepping:
            raise CommandError("stepped mode is off; call simxSynchronous(clientID, True) first")
        if not is_running:
            raise CommandError("the simulation does not run, so there is no step to trigger; start it first")
        future: Future[None] = Future()
        self._triggers.append(future)
        return future

    @property
    def is_waiting(self) -> bool:
        """Whether the simulation must wait for a trigger of this client."""
        return self.is_stepping and not self._triggers

    def release_triggers(self, after: Sequence[Future[Any]] = ()) -> None:
        """The pass was made (or will never be): answer the triggers, as soon as `after` is done as well."""
        triggers, self._triggers = self._triggers, []
        if triggers:
            _answer(triggers, list(after))


def _answer(triggers: list[Future[None]], after: list[Future[Any]]) -> None:
    if after:
        first, *rest = after  # a future that knew itself by its callback would keep its picture
        first.add_done_callback(lambda _: _answer(triggers, rest))
        return
    for future in triggers:
        future.set_result(None)
