"""Paths of CoppeliaSim 4: lists of numbers, configurations one after the other."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from simx_server.errors import CommandError
from simx_server.parts.paths.flat_paths import (
    BEZIER,
    LINEAR,
    MOST_NUMBERS,
    Configuration,
    FlatPath,
    distance,
    lengths_of,
    nearest,
)
from simx_server.parts.paths.splines import BOUNDARIES, cubic_spline
from simx_server.parts.paths.time_optimal import Limits, time_optimal
from simx_server.scripting.conversion.signature import Most
from simx_server.scripting.interpreter import Function, ScriptError
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.values.matrices import vector

_MOST_POINTS = 1000
"""Points of a path to be followed in the shortest time: the spline is a system of equations of this size."""

_Numbers = Annotated[list[float], Most(MOST_NUMBERS)]


class FlatPathFunctions(ApiPart, effect="reads"):
    """Functions for paths as lists. `types` has for each number of a point 0 Cartesian, 1 cyclic with a period of 2
    pi, 2 one of a quaternion's four; nil: all Cartesian.
    """

    def getPathLengths(
        self, path: _Numbers, size: int, measure: str | Function | None = None
    ) -> tuple[list[float], float]:
        """Return the length at each point of `size` numbers, and the total length. The first three numbers count as
        x, y, z, or a function gives the distance between two points.
        """
        own = None if measure is None else self._function(measure)

        def ask(first: Configuration, second: Configuration) -> float:
            assert own is not None
            results = own(first, second)
            if not results or not isinstance(results[0], (int, float)):
                raise ScriptError("the function of sim.getPathLengths must return a number")
            return float(results[0])

        lengths = lengths_of(path, size, None if own is None else ask)
        return lengths, lengths[-1]

    def getPathInterpolatedConfig(
        self,
        path: _Numbers,
        lengths: _Numbers,
        position: float,
        method: dict[str, Any] | None = None,
        types: list[int] | None = None,
    ) -> list[float]:
        """Return the configuration at a length from the start.

        Entries of `method`: `type` linear or quadraticBezier, `strength` of the Bezier curves, `forceOpen` for a path
        whose ends overlap.
        """
        kind, strength, is_open = _method(method)
        return FlatPath(path, lengths, types).at(position, kind, strength, is_open=is_open)

    def resamplePath(
        self,
        path: _Numbers,
        lengths: _Numbers,
        count: int,
        method: dict[str, Any] | None = None,
        types: list[int] | None = None,
    ) -> list[float]:
        """Return the path with this number of points at equal lengths; method and types as for
        getPathInterpolatedConfig.
        """
        kind, strength, is_open = _method(method)
        flat = FlatPath(path, lengths, types)
        if count > MOST_NUMBERS // flat.size:
            raise CommandError(
                f"a path has at most {MOST_NUMBERS} numbers, not {count} points of {flat.size}"
            )
        return flat.resampled(count, kind, strength, is_open=is_open)

    def getClosestPosOnPath(self, path: _Numbers, lengths: _Numbers, point: list[float]) -> float:
        """Return the length at which a path of positions x, y, z is nearest to a point."""
        flat = FlatPath(path, lengths)
        if flat.size < 3:
            raise CommandError(f"a path of positions has three numbers for each point, not {flat.size}")
        return nearest(flat, vector(point, "a point"))

    def generateTimeOptimalTrajectory(
        self,
        path: _Numbers,
        lengths: Annotated[list[float], Most(_MOST_POINTS)],
        velocities: list[float],
        accelerations: list[float],
        samples: int = 1000,
        boundary: str = "not-a-knot",
        _timeout: float = 5.0,
        _script: int = -1,
    ) -> tuple[list[float], list[float], int]:
        """Return the fastest motion along a path, from rest to rest: the points at equal intervals of time, their
        times in s, and -1, since no helper script is needed.

        The path is a cubic spline through the points. Limits: {least, greatest} for each number of a point, in its
        unit per s and per s². `boundary` at the ends of the spline: not-a-knot, clamped, natural or periodic.
        """
        flat = FlatPath(path, lengths)
        if samples < 2 or samples > MOST_NUMBERS // flat.size:
            raise CommandError(f"samples are 2 to {MOST_NUMBERS // flat.size} points, not {samples}")
        knots = np.array(lengths)
        if not (np.isfinite(knots).all() and np.isfinite(path).all() and np.all(np.diff(knots) > 0)):
            raise CommandError("lengths of the points of a path increase, and all numbers are finite")
        if boundary not in BOUNDARIES:
            raise CommandError(f"a boundary condition is {', '.join(BOUNDARIES)}, not '{boundary[:40]}'")
        values = np.reshape(path, (-1, flat.size)).astype(float)
        if boundary == "periodic" and (len(values) < 3 or not np.array_equal(values[0], values[-1])):
            raise CommandError("a periodic path has three points or more, and its ends are equal")
        points, times = time_optimal(
            cubic_spline(knots, values, boundary),
            _limits(velocities, flat.size, "velocities"),
            _limits(accelerations, flat.size, "accelerations"),
            samples,
        )
        return points.ravel().tolist(), times.tolist(), -1

    def closePath(
        self, path: _Numbers, times: Annotated[list[float], Most(MOST_NUMBERS)]
    ) -> tuple[list[float], list[float]]:
        """Return a path that ends where it starts, and its times: the last one is the length of the new piece later."""
        flat = FlatPath(path, times)
        last, first = flat.point(len(times) - 1), flat.point(0)
        return [*path, *first], [*times, times[-1] + lengths_of([*last, *first], flat.size)[1]]

    def getConfigDistance(
        self,
        first: _Numbers,
        second: _Numbers,
        metric: list[float] | None = None,
        types: list[int] | None = None,
    ) -> float:
        """Return the distance between two configurations: the root of the sum of `metric` times squares. A
        quaternion counts once, with its angle.
        """
        return distance(first, second, metric, types)


def _limits(values: list[float], size: int, what: str) -> Limits:
    bounds = np.array(values, dtype=float)
    if len(bounds) != 2 * size or not np.isfinite(bounds).all():
        raise CommandError(f"{what} are {2 * size} finite numbers, {{least, greatest}} for each of a point")
    lower, upper = bounds[::2], bounds[1::2]
    if not (np.all(lower < 0) and np.all(upper > 0)):
        raise CommandError(f"the least of the {what} are below 0, the greatest above")
    return Limits(lower, upper)


def _method(given: dict[str, Any] | None) -> tuple[str, float, bool]:
    """Return type, strength, and whether a path is open although its ends overlap."""
    entries = given or {}
    kind, strength = entries.get("type", LINEAR), entries.get("strength", 1.0)
    if isinstance(kind, bytes):
        kind = kind.decode("utf-8", "replace")
    if kind not in (LINEAR, BEZIER):
        raise CommandError(f"a method's type is {LINEAR} or {BEZIER}, not {kind!r}")
    if not isinstance(strength, (int, float)):
        raise CommandError(f"a method's strength is a number, not {strength!r}")
    return kind, float(strength), bool(entries.get("forceOpen", False))
