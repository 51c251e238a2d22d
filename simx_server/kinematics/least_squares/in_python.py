"""Least squares for a problem: the form in Python. `native/_least_squares.c` does the same."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from simx_server.kinematics.scratch import Array
from simx_server.scene.poses.poses import (
    Pose,
    Quaternion,
    Vector,
    add,
    compose,
    inverse,
    matrix,
    multiply,
    normalised,
    scale,
    turn_z_to,
)

from .problem import LinkKind
from .rows import End, Frames, Miss, weighted_length
from .steps import Row, change, dot, length

_ENOUGH = 0.01
"""Share of the precision below which the solver stops; so a target at rest leaves the joints at rest."""

_STUCK = 1e-7
"""rad or m: an iteration that moves no joint farther is the last."""

HALVINGS = 6
"""Number of times that a step is halved if it increases the error; then the position counts as the nearest."""

_Z = (0.0, 0.0, 1.0)


class InPython:
    """The form in Python, of the arrays of a `Problem`."""

    def __init__(
        self,
        links: NDArray[np.int32],
        present: Array,
        balls: Array,
        ends: NDArray[np.int32],
        poses: Array,
        used: NDArray[np.bool_],
        bounds: Array,
    ) -> None:
        self._links: list[list[int]] = links.tolist()
        self._balls = sorted(column for _, kind, column in self._links if kind == LinkKind.BALL)
        """First columns of the spherical joints."""
        self._fixed: list[Pose] = []
        """Pose of each link's frame, with its joint at 0, in the link before it."""
        moved: list[Pose] = []
        for (before, _, _), now, at_zero in _frames(self._links, present.tolist(), balls.tolist()):
            self._fixed.append(_seen_from(moved, before, at_zero))
            moved.append(now)
        self._ends = [
            End(
                tip_link=tip,
                base_link=base,
                constraints=constraints,
                tip=_seen_from(moved, tip, _pose(each[:7])),
                base=_seen_from(moved, base, _pose(each[7:14])),
                weights=each[14:16],
                precision=each[16:18],
                used=columns,
            )
            for (tip, base, constraints), each, columns in zip(
                ends.tolist(), poses.tolist(), used.tolist(), strict=True
            )
        ]
        self._low, self._high, self._steps, self._eagerness = bounds.tolist()
        self.rows = sum(
            (end.constraints & 7).bit_count() + 2 * bool(end.constraints & 8) + bool(end.constraints & 16)
            for end in self._ends
        )

    def solve(
        self,
        values: Array,
        turns: Array,
        goals: Array,
        method: int,
        damping: float,
        stretch: float,
        iterations: int,
        most_looks: int,
        /,
    ) -> tuple[float, float, bool, bool, int]:
        """Do what `LeastSquares.solve` says."""
        aims = [_pose(each) for each in goals.tolist()]
        present: list[Quaternion] = [(w, x, y, z) for w, x, y, z in turns.tolist()]
        place = self._clipped(values.tolist())
        steps = [stretch * each for each in self._steps]
        error, jacobian, misses = self._look(place, present, aims)
        left = most_looks - 1
        for _ in range(iterations):
            if self._are_within(misses, _ENOUGH):
                break
            ways = self._limited_change(place, error, jacobian, method, damping)
            factor = 1.0
            for way, step in zip(ways, steps, strict=True):
                share = abs(way) / step
                factor = share if share > factor else factor
            ways = [way / factor for way in ways]
            square = dot(error, error)
            trial, looked = place, (error, jacobian, misses)
            for _ in range(min(HALVINGS, left)):
                left -= 1
                trial = self._clipped([a + b for a, b in zip(place, ways, strict=True)])
                looked = self._look(trial, present, aims)
                if dot(looked[0], looked[0]) < square:
                    break
                # The step is too long: out of reach, the direction of improvement curves back.
                ways = [way * 0.5 for way in ways]
            else:
                break
            place, (error, jacobian, misses) = trial, looked
            # Further turns start where the spherical joints are now.
            present = [normalised(self._turned(place, present, number)) for number in range(len(present))]
            for column in self._balls:
                place[column : column + 3] = 0.0, 0.0, 0.0
            if not any(abs(way) >= _STUCK for way in ways):
                break
        values[:] = place
        turns[:] = np.array(present, dtype=float).reshape(-1, 4)
        at_limit = any(
            value <= low or value >= high
            for value, low, high in zip(place, self._low, self._high, strict=True)
        )
        distance, angle = max(miss[0] for miss in misses), max(miss[1] for miss in misses)
        return distance, angle, self._are_within(misses, 1.0), at_limit, most_looks - left

    def look(self, values: Array, turns: Array, goals: Array, error: Array, jacobian: Array, /) -> None:
        """Do what `LeastSquares.look` says."""
        aims = [_pose(each) for each in goals.tolist()]
        found = self._look(values.tolist(), turns.tolist(), aims)
        error[:] = found[0]
        jacobian[:] = np.array(found[1], dtype=float).reshape(jacobian.shape)

    def tips(self, values: Array, turns: Array, poses: Array, /) -> None:
        """Do what `LeastSquares.tips` says."""
        frames = self._frames(values.tolist(), turns.tolist())
        for number, end in enumerate(self._ends):
            place, turn = frames.carried(end.tip_link, end.tip)
            poses[number] = (*place, *turn)

    def sample(
        self,
        random: np.random.Generator,
        low: Array,
        extent: Array,
        goals: Array,
        metric: Sequence[float],
        threshold: float,
        most: int,
        values: Array,
        /,
    ) -> tuple[int, bool]:
        """Do what `LeastSquares.sample` says."""
        aims = [_pose(each) for each in goals.tolist()]
        for number in range(1, most + 1):
            values[:] = low + extent * random.random(len(low))
            frames = self._frames(values.tolist(), ())
            tips = [frames.carried(end.tip_link, end.tip) for end in self._ends]
            if all(
                weighted_length(tip, aim, metric) <= threshold for tip, aim in zip(tips, aims, strict=True)
            ):
                return number, True
        return most, False

    def _look(
        self, values: Sequence[float], turns: Sequence[Sequence[float]], aims: Sequence[Pose]
    ) -> tuple[Row, list[Row], list[Miss]]:
        frames = self._frames(values, turns)
        error: Row = []
        jacobian: list[Row] = []
        misses: list[Miss] = []
        for end, aim in zip(self._ends, aims, strict=True):
            part, rows, miss = end.rows(self._links, frames, aim)
            error += part
            jacobian += rows
            misses.append(miss)
        return error, jacobian, misses

    def _frames(self, values: Sequence[float], turns: Sequence[Sequence[float]]) -> Frames:
        poses: list[Pose] = []
        axes: list[Sequence[Vector]] = []
        for (before, kind, column), fixed in zip(self._links, self._fixed, strict=True):
            place, turn = fixed if before < 0 else compose(poses[before], fixed)
            if kind == LinkKind.BALL:
                turn = multiply(turn, self._turned(values, turns, self._balls.index(column)))
                (a, b, c), (d, e, f), (g, h, i) = matrix(turn)
                axes.append(((a, d, g), (b, e, h), (c, f, i)))
            else:
                axis = _z_of(turn)
                axes.append((axis,))
                if kind == LinkKind.SLIDE:
                    place = add(place, scale(axis, values[column]))
                else:
                    turn = multiply(turn, _about(_Z, values[column]))
            poses.append((place, turn))
        return Frames(poses, axes)

    def _turned(self, values: Sequence[float], turns: Sequence[Sequence[float]], number: int) -> Quaternion:
        """Return the value of a spherical joint after the turn in the values."""
        w, x, y, z = turns[number]
        column = self._balls[number]
        a, b, c = values[column : column + 3]
        angle = length((a, b, c))
        axis = (a / angle, b / angle, c / angle) if angle > 0 else _Z
        return multiply((w, x, y, z), _about(axis, angle))

    def _clipped(self, values: Sequence[float]) -> Row:
        found: Row = []
        for value, low, high in zip(values, self._low, self._high, strict=True):
            value = low if value < low else value
            found.append(high if value > high else value)
        return found

    def _are_within(self, misses: Sequence[Miss], share: float) -> bool:
        """Return whether all tips are within this share of their precisions."""
        for end, (distance, angle) in zip(self._ends, misses, strict=True):
            if distance > end.precision[0] * share or angle > end.precision[1] * share:
                return False
        return True

    def _limited_change(
        self, values: Row, error: Row, jacobian: list[Row], method: int, damping: float
    ) -> Row:
        """Return the change of one step.

        A joint that would leave its interval stays, and the others are solved again.
        """
        eager = list(self._eagerness)
        while True:
            rows = [[a * b for a, b in zip(row, eager, strict=True)] for row in jacobian]
            found = change(rows, error, method, damping, len(eager))
            ways = [a * b for a, b in zip(eager, found, strict=True)]
            outside = [
                column
                for column, (value, way) in enumerate(zip(values, ways, strict=True))
                if (value <= self._low[column] and way < 0) or (value >= self._high[column] and way > 0)
            ]
            if not outside:
                return ways
            for column in outside:
                eager[column] = 0.0


