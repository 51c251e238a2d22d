"""Fit values of a scene so that a repeated run meets a recorded one, by `mujoco.sysid`.

Each candidate is a replay of the same calls in the changed scene. Values are fitted by their logarithms: they are above
0, and may be wrong by a factor.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simx_client.protocol.cli.installing import extra_line
from simx_server.app.compare.departures import aligned
from simx_server.app.compare.quantities import JOINT, ORIENTATION
from simx_server.app.compare.replayed import replayed
from simx_server.app.compare.trajectories import Floats, Quantity, Run, Series
from simx_server.errors import CommandError
from simx_server.recording.replayed import Divergence
from simx_server.settings.settings import Settings

from .parameters import Free

if TYPE_CHECKING:
    from .parameters import Spec

STEPS = (3e-2, 1e-3)
"""Steps of the logarithms for derivatives. The first one sees over the small steps that contacts make in the
differences, the second one finds the place."""

STILL = 1e-6
"""Range below which a quantity says nothing, because it does not move."""

MISSING = 10.0
"""Residual of a value that a candidate does not reach, because its physics diverged: ten times the range."""


@dataclass(frozen=True)
class Fitted:
    """The result of one value."""

    free: Free
    value: float
    factor: float
    """The 95 % interval is from ``value / factor`` to ``value * factor``; infinite: the runs do not tell the value."""

    @property
    def is_at_bound(self) -> bool:
        """Return whether the value ended at one of its bounds."""
        return min(abs(math.log(self.value / each)) for each in (self.free.least, self.free.most)) < 0.01


@dataclass(frozen=True)
class Outcome:
    """The result of a fit."""

    values: list[Fitted]
    before: float
    after: float
    """Root mean square of the residuals, in shares of the quantities' ranges."""

    replays: int
    run: Run
    """The run with the fitted values."""


