"""The controllers of a scene's joints: made when settings have changed, and active within physics steps."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .guards.watch import Watch
from .measured import Measured
from .servo import Entry
from .stepping.apart import Apart, Made
from .stepping.scripted import Ask
from .stepping.stepper import Accompany, Memory, Stepper, Within

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_SCRIPTS = "scripts"
"""Those that call scripts between the physics steps, among the parts that accompany these."""


class Controllers:
    """Controllers that move the joints in physics steps, with the memory of motors from one step to the next."""

    def __init__(self, sim: LiveScene, measured: Measured, entries: Callable[[], Sequence[Entry]]) -> None:
        """Make no controllers yet.

        Args:
            measured: notes positions before the physics steps.
            entries: returns all joints with their settings now.
        """
        self._sim, self._measured, self._entries = sim, measured, entries
        self._watch = Watch(sim)
        self._stepper: Stepper | None = None
        self._earlier: Stepper | None = None
        """The stepper before a change, whose memory the next one takes over."""
        self._asked: Mapping[int, Ask] = {}
        self._custom: frozenset[int] = frozenset()
        """Joints of those that ask only in custom control."""
        self._accompanying: dict[str, Accompany] = {}
        """Functions that are called before and after each physics step, by the part that wants it."""
        self.within_steps: Within | None = None
        """Called within each physics step."""
        self.averages_force = False
        """Whether forces are averaged over the physics steps of a simulation step."""

    # --- settings --------------------------------------------------------------------------------

    def ask(self, asked: Mapping[int, Ask], custom: Collection[int]) -> Collection[int]:
        """Let these functions alone control the motors of their joints (by handle) from the next step on.

        Args:
            custom: joints of them that ask only in custom control.

        Returns:
            Joints that no function controls any more.
        """
        self._custom = frozenset(custom)
        freed = self._asked.keys() - asked.keys()
        if asked or self._asked:
            self._asked = dict(asked)
            self.rebuild()
        return freed

    def accompany(self, call: Accompany | None, name: str = _SCRIPTS) -> None:
        """Call a function before and after each physics step from the next simulation step on; None: no more.

        Args:
            call: takes the index of the step, their number, and whether it is over.
            name: of the part that wants it; each has one function.
        """
        if call == self._accompanying.get(name):
            return
        if call is None:
            del self._accompanying[name]
        else:
            self._accompanying[name] = call
        self.rebuild()

    @property
    def calls_scripts(self) -> bool:
        """Return whether scripts are called between the physics steps of a simulation step."""
        return bool(self._asked) or _SCRIPTS in self._accompanying

    def call_within_steps(self, within: Within | None) -> None:
        """Call a function within each physics step from the next simulation step on; None: no more."""
        self.within_steps = within

    def average_force(self) -> None:
        """Average forces over the physics steps of a simulation step from the next one on, until the run ends."""
        self.averages_force = True

    def retarget(self, handle: int, value: float) -> None:
        """Give a joint another target position; later controllers take it from its settings."""
        if self._stepper is not None:
            self._stepper.retarget(handle, value)

    # --- physics steps ---------------------------------------------------------------------------

    def step(self, count: int, flags: int = 0, *within: Within) -> bool:
        """Make `count` physics steps under the controllers.

        Args:
            count: number of steps.
            flags: what they do besides, see `stepper.LIMIT_SEPARATION`.
            within: called within each of them, beside `within_steps`.

        Returns:
            Whether shapes overlap deeply.

        Raises:
            StepFailed: the simulation step cannot be completed.
            mujoco.FatalError: MuJoCo failed.
        """
        self._measured.begin()
        if self.within_steps is not None:
            within = (self.within_steps, *within)
        stepper = self._stepper or self.stepper
        return stepper.step(count, flags, average_force=self.averages_force, within=within)

    @property
    def may_be_apart(self) -> bool:
        """Return whether nothing within the next physics steps needs Python."""
        return self.within_steps is None and self.stepper.compiled is not None

    def step_apart(
        self, count: int, flags: int, log: Callable[[Sequence[str]], object]
    ) -> Generator[Apart, Made, bool]:
        """Make physics steps as `step`, by the caller; only if they `may_be_apart`.

        Args:
            log: takes the texts of MuJoCo's warnings.
        """
        self._measured.begin()
        return (yield from self.stepper.step_apart(count, flags, log, average_force=self.averages_force))

    @property
    def mean_sensed(self) -> np.ndarray:
        """Return the values of all sensors (as `sensordata`), mean over the last simulation step.

        They are averaged in scenes with force sensors.
        """
        return self.stepper.mean_sensed

    # --- their life ------------------------------------------------------------------------------

    @property
    def stepper(self) -> Stepper:
        """Return the controllers of the next physics steps."""
        if self._stepper is None:
            self._stepper = self._make()
            if self._earlier is not None:
                self._stepper.adopt(self._earlier)
                self._earlier = None
        return self._stepper

    @property
    def made(self) -> Stepper | None:
        """Return the controllers of the next physics steps if they are made already."""
        return self._stepper

    @property
    def have_run(self) -> bool:
        """Return whether controllers were made in this run."""
        return self._stepper is not None or self._earlier is not None

    @property
    def is_rebuilding(self) -> bool:
        """Return whether the controllers are made again before the next physics step."""
        return self._stepper is None and self._earlier is not None

    def rebuild(self) -> None:
        """Request a new stepper before the next physics step, because the arrays' targets are stale.

        It takes over the memory of the old one. Many changes in a row make a single one.
        """
        if self._stepper is not None:
            self._earlier, self._stepper = self._stepper, None

    def forget_run(self) -> None:
        """Forget what motors remember: a run starts."""
        self.averages_force = False
        self._stepper = self._earlier = None

    def remember(self) -> Memory | None:
        """Return what the controllers remember; None: no physics step was made in this run yet."""
        stepper = self._stepper or self._earlier
        return None if stepper is None else stepper.remember()

    def recall(self, memory: Memory | None, *, averages_force: bool, is_rebuilding: bool) -> None:
        """Go on from what `remember` returned.

        Writes velocities of joints that move without a motor.
        """
        self.averages_force = averages_force
        if memory is None:
            return
        self.stepper.recall(memory)
        if is_rebuilding:
            self.rebuild()

    def _make(self) -> Stepper:
        entries = self._entries()
        scripted = {binding.handle for binding, state, _ in entries if state.scripted}
        asked = {
            handle: ask
            for handle, ask in self._asked.items()
            if handle not in self._custom or handle in scripted
        }
        calls = tuple(self._accompanying.values())

        def accompany(index: int, count: int, is_over: bool) -> None:
            for call in calls:
                call(index, count, is_over)

        return Stepper(
            self._sim.model, self._sim.data, entries, self._watch, asked, accompany if calls else None
        )
