"""The curve of a V-REP path: control points, the Bezier points between them, and lengths along the curve.

Around each control point V-REP lays a quadratic Bezier curve: it starts on the way from the point before, at half the
point's first factor, and ends on the way to the next point, at half the second one. Its Bezier points are joined by
straight lines. The positions of 26 dummies that V-REP placed on a path agree with this to 1e-6 m.

A path may rest. Its points have a virtual distance too, a coordinate as the three of the place, which the Bezier
curves round off in the same way. The length between two points grows by the change of this coordinate: at a control
point with a virtual distance of 0.1 between points without, by 0.1 before it and by 0.1 after it. Asti's feet agree.

Poses are in the path's frame; the z axis points along the path.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import replace
from enum import IntEnum
from itertools import pairwise

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.poses import poses
from simx_server.scene.poses.poses import Pose, Quaternion, Vector

LENGTH_PER_ANGLE = 0.1 / math.radians(90)
"""V-REP's default: a quarter turn counts as 0.1 m."""

_SAME_PLACE, _SAME_TURN = 1e-4, math.radians(0.5)
"""V-REP leaves out a Bezier point that is nearer to the one before than both, and has its virtual distance."""

_COLLINEAR = 0.99999
"""Cosine of the angle between two ways from which on V-REP lays no curve around the point between them."""

_TURNS, _SAME_AXIS = math.radians(1.0), 0.99
"""Angle above which two orientations differ, and cosine from which on two rotations have the same axis."""

_NO_LENGTH, _NO_ANGLE = 5e-5, math.radians(0.01)
"""V-REP ignores distances below these when the other kind of distance can be used instead."""

MOST_CONTROL_POINTS = 4000
MOST_POINTS = 100_000
"""Most Bezier points of a path."""


class Method(IntEnum):
    """How the length between two points follows from distance and angle: `sim_distcalcmethod_*`."""

    DISTANCE = c.sim_distcalcmethod_dl
    ANGLE = c.sim_distcalcmethod_dac
    LARGER = c.sim_distcalcmethod_max_dl_dac
    SUM = c.sim_distcalcmethod_dl_and_dac
    ROOT = c.sim_distcalcmethod_sqrt_dl2_and_dac2
    DISTANCE_OR_ANGLE = c.sim_distcalcmethod_dl_if_nonzero
    ANGLE_OR_DISTANCE = c.sim_distcalcmethod_dac_if_nonzero


def length_by(method: Method, distance: float, angle: float) -> float:
    """Return the length that a method gives for a distance (m) and an angle that was converted to metres."""
    match method:
        case Method.DISTANCE:
            return distance
        case Method.ANGLE:
            return angle
        case Method.LARGER:
            return max(distance, angle)
        case Method.SUM:
            return distance + angle
        case Method.ROOT:
            return math.hypot(distance, angle)
        case Method.DISTANCE_OR_ANGLE:
            return angle if distance < _NO_LENGTH else distance
        case Method.ANGLE_OR_DISTANCE:
            return distance if angle < _NO_ANGLE else angle


@dataclass(frozen=True)
class ControlPoint:
    """A control point of a path."""

    pose: Pose
    before: float = 0.5
    """Bezier factor towards the point before, 0 to 1."""
    after: float = 0.5
    """Bezier factor towards the next point."""
    count: int = 1
    """Number of Bezier points; 1: the control point itself."""
    virtual: float = 0.0
    """V-REP's virtual distance; its change along the path is length on the spot."""
    velocity: float = 1.0
    """Share of the nominal velocity."""
    flags: int = 0
    channels: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Rules:
    """The settings that define a curve, beside its control points."""

    is_closed: bool = False
    method: Method = Method.DISTANCE_OR_ANGLE
    angle_to_length: float = LENGTH_PER_ANGLE
    """Metres per radian."""
    virtual_to_length: float = 1.0
    """Metres per unit of the virtual distance."""
    follows_curve: bool = False
    """The z axis of each Bezier point points along the curve, whatever the orientations of control points."""
    keeps_x_up: bool = False
    """With `follows_curve`: the x axis points upwards in the path's frame."""
    is_flat: bool = False
    """All points count with z = 0."""


