"""Execute the events of a recording with the service of a server: without its loop, network and clock.

Images for clients are not made; images for scripts are.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_client.protocol.commands import TABLE
from simx_server.history.journal import Block
from simx_server.history.succession import resume
from simx_server.history.writing import First
from simx_server.service.answers.link import Link
from simx_server.service.calls.registry import Handler
from simx_server.service.calls.work import BatchWork
from simx_server.service.clock import Pacer
from simx_server.service.due import HELD
from simx_server.service.queue.box import Arrival, Event
from simx_server.service.queue.inbox import Inbox
from simx_server.service.service import build_service
from simx_server.service.watcher import Watcher

from ..errors import CommandError
from ..gateways.zmq.replayed import ReplayedClients, Replaying
from ..gateways.zmq2.clients import KEY
from ..gateways.zmq2.replayed import ReplayedModelClients
from ..handlers import HANDLERS
from .log_file import LogError
from .records import Kind, Record

if TYPE_CHECKING:
    from simx_server.world.world import World

_IMAGES = tuple(command.name for command in TABLE if command.makes_image and command.only_reads)
"""Commands that request an image and change nothing."""


class NoImage(CommandError):
    """The answer to a client that is not connected."""

    silent = True


class Divergence(Exception):
    """The replay differs from the recording; the text says where and in which quantities."""


class _RecordedQueue(Inbox):
    """The queue of a replay: what the server would queue for later is in the recording as well."""

    def post(self, event: Event) -> None:
        """Do nothing: the consequences of an answer are in the recording."""

    def put_first(self, client: str, event: Event) -> None:
        """Do nothing: the recording also contains the continuation of a batch."""

    def meanwhile(
        self, executing: str, waits: Callable[[str], bool] = lambda _: False, seconds: float = math.inf
    ) -> Iterator[Event | Arrival]:
        """Return nothing: the recording, and not the clock, decides when others are served."""
        return iter(())


class _WholeBatches(Watcher):
    """Has no batch cut: only recorded events happen."""

    needs_whole_batches = True


class Replayed:
    """Executes the events of a recording, one after the other."""

    def __init__(self, world: World, *, has_physics_points: bool = True) -> None:
        skipped = {name: _without_image(HANDLERS[name]) for name in _IMAGES}
        self.service = build_service(
            world,
            {**HANDLERS, **skipped},
            Pacer(math.inf),
            queue=_RecordedQueue(lambda: world.simulation.limits),
        )
        self.service.watchers.add(_WholeBatches())
        self._simulation, self._clients, self._serving = (
            world.simulation, self.service.clients, self.service.serving
        )  # fmt: skip
        self._handle = self.service.handling.handle
        self.points = 0
        self._scene = world.simulation.scene.path
        self._due: deque[tuple[int, Record]] = deque()
        """Events within a script's run, each with the number of the recorded event that it follows."""

        self._ids: dict[int, str] = {}
        """The clients by the numbers that the recording has for them."""

        self._zmq = ReplayedClients(self.service)
        self._zmq2 = ReplayedModelClients(self.service)
        world.simulation.interruptions.count(
            self._reach_point, self._reach_point if has_physics_points else None
        )

    def await_room(self) -> None:
        """Wait as long as simulation steps are held, so that films and state logs contain all of a replay."""
        while self._simulation.parts.holds_step():
            time.sleep(HELD)

    def await_point(self, number: int, record: Record) -> None:
        """Execute a record later, when scripts have reached the point at which it was recorded."""
        self._due.append((number, record))

    def await_answer(self, record: Record) -> None:
        """Give a message to the function of a client of the ZeroMQ remote API that the next event calls."""
        client = self._client(record[1])
        self._callers(client).answers[client].append(record[2])

    def do_what_is_due(self, before: int | None = None) -> None:
        """Execute the records that are due: all, or those in front of this event."""
        while self._due and (before is None or self._due[0][0] < before):
            self._do_while_serving(self._due.popleft()[1])

    def do(self, record: Record) -> None:
        """Execute a record; raise Divergence when that is impossible, because it was possible when it was recorded."""
        match record:
            case [Kind.JOINED, _, number, client, name, port]:
                self._ids[number] = client
                self._handle(lambda: self._clients.join(client, name, port, Link(), entrance=None))
            case [Kind.JOINED_ZMQ | Kind.CONTINUED, *_]:
                self._do_of_zmq(record)
            case [Kind.LEFT | Kind.STEPPING_LOST as kind, _, number]:
                client = self._client(number)
                end = partial(self._clients.end_stepping, client, "it was silent")
                self._handle(partial(self._clients.leave, client) if kind == Kind.LEFT else end)
            case [Kind.BATCH, _, number, payload]:
                client = self._client(number)
                self._handle(
                    Arrival(client, self._callers(client).recorded(client, payload) or BatchWork(payload))
                )
            case [Kind.WENT_ON, number]:
                session = self._clients.sessions.get(self._client(number))
                if session is None or session.interrupted is None:
                    raise Divergence("no batch waits for a pass, as one did")
                self._handle(partial(self.service.batches.execute_rest, session))
            case [Kind.STARTED]:
                self._handle(self._simulation.start)
            case [Kind.PASS, _]:
                if not self.service.due.is_advancing:
                    raise Divergence(
                        f"the simulation is {self._simulation.state.value}, or waits for a trigger"
                    )
                self.service.rounds.make()
            case [Kind.IDLE]:
                if self.service.due.is_advancing:
                    raise Divergence("the simulation runs where it stood still")
                self.service.rounds.make()
            case _:
                self._simulation.stop()

    def _do_of_zmq(self, record: Record) -> None:
        match record:
            case [Kind.JOINED_ZMQ, _, number, client, name, port]:
                self._ids[number] = client
                self._handle(lambda: self._callers(client).join(client, name, port))
            case [_, number, connection]:
                client = self._client(number)
                self._handle(lambda: self._callers(client).go_on(client, connection))
            case _:  # callers give these two kinds alone
                pass

    def _callers(self, client: str) -> Replaying:
        """Return the clients among which one is that calls functions of scripts, or methods of objects."""
        return self._zmq2 if KEY in client else self._zmq

    def resume(self, what: str, blocks: list[list[Any]]) -> None:
        """Start as the successor of a crashed server did: with the scene of the start, without clients."""
        for client in list(self._clients.sessions):
            self._handle(partial(self._clients.leave, client))
        self._ids.clear()
        self._zmq.begin_again()
        self._zmq2.begin_again()
        self._due.clear()
        self._simulation.stop()
        assert self._scene is not None  # recordings are of files
        self._simulation.load(self._scene)
        self.points = 0
        first = First.of(self._simulation.scene, self._simulation.model)
        try:
            resume(self.service, first, what, [Block(*block) for block in blocks])
        except TypeError:
            raise LogError("the recording has no moment where its server was started again") from None

    def _client(self, number: int) -> str:
        try:
            return self._ids[number]
        except KeyError:
            raise LogError(f"the recording has no client {number} here") from None

    def _reach_point(self) -> None:
        while self._due and not self._serving.is_active and self._due[0][1][1] <= self.points:
            self._do_while_serving(self._due.popleft()[1])
        self.points += 1

    def _do_while_serving(self, record: Record) -> None:
        with self._serving.within_script():
            self.do(record)


def _without_image(handler: Handler) -> Handler:
    return replace(handler, function=_no_image, with_client=False)


def _no_image(*_arguments: Any) -> Any:
    raise NoImage("a replay makes no pictures for clients")
