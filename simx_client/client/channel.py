"""Make the calls of a `Client`: at once, batched, or answered from the results of a step.

Built like batches: ``Calls`` notes the calls, an ``Exchange`` sends them as one message, and failures become
exceptions.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager, nullcontext, suppress
from typing import Any, Protocol, TypeVar

from simx_client.calls.answers import Answer
from simx_client.connection.calls import Calls
from simx_client.connection.connection import Connection
from simx_client.connection.exchange import Exchange
from simx_client.errors import NotConnected, ObjectGone, RemoteError, TimedOut
from simx_client.protocol import constants as c

from .known_calls import KnownCalls, Reads

T = TypeVar("T")

Generation = tuple[int, int]
"""Number of the connection and of the scene. A handle is valid within one generation."""


class Subject(Protocol):
    """The object that calls use; it is notified when the object was removed from the scene."""

    @property
    def handle(self) -> int: ...
    @property
    def generation(self) -> Generation: ...
    def __str__(self) -> str: ...
    def forget(self) -> None:
        """Handle the removal of the object."""
        ...


class Channel:
    """The calls of one client. Not thread-safe: each thread needs its own client."""

    def __init__(self, connection: Connection, timeout: float) -> None:
        self.timeout = timeout
        self.generation: Generation = (-1, -1)
        """Generation of the newest answer."""

        self._connection = connection
        self._batched: list[Answer[Any]] = []
        self._batching_depth = 0
        self.is_closed = False
        self.is_stepping = False
        self._known: KnownCalls | None = None
        """Calls with answers, while the results of a step are read."""

        self._looked_at: Reads = {}

    @property
    def where(self) -> str:
        return self._connection.where

    @property
    def state(self) -> str:
        """Return the address and the state of the connection, for ``repr``; sends nothing."""
        condition = "closed" if self.is_closed else self._connection.condition
        return f"at {self.where}" + ("" if condition == "connected" else f", {condition}")

    # --- calling ---------------------------------------------------------------------------------

    def request(self, note: Callable[[Calls], Answer[T]], *subjects: Subject) -> T:
        """Make a call and return its result. Raises as ``gather``."""
        if self._known is not None and (answer := self._at_hand(self._known, note, subjects)) is not None:
            return answer.value
        return self.gather(note, *subjects).value

    def gather(self, note: Callable[[Calls], T], *subjects: Subject) -> T:
        """Make calls in one message, together with the batched ones.

        Args:
            note: notes the calls and returns their answers, which have values when `gather` returns.
            subjects: the objects whose handles are used.

        Returns:
            The result of `note`.

        Raises:
            RemoteError: the server refused one of the calls.
            TimedOut, NotConnected: an answer is missing.
            ObjectGone: a subject was removed, or its scene was replaced.
        """
        if self._known is not None and (result := self._at_hand(self._known, note, subjects)) is not None:
            return result
        calls = Calls(0, self.where)
        result = self._make(calls, note, subjects)
        if refused := [answer for answer in calls.noted if answer.code]:
            self._raise(refused, subjects)
        return result

    def _at_hand(
        self, known: KnownCalls, note: Callable[[Calls], T], subjects: Sequence[Subject]
    ) -> T | None:
        """Return the result of `note` if the answers to all its calls are known; None: they have to be made."""
        if self._batched:
            return None
        self._check(subjects)
        return known.result(note)

    def try_all(self, note: Callable[[Calls], T]) -> T:
        """Make calls that the server may refuse: read the code of each answer. Otherwise as ``gather``."""
        return self._make(Calls(0, self.where), note, ())

    def _make(self, calls: Calls, note: Callable[[Calls], T], subjects: Sequence[Subject]) -> T:
        self._check(subjects)
        result = note(calls)
        if self._known is not None and all(answer.marshal.command.only_reads for answer in calls.noted):
            self._recall(calls.noted, self._known.answers)
        else:
            self.exchange(calls.noted)
        self._check(subjects)  # another client may have loaded a scene meanwhile
        return result

    @contextmanager
    def noting(self, *, check: bool) -> Generator[Calls]:
        """Send the calls of a ``with`` block as one message; none after an exception. Raises as ``gather``.

        Args:
            check: raise if a call failed; otherwise read the code of each answer.
        """
        calls = Calls(0, self.where)
        yield calls
        with nullcontext() if check else suppress(TimedOut, NotConnected):
            self.exchange(calls.noted)
        if check:
            self._raise([answer for answer in calls.noted if answer.code])

    def send(self, note: Callable[[Calls], object], *subjects: Subject) -> None:
        """Make calls without a result; within ``batching`` they are sent later. Raises as ``gather``."""
        if not self._batching_depth:
            self.gather(note, *subjects)
            return
        self._check(subjects)
        calls = Calls(0, self.where)
        note(calls)
        self._batched += calls.noted

    @property
    def batched_count(self) -> int:
        """Return how many calls wait for the next message."""
        return len(self._batched)

    def exchange(self, answers: Sequence[Answer[Any]]) -> None:
        """Send the batched calls and these calls, and wait for the answers.

        Raises:
            RemoteError: the server refused a batched call. The caller handles refusals of the others.
            TimedOut, NotConnected: an answer is missing.
        """
        batched, self._batched = self._batched, []
        sent = [*batched, *answers]
        if not sent:
            return
        if self.is_closed:
            for answer in sent:
                answer.give_up("this client was closed")
            raise NotConnected([answer.failure for answer in sent])
        before = self._connection.connection_id
        exchange = Exchange(self._connection, sent)
        exchange.send()
        exchange.finish(time.monotonic() + self.timeout, self.timeout)
        if exchange.is_lost:
            missing = [answer.failure for answer in sent if answer.reply is None]
            now = self._connection.connection_id
            raise (NotConnected if now == -1 or now != before else TimedOut)(missing)
        if (scene := self._connection.newest_scene()) is not None:
            self.generation = (before, scene)
        if refused := [answer for answer in batched if answer.code]:
            self._raise(refused)

    # --- batching --------------------------------------------------------------------------------

    @contextmanager
    def batching(self) -> Generator[None]:
        """Batch calls without a result: send them with the next call that has one, or at the end of the
        block."""
        self._batching_depth += 1
        try:
            yield
            if self._batching_depth == 1:
                self.exchange([])
        finally:
            self._batching_depth -= 1
            if not self._batching_depth:
                self._batched = []  # an error drops the calls that were not sent

    # --- reading the results of a step -----------------------------------------------------------

    def look(self, read: Callable[[], T], known: Reads) -> tuple[T, Reads]:
        """Run a function that reads; take known answers from `known` and make the other calls.

        Returns:
            The function's result, and all reads that it made.
        """
        outer = self._known, self._looked_at
        self._looked_at = {}
        self._known = KnownCalls(self.where, known, self._looked_at)
        try:
            return read(), self._looked_at
        finally:
            self._known, self._looked_at = outer

    def _recall(self, answers: Sequence[Answer[Any]], known: Reads) -> None:
        new: list[Answer[Any]] = []
        for answer in answers:
            key = (answer.marshal.command.name, *answer.arguments)
            at_hand = known.get(key) or self._looked_at.get(key)
            if at_hand is None:
                new.append(answer)
            else:
                answer.reply = at_hand.reply
            self._looked_at[key] = answer
        self.exchange(new)

    # --- errors ----------------------------------------------------------------------------------

    def _check(self, subjects: Iterable[Subject]) -> None:
        for subject in subjects:
            if subject.generation != self.generation:
                raise ObjectGone(f"{subject} belongs to a scene that was replaced; look it up again")

    def _raise(self, refused: Sequence[Answer[Any]], subjects: Iterable[Subject] = ()) -> None:
        if not refused:
            return
        error = RemoteError([answer.failure for answer in refused])
        if handles := {subject.handle: subject for subject in subjects}:
            there = Calls(0, self.where).simxGetObjects(c.sim_handle_all)
            self.exchange([there])
            for handle, subject in handles.items():
                if handle not in there.value:
                    subject.forget()
                    raise ObjectGone(f"{subject} was removed from the scene; look it up again") from error
        raise error