class Curve:
    """The Bezier points of a path, and the lengths at which they lie."""

    def __init__(self, points: Sequence[ControlPoint], rules: Rules) -> None:
        """Compute the curve. Raises CommandError: too many points."""
        if len(points) > MOST_CONTROL_POINTS:
            raise CommandError(f"a path has at most {MOST_CONTROL_POINTS} control points, not {len(points)}")
        if sum(max(1, each.count) for each in points) > MOST_POINTS:
            raise CommandError(f"a path has at most {MOST_POINTS} Bezier points")
        self.control = tuple(points)
        self.rules = rules
        bezier = _bezier_points(_flattened(points, rules), is_closed=rules.is_closed)
        if rules.is_closed and len(bezier) > 1:
            bezier = [*bezier, bezier[0]]
        self.points = _turned_along(bezier, rules) if rules.follows_curve else bezier
        """Bezier points, as separate control points; the first one again at the end of a closed path."""
        self._arrivals: list[float] = []
        """Length at which each point is reached."""
        at = 0.0
        for before, point in pairwise([None, *self.points]):
            if before is not None and point is not None:
                at += self._distance(before, point)
            self._arrivals.append(at)
        self.length = at
        """Length of the whole path in metres, by its method."""

    def along(self, position: float) -> float:
        """Return a position in metres brought into 0 to the length: closed paths go round, open ones end."""
        if self.length <= 0 or not math.isfinite(position):
            return 0.0
        if self.rules.is_closed:
            return position % self.length
        return min(max(position, 0.0), self.length)

    def at(self, position: float) -> ControlPoint:
        """Return what lies at a position in metres. Raises CommandError: the path has no points."""
        if not self.points:
            raise CommandError("the path has no points")
        position = self.along(position)
        index = min(bisect_right(self._arrivals, position), len(self.points)) - 1
        start = self.points[index]
        left = self._arrivals[index]
        if index + 1 == len(self.points) or position <= left:
            return start
        share = (position - left) / (self._arrivals[index + 1] - left)
        return _between(start, self.points[index + 1], share)

    def nearest(self, place: Sequence[float]) -> float:
        """Return the position in metres whose point is nearest to a place in the path's frame.

        Raises CommandError: the path has no points.
        """
        if not self.points:
            raise CommandError("the path has no points")
        best, found = math.inf, 0.0
        for index, point in enumerate(self.points):
            gap = math.dist(point.pose[0], place)
            if gap < best:
                best, found = gap, self._arrivals[index]
        for index, (start, end) in enumerate(pairwise(self.points)):
            way = poses.subtract(end.pose[0], start.pose[0])
            squared = sum(each * each for each in way)
            if squared == 0:
                continue
            offset = poses.subtract(place, start.pose[0])
            share = sum(a * b for a, b in zip(way, offset, strict=True)) / squared
            if not 0 < share < 1:
                continue
            gap = math.dist(poses.add(start.pose[0], poses.scale(way, share)), place)
            if gap < best:
                left = self._arrivals[index]
                best, found = gap, left + share * (self._arrivals[index + 1] - left)
        return found

    def _distance(self, start: ControlPoint, end: ControlPoint) -> float:
        rules = self.rules
        angle = _angle(start.pose[1], end.pose[1]) * rules.angle_to_length
        rest = abs(start.virtual - end.virtual) * rules.virtual_to_length
        return length_by(rules.method, math.dist(start.pose[0], end.pose[0]), angle) + rest


def _flattened(points: Sequence[ControlPoint], rules: Rules) -> list[ControlPoint]:
    if not rules.is_flat:
        return list(points)
    return [replace(each, pose=((each.pose[0][0], each.pose[0][1], 0.0), each.pose[1])) for each in points]


def _bezier_points(points: Sequence[ControlPoint], *, is_closed: bool) -> list[ControlPoint]:
    last = len(points) - 1
    found: list[ControlPoint] = []
    for index, point in enumerate(points):
        before, after = points[index - 1], points[(index + 1) % len(points)]
        is_end = not is_closed and index in (0, last)
        is_bent = not is_end and last > 1 and point.count > 1 and _is_bent(before, point, after)
        for each in _section(before, point, after) if is_bent else [point]:
            if not found or not _is_same(found[-1], each):
                found.append(each)
    return found