class Problem:
    """A recorded run, a run of ours to repeat, and the values that are free."""

    def __init__(
        self,
        recording: Path,
        target: Run,
        free: Sequence[Free],
        *,
        chosen: Settings | None = None,
        report: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Replay the run once as it is.

        Args:
            recording: of ``simx-server --record``; its calls are repeated.
            target: the states to meet.
            free: the values.
            report: gets a line after each replay.

        Raises:
            CommandError: the two have no moving quantity in common.
        """
        self._recording, self._free, self._chosen, self._report = recording, free, chosen, report
        quantities = [each for each, series in target.series.items() if _range(series) > STILL]
        self.moving = Run({each: target.series[each] for each in quantities})
        """The part of the recorded run that says something."""

        self.first = replayed(recording, quantities, chosen=chosen)
        self._targets: dict[Quantity, Series] = {}
        for quantity in sorted(self.first.series.keys() & set(quantities)):
            series = target.series[quantity]
            places, _ = aligned(series.times, self.first.series[quantity])
            if len(places):
                self._targets[quantity] = Series(series.times[places], series.values[places])
        if not self._targets:
            raise CommandError(
                "no quantity that moves in the recorded run is in the run here at the same times; "
                "the names of objects must be those of the scene"
            )
        self.replays = 0

    @property
    def quantities(self) -> list[Quantity]:
        """Return the quantities that are met."""
        return list(self._targets)

    def change(self, values: Sequence[float]) -> Callable[[Spec], None]:
        """Return a change of the scene to these values."""

        def change(spec: Spec) -> None:
            for each, value in zip(self._free, values, strict=True):
                each.put(spec, value)

        return change

    def run(self, values: Sequence[float]) -> Run:
        """Return the run in the scene with these values."""
        self.replays += 1
        return replayed(self._recording, self.quantities, change=self.change(values), chosen=self._chosen)

    def residual(self, values: Sequence[float]) -> Floats:
        """Return all differences from the recorded run, each in shares of its quantity's range, shape (n,)."""
        try:
            found = self.run(values)
        except Divergence:
            found = Run({})
        parts = [self._part(quantity, found.series.get(quantity)) for quantity in self._targets]
        residual = np.concatenate(parts)
        shown = ", ".join(f"{each}={value:.5g}" for each, value in zip(self._free, values, strict=True))
        self._report(f"{rms(residual):10.3e}  {shown}")
        return residual

    def _part(self, quantity: Quantity, series: Series | None) -> Floats:
        target = self._targets[quantity]
        width = 3 if quantity.name == ORIENTATION else target.values.shape[1]
        differences = np.full((len(target.times), width), MISSING)
        if series is not None and len(series.times):
            places, values = aligned(target.times, series)
            scale = 1.0 if quantity.name == ORIENTATION else _range(target)
            differences[places] = _differences(quantity, values, target.values[places]) / scale
        # Quantities count alike, however many numbers they have.
        return differences.ravel() / math.sqrt(differences.size)


def _range(series: Series) -> float:
    return float(np.max(np.ptp(series.values, axis=0))) if len(series.times) else 0.0


def _differences(quantity: Quantity, one: Floats, other: Floats) -> Floats:
    if quantity.name == ORIENTATION:
        return _turns(one, other)
    found = one - other
    return (
        (found + math.pi) % (2 * math.pi) - math.pi
        if quantity.name == JOINT and np.any(abs(found) > math.pi)
        else found
    )


def _turns(one: Floats, other: Floats) -> Floats:
    """Return the rotation from one orientation to another in half angles, shape (n, 3); quaternions w, x, y, z."""
    w, v = one[:, :1], one[:, 1:]
    w2, v2 = other[:, :1], -other[:, 1:]
    turned = w * v2 + w2 * v + np.cross(v, v2)
    return np.where(w * w2 - np.sum(v * v2, axis=1, keepdims=True) < 0, -turned, turned)


def rms(residual: Floats) -> float:
    """Return the root of the summed squares; those of a quantity are a mean."""
    return float(np.sqrt(np.sum(residual**2)))


def sysid() -> Any:
    """Return `mujoco.sysid`. Raises CommandError: the packages that it needs are missing."""
    from mujoco import sysid as found

    if not hasattr(found, "optimize"):  # it leaves its names out without them
        raise CommandError(f"simx fit needs packages of mujoco.sysid; install them: {extra_line('fit')}")
    return found


def fit(problem: Problem, free: Sequence[Free], *, most_iterations: int = 30) -> Outcome:
    """Fit the values.

    Raises:
        CommandError: `mujoco.sysid` is not complete here.
    """
    toolbox = sysid()
    parameters = toolbox.ParameterDict()
    for each in free:
        parameters.add(
            toolbox.Parameter(str(each), math.log(each.start), math.log(each.least), math.log(each.most))
        )
    # From a bound, the first steps would lead nowhere.
    parameters.move_off_bounds()
    start = np.exp(parameters.as_vector())

    def residual(x: Any, _: Any) -> tuple[list[Any], None, None]:
        columns = np.exp(np.atleast_2d(np.asarray(x).T))
        found = np.column_stack([problem.residual(list(map(float, column))) for column in columns])
        return [found[:, 0] if np.ndim(x) == 1 else found], None, None

    before = problem.residual(list(map(float, start)))
    fitted: Any = parameters
    result: Any = None
    for step in STEPS:
        fitted, result = toolbox.optimize(
            fitted,
            residual,
            optimizer="mujoco",
            verbose=False,
            max_iters=most_iterations,
            eps=step,
            xtol=1e-5,
            x_scale="jac",  # values differ much in how far they move a run
            output=StringIO(),  # its own lines; `report` has ours
        )
    values = list(map(float, np.exp(fitted.as_vector())))
    after = problem.residual(values)
    intervals = _intervals(toolbox, after, np.asarray(result.jac))
    run = problem.run(values)
    found = [
        Fitted(each, value, math.exp(min(interval, 700.0)) if math.isfinite(interval) else math.inf)
        for each, value, interval in zip(free, values, intervals, strict=True)
    ]
    return Outcome(found, rms(before), rms(after), problem.replays, run)


def _intervals(toolbox: Any, residual: Floats, jacobian: Floats) -> list[float]:
    """Return the half widths of the 95 % intervals; infinite for values that change no residual."""
    found = np.full(jacobian.shape[1], math.inf)
    told = np.flatnonzero(np.linalg.norm(jacobian, axis=0))
    if len(told):
        found[told] = np.ravel(toolbox.calculate_intervals([residual], jacobian[:, told])[1])
    return found.tolist()
