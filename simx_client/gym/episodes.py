"""Episodes of a task on simulations that step together: one message per simulation and step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from simx_client.client.servers import Servers
from simx_client.connection.calls import Calls
from simx_client.errors import SimxError
from simx_client.protocol import constants as c

from .actions import Actions
from .lookup import Objects
from .names import Subject, read_name
from .observations import Observations, find_reading, groups_of
from .task import State, Task
from .writable import WRITABLE, Writable


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
        self._counted = {
            part.name.text: name for part in self.actions.parts if (name := part.counted_from) is not None
        }
        read = dict.fromkeys((*texts, *task.measures))
        self._readings = [find_reading(text, self._objects) for text in read]
        self._started = {name.text: find_reading(name.text, self._objects) for name in self._counted.values()}
        self._starts: dict[str, tuple[Writable, list[Subject]]] = {
            text: self._writable(text, len(value)) for text, value in starts.items()
        }
        self.observations = Observations(
            task.observations, {each.name.text: each for each in self._readings}, servers
        )
        self._random = None if task.randomize is None else task.randomize.on(servers)
        self.states: list[State] = [State() for _ in range(len(servers))]
        """The newest state of each simulation."""

        self._values: list[dict[str, list[float]]] = [{} for _ in range(len(servers))]
        """Values of the increments, for each simulation by name."""

        self._steps: dict[int, tuple[Calls, list[Any]]] = {}
        """For each simulation the calls of every step, behind those of the action, and the answers of `_readings`."""

    def start(self, random: Mapping[int, np.random.Generator]) -> None:
        """Start an episode: a stop restores the state of the scene, so equal episodes are equal bit for bit.

        Args:
            random: generators of the simulations, by index; the others are left as they are.
        """
        drawn = {
            place: {} if self._random is None else self._random.draw(place, generator)
            for place, generator in random.items()
        }
        starts = {place: self.task.draw_start(generator) for place, generator in random.items()}

        def note(calls: Calls, place: int) -> tuple[list[Any], list[Any]]:
            if place not in starts:
                return [], []
            self._note_start(calls, place, drawn[place], starts[place])
            read = (self._readings, self._started.values())
            answers, counted = (
                [each.note(calls, place, is_start=True) for each in readings] for readings in read
            )
            return answers, counted

        for place, (answers, counted) in enumerate(self.servers.each(note)):
            if place in starts:
                self.states[place] = self._state(answers)
                found = dict(zip(self._started, counted, strict=True))
                self._values[place] = {
                    text: np.atleast_1d(self._started[name.text].value(found[name.text])).tolist()
                    for text, name in self._counted.items()
                }

    def step(self, actions: Mapping[int, Any]) -> None:
        """Make a step of some of the simulations.

        Args:
            actions: by the index of the simulation.

        Raises:
            CallsFailed: a simulation is gone, or refused a call; the others have made the step.
            ValueError: an action is not valid; no simulation has made the step.
            SimxError: no episode was started; no simulation has made the step.
        """
        if not all(self.states[place] for place in actions):
            raise SimxError("no episode was started yet; call reset first")
        numbers = {
            place: self.actions.values(action, self._values[place]) for place, action in actions.items()
        }

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
                after.before, after.action = self.states[place], actions[place]
                after.before.before = None  # otherwise all states of the episode would be kept
                self.states[place] = after
                if self._counted:
                    for part, value in zip(self.actions.parts, numbers[place], strict=True):
                        if part.name.text in self._counted:
                            self._values[place][part.name.text] = value

    def end(self) -> None:
        """Stop the simulations that still answer, and leave stepped mode."""
        self.servers.each(
            lambda calls, _: (calls.simxStopSimulation(), calls.simxSynchronous(False)), check=False
        )

    def _note_start(
        self, calls: Calls, place: int, drawn: Mapping[str, list[float]], values: Mapping[str, list[float]]
    ) -> None:
        calls.simxStopSimulation()
        if self.task.time_step is not None:
            calls.simxSetFloatingParameter(c.sim_floatparam_simulation_time_step, self.task.time_step)
        calls.simxSynchronous(True)
        calls.simxStartSimulation()
        if self._random is not None:  # within the run, so that the stop restores the scene
            self._random.note(calls, place, drawn)
        for text, value in values.items():
            if text not in self._starts:
                raise ValueError(
                    f"start returned {text!r}, which it had not returned at first: it must always return the same names"
                )
            entry, subjects = self._starts[text]
            entry.note(calls, subjects[place], value)

    def _note_step(self, place: int, where: str) -> tuple[Calls, list[Any]]:
        calls = Calls(place, where)
        for _ in range(self.task.frame_skip):
            calls.simxSynchronousTrigger()
        answers = [each.note(calls, place, is_start=False) for each in self._readings]
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
            for reading, answer in zip(self._readings, answers, strict=True)
        )
