"""Episodes of a task on simulations that step together: one message per simulation and step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_client.client.servers import Servers
from simx_client.connection.calls import Calls
from simx_client.errors import SimxError
from simx_client.gym.actions import Actions
from simx_client.gym.observations import Observations, find_reading, groups_of
from simx_client.gym.quantities.lookup import Objects
from simx_client.gym.quantities.names import Subject, read_name
from simx_client.gym.quantities.writable import WRITABLE, Writable
from simx_client.gym.task import State, Task
from simx_client.protocol import constants as c


class Drawn(NamedTuple):
    """Random values of an episode, by name."""

    properties: Mapping[str, list[float]]
    """Those of `Task.randomize`."""

    values: Mapping[str, list[float]]
    """Those of `Task.start`."""


class Episodes:
    """Starts episodes and makes steps on any of the simulations."""

    def __init__(self, task: Task, servers: Servers) -> None:
        """Look up everything that the task names.

        Raises:
            CallsFailed: an object does not exist, or a simulation is gone.
            ValueError: a name or a range of the task cannot be used.
        """
        self.task, self.servers = task, servers
        texts = [text for group in groups_of(task.observations).values() for text in group]
        starts = task.draw_start(np.random.default_rng(0))
        names = [read_name(text) for text in (*texts, *task.measures, *task.actions, *starts)]
        self._objects = Objects(servers, names)
        self.actions = Actions(task.actions, self._objects)
        self.counted = {
            part.name.text: name for part in self.actions.parts if (name := part.counted_from) is not None
        }
        """The quantities from which increments count, by the name of what these set."""

        read = dict.fromkeys((*texts, *task.measures))
        self.readings = [find_reading(text, self._objects) for text in read]
        """Of all values of a state."""

        self.started = {name.text: find_reading(name.text, self._objects) for name in self.counted.values()}
        """Of the values from which increments count."""

        self._starts: dict[str, tuple[Writable, list[Subject]]] = {
            text: self._writable(text, len(value)) for text, value in starts.items()
        }
        self.observations = Observations(
            task.observations, {each.name.text: each for each in self.readings}, servers
        )
        self._random = None if task.randomize is None else task.randomize.on(servers)
        self._states: list[State] = [State() for _ in range(len(servers))]
        """The newest state of each simulation."""

        self._values: list[dict[str, list[float]]] = [{} for _ in range(len(servers))]
        """Values of the increments, for each simulation by name."""

        self._steps: dict[int, tuple[Calls, list[Any]]] = {}
        """For each simulation the calls of every step, behind those of the action, and the answers of `readings`."""

    def start(self, random: Mapping[int, np.random.Generator]) -> None:
        """Start an episode: a stop restores the state of the scene, so equal episodes are equal bit for bit.

        Args:
            random: generators of the simulations, by index; the others are left as they are.
        """
        self.start_with({place: self.draw(place, generator) for place, generator in random.items()})

    def draw(self, place: int, random: np.random.Generator) -> Drawn:
        """Return the random values of an episode."""
        properties = {} if self._random is None else self._random.draw(place, random)
        return Drawn(properties, self.task.draw_start(random))

    def start_with(self, drawn: Mapping[int, Drawn]) -> None:
        """Start an episode with these values in some of the simulations, by index."""

        def note(calls: Calls, place: int) -> tuple[list[Any], list[Any]]:
            if place not in drawn:
                return [], []
            self._note_start(calls, place, drawn[place])
            read = (self.readings, self.started.values())
            answers, counted = (
                [each.note(calls, place, is_start=True) for each in readings] for readings in read
            )
            return answers, counted

        for place, (answers, counted) in enumerate(self.servers.each(note)):
            if place in drawn:
                self._states[place] = self._state(answers)
                found = dict(zip(self.started, counted, strict=True))
                self._values[place] = {
                    text: np.atleast_1d(self.started[name.text].value(found[name.text])).tolist()
                    for text, name in self.counted.items()
                }

    def step(self, places: Sequence[int], actions: Sequence[Any]) -> None:
        """Make a step of some of the simulations.

        Args:
            places: their indexes, rising.
            actions: those of all simulations.

        Raises:
            CallsFailed: a simulation is gone, or refused a call; the others have made the step.
            ValueError: an action is not valid; no simulation has made the step.
            SimxError: no episode was started; no simulation has made the step.
        """
        if not all(self._states[place] for place in places):
            raise SimxError("no episode was started yet; call reset first")
        numbers = {place: self.actions.values(actions[place], self._values[place]) for place in places}

        def note(calls: Calls, place: int) -> list[Any]:
            if place not in numbers:
                return []
            for part, value in zip(self.actions.parts, numbers[place], strict=True):
                part.entry.note(calls, part.subjects[place], value)
            step, answers = self._steps.get(place) or self._note_step(place, calls.where)
            calls.repeat(step.noted)
            return answers

        for place, answers in enumerate(self.servers.each(note)):
            if place in numbers:
                after = self._state(answers)
                after.before, after.action = self._states[place], actions[place]
                after.before.before = None  # otherwise all states of the episode would be kept
                self._states[place] = after
                if self.counted:
                    for part, value in zip(self.actions.parts, numbers[place], strict=True):
                        if part.name.text in self.counted:
                            self._values[place][part.name.text] = value

    def end(self) -> None:
        """Stop the simulations that still answer, and leave stepped mode."""
        self.servers.each(
            lambda calls, _: (calls.simxStopSimulation(), calls.simxSynchronous(False)), check=False
        )

    # --- results ---------------------------------------------------------------------------------

    def state(self, place: int) -> State:
        """Return the newest state of a simulation."""
        return self._states[place]

    def counts_of(self, place: int) -> Mapping[str, Sequence[float]]:
        """Return the values of the increments of a simulation, by name."""
        return self._values[place]

    def observation(self, place: int) -> Any:
        """Return the observation of a simulation, as new arrays."""
        return self.observations.make(self._states[place])

    def observe(self) -> Any:
        """Return the observations of all simulations, as new arrays."""
        return self.observations.stacked([self.observations.make(state) for state in self._states])

    def judge(self, places: Sequence[int]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return the rewards of the newest states, and whether they end the episodes, for all simulations.

        Args:
            places: those that have made a step; the others get 0 and False.
        """
        count = len(self._states)
        rewards, terminated = np.zeros(count), np.zeros(count, bool)
        for place in places:
            rewards[place], terminated[place] = self.task.judge(self._states[place])
        return rewards, terminated

    def prepare_calls(self) -> None:
        """Do nothing: all steps are made by calls."""

    # --- calls -----------------------------------------------------------------------------------

    def note_values(self, calls: Calls, place: int) -> None:
        """Note the calls that set the values of a start, with any numbers."""
        for entry, subjects in self._starts.values():
            entry.note(calls, subjects[place], [0.0] * entry.size)

    def start_row(self, values: Mapping[str, list[float]]) -> list[float]:
        """Return the numbers of the values of a start: the last arguments of the calls of `note_values`."""
        row: list[float] = []
        for text, numbers in values.items():
            entry, _ = self._start_entry(text)
            row += numbers if entry.arguments is None else entry.arguments(numbers)
        return row

    def _start_entry(self, text: str) -> tuple[Writable, list[Subject]]:
        if text not in self._starts:
            raise ValueError(
                f"start returned {text!r}, which it had not returned at first: it must always return the same names"
            )
        return self._starts[text]

    def _note_start(self, calls: Calls, place: int, drawn: Drawn) -> None:
        calls.simxStopSimulation()
        if self.task.time_step is not None:
            calls.simxSetFloatingParameter(c.sim_floatparam_simulation_time_step, self.task.time_step)
        calls.simxSynchronous(True)
        calls.simxStartSimulation()
        if self._random is not None:  # within the run, so that the stop restores the scene
            self._random.note(calls, place, drawn.properties)
        for text, value in drawn.values.items():
            entry, subjects = self._start_entry(text)
            entry.note(calls, subjects[place], value)

    def _note_step(self, place: int, where: str) -> tuple[Calls, list[Any]]:
        calls = Calls(place, where)
        for _ in range(self.task.frame_skip):
            calls.simxSynchronousTrigger()
        answers = [each.note(calls, place, is_start=False) for each in self.readings]
        self._steps[place] = calls, answers
        return self._steps[place]

    def _writable(self, text: str, count: int) -> tuple[Writable, list[Subject]]:
        name = read_name(text)
        entry = self._objects.quantity(name, WRITABLE, "set")
        if count != entry.size:
            raise ValueError(f"{text!r} takes {entry.size} numbers, not {count}")
        return entry, self._objects.subjects(name)

    def _state(self, answers: list[Any]) -> State:
        return State(
            (reading.name.text, reading.value(answer))
            for reading, answer in zip(self.readings, answers, strict=True)
        )
