"""The class `Path` of API 2: its options, and the objects that it belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from simx_server.errors import CommandError
from simx_server.parts.instances import Instance
from simx_server.parts.paths.configuration_path import ConfigurationPath, Rules, Way
from simx_server.parts.paths.configurations import POSE, Array, Bounds, Coordinate, Space
from simx_server.sim_api.object_model.values import Color, Matrix, to_color, to_matrix

_COORDINATES = {"lin": Coordinate.LINEAR, "ang": Coordinate.ANGLE, "quat": Coordinate.QUATERNION}
_WORDS = {coordinate: word for word, coordinate in _COORDINATES.items()}

_POINT_TYPES, _LINE_TYPES = ("none", "sphere", "cube"), ("none", "line", "tube")
_WAY_TYPES = ("linear", "quadraticBezier")


@dataclass(frozen=True)
class Look:
    """How markers show points."""

    point_type: str
    point_color: Color
    point_radius: float
    line_type: str
    line_color: Color
    tube_radius: float
    shows_axes: bool

    def described(self) -> dict[str, Any]:
        """Return it as the options that make it."""
        return {
            "pointType": self.point_type,
            "pointColor": self.point_color,
            "pointRadius": self.point_radius,
            "lineType": self.line_type,
            "lineColor": self.line_color,
            "tubeRadius": self.tube_radius,
            "showAxes": self.shows_axes,
        }


@dataclass(frozen=True)
class Carrier:
    """The objects that a path leads: joints with the object at their end and that at their base, or one object."""

    joints: tuple[int, ...] = ()
    tip: int = -1
    base: int = -1
    """-1: the world."""
    object: int = -1


@dataclass(eq=False)
class PathInstance(Instance):
    """A path."""

    kind = "Path"

    path: ConfigurationPath
    control_look: Look
    way_look: Look
    repeats_start: bool
    """Whether `data` repeats the first point of a closed path at the end."""
    carrier: Carrier = field(default_factory=Carrier)
    markers: dict[str, dict[str, int]] = field(default_factory=dict[str, dict[str, int]])
    """Handles of its markers, by the group of points and by what they show."""

    @property
    def space(self) -> Space:
        """Return its coordinates."""
        return self.path.space

    @property
    def shown_coordinates(self) -> int:
        """Return how many coordinates markers show: 7 for poses, 3 or 2 for places, 0: none."""
        kinds = self.space.kinds
        if kinds[:7] == POSE:
            return 7
        linear = [kind == Coordinate.LINEAR for kind in kinds[:3]]
        return 3 if len(linear) == 3 and all(linear) else 2 if len(linear) > 1 and all(linear[:2]) else 0

    def data(self) -> dict[str, Any]:
        """Return what `Path:data` does: the points with their distances, and the options."""
        self.path.update()
        control, way, rules = self.path.control, self.path.way, self.path.rules
        found: dict[str, Any] = {
            "opt": self.options(),
            "ctrlPoints": self._measured(control) | {"opt": self.control_options()},
        }
        found["pathPoints"] = {"opt": self.way_options()}
        if not rules.only_control_points:
            found["pathPoints"] |= self._measured(way)
        return found

    def _measured(self, way: Way) -> dict[str, Any]:
        points, along = way.points, way.along
        if way.is_closed and self.repeats_start and len(points) > 1:
            points, along = way.ring, np.append(along, way.length)
        return {
            "points": columns(points, len(self.space)),
            "arcLengths": Matrix.vector(way.lengths.tolist()),
            "distancesAlongPath": Matrix.vector(along.tolist()),
            "pathLength": way.length,
        }

    def options(self) -> dict[str, Any]:
        """Return the options of the whole path."""
        space, rules = self.space, self.path.rules
        return {
            "dim": len(space),
            "types": [_WORDS[kind] for kind in space.kinds],
            "metric": Matrix.vector(space.metric),
            "bounds": [list(each) if each else [] for each in space.bounds],
            "closed": rules.is_closed,
            "closedRepeatsStart": self.repeats_start,
            "onlyCtrlPoints": rules.only_control_points,
        }

    def control_options(self) -> dict[str, Any]:
        """Return the options of the control points."""
        rules = self.path.rules
        return {
            "duplicateThreshold": rules.merged_below,
            "linearityTolerance": rules.straight_below,
            **self.control_look.described(),
        }

    def way_options(self) -> dict[str, Any]:
        """Return the options of the points of the way."""
        rules = self.path.rules
        return {
            "type": _WAY_TYPES[rules.is_curved],
            "bezierSmoothing": rules.smoothing,
            "samplingDistance": rules.sampling,
            **self.way_look.described(),
        }


def made(points: Any, options: Mapping[str, Any], carrier: Carrier | None = None) -> PathInstance:
    """Return a path of control points and options. Raises CommandError.

    Args:
        points: a matrix whose columns are the points; None: none.
        options: as of the constructor of `Path`.
        carrier: what it leads.
    """
    matrix = None if points is None else _matrix(points)
    kinds = _kinds(options.get("types"), matrix)
    space = Space.of(kinds, _metric(options.get("metric")), _bounds(options.get("bounds")))
    control, way = _part(options, "ctrlPoints"), _part(options, "pathPoints")
    smoothing = _number(way, "bezierSmoothing", 1.0)
    sampling = _number(way, "samplingDistance", 0.02)
    if not 0.05 <= smoothing <= 1.0 or sampling <= 0:
        raise CommandError("'bezierSmoothing' is 0.05 to 1, and 'samplingDistance' is above 0")
    rules = Rules(
        is_closed=bool(options.get("closed", False)),
        merged_below=_number(control, "duplicateThreshold", 0.02),
        straight_below=_number(control, "linearityTolerance", 0.001),
        sampling=sampling,
        smoothing=smoothing,
        is_curved=_word(way, "type", _WAY_TYPES, "quadraticBezier") == "quadraticBezier",
        only_control_points=bool(options.get("onlyCtrlPoints", False)),
    )
    path = PathInstance(
        ConfigurationPath(space, rules),
        _look(control, "cube", 0.005, ("#ffff00", "#ff8800")),
        _look(way, "none", 0.002, ("#000000", "#050505")),
        bool(options.get("closedRepeatsStart", False)),
        carrier or Carrier(),
    )
    if matrix is not None:
        path.path.set_points(rows(matrix, len(space)))
    return path


def rows(points: Any, length: int) -> Array:
    """Return the columns of a matrix as rows (n, d). Raises CommandError: they have another length."""
    matrix = _matrix(points)
    if matrix.rows != length:
        raise CommandError(
            f"a point of this path has {length} coordinates: a matrix of points has as many rows"
        )
    return np.array(matrix.numbers, dtype=float).reshape(matrix.rows, matrix.columns).T


def columns(points: Array, length: int) -> Matrix:
    """Return rows (n, d) as the columns of a matrix."""
    return Matrix(length, len(points), points.T.ravel().tolist())


def vector(value: Any, length: int) -> Array:
    """Return a point (d,). Raises CommandError."""
    matrix = _matrix(value)
    if len(matrix.numbers) != length:
        raise CommandError(f"a point of this path has {length} coordinates, not {len(matrix.numbers)}")
    return np.array(matrix.numbers, dtype=float)


def _matrix(value: Any) -> Matrix:
    try:
        return to_matrix(value)
    except TypeError as problem:
        raise CommandError(f"points are {problem}") from None


def _kinds(given: Any, points: Matrix | None) -> tuple[Coordinate, ...]:
    if given is None:
        if points is None:
            raise CommandError(
                "a path without points has the option 'types': lin, ang or quat of each coordinate"
            )
        return POSE if points.rows == len(POSE) else (Coordinate.LINEAR,) * points.rows
    if not isinstance(given, list):
        raise CommandError("'types' is a table of lin, ang and quat")
    words = [_text(each) for each in cast(list[Any], given)]
    for word in words:
        if word not in _COORDINATES:
            raise CommandError(
                f"'{word[:40]}' is no type of a coordinate; those are {', '.join(_COORDINATES)}"
            )
    if points is not None and len(words) != points.rows:
        raise CommandError(f"'types' has {len(words)} items, and a point has {points.rows} coordinates")
    return tuple(_COORDINATES[word] for word in words)


def _metric(given: Any) -> list[float] | None:
    return None if given is None else _matrix(given).numbers


def _bounds(given: Any) -> list[Bounds | None] | None:
    if given is None:
        return None
    if not isinstance(given, list):
        raise CommandError("'bounds' is a table with {least, greatest} or {} for each coordinate")
    found: list[Bounds | None] = []
    for each in cast(list[Any], given):
        pair = [] if each in ({}, None) else _matrix(each).numbers
        if len(pair) not in (0, 2) or (pair and pair[1] < pair[0]):
            raise CommandError("'bounds' is a table with {least, greatest} or {} for each coordinate")
        found.append((pair[0], pair[1]) if pair else None)
    return found


def _part(options: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = options.get(name)
    if found is None or found == []:
        return {}
    if not isinstance(found, dict):
        raise CommandError(f"the option '{name}' is a map")
    return cast(dict[str, Any], found)


def _look(options: Mapping[str, Any], point: str, radius: float, colors: tuple[str, str]) -> Look:
    point_color, line_color = (
        _color(options.get(name), first)
        for name, first in zip(("pointColor", "lineColor"), colors, strict=True)
    )
    return Look(
        _word(options, "pointType", _POINT_TYPES, point),
        point_color,
        _number(options, "pointRadius", radius),
        _word(options, "lineType", _LINE_TYPES, "line"),
        line_color,
        _number(options, "tubeRadius", 0.0025),
        bool(options.get("showAxes", False)),
    )


def _color(given: Any, first: str) -> Color:
    try:
        return to_color(bytes.fromhex(first[1:]) if given is None else given)
    except TypeError as problem:
        raise CommandError(f"an option must be {problem}") from None


def _number(options: Mapping[str, Any], name: str, first: float) -> float:
    value = options.get(name)
    if value is None:
        return first
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
        raise CommandError(f"'{name}' is a number")
    return float(value)


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _word(options: Mapping[str, Any], name: str, words: tuple[str, ...], first: str) -> str:
    """Return an option that is one of some words, or its number."""
    value = options.get(name)
    if value is None:
        return first
    if isinstance(value, int) and 0 <= value < len(words):
        return words[value]
    word = _text(value)
    if word not in words:
        raise CommandError(f"'{name}' is one of {', '.join(words)}, not '{word[:40]}'")
    return word
