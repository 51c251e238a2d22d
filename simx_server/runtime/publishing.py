"""What the physics thread sends of its own: the streams, each computed once after a pass when it is due.

Also what every message to a client carries in its head: the state of the simulation at that instant.
"""

from __future__ import annotations

import logging
import math
import time
from collections import deque
from collections.abc import Iterable
from concurrent.futures import Future
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING
from weakref import WeakValueDictionary

from simx_client.protocol.codec import answer_packer, encode, encode_delivery, pack_answer, pack_reply_head
from simx_client.protocol.commands import Command
from simx_client.protocol.messages import STATUS_OK, Call, Delivery, Reply
from simx_server.errors import CommandError
from simx_server.limits import LimitReached
from simx_server.world.simulation import SimulationState

from .clock import Pacer
from .dispatch import Answer, Dispatch
from .monitoring.metrics import Metrics, Tally
from .sessions import ClientSession
from .streams import PassAnswers, Question, Shared, Stream

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

REPEAT = 0.25
"""Seconds after which unchanged stream values are sent once more, in case a message was dropped."""

LONGEST = 0.05
"""Seconds at most that the streams of one client take after a pass. Values beyond that are repeated from before, and
come first after the next one; a client that wants less sees one instant."""

LONGEST_FOR_ALL = 0.1
"""Seconds of all streams, after which clients have to wait for the next pass. Others' calls would wait for longer."""

LONGEST_STEPPED = 0.5
"""The same as `LONGEST` for a client that steps: it waits for the values itself."""

_STATE_BITS = {
    SimulationState.STOPPED: 0b000,
    SimulationState.RUNNING: 0b001,
    SimulationState.PAUSED: 0b011,
}
_REAL_TIME_BIT = 0b100

_SCENE_ID_MASK = 0xFFFF
"""The message header has two bytes for it."""