def _frames(
    links: Sequence[Sequence[int]], present: Sequence[Sequence[float]], balls: Sequence[Sequence[float]]
) -> Iterator[tuple[Sequence[int], Pose, Pose]]:
    """Yield links with the world poses of their frames, as they are and with the joint at 0."""
    turns = iter(balls)
    for link, (x, y, z, a, b, c, value, rest) in zip(links, present, strict=True):
        anchor = x, y, z
        if link[1] == LinkKind.BALL:
            qw, qx, qy, qz, rw, rx, ry, rz = next(turns)
            yield link, (anchor, (qw, qx, qy, qz)), (anchor, (rw, rx, ry, rz))
            continue
        turn = turn_z_to((a, b, c))
        if link[1] == LinkKind.HINGE:
            yield link, (anchor, turn), (anchor, multiply(turn, _about(_Z, -value)))
        else:
            now, zero = (add(anchor, scale((a, b, c), way)) for way in (value - rest, -rest))
            yield link, (now, turn), (zero, turn)


def _seen_from(moved: Sequence[Pose], link: int, pose: Pose) -> Pose:
    """Return a world pose in the frame of a link."""
    return pose if link < 0 else compose(inverse(moved[link]), pose)


def _pose(numbers: Sequence[float]) -> Pose:
    x, y, z, qw, qx, qy, qz = numbers
    return (x, y, z), (qw, qx, qy, qz)


def _z_of(turn: Quaternion) -> Vector:
    w, x, y, z = turn
    return 2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)


def _about(axis: Vector, angle: float) -> Quaternion:
    """Return the rotation about an axis; not a number for an infinite angle, as in C."""
    half = angle / 2 if math.isfinite(angle) else math.nan
    sine = math.sin(half)
    return math.cos(half), axis[0] * sine, axis[1] * sine, axis[2] * sine
