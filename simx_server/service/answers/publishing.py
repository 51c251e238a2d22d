"""Compute each stream once after a simulation step when it is due, and send it to its clients."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from functools import partial
from operator import attrgetter
from typing import Any
from weakref import WeakValueDictionary

from simx_client.protocol.codec import answer_packer, pack_answer, pack_reply_head
from simx_client.protocol.commands import Command
from simx_client.protocol.messages import STATUS_OK, Call, Reply
from simx_server.errors import CommandError
from simx_server.limits import LimitReached
from simx_server.service.calls.dispatch import check, permit
from simx_server.service.calls.executor import Executor
from simx_server.service.clients.sessions import ClientSession

from .answers import Answer
from .positions import JOINT_POSITION, Positions, find_positions
from .replies import Messages
from .streams import NewestValues, Question, Shared, StepAnswers, Stream, Streams, Value

logger = logging.getLogger(__name__)

LONGEST = 0.05
"""Most seconds that the streams of one client take after a step. Values beyond that are repeated from before, and come
first after the next step; a client with fewer streams gets all values of one instant. Time in which the system ran
other programs does not count while values are only read.
"""

LONGEST_FOR_ALL = 0.1
"""Seconds of all streams, after which clients have to wait for the next step. Otherwise calls would wait for longer."""

LONGEST_STEPPED = 0.5
"""The same as `LONGEST` for a client that steps: it waits for the values itself."""


class _Limit:
    """Until when the streams of one client are computed."""

    def __init__(self, seconds: float) -> None:
        """Start to count seconds."""
        self._wall, self._own = time.perf_counter(), time.thread_time()
        self.end = self._wall + seconds

    def is_extended(self) -> bool:
        """Add the time in which this thread waited for a processor; return whether that moves the end beyond now.

        For work that waits for nothing else.
        """
        wall, own = time.perf_counter(), time.thread_time()
        self.end += max(0.0, (wall - self._wall) - (own - self._own))
        self._wall, self._own = wall, own
        return wall < self.end


class Publisher:
    """Arms, computes and sends the streams. Physics thread only."""

    def __init__(self, executor: Executor, messages: Messages) -> None:
        self._world = executor.world
        self._simulation = executor.world.simulation
        self._dispatch = executor.dispatch
        self._executor = executor
        self._messages = messages
        self._round = 0
        self._next_client = ""
        """The client whose streams had to wait for the next step."""

        self._shared: WeakValueDictionary[Question, Shared] = WeakValueDictionary()

    def arm(
        self, session: ClientSession, call: Call, command: Command, answer: Answer | Future[Answer]
    ) -> None:
        """Start a stream with the answer to its call, unless the call was refused."""
        try:
            arguments = check(command, call.arguments)
            handler = self._dispatch.handler(session, command)
            permit(session, command, arguments)
        except CommandError:
            return  # the answer reports this, and it would be the same after each step
        try:
            wanted = len(session.streams.by_id) + (call.call_id not in session.streams.by_id)
            self._simulation.limits.check("streams", wanted, "end some with discontinue")
        except LimitReached as problem:
            session.errors.append(str(problem))
            return
        if not isinstance(answer, Future) and answer[0] == STATUS_OK and command.is_hit(answer[1]):
            return
        head = pack_reply_head(call.call_id)
        stream = Stream(call.call_id, command, arguments, max(0, call.delay_ms) / 1000, head)
        if isinstance(answer, Future):
            stream.pending = answer
        else:
            if answer[0] != STATUS_OK:
                session.paced.step_comes()
            time_ms = self._messages.time_ms()
            stream.last = Value(command, answer, time_ms)
            question = stream.question()
            if question is not None and not stream.delay:
                stream.shared = self._shared.get(question)
                if stream.shared is None:
                    work = None
                    if command.only_reads and not handler.with_client:
                        work = partial(handler.bound(self._world, None), *arguments)
                    stream.shared = Shared(
                        command, answer, time_ms, question=question, arguments=arguments, work=work
                    )
                    self._shared[question] = stream.shared
                else:  # nothing renews it while all its clients read from copies
                    stream.shared.answer, stream.shared.time_ms = answer, time_ms
                    stream.shared.packed = None
        session.streams.arm(stream)

    def publish(
        self, sessions: Iterable[ClientSession], *, after_step: bool, is_bounded: bool = True
    ) -> None:
        """Compute and send every stream that is due; one that fails ends those of its client.

        Args:
            after_step: the simulation has just made a simulation step.
            is_bounded: stop when the time is over. False for a recording, which must not depend on the clock.
        """
        answers: StepAnswers = {}
        self._round += 1
        until = time.perf_counter() + LONGEST_FOR_ALL if is_bounded else math.inf
        # A copy, as clients come and go while a streamed call runs a script.
        waiting = [session for session in sessions if session.streams.by_id]
        if self._next_client:
            clients = [session.client for session in waiting]
            first = clients.index(self._next_client) if self._next_client in clients else 0
            waiting, self._next_client = waiting[first:] + waiting[:first], ""
        for position, session in enumerate(waiting):
            is_stepped = after_step and session.is_stepping
            if position and not is_stepped and time.perf_counter() >= until:
                self._next_client = self._next_client or session.client
                continue
            if session.streams.by_id:
                try:
                    longest = LONGEST_STEPPED if is_stepped else LONGEST
                    seconds = longest if is_bounded else math.inf
                    self._publish_client(session, answers, seconds, every_image=is_stepped)
                except Exception:
                    logger.exception("the streams of client %s failed and are ended", session.name)
                    session.streams.clear()

    def _publish_client(
        self, session: ClientSession, answers: StepAnswers, longest: float, *, every_image: bool
    ) -> None:
        now, time_ms = time.monotonic(), self._messages.time_ms()
        streams = session.streams
        positions, numbers = None, None
        if session.link.copies_positions:
            positions, numbers = self._copy_positions(streams, session.link.keeps_positions)
        shares = streams.shares() if positions is None else positions.others
        if shares or streams.single:
            limit = _Limit(longest)
            self._compute_shared(session, shares, answers, time_ms, limit)
            if streams.single:
                self._compute_single(session, answers, limit.end, time_ms, now, every_image=every_image)
        if streams.shared or any(stream.value is not None for stream in streams.single.values()):
            head = partial(self._messages.delivery, session, [])
            packer = partial(self._packer, session, time_ms)
            session.link.publish(NewestValues(streams, now, time_ms, head, packer, positions, numbers))

    def _copy_positions(self, streams: Streams, are_kept: bool) -> tuple[Positions, memoryview[float] | None]:
        """Return the streams that can be read from a copy of the joints' numbers, and the copy; None: there are none.

        They count as executed.

        Args:
            are_kept: the numbers are read later, so that the joints' own numbers do not serve.
        """
        joints, positions = self._simulation.joints, streams.positions
        if positions is None or not positions.hold(joints):
            positions = streams.positions = find_positions(joints, streams)
        count = len(positions.places)
        if not count:
            return positions, None
        began = time.perf_counter()
        numbers = joints.copied_positions() if are_kept else positions.present
        self._executor.metrics.executed(JOINT_POSITION, (time.perf_counter() - began) / count, count)
        return positions, numbers

    def _compute_single(
        self,
        session: ClientSession,
        answers: StepAnswers,
        until: float,
        time_ms: int,
        now: float,
        *,
        every_image: bool,
    ) -> None:
        """Compute the streams that are not shared and due; send at once what must not be lost."""
        streams = session.streams
        version = self._simulation.version, self._simulation.model_version
        tally = self._executor.tally()
        taken: list[Reply] = []
        has_begun = False
        for stream in streams.single_in_turn():
            command = stream.command
            if has_begun and time.perf_counter() >= until:
                streams.next_single = streams.next_single or stream.stream_id
            elif session.is_stepping and stream.sent_version == version:
                continue  # nothing has changed since the step
            elif stream.is_due(now, every_image=every_image):
                has_begun = True
                question = stream.question()
                answer = None if question is None else answers.get(question)
                if answer is None:
                    work = self._dispatch.bind(session, command, stream.arguments)
                    answer = self._executor.execute(session, tally, command, work)
                    if question is not None:
                        answers[question] = answer
                if isinstance(answer, Future):
                    published: Future[None] = Future()
                    stream.pending, stream.last = published, None
                    stream.sent_version = version if every_image else None
                    publish = partial(
                        self._publish_image, session, stream.stream_id, time_ms, published, every_image
                    )
                    answer.add_done_callback(publish)
                    continue
                status, values = answer
                if command.takes_what_it_reads:
                    if status or values[0]:
                        taken.append(Reply(stream.stream_id, status, time_ms, values))
                    continue
                if status == STATUS_OK and command.is_hit(values):
                    streams.cancel(stream.stream_id)
                    taken.append(Reply(stream.stream_id, status, time_ms, values))
                    continue
                stream.last = Value(command, answer, time_ms)
        tally.end()
        if taken:
            session.link.deliver(self._messages.delivery(session, taken))

    def _compute_shared(
        self,
        session: ClientSession,
        shares: Sequence[Shared],
        answers: StepAnswers,
        time_ms: int,
        limit: _Limit,
    ) -> None:
        """Compute the shared streams of this client that were not computed in this round, while there is time."""
        now, has_begun, execute = time.perf_counter, False, self._executor.execute
        only_reads = True
        streams, this = session.streams, self._round
        due = [share for share in shares if share.round != this]
        if streams.is_cut:
            due.sort(key=attrgetter("round"))
        streams.is_cut = False
        late: list[Shared] = []
        tally = self._executor.tally()
        for share in due:
            if share.round == this:
                continue  # another stream of this client has the same question
            if has_begun and now() >= limit.end and not (only_reads and limit.is_extended()):
                streams.is_cut = True
                break
            has_begun = True
            command = share.command
            only_reads = only_reads and share.work is not None
            work = share.work or self._dispatch.bind(session, command, share.arguments)
            answer = execute(session, tally, command, work)
            if isinstance(answer, Future):
                answers[share.question] = answer
                late.append(share)
                continue
            share.answer, share.time_ms, share.packed, share.round = answer, time_ms, None, this
        tally.end()
        for share in late:
            streams.separate(share)

    def _packer(self, session: ClientSession, time_ms: int) -> Callable[[Value], bytes]:
        """Return a function that packs the answers of a client, of which most have this time."""
        return partial(self._packed, session, answer_packer(STATUS_OK, time_ms), time_ms)

    def _packed(
        self, session: ClientSession, pack: Callable[[list[Any]], bytes], time_ms: int, value: Value
    ) -> bytes:
        """Pack an answer, once for all its clients. One that cannot be packed is an error of its stream alone.

        Args:
            pack: packs an answer of success with the time `time_ms`.
        """
        status, values = value.answer
        try:
            is_plain = status == STATUS_OK and value.time_ms == time_ms
            value.packed = pack(values) if is_plain else pack_answer(status, value.time_ms, values)
        except Exception as error:
            status, values = self._executor.failure(session, value.command.name, error)
            value.packed = pack_answer(status, time_ms, values)
        return value.packed

    def _publish_image(
        self,
        session: ClientSession,
        stream_id: int,
        time_ms: int,
        published: Future[None],
        in_order: bool,
        done: Future[Answer],
    ) -> None:
        # Between steps it is not sent in order: a client that computes reads nothing, and images would pile up.
        try:
            status, values = done.result()
            delivery = self._messages.delivery(session, [Reply(stream_id, status, time_ms, values)])
            session.link.publish_image(stream_id, delivery, in_order=in_order)
        finally:
            published.set_result(None)
