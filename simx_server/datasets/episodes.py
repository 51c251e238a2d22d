"""Collect the episodes of a replay: what was observed before each simulation step, and what was commanded for it.

Each run is an episode, from the start of the simulation to its stop. A recording may mark parts of its runs instead, by
the integer signal `demonstration`: 1 starts an episode, 2 ends it as a success, 3 discards it. At least one simulation
step lies between two marks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.add_ons.teleoperation import DISCARDED, MARK, STARTED, SUCCEEDED
from simx_server.errors import CommandError
from simx_server.outputs.filming.shot import Pixels
from simx_server.simulation.part import Part

from .cameras import Cameras
from .quantities import Quantity, find, usual_actions, usual_observations
from .wanted import Light, Wanted

if TYPE_CHECKING:
    from simx_server.world.world import World

Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Choice:
    """The contents of a dataset; empty lists stand for the usual ones."""

    observations: Sequence[str] = ()
    actions: Sequence[str] = ()
    cameras: Sequence[Wanted] = ()
    light: Light = field(default_factory=Light)
    only_successes: bool = False


@dataclass(frozen=True)
class Layout:
    """The form of all episodes of a dataset."""

    observations: tuple[str, ...]
    """The name of each number."""

    is_of_robot: tuple[bool, ...]
    """For each number of an observation; the others belong to the surroundings."""

    actions: tuple[str, ...]
    cameras: dict[str, tuple[int, int]]
    """Width and height of the images."""

    time_step: float


@dataclass(frozen=True)
class Episode:
    """One episode of n simulation steps."""

    times: Numbers
    """(n + 1,) simulated seconds."""

    observations: Numbers
    """(n + 1, k), before each step, and at the end."""

    actions: Numbers
    """(n, m): what was commanded while step i was made, after observation i."""

    images: dict[str, NDArray[np.uint8]]
    """(n + 1, height, width, 3) by camera, RGB from the top row."""

    is_success: bool | None
    """None: the recording does not say."""


class Writer(Protocol):
    """Writes a dataset, one episode after the other."""

    def add(self, layout: Layout, episode: Episode) -> None: ...

    def close(self) -> None: ...


class Collector(Part):
    """Collects the episodes of a world. Physics thread. Call `before_step` before each simulation step."""

    def __init__(self, world: World, choice: Choice, take: Callable[[Layout, Episode], object]) -> None:
        """Listen to a world; `take` gets each episode when it is over."""
        self._world, self._choice, self._take = world, choice, take
        self._layout: Layout | None = None
        self._rows: _Rows | None = None
        """None: no episode is collected."""

        self._is_marked = self._is_due = False
        self._problem: Exception | None = None
        """It came up where only the server's own code could catch it."""

        self.episodes = self.left_out = 0
        """Number of episodes that were taken, and of others."""

        world.simulation.parts.attach(self)

    def run_started(self) -> None:
        self._is_due = True

    def before_step(self) -> None:
        """Observe, if an episode is collected; start or end one where the recording has a mark.

        Raises:
            Exception: the episode cannot be collected, or the last one not be written.
        """
        self.check()
        mark = self._world.signals.get_integer(MARK)
        if self._is_due:
            self._begin(is_marked=False)
        if self._is_marked and mark != STARTED:
            self._end(mark)
        elif not self._is_marked and mark == STARTED:
            self._begin(is_marked=True)
        if self._rows is not None:
            self._rows.observe()

    def check(self) -> None:
        """Raise what went wrong at the end of a run."""
        if self._problem is not None:
            raise self._problem

    def step_finished(self) -> None:
        if self._rows is not None:
            self._rows.act()

    def run_stopping(self) -> None:
        try:
            self._end(self._world.signals.get_integer(MARK))
        except Exception as problem:  # the simulation would only log it
            self._problem = problem

    def _begin(self, *, is_marked: bool) -> None:
        self._is_due, self._is_marked = False, is_marked
        self._rows = _Rows(self._world, self._choice)
        layout = self._rows.layout
        if self._layout is not None and layout != self._layout:
            raise CommandError(
                "the episodes differ in joints, free bodies, cameras or time step; choose the numbers by --observe and "
                "--act, or export a recording of one scene"
            )
        self._layout = layout

    def _end(self, mark: int | None) -> None:
        rows, self._rows = self._rows, None
        was_marked, self._is_marked = self._is_marked, False
        if rows is None or not rows.count:
            return
        is_success = mark == SUCCEEDED if was_marked or mark in (SUCCEEDED, DISCARDED) else None
        if mark == DISCARDED or (self._choice.only_successes and not is_success):
            self.left_out += 1
            return
        rows.observe()
        self.episodes += 1
        self._take(rows.layout, rows.episode(is_success))


class _Rows:
    """The steps of an episode so far."""

    def __init__(self, world: World, choice: Choice) -> None:
        """Find the quantities in the scene. Raises CommandError."""
        self._simulation = world.simulation
        self._observed = [find(world, each) for each in choice.observations or usual_observations(world)]
        self._commanded = [find(world, each) for each in choice.actions or usual_actions(world)]
        if not self._observed or not self._commanded:
            raise CommandError(
                "the scene has nothing that is usually observed and commanded; name it by --observe and --act"
            )
        self._cameras = Cameras(world, list(choice.cameras), choice.light)
        self._times: list[float] = []
        self._observations: list[list[float]] = []
        self._actions: list[list[float]] = []
        self._images: dict[str, list[Pixels]] = {name: [] for name in self._cameras.sizes}
        self.layout = Layout(
            _names(self._observed),
            tuple(each.is_of_robot for each in self._observed for _ in each.names),
            _names(self._commanded),
            self._cameras.sizes,
            self._simulation.time_step,
        )

    @property
    def count(self) -> int:
        """Return the number of complete steps."""
        return len(self._actions)

    def observe(self) -> None:
        """Add the present state; in place of an observation that no step has followed."""
        if len(self._times) > self.count:
            self._drop_last()
        self._simulation.refresh()
        self._times.append(self._simulation.time)
        self._observations.append(_numbers(self._observed))
        for name, pixels in self._cameras.take().items():
            self._images[name].append(pixels)

    def act(self) -> None:
        """Add what was commanded in the step that is over."""
        self._actions.append(_numbers(self._commanded))

    def episode(self, is_success: bool | None) -> Episode:
        return Episode(
            np.array(self._times),
            np.array(self._observations),
            np.array(self._actions),
            {name: np.stack(images) for name, images in self._images.items()},
            is_success,
        )

    def _drop_last(self) -> None:
        for rows in (self._times, self._observations, *self._images.values()):
            rows.pop()


def _names(quantities: Sequence[Quantity]) -> tuple[str, ...]:
    return tuple(name for each in quantities for name in each.names)


def _numbers(quantities: Sequence[Quantity]) -> list[float]:
    return [float(number) for each in quantities for number in each.read()]