class Publisher:
    """Puts replies into messages, and makes and sends those of the streams. Physics thread, but for `message`."""

    def __init__(self, world: World, dispatch: Dispatch, pacer: Pacer, metrics: Metrics) -> None:
        self._world = world
        self._simulation = world.simulation
        self._metrics = metrics
        self._dispatch = dispatch
        self._pacer = pacer
        self._round = 0
        self._next_client = ""
        """Whose streams had to wait for the next pass."""

        self._shared: WeakValueDictionary[Question, Shared] = WeakValueDictionary()

    def message(self, session: ClientSession, replies: list[Reply]) -> bytes:
        """Replies with their head, as they travel."""
        return encode(self._delivery(session, replies))

    def _delivery(self, session: ClientSession, replies: list[Reply]) -> Delivery:
        state = _STATE_BITS[self._simulation.state] | (
            _REAL_TIME_BIT if math.isfinite(self._pacer.speed) else 0
        )
        return Delivery(
            session.message_id,
            session.client_time,
            int(time.monotonic() * 1000) & 0x7FFF_FFFF,
            self._simulation.scene_id & _SCENE_ID_MASK,
            state,
            replies,
        )

    def time_ms(self) -> int:
        """Simulated time as replies tell it."""
        return int(self._simulation.time * 1000 + 1e-6)  # 0.15 s is 149.99... as a float

    def arm(self, session: ClientSession, call: Call, answer: Answer | Future[Answer]) -> None:
        """A stream begins with what its call was answered, unless that was refused."""
        try:
            command, arguments = self._dispatch.check(call.command, call.arguments)
            handler = self._dispatch.handler(session, command)
        except CommandError:
            return  # the answer has said so, and it would be the same after each pass
        try:
            wanted = len(session.streams.by_id) + (call.call_id not in session.streams.by_id)
            self._simulation.limits.check("streams", wanted, "end some with discontinue")
        except LimitReached as problem:
            session.errors.append(str(problem))
            return
        if isinstance(answer, Answer) and answer.status == STATUS_OK and command.is_hit(answer.values):
            return
        head = pack_reply_head(call.call_id)
        stream = Stream(call.call_id, command, arguments, max(0, call.delay_ms) / 1000, head)
        if isinstance(answer, Future):
            stream.pending = answer
        else:
            stream.last = self._packed(session, command, answer, self.time_ms())
            question = stream.question()
            if question is not None and not stream.delay:
                stream.shared = self._shared.get(question)
                if stream.shared is None:
                    read = None
                    if command.only_reads and not handler.with_client:
                        read = partial(handler.bound(self._world, None), *arguments)
                    stream.shared = Shared(question, command, arguments, read, stream.last)
                    self._shared[question] = stream.shared
        session.streams.arm(stream)

    def publish(
        self, sessions: Iterable[ClientSession], *, after_pass: bool, is_bounded: bool = True
    ) -> None:
        """Compute and send every stream that is due; one that fails ends those of its client.

        Args:
            after_pass: the simulation has just made one.
            is_bounded: as long as there is time. A recording knows no clock.
        """
        answers = PassAnswers()
        self._round += 1
        until = time.perf_counter() + LONGEST_FOR_ALL if is_bounded else math.inf
        # A copy, as clients come and go while a streamed call runs a script.
        waiting = deque(session for session in sessions if session.streams.by_id)
        if any(session.client == self._next_client for session in waiting):
            while waiting[0].client != self._next_client:
                waiting.rotate(-1)
        self._next_client = ""
        for position, session in enumerate(waiting):
            is_stepped = after_pass and session.is_stepping
            if position and not is_stepped and time.perf_counter() >= until:
                self._next_client = self._next_client or session.client
                continue
            if session.streams.by_id:
                try:
                    longest = LONGEST_STEPPED if is_stepped else LONGEST
                    end = time.perf_counter() + longest if is_bounded else math.inf
                    self._publish_client(session, answers, end, every_picture=is_stepped)
                except Exception:
                    logger.exception("the streams of client %s failed and are ended", session.name)
                    session.streams.clear()

    def _publish_client(
        self, session: ClientSession, answers: PassAnswers, until: float, *, every_picture: bool
    ) -> None:
        now, time_ms = time.monotonic(), self.time_ms()
        streams = session.streams
        newest = self._shared_parts(session, answers, time_ms, until)
        taken: list[Reply] = []
        has_begun = False
        for stream in streams.single_in_turn():
            command = stream.command
            if has_begun and time.perf_counter() >= until:
                streams.next_single = streams.next_single or stream.stream_id
            elif stream.is_due(now, every_picture=every_picture):
                has_begun = True
                question = stream.question()
                answer = answers.get(question)
                if answer is None:
                    answer = self._dispatch.carry_out(session, command, stream.arguments)
                    answers.put(question, answer)
                if isinstance(answer, Future):
                    stream.pending, stream.last = answer, None
                    answer.add_done_callback(
                        partial(self._publish_picture, session, stream.stream_id, time_ms)
                    )
                    continue
                if command.takes_what_it_reads:
                    if answer.status or answer.values[0]:
                        taken.append(Reply(stream.stream_id, answer.status, time_ms, answer.values))
                    continue
                if answer.status == STATUS_OK and command.is_hit(answer.values):
                    streams.cancel(stream.stream_id)
                    taken.append(Reply(stream.stream_id, answer.status, time_ms, answer.values))
                    continue
                stream.last = self._packed(session, command, answer, time_ms)
            if stream.last is not None and not command.takes_what_it_reads:
                newest += (stream.head, stream.last)
        if taken:
            session.link.deliver(self.message(session, taken))
        if newest and ((values := b"".join(newest)) != streams.last_sent or now >= streams.next_repeat):
            streams.last_sent, streams.next_repeat = values, now + REPEAT
            session.link.publish(encode_delivery(self._delivery(session, []), values, len(newest) // 2))

    def _shared_parts(
        self, session: ClientSession, answers: PassAnswers, time_ms: int, until: float
    ) -> list[bytes]:
        """Heads and answers, by turns, of this client's streams that share theirs."""
        streams, this = session.streams, self._round
        due = [share for share in streams.shares() if share.round != this]
        if streams.is_cut:
            due.sort(key=attrgetter("round"))
        late = self._answer(session, answers, time_ms, due, until)
        streams.is_cut = time.perf_counter() >= until
        for share in late:
            streams.separate(share)
        return streams.parts()

    def _answer(
        self, session: ClientSession, answers: PassAnswers, time_ms: int, shares: list[Shared], until: float
    ) -> list[Shared]:
        """Answer what no stream of another client has asked for yet in this round, as long as there is time.

        Returns:
            What will be answered later.
        """
        now, has_begun = time.perf_counter, False
        late: list[Shared] = []
        pack = answer_packer(STATUS_OK, time_ms)
        tally, counted, is_one_value = Tally(self._metrics), None, False
        for share in shares:
            if share.round == self._round:
                continue  # another stream of this client asks the same
            if has_begun and now() >= until:
                break
            has_begun = True
            command = share.command
            if share.read is None:
                tally.end()
                counted = None
                answer = self._dispatch.carry_out(session, command, share.arguments)
            else:
                if command is not counted:
                    counted, is_one_value = command, len(command.results) == 1
                    tally.turn_to(command.name)
                tally.count += 1
                try:
                    result = share.read()
                    if is_one_value and not isinstance(result, Future):
                        share.packed, share.round = pack([result]), self._round
                        continue
                    answer = self._dispatch.answer(session, command, result)
                except Exception as error:
                    answer = self._dispatch.failure(session, command.name, error)
            if isinstance(answer, Future):
                answers.put(share.question, answer)
                late.append(share)
                continue
            share.packed, share.round = self._packed(session, command, answer, time_ms), self._round
        tally.end()
        return late

    def _packed(self, session: ClientSession, command: Command, answer: Answer, time_ms: int) -> bytes:
        """An answer as it travels. What cannot be packed is an error of its stream alone."""
        try:
            return pack_answer(answer.status, time_ms, answer.values)
        except Exception as error:
            status, values = self._dispatch.failure(session, command.name, error)
            return pack_answer(status, time_ms, values)

    def _publish_picture(
        self, session: ClientSession, stream_id: int, time_ms: int, done: Future[Answer]
    ) -> None:
        status, values = done.result()
        message = self.message(session, [Reply(stream_id, status, time_ms, values)])
        session.link.publish_picture(stream_id, message)
