"""Episodes of a task on worlds of this process that step together in threads, with arrays for all of them.

Numbers, episodes and failures are those of `episodes`, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_client.connection.calls import Calls
from simx_client.errors import CallsFailed, ConnectionFailed
from simx_client.gym.observations import Reading
from simx_client.gym.quantities.readable import all_numbers
from simx_client.gym.task import State
from simx_client.transport.direct import Crew, Noted, Plan

from .episodes import Drawn, Episodes

Rows = NDArray[np.float64]
Places = NDArray[np.intp]


class Together:
    """Starts episodes and makes steps on worlds of this process."""

    def __init__(self, episodes: Episodes, threads: int) -> None:
        """Prepare the worlds, in all of which `episodes` has started an episode.

        Args:
            episodes: looks names up, and starts episodes by calls.
            threads: number of threads, with that of the caller.

        Raises:
            ConnectionFailed: the worlds cannot step in threads; the text gives the reason.
        """
        self.task, self.servers = episodes.task, episodes.servers
        self.actions, self.observations = episodes.actions, episodes.observations
        self._episodes = episodes
        self._count = count = len(self.servers)
        every = {each.name.text: each for each in (*episodes.readings, *episodes.started.values())}
        self.crew: Crew = self.servers.crew(self._plan(every.values()), threads)
        starts, writes, reads = self.crew.widths
        self._starts, self._values = np.zeros((count, starts)), np.zeros((count, writes))
        self._results = np.zeros((count, sum(reads)))
        self._before, self._spare = np.zeros_like(self._results), np.zeros_like(self._results)
        columns = _columns(every.values(), reads)
        self._names = [each.name.text for each in episodes.readings]
        self._are_plain = all(columns[text].is_plain(at) for at, text in enumerate(self._names))
        """Each value of a state is one number, in this order."""

        self._is_one_array = self._are_plain and self.observations.is_array_of(self._names)

        self._counted = {text: columns[name.text] for text, name in episodes.counted.items()}
        self._columns = [columns[each.name.text] for each in episodes.readings]
        self._everywhere = np.arange(count)
        self._is_first, self._was_first = np.ones(count, bool), np.ones(count, bool)
        """For each world whether its state is that of the start of an episode, and whether the one before was."""

        self._actions: Sequence[Any] = ()
        self._earlier: Sequence[Any] = ()
        """The actions of the last step, and of the one before."""

        self._counts: dict[str, Rows] = {}
        """Values of the increments by name, for each world."""

        self._states: dict[int, State] = {}
        """Those that were asked for since the last step."""

        self._take_start(self._everywhere, are_by_calls=True)

    def _plan(self, readings: Iterable[Reading]) -> Plan:
        """Return the calls of a step and of a start. Raises ConnectionFailed."""
        for each in readings:
            if each.entry.rows is None:
                raise ConnectionFailed(f"{each.name.text!r} needs calls")
        episodes, places = self._episodes, range(self._count)
        return Plan(
            None
            if self.task.randomize is not None
            else [_noted(lambda calls, at=place: episodes.note_values(calls, at)) for place in places],
            [_noted(lambda calls, at=place: self._note_writes(calls, at)) for place in places],
            self.task.frame_skip,
            [
                _noted(lambda calls, at=place: [each.note(calls, at, is_start=False) for each in readings])
                for place in places
            ],
        )

    def _note_writes(self, calls: Calls, place: int) -> None:
        for part in self.actions.parts:
            part.entry.note(calls, part.subjects[place], [0.0] * part.entry.size)

    # --- episodes --------------------------------------------------------------------------------

    def start(self, random: Mapping[int, np.random.Generator]) -> None:
        """Start an episode in some worlds; see `Episodes.start`."""
        drawn = {place: self._episodes.draw(place, generator) for place, generator in random.items()}
        places = np.array(sorted(drawn), np.intp)
        left = places if self.task.randomize is not None else self._restart(places, drawn)
        if len(left):
            chosen = left.tolist()
            self.crew.give_back(chosen)
            self._episodes.start_with({place: drawn[place] for place in chosen})
            self._take_start(left, are_by_calls=True)
        if len(left) < len(places):
            self._take_start(np.setdiff1d(places, left), are_by_calls=False)

    def _restart(self, places: Places, drawn: Mapping[int, Drawn]) -> Places:
        """Start episodes without calls; return the places where that is impossible."""
        for place, (_, values) in drawn.items():
            self._starts[place] = self._episodes.start_row(values)
        return self.crew.restart(places, self._starts, self._results)

    def _take_start(self, places: Places, *, are_by_calls: bool) -> None:
        """Take over the states at the start of episodes."""
        if are_by_calls:
            self.crew.started(places, self._results)
        self._is_first[places] = True
        self._states.clear()
        for text, column in self._counted.items():
            present = column.rows(self._results)
            counts = self._counts.setdefault(text, np.array(present))
            counts[places] = present[places]

    def step(self, places: Sequence[int], actions: Sequence[Any]) -> None:
        """Make a step of some of the worlds; see `Episodes.step`."""
        is_everywhere = len(places) == self._count
        chosen = self._everywhere if is_everywhere else np.array(places, np.intp)
        parts = self._write(chosen, actions)
        results, was_first = self._spare, self._was_first
        if not is_everywhere:
            results[:] = self._results
        refusals = self.crew.step(chosen, self._values, results)
        if refusals:
            raise CallsFailed([self.servers.failure_of(each) for each in refusals])
        self._spare, self._before, self._results = self._before, self._results, results
        self._was_first, self._is_first = self._is_first, was_first
        if is_everywhere:
            was_first.fill(False)
        else:
            was_first[:] = self._was_first
            was_first[chosen] = False
        self._earlier, self._actions = self._actions, actions
        self._states.clear()
        if self._counts:
            for part, numbers in zip(self.actions.parts, parts, strict=True):
                if (counts := self._counts.get(part.name.text)) is not None:
                    counts[chosen] = numbers[chosen]

    def _write(self, places: Places, actions: Sequence[Any]) -> list[Rows]:
        """Put the numbers of a step into the rows; return those of each part of the actions.

        Raises:
            ValueError: an action is not valid.
        """
        parts = self.actions.rows(actions, self._counts, self._count) if self._count > 1 else None
        if parts is None:
            return self._write_each(places, actions)
        column = 0
        for part, numbers in zip(self.actions.parts, parts, strict=True):
            written = numbers if part.entry.rows is None else part.entry.rows(numbers)
            self._values[:, column : column + written.shape[1]] = written
            column += written.shape[1]
        return parts

    def _row_of(self, values: list[list[float]]) -> list[float]:
        row: list[float] = []
        for part, value in zip(self.actions.parts, values, strict=True):
            row += value if part.entry.arguments is None else part.entry.arguments(value)
        return row

    def _write_each(self, places: Places, actions: Sequence[Any]) -> list[Rows]:
        """Do the same for one world after the other: it is faster for one, and says what is not valid.

        Only increments need the numbers of each part.
        """
        parts = (
            [np.zeros((self._count, part.entry.size)) for part in self.actions.parts] if self._counted else []
        )
        rows: dict[int, list[float]] = {}
        for place in places.tolist():
            values = self.actions.values(actions[place], self.counts_of(place))
            for numbers, value in zip(parts, values, strict=False):
                numbers[place] = value
            rows[place] = self._row_of(values)
        for place, row in rows.items():
            self._values[place] = row
        return parts

    def prepare_calls(self) -> None:
        """Give the worlds back for calls, such as those that make images."""
        self.crew.give_back()

    def end(self) -> None:
        """Stop the simulations, and end the threads."""
        self.crew.close()
        self._episodes.end()

    # --- results ---------------------------------------------------------------------------------

    def observe(self) -> Any:
        """Return the observations of all worlds, as new arrays."""
        if self._count == 1:
            return self.observations.stacked([self.observation(0)])
        if self._is_one_array:
            return self._results[:, : len(self._names)].astype(np.float32)
        return self.observations.rows({each.text: each.rows(self._results) for each in self._columns})

    def counts_of(self, place: int) -> Mapping[str, Sequence[float]]:
        """Return the values of the increments of a world, by name."""
        return {text: counts[place].tolist() for text, counts in self._counts.items()}

    def observation(self, place: int) -> Any:
        """Return the observation of one world, as new arrays."""
        return self.observations.make(self.state(place))

    def state(self, place: int) -> State:
        """Return the newest state of a world."""
        state = self._states.get(place)
        if state is None:
            is_first = bool(self._is_first[place])
            state = self._states[place] = _LateState(
                self._values_of(self._results, place), None if is_first else lambda: self._state_before(place)
            )
            state.action = None if is_first else self._actions[place]
        return state

    def _state_before(self, place: int) -> State:
        state = State(self._values_of(self._before, place))
        state.action = None if self._was_first[place] else self._earlier[place]
        return state

    def _values_of(self, results: Rows, place: int) -> Iterable[tuple[str, Any]]:
        row = results[place].tolist()
        if self._are_plain:
            return zip(self._names, row, strict=False)  # numbers from which increments count follow
        return [(each.text, each.value(row)) for each in self._columns]

    def judge(self, places: Sequence[int]) -> tuple[Rows, NDArray[np.bool_]]:
        """Return the rewards of the newest states, and whether they end the episodes; see `Episodes.judge`."""
        task, count = self.task, self._count
        rewards, terminated = np.zeros(count), np.zeros(count, bool)
        if not task.vectorized or count == 1:
            for place in places:
                rewards[place], terminated[place] = task.judge(self.state(place))
            return rewards, terminated
        before = self._before
        now = _LateState(self._values_of_all(self._results), lambda: State(self._values_of_all(before)))
        now.action = self._actions
        rewards[:] = task.reward(now)
        if task.done is not None:
            terminated[:] = task.done(now)
        if len(places) < count:
            resting = np.ones(count, bool)
            resting[np.array(places, np.intp)] = False
            rewards[resting], terminated[resting] = 0.0, False
        return rewards, terminated

    def _values_of_all(self, results: Rows) -> Iterable[tuple[str, Any]]:
        copy = results.copy()  # which stays as it is in the next steps
        return [(each.text, each.of_all(copy)) for each in self._columns]


class Running:
    """The episodes of an environment: by calls at first, in threads when the first one has started."""

    def __init__(self, episodes: Episodes) -> None:
        self.episodes: Episodes | Together = episodes

    def join(self, threads: int) -> None:
        """Have threads make the steps from now on.

        Raises:
            ConnectionFailed: the worlds cannot step in threads; the text gives the reason.
        """
        if isinstance(self.episodes, Episodes):
            self.episodes = Together(self.episodes, threads)

    def join_if_whole(self) -> None:
        """Have compiled code make the steps from now on, if it can do everything of them."""
        if not isinstance(self.episodes, Episodes):
            return
        try:
            together = Together(self.episodes, 1)
        except ConnectionFailed:
            return
        if together.crew.is_whole:
            self.episodes = together
        else:
            together.crew.close()

    def end(self) -> None:
        """Stop the simulations."""
        self.episodes.end()


class _Column(NamedTuple):
    """Where the numbers of a reading are among the results."""

    text: str
    start: int
    end: int
    size: int
    convert: Callable[[Any], Any]

    def is_plain(self, place: int) -> bool:
        """Return whether the value is the one number at this place."""
        return self.size == 1 and self.convert is all_numbers and self.start == place

    def rows(self, results: Rows) -> Rows:
        """Return the numbers of all worlds, (n, size)."""
        return self.convert(results[:, self.start : self.end])

    def of_all(self, results: Rows) -> Rows:
        """Return the values of all worlds in a state: numbers or vectors."""
        rows = self.rows(results)
        return rows[:, 0] if self.size == 1 else rows

    def value(self, row: list[float]) -> Any:
        """Return the value in the state of one world: a number or a vector."""
        if self.convert is all_numbers:
            return row[self.start] if self.size == 1 else np.array(row[self.start : self.end])
        numbers = self.convert(np.array([row[self.start : self.end]]))[0]
        return float(numbers[0]) if self.size == 1 else np.array(numbers)


class _LateState(State):
    """A state that makes the one before when that is read."""

    def __init__(self, values: Iterable[tuple[str, Any]], before: Callable[[], State] | None) -> None:
        super().__init__(values)
        self._make = before
        self._before: State | None = None

    @property
    def before(self) -> State | None:  # pyright: ignore[reportIncompatibleVariableOverride]
        if self._make is not None:
            self._before, self._make = self._make(), None
        return self._before


def _columns(readings: Iterable[Reading], widths: Sequence[int]) -> dict[str, _Column]:
    columns: dict[str, _Column] = {}
    start = 0
    for reading, width in zip(readings, widths, strict=True):
        assert reading.entry.rows is not None
        text = reading.name.text
        columns[text] = _Column(text, start, start + width, reading.entry.size, reading.entry.rows)
        start += width
    return columns


def _noted(note: Callable[[Calls], object]) -> Noted:
    calls = Calls(0, "")
    note(calls)
    return [(answer.marshal.command, answer.arguments) for answer in calls.noted]
