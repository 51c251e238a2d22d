"""The link between a client and a server in one process.

Most calls are executed directly: the caller's thread runs the handler and returns its values. Batches, paced calls and
recordings take the form of messages, so that they behave, and are recorded, as those of other clients.
"""

from __future__ import annotations

import math
import threading
import time
from array import array
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from threading import get_ident
from time import monotonic, perf_counter
from typing import Any, cast

from simx_client.errors import ConnectionFailed
from simx_client.protocol.commands import TRIGGER, Command
from simx_client.protocol.messages import PROTOCOL_VERSION, STATUS_OK, Delivery, Reply, Welcome, of_fields
from simx_client.protocol.precision import Values
from simx_client.transport.direct import Crew, DirectFunction, DirectTransport, Plan, ShortWay, StreamWay
from simx_server.joints.joints import position_in
from simx_server.limits import LimitReached
from simx_server.service.answers.answers import Answer
from simx_server.service.answers.link import PackingLink
from simx_server.service.answers.positions import JOINT_POSITION
from simx_server.service.answers.replies import Instant
from simx_server.service.answers.streams import NewestValues
from simx_server.service.calls.addresses import Shortcut
from simx_server.service.calls.direct import DirectCall
from simx_server.service.calls.work import BatchWork
from simx_server.service.clients.rights import may
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.loop import ServerLoop
from simx_server.simulation.simulation import SimulationState

from .alone import Alone
from .crew.lent import Lent
from .published import Published
from .turns import Turns

_MOST_WAITED = 0.05
"""Seconds after which a thread that waits for an answer checks again whether it has to make a step itself."""


