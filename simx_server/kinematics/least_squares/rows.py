"""The error of one tip's pose, and the rows of the Jacobian that belong to it."""

from __future__ import annotations

from collections.abc import Sequence

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.kinematics.chain import Constraint
from simx_server.scene.poses.poses import (
    NO_TURN,
    Pose,
    Quaternion,
    Vector,
    compose,
    conjugate,
    matrix,
    multiply,
    normalised,
    rotation_vector,
    subtract,
    turn_z_to,
)

from .problem import LinkKind
from .steps import Row, length

_TINY = 1e-9
"""Parts of a quaternion below which a rotation about z has no sense."""

Miss = tuple[float, float]
"""Distance in metres, and angle in radians, of a tip from its goal."""


@dataclass(frozen=True)
class Frames:
    """Where the links are: of each its world pose, and the axes of its joint."""

    poses: Sequence[Pose]
    axes: Sequence[Sequence[Vector]]
    """One axis of a hinge or slide, three of a spherical joint."""

    def carried(self, link: int, local: Pose) -> Pose:
        """Return the world pose of what a link carries; -1: the world."""
        return local if link < 0 else compose(self.poses[link], local)


@dataclass(frozen=True)
class End:
    """One element: see `Problem`."""

    tip_link: int
    base_link: int
    constraints: int
    tip: Pose
    base: Pose
    weights: Sequence[float]
    precision: Sequence[float]
    used: Sequence[bool]

    def rows(self, links: Sequence[Sequence[int]], frames: Frames, goal: Pose) -> tuple[Row, list[Row], Miss]:
        """Return weighted error (k,) and Jacobian (k, m), and how far the tip is from its goal (in the world).

        First come the coordinates along the base's axes, then rotations about the tip's own axes.
        """
        tip = frames.carried(self.tip_link, self.tip)
        error: Row = []
        rows: list[Row] = []
        linear, angular = self.weights
        across = [i for i in range(3) if self.constraints & (1 << i)]
        if across:
            base = self.base[1]
            if self.base_link >= 0:
                base = multiply(frames.poses[self.base_link][1], base)
            way, axes = subtract(goal[0], tip[0]), matrix(base)
            for i in across:
                axis = axes[0][i], axes[1][i], axes[2][i]
                error.append(_dot(axis, way))
                rows.append([_dot(axis, each) * linear for each in self._columns(links, frames, tip[0])])
        straight = len(error)
        chosen, turn = self._turn(multiply(conjugate(tip[1]), goal[1]))
        if chosen:
            vector, axes, columns = rotation_vector(turn), matrix(tip[1]), self._columns(links, frames, None)
            for i in chosen:
                axis = axes[0][i], axes[1][i], axes[2][i]
                error.append(vector[i])
                rows.append([_dot(axis, each) * angular for each in columns])
        miss = length(error[:straight]), length(error[straight:])
        weights = [linear] * straight + [angular] * (len(error) - straight)
        return [each * weight for each, weight in zip(error, weights, strict=True)], rows, miss

    def _turn(self, turn: Quaternion) -> tuple[range, Quaternion]:
        """Return about which axes of the tip it shall turn, and how far, out of the whole turn."""
        if self.constraints & Constraint.GAMMA:
            if self.constraints & Constraint.ALPHA_BETA:
                return range(3), turn
            return range(2, 3), _about_z(turn)
        if self.constraints & Constraint.ALPHA_BETA:
            return range(2), turn_z_to([row[2] for row in matrix(turn)])
        return range(0), turn

    def _columns(self, links: Sequence[Sequence[int]], frames: Frames, point: Vector | None) -> list[Vector]:
        """Return how a point, or with None the turn, of what the tip's link carries changes with each column."""
        found: list[Vector] = [(0.0, 0.0, 0.0)] * len(self.used)
        link = self.tip_link
        while link >= 0:
            before, kind, column = links[link]
            for number, axis in enumerate(frames.axes[link], column):
                if not self.used[number]:
                    continue
                if kind == LinkKind.SLIDE:
                    found[number] = axis if point is not None else (0.0, 0.0, 0.0)
                elif point is None:
                    found[number] = axis
                else:
                    found[number] = _cross(axis, subtract(point, frames.poses[link][0]))
            link = before
        return found


def weighted_length(tip: Pose, goal: Pose, metric: Sequence[float]) -> float:
    """Return the length of the differences of two poses with weights of x, y, z and the angle."""
    angle = length(rotation_vector(multiply(conjugate(tip[1]), goal[1])))
    x, y, z = subtract(goal[0], tip[0])
    a, b, c, d = metric
    return length((a * x, b * y, c * z, d * angle))


def _about_z(turn: Quaternion) -> Quaternion:
    """Return the part of a rotation that is about z, so that the rest turns z to where it shall be."""
    w, _, _, z = turn
    return normalised((w, 0.0, 0.0, z)) if abs(w) + abs(z) > _TINY else NO_TURN


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
