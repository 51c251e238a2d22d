"""One connected client as the server sees it: its errors, its stepped mode, its link."""

from __future__ import annotations

import logging
from collections import defaultdict, deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Protocol

from simx_client.protocol.messages import Reply
from simx_client.protocol.python.light_dataclass import dataclass
from simx_client.protocol.zenoh.keys import VIEWER
from simx_client.protocol.zenoh.link import LEASE_MS
from simx_server.errors import CommandError
from simx_server.service.answers.link import Link
from simx_server.service.answers.streams import Streams
from simx_server.service.calls.background import after_all
from simx_server.service.calls.pacing import PacedCalls

from .admission.entrance import Entrance

if TYPE_CHECKING:
    from simx_client.protocol.commands import Command
    from simx_server.service.calls.interrupted import Interrupted

logger = logging.getLogger(__name__)

MAX_ERRORS = 50
"""Error texts kept for simxGetLastErrors; the oldest are dropped first."""

FROZEN = LEASE_MS / 1000
"""Seconds of silence after which a client loses its stepped mode, at all gateways: that of Zenoh's links."""

MAX_LOGGED = 1000
"""Failures of one client that reach the log; later ones are available from simxGetLastErrors only."""


MAX_DEPARTED = 20
"""Former clients that the metrics still report; the oldest are dropped first."""


@dataclass(frozen=True)
class Departed:
    """The data that is kept of a client that has left."""

    client: str
    name: str
    port: int
    may_only_read: bool
    calls: int
    called: Mapping[str, int]
    left_at: float
    """Age of the server at that time, in seconds."""


class Trigger(Protocol):
    """Waits for a step, as a future does."""

    def set_result(self, result: None, /) -> None:
        """Note that the step was made."""
        ...

    def set_exception(self, exception: BaseException, /) -> None:
        """Note that the step cannot be made, and why."""
        ...


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
    calls_sim: bool = False
    """Its messages hold calls of the namespaces of scripts, and not of the table."""

    entrance: Entrance = field(default_factory=Entrance)
    is_stepping: bool = False
    allows_steps: bool = False
    """A call of this client waits for simulation steps, and allows the next one without a trigger."""

    lent_files: dict[str, tuple[str, bytes]] = field(default_factory=dict[str, tuple[str, bytes]])
    """Files of the client's machine that a loading call will read: given path to name and content."""
    called: defaultdict[str, int] = field(default_factory=lambda: defaultdict(int))
    """How often it has called each command."""

    message_id: int = 0
    client_time: int = 0
    interrupted: Interrupted | None = None
    """The batch that waits in its middle for a simulation step."""

    paced: PacedCalls = field(default_factory=PacedCalls)
    guard: Callable[[Command, Sequence[Any]], object] | None = None
    """Raises CommandError for a call of the table with checked arguments that this client may not make; None: it may
    make all that its role allows. Clients within this process have none.
    """

    is_onlooker: bool = False
    """Only shows the simulation, as the web viewer does; the end of the server does not wait for it."""

    before_trigger: list[Reply] = field(default_factory=list[Reply])
    """Replies to the calls before the last trigger, sent with its answer or before those to the next batch."""

    lost_stepping: str = ""
    """Why the server has ended its stepped mode; empty again when the mode is set."""

    _triggers: list[Trigger] = field(default_factory=list[Trigger])
    _logged: set[str] = field(default_factory=set[str])

    @cached_property
    def may_only_read(self) -> bool:
        return self.client.startswith(VIEWER)

    def is_news(self, failure: str) -> bool:
        """Return whether to log a failure: each only once, because scripts poll values that are missing for a while."""
        if failure in self._logged or len(self._logged) >= MAX_LOGGED:
            return False
        self._logged.add(failure)
        return True

    def has_lost(self, messages: int, reason: str) -> None:
        """Record that messages were not executed: in the client's errors each time, in the log once."""
        self.errors.append(f"{messages} messages were not executed: {reason}")
        if self.is_news(reason):
            logger.warning("%d messages of client %s were not executed: %s", messages, self.name, reason)

    def heard(self, message_id: int, client_time: int) -> None:
        """Note the header of a message of the client, for the headers of its replies."""
        self.message_id, self.client_time = message_id, client_time

    def look_on(self) -> None:
        """Note that the client only shows the simulation: the end of the server does not wait for it."""
        self.is_onlooker = True

    def interrupt(self, batch: Interrupted) -> None:
        """Keep a batch whose rest waits."""
        self.interrupted = batch

    def take_rest(self) -> Interrupted | None:
        """Return the batch that waits, which does not wait any more; None if there is none."""
        batch, self.interrupted = self.interrupted, None
        return batch

    def keep_for_trigger(self, replies: list[Reply]) -> None:
        """Keep replies for the answer of a trigger."""
        self.before_trigger = replies

    def allow_steps(self, are_allowed: bool) -> None:
        """Note whether a call of this client waits for simulation steps, and allows the next one without a trigger."""
        self.allows_steps = are_allowed

    def take_lost_stepping(self) -> bool:
        """Return whether the server has ended its stepped mode since the last call of this."""
        was_lost, self.lost_stepping = bool(self.lost_stepping), ""
        return was_lost

    def abandon_call(self) -> None:
        """Abandon a call with a step under way, and the rest of its batch."""
        batch = self.take_rest()
        if batch is not None and batch.call is not None:
            batch.call.abandon()

    def set_stepping(self, enable: bool) -> None:
        """Arm or end stepped mode. Ending it answers waiting triggers."""
        self.is_stepping, self.lost_stepping = enable, ""
        if not enable:
            self.release_triggers()

    def lose_stepping(self, why: str) -> None:
        """End stepped mode, because the client is not heard of any more; its next call about steps is told why."""
        self.set_stepping(False)
        self.lost_stepping = why
        self.errors.append(why)

    def trigger(self, *, is_running: bool) -> Future[None]:
        """Allow one simulation step; the future is done after it.

        Raises:
            CommandError: stepped mode is off, or no simulation step can come.
        """
        if not self.is_stepping:
            why = self.lost_stepping or "stepped mode is off"
            raise CommandError(f"{why}; call simxSynchronous(clientID, True) first")
        if not is_running:
            raise CommandError("the simulation does not run, so there is no step to trigger; start it first")
        future: Future[None] = Future()
        self.add_trigger(future)
        return future

    def add_trigger(self, trigger: Trigger) -> None:
        """Allow one simulation step; the trigger is answered after it."""
        self._triggers.append(trigger)

    @property
    def is_waiting(self) -> bool:
        """Return whether the simulation must wait for a trigger of this client."""
        return self.is_stepping and not self._triggers and not self.allows_steps

    def release_triggers(self, after: Sequence[Future[Any]] = ()) -> None:
        """Answer the triggers, because the step was made (or never will be), as soon as `after` is done as well."""
        triggers, self._triggers = self._triggers, []
        if triggers and not after:
            _answer(triggers)
        elif triggers:
            after_all(after, partial(_answer, triggers))

    def fail_triggers(self, problem: str) -> None:
        """Answer the triggers with the reason why their step cannot be made."""
        triggers, self._triggers = self._triggers, []
        for trigger in triggers:
            trigger.set_exception(CommandError(problem))


def _answer(triggers: list[Trigger]) -> None:
    for trigger in triggers:
        trigger.set_result(None)
