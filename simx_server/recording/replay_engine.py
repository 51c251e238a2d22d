"""An engine whose loop is a recording: no network, no clock.

Pictures that clients asked for are not made; those that scripts look at are.
"""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_client.protocol.commands import TABLE
from simx_server.runtime.clock import Pacer
from simx_server.runtime.inbox import Arrival
from simx_server.runtime.server_loop import Engine

from ..errors import CommandError
from ..handlers import HANDLERS
from ..handlers.registry import Handler
from .log_file import LogError
from .records import Kind, Record

if TYPE_CHECKING:
    from simx_server.world.world import World

_PICTURES = tuple(command.name for command in TABLE if command.makes_image and command.only_reads)
"""Commands that ask for an image and change nothing."""


class NoPicture(CommandError):
    """The answer to a client that is not there."""

    silent = True


class Divergence(Exception):
    """The replay is not what was recorded; the text says where and in what."""


class ReplayEngine(Engine):
    """An engine whose loop is the recording."""

    def __init__(self, world: World, *, has_physics_points: bool = True) -> None:
        skipped = {name: _without_picture(HANDLERS[name]) for name in _PICTURES}
        super().__init__(world, {**HANDLERS, **skipped}, Pacer(math.inf))
        self.points = 0
        self._due: deque[tuple[int, Record]] = deque()
        """What came within a script's run, and after which event of the recording it stands there."""

        self._clients: dict[int, str] = {}
        points = world.simulation.interruptions
        points.script_point = self._reach_point
        points.physics_point = self._reach_point if has_physics_points else None

    def post(self, event: Any) -> None:
        """Nobody waits: what an answer leads to is in the recording as well."""

    def post_for(self, client: str, event: Any) -> None:
        """So it is with what follows in a batch."""

    def serve_others(self) -> None:
        """The clock decides nothing here."""

    @property
    def may_cut_batches(self) -> bool:
        """Nothing happens but what was recorded."""
        return False

    def await_room(self) -> None:
        """Wait as long as passes are held, so films and state logs have all of a replay."""
        while held := self._seconds_held(True):
            time.sleep(held)

    def await_point(self, number: int, record: Record) -> None:
        """To be done when scripts have come as far as when it was recorded."""
        self._due.append((number, record))

    def do_what_is_due(self, before: int | None = None) -> None:
        """Do what was to be done within what is over by now: all, or what stood in front of this event."""
        while self._due and (before is None or self._due[0][0] < before):
            self._do_while_serving(self._due.popleft()[1])

    def do(self, record: Record) -> None:
        """Do what a record says; raises Divergence when that is impossible, as it was possible before."""
        match record:
            case [Kind.JOINED, _, number, client, name, port]:
                self._clients[number] = client
                self._handle(lambda: self.join(client, name, port, NoLink()))
            case [Kind.LEFT, _, number]:
                self._handle(partial(self.leave, self._client(number)))
            case [Kind.BATCH, _, number, payload]:
                self._handle(Arrival(self._client(number), payload))
            case [Kind.WENT_ON, number]:
                session = self.sessions.get(self._client(number))
                if session is None or session.interrupted is None:
                    raise Divergence("no batch waits for a pass, as one did")
                self._handle(partial(self._batches.execute_rest, session))
            case [Kind.STARTED]:
                self._handle(self.simulation.start)
            case [Kind.PASS, _]:
                if not self._is_advancing():
                    raise Divergence(
                        f"the simulation is {self.simulation.state.value}, or waits for a trigger"
                    )
                self._pass()
            case [Kind.IDLE]:
                if self._is_advancing():
                    raise Divergence("the simulation runs where it stood still")
                self._pass()
            case _:
                self.simulation.stop()

    def _client(self, number: int) -> str:
        try:
            return self._clients[number]
        except KeyError:
            raise LogError(f"the recording has no client {number} here") from None

    def _reach_point(self) -> None:
        while self._due and not self._is_serving and self._due[0][1][1] <= self.points:
            self._do_while_serving(self._due.popleft()[1])
        self.points += 1

    def _do_while_serving(self, record: Record) -> None:
        before, self._is_serving = self._is_serving, True
        try:
            self.do(record)
        finally:
            self._is_serving = before


class NoLink:
    """The way to a client that is not there."""

    def deliver(self, payload: bytes) -> None: ...

    def publish(self, payload: bytes) -> None: ...

    def publish_picture(self, stream_id: int, payload: bytes) -> None: ...

    def close(self) -> None: ...


def _without_picture(handler: Handler) -> Handler:
    return replace(handler, function=_no_picture, with_client=False)


def _no_picture(*_arguments: Any) -> Any:
    raise NoPicture("a replay makes no pictures for clients")