class EmbeddedTransport(PackingLink):
    """A ``simx_client.transport.direct.DirectTransport`` to a server loop in this process."""

    copies_positions = keeps_positions = True

    def __init__(self, loop: ServerLoop, turns: Turns, client: str, name: str, port: int) -> None:
        """Make a link; ``greet`` joins the server.

        Args:
            client: the client's id, which also gives its role.
            name: the client's name, for logs and lists.
            port: the port that the script asked for; some ports start the simulation.
        """
        self.client = client
        self._loop, self._service, self._turns = loop, loop.service, turns
        self._simulation = loop.service.simulation
        self._name, self._port = name, port
        self._session: ClientSession | None = None
        self._alone: Alone | None = None
        self.is_direct = False
        """Whether calls may be direct: the client has joined, and no recording needs messages."""

        self._deliveries: deque[bytes] = deque()
        self._came = threading.Event()
        self._published: Published | None = None
        """The newest values of the streams, until the client takes them."""

        self._replied: tuple[float, SimulationState, int] | None = None
        """When the client took the newest values, or got its newest direct reply."""

        self._images: dict[int, bytes] = {}
        self._prepared: dict[str, tuple[DirectCall, Shortcut | None]] = {}
        """By function: what executes it, and its shortcut, if it has one that this client may take."""

        self._version = -1
        self.replied_at_ms = 0

    # --- the client's side: messages -------------------------------------------------------------

    @property
    def is_connected(self) -> bool:
        return self._session is not None

    @property
    def was_lost(self) -> bool:
        return self._session is None or self._service.ending.has_come

    def greet(self, timeout: float) -> Welcome:
        if self._service.ending.has_come:
            raise ConnectionFailed("this embedded simulation has ended")
        if not self._turns.begin(time.monotonic() + timeout):
            raise ConnectionFailed("the embedded simulation does not answer: another thread keeps it busy")
        try:
            session = self._service.clients.join(self.client, self._name, self._port, self)
            self._session, self._alone = session, Alone(self._service, self._turns, session)
            self.is_direct = not self._service.watchers.need_whole_batches
            self._turns.note_change()
        except LimitReached as problem:
            raise ConnectionFailed(str(problem)) from problem
        finally:
            self._turns.end()
        return Welcome(PROTOCOL_VERSION, "", "embedded", "", self._simulation.scene.name)

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        if not self._turns.begin():  # within a step of this very thread
            self._service.queue.submit(self.client, BatchWork(payload))
            return
        try:
            self._service.handling.execute(self.client, BatchWork(payload))
            self._turns.note_change()
        finally:
            self._turns.end()

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        if self._deliveries:
            return self._deliveries.popleft()
        if timeout <= 0.0:
            return None
        deadline = time.monotonic() + timeout
        while True:
            if self._deliveries:
                return self._deliveries.popleft()
            left = deadline - time.monotonic()
            if left <= 0.0 or self.was_lost:
                return None
            self._came.clear()
            wait = self._turn(deadline)
            if not self._deliveries:
                self._came.wait(max(0.0, min(left, wait)))

    def _turn(self, deadline: float) -> float:
        """Do what is due, such as the step that a trigger allows; return the seconds until there is more to do."""
        if not self._turns.begin(deadline):
            return 0.0
        try:
            self._loop.turn()
            if self._service.queue.has_work():  # a batch that has waited for this step goes on
                return 0.0
            return min(_MOST_WAITED, self._service.due.seconds_until_round())
        finally:
            self._turns.end()

    @property
    def has_messages(self) -> bool:
        return bool(self._deliveries or self._images)

    def is_still(self) -> bool:
        return False  # to know it takes as long as to look

    def newest(self) -> bytes | None:
        """Return None: values come by `take_values`."""
        return None

    def images(self) -> list[bytes]:
        if not self._images:
            return []
        images, self._images = self._images, {}
        return list(images.values())

    def close(self) -> None:
        """Leave the server, or have it end this session after the piece of work in which this is called."""
        if self._session is None:
            return
        self._session, self.is_direct = None, False
        self._service.clients.depart(self.client)
        if self._turns.begin():
            try:
                self._loop.turn()
            finally:
                self._turns.end()

    # --- worlds that step together ---------------------------------------------------------------

    def crew_of(self, links: Sequence[DirectTransport], plan: Plan, threads: int) -> Crew:
        """Return what steps the worlds of several links together; see `DirectTransport`."""
        from .crew.crew import Crew as Together  # few programs need it

        return Together([cast("EmbeddedTransport", link).member() for link in links], plan, threads)

    def member(self) -> Lent:
        """Return what a crew needs of this link's world."""
        if self._session is None or self._alone is None:
            raise ConnectionFailed("the client has not joined")
        return Lent(self, self._service, self._turns, self._session, self._alone, self._direct)

    def lend(self, take_back: Callable[[], object]) -> None:
        """Let a crew step the world until the next turn, which calls `take_back`. Within a turn."""
        self.is_direct = False  # direct calls would pass by the turns
        self._turns.lend(take_back)

    def returned(self) -> None:
        """Note that calls come in turns again."""
        self._turns.returned()
        self.is_direct = True

    # --- the client's side: direct calls ---------------------------------------------------------

    @property
    def is_running_freely(self) -> bool:
        """Return whether simulation steps follow the wall clock, so that paced calls wait for them."""
        return self._service.due.is_running_freely

    def prepare(self, command: Command) -> DirectFunction:
        """Return a function that executes a command directly, for many calls."""
        if self._session is None:
            raise ConnectionFailed("the client has not joined")
        turns, simulation, direct = (
            self._turns,
            self._simulation,
            self._direct(self._session, command),
        )
        lock, is_held_here, execute, received = (
            turns.lock,
            turns.is_held_here,
            direct.execute,
            direct.received,
        )

        def call(arguments: Values, timeout: float) -> Reply | None:
            if (is_held_here() or not lock.acquire(False)) and not turns.wait(time.monotonic() + timeout):
                return None
            turns.owner = get_ident()
            try:
                answer = execute(arguments)
                if simulation.version != self._version:
                    self._note_time()
                time_ms = self.replied_at_ms
                self._replied = monotonic(), simulation.state, simulation.scene_id
                if direct.may_change_pace:
                    self._note_change(answer)
            finally:
                turns.owner = 0
                lock.release()
            is_here = answer.__class__ is tuple
            if not is_here and (answer := self._await(answer, time.monotonic() + timeout)) is None:
                return None
            status, values = cast(Answer, answer)
            return of_fields(Reply, (0, status, time_ms, values if status else received(values)))

        return call

    def short_way(self, command: Command, report: Callable[[str], object]) -> ShortWay | None:
        """Return a function that makes a call without marshalling; None if the command has none.

        Args:
            report: is called with the reason of a refused call.
        """
        session, alone = self._session, self._alone
        if session is None or alone is None:
            raise ConnectionFailed("the client has not joined")
        direct, shortcut = self._prepared.get(command.name) or self._prepare(session, command)
        if command.name == TRIGGER:
            return self._step(direct, alone, report)
        return None if shortcut is None else self._short(shortcut)

    def _short(self, shortcut: Shortcut) -> ShortWay:
        turns, simulation = self._turns, self._simulation
        lock, is_held_here = turns.lock, turns.is_held_here

        def call(arguments: Sequence[Any]) -> Any:
            if is_held_here() or not lock.acquire(False):
                return None
            turns.owner = get_ident()
            try:
                result = shortcut(arguments)
                if result is not None:
                    self._replied = monotonic(), simulation.state, simulation.scene_id
                return result
            finally:
                turns.owner = 0
                lock.release()

        return call

    def _counted(self, direct: DirectCall, shortcut: Shortcut) -> Shortcut:
        """Return a shortcut that counts its calls. None: the call has to be executed. Within a turn."""
        executor, simulation, begin = self._service.executor, self._simulation, direct.begin

        def call(arguments: Sequence[Any]) -> Any:
            if executor.log_of_calls is not None:
                return None
            result = shortcut(arguments)
            if result is not None:
                if (began := begin()) is not None:
                    direct.record(perf_counter() - began)
                if simulation.version != self._version:
                    self._note_time()
            return result

        return call

    def _step(self, direct: DirectCall, alone: Alone, report: Callable[[str], object]) -> ShortWay:
        turns, simulation = self._turns, self._simulation
        lock, is_held_here = turns.lock, turns.is_held_here

        def step(_arguments: Sequence[Any]) -> int | None:
            if is_held_here() or not lock.acquire(False):
                return None
            turns.owner = get_ident()
            try:
                if not alone.is_alone:
                    return None
                self._note_time()
                self._replied = monotonic(), simulation.state, simulation.scene_id
                status, values = alone.step(direct)
            finally:
                turns.owner = 0
                lock.release()
            if status and values:
                report(str(values[0]))
            return status

        return step

    def _note_time(self) -> None:
        """Note the time of replies, which changes with `Simulation.version`: steps and stops change that too."""
        self._version, self.replied_at_ms = self._simulation.version, self._service.messages.time_ms()

    def execute_together(self, calls: Sequence[tuple[Command, Values]], timeout: float) -> list[Reply] | None:
        if self._session is None:
            raise ConnectionFailed("the client has not joined")
        if self._turns.owner == get_ident():
            return None
        replies: list[Reply] = []
        left, deadline = iter(calls), time.monotonic() + timeout
        while len(replies) < len(calls) and self._turns.begin(deadline):
            try:
                later = self._execute_until_wait(self._session, left, replies)
                self._replied = monotonic(), self._simulation.state, self._simulation.scene_id
            finally:
                self._turns.end()
            if later is not None:
                direct, awaited = later
                if (answer := self._await(awaited, deadline)) is None:
                    break
                replies.append(self._reply(direct, answer))
        return replies

    def _execute_until_wait(
        self, session: ClientSession, calls: Iterator[tuple[Command, Values]], replies: list[Reply]
    ) -> tuple[DirectCall, Future[Answer]] | None:
        """Execute calls and add their replies, until one is answered later; return that one. Within a turn."""
        prepared, alone, reply = self._prepared, self._alone, self._reply
        for command, arguments in calls:
            direct, shortcut = prepared.get(command.name) or self._prepare(session, command)
            if shortcut is not None and (result := shortcut(arguments)) is not None:
                values = [] if result.__class__ is int else [result[1]]
                replies.append(of_fields(Reply, (0, STATUS_OK, self.replied_at_ms, values)))
                continue
            if command.name == TRIGGER and alone is not None and alone.is_alone:
                replies.append(reply(direct, alone.step(direct)))
                continue
            answer = direct.execute(arguments)
            if direct.may_change_pace:
                self._note_change(answer)
            if answer.__class__ is not tuple:
                return direct, cast("Future[Answer]", answer)
            replies.append(reply(direct, cast(Answer, answer)))
        return None

    def _direct(self, session: ClientSession, command: Command) -> DirectCall:
        return (self._prepared.get(command.name) or self._prepare(session, command))[0]

    def _prepare(self, session: ClientSession, command: Command) -> tuple[DirectCall, Shortcut | None]:
        direct = DirectCall(self._service.executor, session, command)
        shortcut = self._service.addresses.shortcut(command.name) if may(session, command) else None
        found = direct, None if shortcut is None else self._counted(direct, shortcut)
        self._prepared[command.name] = found
        return found

    def _reply(self, direct: DirectCall, answer: Answer) -> Reply:
        """Return the reply to a direct call."""
        status, values = answer
        if self._simulation.version != self._version:
            self._note_time()
        return of_fields(
            Reply, (0, status, self.replied_at_ms, values if status else direct.received(values))
        )

    def _note_change(self, answer: Answer | Future[Answer]) -> None:
        """Go on after a call that may have started, stopped or stepped the simulation. Within a turn."""
        if isinstance(answer, Future) and not answer.done():
            self._loop.turn()  # the step that this call has triggered
        self._turns.note_change()

    def _await(self, answer: Answer | Future[Answer], deadline: float) -> Answer | None:
        """Wait for an image, or for the step that other clients delay; make due steps meanwhile."""
        assert isinstance(answer, Future)
        while not answer.done():
            left = deadline - time.monotonic()
            if left <= 0.0 or self.was_lost:
                return None
            wait = self._turn(deadline)
            try:
                return answer.result(max(0.0, min(left, wait)))
            except TimeoutError:
                continue
        return answer.result()

    def take_values(self) -> list[Reply]:
        """Return the newest values of the streams that came since the last call; refresh them if that is due."""
        published, session = self._published, self._session
        if session is None:
            return []
        if (published is None or published.is_seen) and self._service.due.are_streams_due():
            self._turn(math.inf)
            published = self._published
        if published is None:
            return []
        self._published = None
        if not published.is_seen:
            self._see(published)
        return published.replies(lambda command, values: self._direct(session, command).received(values))

    def stream_way(self, command: Command, seen: Callable[[], object]) -> StreamWay | None:
        """Return a function that reads the newest value of a stream without taking the others; None if it cannot.

        Args:
            seen: is called when the first of the newest values is read.
        """
        if command.name != JOINT_POSITION:
            return None
        due, single = self._service.due, array("f", [0.0])

        def newest(arguments: Sequence[Any], stream_id: int) -> tuple[int, tuple[int, float]] | None:
            published, (handle,) = self._published, arguments
            if published is None or handle.__class__ is not int:
                return None
            if published.is_seen and due.are_streams_due():
                return None
            place, numbers = published.places.get(handle), published.numbers
            if place is None or numbers is None or place[0] != stream_id:
                return None
            single[0] = position_in(numbers, place[1])
            if not published.is_seen:
                self._see(published)
                seen()
            return published.time_ms, (0, single[0])

        return newest

    def _see(self, published: Published) -> None:
        """Note that the client reads published values, which are then the newest that its header tells of."""
        published.is_seen, self._replied = True, published.at

    @property
    def scene_id(self) -> int | None:
        """Return the number of the scene in that header, without making it."""
        return None if self._replied is None else self._service.messages.scene_id(self._replied[2])

    def header(self, message_id: int, client_time: int) -> Delivery | None:
        """Return the newest direct reply, or values of streams, in the form of a message's header."""
        at = self._replied
        return (
            None if at is None else self._service.messages.header(Instant._make(at), message_id, client_time)
        )

    # --- the server's side: the link -------------------------------------------------------------

    def put_replies(self, payload: bytes) -> None:
        self._deliveries.append(payload)
        self._came.set()

    def put_image(self, stream_id: int, payload: bytes) -> None:
        self._images[stream_id] = payload
        self._came.set()

    def publish(self, values: NewestValues) -> None:
        """Keep the newest values of the streams; `take_values` gives them the form that a message would give them."""
        if self._session is not None:
            simulation = self._simulation
            self._published = Published(values, (monotonic(), simulation.state, simulation.scene_id))
