"""How `Client` calls the table: at once, held back to go out together, or answered by what came with a step.

Built on what batches are made of: calls are noted on ``Calls``, sent as one message by an ``Exchange``, and failures
become exceptions.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager, nullcontext, suppress
from typing import Any, Protocol, TypeVar

from simx_client.connection.answers import Answer
from simx_client.connection.calls import Calls
from simx_client.connection.connection import Connection
from simx_client.connection.exchange import Exchange
from simx_client.errors import NotConnected, ObjectGone, RemoteError, TimedOut
from simx_client.protocol import constants as c

T = TypeVar("T")

Generation = tuple[int, int]
"""Number of the connection and of the scene: handles mean something within one of these."""

Reads = dict[tuple[Any, ...], Answer[Any]]
"""Calls that only read, by function and arguments."""


class Subject(Protocol):
    """What calls are about, so that it can be told when it has gone."""

    @property
    def handle(self) -> int: ...
    @property
    def generation(self) -> Generation: ...
    def __str__(self) -> str: ...
    def forget(self) -> None:
        """It has gone."""
        ...


class Channel:
    """Calls of one client. Not for several threads at a time: each makes a client of its own."""

    def __init__(self, connection: Connection, timeout: float) -> None:
        self.timeout = timeout
        self.generation: Generation = (-1, -1)
        """As of the newest answer."""

        self._connection = connection
        self._held: list[Answer[Any]] = []
        self._holds = 0
        self.is_closed = False
        self.is_stepping = False
        self._known: Reads | None = None
        """Answers that are at hand, while what a step brought is looked at."""

        self._looked_at: Reads = {}

    @property
    def where(self) -> str:
        return self._connection.where

    @property
    def state(self) -> str:
        """Where the server is, and what is known of the connection, for ``repr``; nothing is asked for."""
        condition = "closed" if self.is_closed else self._connection.condition
        return f"at {self.where}" + ("" if condition == "connected" else f", {condition}")

    # --- calling ---------------------------------------------------------------------------------

    def ask(self, note: Callable[[Calls], Answer[T]], *subjects: Subject) -> T:
        """Make a call and give its result. Raises as ``gather``."""
        return self.gather(note, *subjects).value

    def gather(self, note: Callable[[Calls], T], *subjects: Subject) -> T:
        """Make calls, one message for all, together with what is held back.

        Args:
            note: notes the calls; its result comes back as it is, with answers that have their values by then.
            subjects: the objects whose handles are used.

        Raises:
            RemoteError: the server refused one of them. TimedOut, NotConnected: an answer is missing.
            ObjectGone: a subject is no longer there.
        """
        calls = Calls(0, self.where)
        result = self._make(calls, note, subjects)
        self._raise([answer for answer in calls.noted if answer.code], subjects)
        return result

    def try_all(self, note: Callable[[Calls], T]) -> T:
        """As ``gather``, but these calls may be refused: ask each answer for its code."""
        return self._make(Calls(0, self.where), note, ())

    def _make(self, calls: Calls, note: Callable[[Calls], T], subjects: Sequence[Subject]) -> T:
        self._check(subjects)
        result = note(calls)
        if self._known is not None and all(answer.shape.command.only_reads for answer in calls.noted):
            self._recall(calls.noted, self._known)
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

    def tell(self, note: Callable[[Calls], object], *subjects: Subject) -> None:
        """Make calls without a result; within ``holding`` they go out later. Raises as ``gather``."""
        if not self._holds:
            self.gather(note, *subjects)
            return
        self._check(subjects)
        calls = Calls(0, self.where)
        note(calls)
        self._held += calls.noted

    @property
    def held_back(self) -> int:
        """How many calls wait for the next message."""
        return len(self._held)

    def exchange(self, answers: Sequence[Answer[Any]]) -> None:
        """Send what is held back and these calls, and wait for the answers.

        Raises:
            RemoteError: a call that was held back was refused. Refusals of the others are left to the caller.
            TimedOut, NotConnected: an answer is missing.
        """
        held, self._held = self._held, []
        sent = [*held, *answers]
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
        if header := self._connection.newest_header():
            self.generation = (before, header.scene_id)
        self._raise([answer for answer in held if answer.code])

    # --- holding back ----------------------------------------------------------------------------

    @contextmanager
    def holding(self) -> Generator[None]:
        """What is told goes out with the next call that has a result, or at the end."""
        self._holds += 1
        try:
            yield
            if self._holds == 1:
                self.exchange([])
        finally:
            self._holds -= 1
            if not self._holds:
                self._held = []  # after an error nothing of it is done any more

    # --- looking at what a step brought ----------------------------------------------------------

    def look(self, read: Callable[[], T], known: Reads) -> tuple[T, Reads]:
        """Run a function whose reading calls are answered by those that are known; the others are made.

        Returns:
            Its result, and all reads that it made.
        """
        outer = self._known, self._looked_at
        self._known, self._looked_at = known, {}
        try:
            return read(), self._looked_at
        finally:
            self._known, self._looked_at = outer

    def _recall(self, answers: Sequence[Answer[Any]], known: Reads) -> None:
        new: list[Answer[Any]] = []
        for answer in answers:
            key = (answer.shape.command.name, *answer.arguments)
            at_hand = known.get(key) or self._looked_at.get(key)
            if at_hand is None:
                new.append(answer)
            else:
                answer.reply = at_hand.reply
            self._looked_at[key] = answer
        self.exchange(new)

    # --- what goes wrong -------------------------------------------------------------------------

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