def _is_bent(before: ControlPoint, point: ControlPoint, after: ControlPoint) -> bool:
    """Return whether the path changes its direction, the axis of its rotation or its rest at a point."""
    there, onwards = (
        poses.subtract(end.pose[0], start.pose[0]) for start, end in ((before, point), (point, after))
    )
    lengths = math.hypot(*there) * math.hypot(*onwards)
    if lengths and _dot(there, onwards) / lengths < _COLLINEAR:
        return True
    if before.virtual != point.virtual != after.virtual:
        return True
    turns = [_rotation(start.pose[1], end.pose[1]) for start, end in ((before, point), (point, after))]
    angles = [math.hypot(*turn) for turn in turns]
    return min(angles) > _TURNS and _dot(*turns) / (angles[0] * angles[1]) < _SAME_AXIS


def _section(before: ControlPoint, point: ControlPoint, after: ControlPoint) -> list[ControlPoint]:
    """Return the Bezier points of one control point."""
    start, end = _between(point, before, point.before / 2), _between(point, after, point.after / 2)
    shares = [step / (point.count - 1) for step in range(point.count)]
    found = [_between(_between(start, point, t), _between(point, end, t), t) for t in shares]
    return [replace(each, flags=point.flags) for each in found]


def _between(start: ControlPoint, end: ControlPoint, share: float) -> ControlPoint:
    place = poses.add(
        poses.scale(start.pose[0], 1 - share),
        poses.scale(end.pose[0], share),
    )
    a, b, d, e = (x + (y - x) * share for x, y in zip(start.channels, end.channels, strict=True))
    return ControlPoint(
        (place, poses.blend(start.pose[1], end.pose[1], share)),
        virtual=start.virtual + (end.virtual - start.virtual) * share,
        velocity=start.velocity + (end.velocity - start.velocity) * share,
        flags=start.flags,
        channels=(a, b, d, e),
    )


def _is_same(first: ControlPoint, second: ControlPoint) -> bool:
    return (
        first.virtual == second.virtual
        and math.dist(first.pose[0], second.pose[0]) < _SAME_PLACE
        and _angle(first.pose[1], second.pose[1]) < _SAME_TURN
    )


def _rotation(first: Quaternion, second: Quaternion) -> Vector:
    """Return the rotation vector from one orientation to another, in the frame of the first."""
    return poses.rotation_vector(poses.multiply(poses.conjugate(first), second))


def _angle(first: Quaternion, second: Quaternion) -> float:
    return math.hypot(*_rotation(first, second))


def _dot(first: Vector, second: Vector) -> float:
    return sum(a * b for a, b in zip(first, second, strict=True))


def _turned_along(points: list[ControlPoint], rules: Rules) -> list[ControlPoint]:
    """Return the points with their z axes along the curve."""
    last = len(points) - 1
    found: list[ControlPoint] = []
    for index, point in enumerate(points):
        if rules.is_closed:
            ends = points[index - 1 if index else last - 1], points[index + 1 if index < last else 1]
        else:
            ends = points[max(0, index - 1)], points[min(last, index + 1)]
        way = poses.subtract(ends[1].pose[0], ends[0].pose[0])
        found.append(replace(point, pose=(point.pose[0], _along(way, point.pose[1], rules.keeps_x_up))))
    return found


def _along(way: Vector, turn: Quaternion, keeps_x_up: bool) -> Quaternion:
    """Return the rotation nearest to `turn` whose z axis points along a way."""
    length = math.hypot(*way)
    if length < 1e-12:
        return turn
    z = poses.scale(way, 1 / length)
    if keeps_x_up:
        rise = z[2]
        x = poses.subtract((0.0, 0.0, 1.0), poses.scale(z, rise))
        if math.hypot(*x) > 1e-6:
            x = poses.scale(x, 1 / math.hypot(*x))
            y = (z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0])
            return poses.from_rows(list(zip(x, y, z, strict=True)))
    local = poses.rotate(poses.conjugate(turn), z)
    return poses.normalised(poses.multiply(turn, poses.turn_z_to(local)))
