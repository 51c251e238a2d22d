"""The volume of a proximity sensor: ray, cone, cylinder, pyramid or disc along the sensor's +z.

A volume is where some quadratic functions are all not above 0: f(p) = d . p^2 + b . p + c, one for each surface
that bounds it (all are planes, spheres, cones or cylinders in line with the axes, so d is a diagonal). Its curved
surfaces are also given as lines that sweep them.

Geometry as in V-REP: `offset` moves the whole volume along z, backwards below 0, while distances are measured from
the sensor's origin;
`radius` of cone and disc is the radius of the blind zone at the start; `inside_gap` is the share of the angle that
is left out in the middle; a cone or disc opened beyond half a turn is a whole sphere or circle.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass

Array = NDArray[np.float64]
Lines = Callable[[Array], tuple[Array, Array]]
"""Maps angles (...) to starts and ends (..., 3) of lines that lie in a surface."""

TYPES = {"pyramid": 30, "cylinder": 31, "disc": 32, "cone": 33, "ray": 34, "random_rays": 34}
"""Maps the volume type to `sim_proximitysensor_*_subtype`."""

_TOLERANCE = 1e-9
"""Maximum of a function (m^2, or m for planes) at a point that was computed to lie on the surface."""
_SLACK = 1e-4
"""Metres, and a cosine: margin of the bounds, which keeps them beyond the tolerance also near an apex."""
_RAY = 0.001
"""Metres: half width of the box around a ray."""
_HALF_TURN = math.radians(181.8)
"""Angle from which V-REP draws a cone as a whole sphere (1.01 half turns)."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """A curved surface as lines, for angles from `least` to `greatest`."""

    lines: Lines
    least: float
    greatest: float
    axes: tuple[int, int]
    """The angle turns from the first of these axes to the second."""
    centred: bool
    """The origin lies on the surface's axis, not within a cut.

    Then a plane meets the surface closest to it where the plane's normal points along the line's own angle, or
    against it, unless an edge or another surface comes before.
    """


@dataclass(frozen=True, eq=False)
class Volume:
    """The space in which a sensor detects, in its own frame, metres."""

    squares: Array
    """(k, 3) quadratic coefficients d."""
    linear: Array
    """(k, 3) linear coefficients b."""
    constant: Array
    """(k,) constants c."""
    faces: Array
    """(j, 4): the plane surfaces, as unit normal and distance."""
    sweeps: tuple[Sweep, ...]
    spheres: tuple[tuple[float, float], ...]
    """Centres (on the z axis) and radii of the spherical surfaces that may hold a nearest point."""
    hull: Array
    """(h, 5): a x + b y + c z + e r <= d within the volume, r the distance from z, of unit slope: to exclude geoms."""
    centre: Array
    """(3,) centre of a ball that contains the volume."""
    reach: float
    """Radius of that ball."""
    box: Array
    """(2, 3) least and greatest x, y, z of a box around the volume and the sensor's origin, as V-REP gives it."""
    spread: float
    """Maximum angle in radians between z and any direction from the origin to a point of the volume."""

    def values(self, points: Array) -> Array:
        """Return (..., k): every function at points (..., 3)."""
        return (points * points) @ self.squares.T + points @ self.linear.T + self.constant

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Return (...) for points (..., 3) whether the volume contains them; the surfaces belong to the volume."""
        return np.all(self.values(points) <= _TOLERANCE, axis=-1)

    def may_touch(self, centres: Array, radii: Array) -> NDArray[np.bool_]:
        """Return (...) whether balls with centres (..., 3) may reach into the volume.

        The result is false only where they surely do not.
        """
        away = centres - self.centre
        near = (away * away).sum(axis=-1) <= (radii + self.reach) ** 2
        if len(self.hull) == 0:
            return near
        distances = np.hypot(centres[..., 0], centres[..., 1])
        beyond = centres @ self.hull[:, :3].T + distances[..., np.newaxis] * self.hull[:, 3] - self.hull[:, 4]
        return near & (beyond.max(axis=-1) <= radii)

    def lower_bounds(self, normals: Array, heights: Array) -> Array:
        """Return (n,) a lower bound of the distance of each plane's points within the volume; infinity for none.

        A point of the plane normal . p = height at distance r is seen under the cosine height / r to the normal,
        and no direction within the volume comes nearer to the normal than the one that leans to it by `spread`.
        """
        leaning = np.clip(np.copysign(normals[:, 2], normals[:, 2] * heights), -1.0, 1.0)
        cosines = np.cos(np.maximum(np.arccos(leaning) - self.spread, 0.0)) + _SLACK
        away = np.maximum(np.abs(heights) - _SLACK, 0.0)
        bounds = np.full(len(away), np.inf)
        np.divide(away, cosines, out=bounds, where=cosines > 0.0)
        return np.where(away > 0.0, bounds, 0.0)

    def crossings(self, origins: Array, directions: Array) -> Array:
        """Return (n, 2 k): where lines origin + s direction cross the surfaces; nan where they do not."""
        a = (directions * directions) @ self.squares.T
        b = 2.0 * (origins * directions) @ self.squares.T + directions @ self.linear.T
        c = self.values(origins)
        with np.errstate(divide="ignore", invalid="ignore"):
            # The form without cancellation; for a plane (a = 0) one of the two is its single crossing.
            q = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
            found = np.concatenate([q / a, c / q], axis=1)
        return np.where(np.isfinite(found), found, np.nan)


def half_angle(angle: float) -> float:
    """Return half the opening angle of a cone or disc, radians; pi where V-REP makes it a whole sphere or circle."""
    return math.pi if angle > _HALF_TURN else min(angle / 2, math.pi / 2)


def cone(
    angle: float, reach: float, offset: float = 0.0, radius: float = 0.0, inside_gap: float = 0.0
) -> Volume:
    """Return a cone; `angle`: full opening angle in radians."""
    build = _Builder()
    far = radius + reach
    half = half_angle(angle)
    whole = half == math.pi
    build.sphere(offset, far)
    if offset != 0:
        build.spheres.append((offset, far))
    if radius > 0:
        build.sphere(offset, radius, outside=True)
        build.spheres.append((offset, radius))
    if not whole:
        build.plane((0.0, 0.0, -1.0), -offset)
        build.cone(offset, half)
        build.sweeps.append(_cone_lines(offset, half, radius, far))
        if inside_gap > 0:
            build.cone(offset, half * inside_gap, outside=True)
            # The cut is not convex: from within it, a plane is nearest beside the line of its normal.
            build.sweeps.append(_cone_lines(offset, half * inside_gap, radius, far, centred=offset >= 0))
    build.wide(far * math.sin(half) if not whole else far)
    build.tall(offset - far if whole else offset, offset + far)
    if half < math.pi / 3:
        middle = far / 2 / math.cos(half)  # the ball through the apex and the far rim
        return build.volume(offset + middle, max(middle, far - middle), _spread(offset, half))
    return build.volume(offset, far, _spread(offset, half))


def cylinder(radius: float, reach: float, offset: float = 0.0, radius_far: float | None = None) -> Volume:
    """Return a cylinder, or with `radius_far` a truncated cone."""
    far = radius if radius_far is None else radius_far
    build = _Builder()
    slope = (far - radius) / reach
    at_origin = radius - slope * offset
    build.add((1.0, 1.0, -(slope**2)), (0.0, 0.0, -2.0 * slope * at_origin), -(at_origin**2))
    build.plane((0.0, 0.0, -1.0), -offset)
    build.plane((0.0, 0.0, 1.0), offset + reach)

    def lines(angles: Array) -> tuple[Array, Array]:
        ring = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=-1)
        return ring * radius + (0.0, 0.0, offset), ring * far + (0.0, 0.0, offset + reach)

    build.wide(max(radius, far))
    build.tall(offset, offset + reach)
    length = math.hypot(1.0, slope)
    build.hull.append((0.0, 0.0, -slope / length, 1.0 / length, at_origin / length))
    build.sweeps.append(Sweep(lines, 0.0, 2 * math.pi, (0, 1), centred=True))
    spread = _spread(offset, max(math.atan2(radius, offset), math.atan2(far, offset + reach)))
    return build.volume(offset + reach / 2, math.hypot(reach / 2, max(radius, far)), spread)


def pyramid(
    size: tuple[float, float], reach: float, offset: float = 0.0, size_far: tuple[float, float] | None = None
) -> Volume:
    """Return a pyramid; `size`, `size_far`: full width along x and y at the start and at the end."""
    far = size if size_far is None else size_far
    build = _Builder()
    build.plane((0.0, 0.0, -1.0), -offset)
    build.plane((0.0, 0.0, 1.0), offset + reach)
    for axis in (0, 1):
        slope = (far[axis] - size[axis]) / 2 / reach
        for side in (1.0, -1.0):
            normal = np.array([0.0, 0.0, -slope])
            normal[axis] = side
            build.plane(normal, size[axis] / 2 - slope * offset)
    build.wide(max(size[0], far[0]) / 2, max(size[1], far[1]) / 2)
    build.tall(offset, offset + reach)
    widest = math.hypot(max(size[0], far[0]), max(size[1], far[1])) / 2
    spread = max(math.atan2(math.hypot(*size) / 2, offset), math.atan2(math.hypot(*far) / 2, offset + reach))
    return build.volume(offset + reach / 2, math.hypot(reach / 2, widest), _spread(offset, spread))


def disc(
    angle: float,
    reach: float,
    height: float,
    offset: float = 0.0,
    radius: float = 0.0,
    inside_gap: float = 0.0,
) -> Volume:
    """Return a sector of a flat disc in the x-z plane, `height` thick along y."""
    build = _Builder()
    far = radius + reach
    half = half_angle(angle)
    whole = half == math.pi
    for side in (1.0, -1.0):
        build.plane((0.0, side, 0.0), height / 2)
    build.round(offset, far)
    build.sweeps.append(_round_lines(offset, far, height, half))
    if radius > 0:
        build.round(offset, radius, outside=True)
        build.sweeps.append(_round_lines(offset, radius, height, half))
    # Not a surface, but the nearest point of a plane along the sweeping lines, which those miss, is close
    # to it.
    build.faces.append((0.0, 1.0, 0.0, 0.0))
    if not whole:
        for side in (1.0, -1.0):
            normal = (side * math.cos(half), 0.0, -math.sin(half))
            build.plane(normal, normal[2] * offset)
        if inside_gap > 0:
            # |x| >= tan(gap) (z - offset), as one function; both its branches lie within the sector.
            sine, cosine = math.sin(half * inside_gap), math.cos(half * inside_gap)
            build.add((-(cosine**2), 0.0, sine**2), (0.0, 0.0, -2 * sine**2 * offset), (sine * offset) ** 2)
            for side in (1.0, -1.0):
                normal = (side * cosine, 0.0, -sine)
                build.faces.append((*normal, normal[2] * offset))
    build.wide(far if whole else far * math.sin(half), height / 2)
    build.tall(offset - far if whole else offset, offset + far)
    spread = math.pi if whole else math.pi / 2
    return build.volume(offset, math.hypot(far, height / 2), _spread(offset, spread))


def ray(reach: float, offset: float = 0.0) -> Volume:
    """Return a segment of the z axis: as a volume it is only used to find what may touch it."""
    build = _Builder()
    build.hull.append((0.0, 0.0, 0.0, 1.0, 0.0))
    build.wide(_RAY)
    build.tall(offset, offset + reach)
    return build.volume(offset + reach / 2, reach / 2, _spread(offset, 0.0))


def _spread(offset: float, ahead: float) -> float:
    """Return the spread of a volume: that of one ahead of the sensor, or all directions if it starts behind."""
    return ahead if offset >= 0.0 else math.pi


class _Builder:
    def __init__(self) -> None:
        self.functions: list[tuple[tuple[float, ...], tuple[float, ...], float]] = []
        self.faces: list[tuple[float, float, float, float]] = []
        self.sweeps: list[Sweep] = []
        self.spheres: list[tuple[float, float]] = []
        self.hull: list[tuple[float, float, float, float, float]] = []
        self.box = np.zeros((2, 3))

    def wide(self, x: float, y: float | None = None) -> None:
        """Set the box's half widths; y is x by default."""
        y = x if y is None else y
        self.box[:, :2] = (-x, -y), (x, y)

    def tall(self, low: float, high: float) -> None:
        """Set the box's least and greatest z, between which it contains the sensor's origin too."""
        self.box[:, 2] = min(low, 0.0), max(high, 0.0)

    def add(self, squares: tuple[float, ...], linear: tuple[float, ...], constant: float) -> None:
        self.functions.append((squares, linear, constant))

    def plane(self, normal: tuple[float, ...] | Array, distance: float) -> None:
        """Add normal . p <= distance; the normal may have any length."""
        x, y, z = (float(v) for v in normal)
        length = math.sqrt(x * x + y * y + z * z)
        unit = (x / length, y / length, z / length)
        self.add((0.0, 0.0, 0.0), unit, -distance / length)
        self.faces.append((*unit, distance / length))
        self.hull.append((*unit, 0.0, distance / length))

    def sphere(self, height: float, radius: float, *, outside: bool = False) -> None:
        sign = -1.0 if outside else 1.0
        self.add((sign,) * 3, (0.0, 0.0, -2 * sign * height), sign * (height**2 - radius**2))

    def round(self, height: float, radius: float, *, outside: bool = False) -> None:
        """Add a cylinder around the line x = 0, z = height."""
        sign = -1.0 if outside else 1.0
        self.add((sign, 0.0, sign), (0.0, 0.0, -2 * sign * height), sign * (height**2 - radius**2))

    def cone(self, height: float, half: float, *, outside: bool = False) -> None:
        sign = -1.0 if outside else 1.0
        sine, cosine = sign * math.sin(half) ** 2, sign * math.cos(half) ** 2
        self.add((cosine, cosine, -sine), (0.0, 0.0, 2 * sine * height), -sine * height**2)
        if not outside:
            self.hull.append((0.0, 0.0, -math.sin(half), math.cos(half), -math.sin(half) * height))

    def volume(self, middle: float, reach: float, spread: float) -> Volume:
        squares = np.array([f[0] for f in self.functions], np.float64).reshape(-1, 3)
        linear = np.array([f[1] for f in self.functions], np.float64).reshape(-1, 3)
        constant = np.array([f[2] for f in self.functions], np.float64)
        faces = np.array(self.faces, np.float64).reshape(-1, 4)
        hull = np.array(self.hull, np.float64).reshape(-1, 5)
        centre = np.array([0.0, 0.0, middle])
        return Volume(
            squares, linear, constant, faces, tuple(self.sweeps), tuple(self.spheres), hull, centre, reach,
            self.box, spread,
        )  # fmt: skip


def _cone_lines(offset: float, half: float, radius: float, far: float, *, centred: bool = True) -> Sweep:
    def lines(angles: Array) -> tuple[Array, Array]:
        rim = np.full_like(angles, math.cos(half))
        ring = np.stack([np.cos(angles) * math.sin(half), np.sin(angles) * math.sin(half), rim], axis=-1)
        apex = np.array([0.0, 0.0, offset])
        return apex + radius * ring, apex + far * ring

    return Sweep(lines, 0.0, 2 * math.pi, (0, 1), centred=centred)


def _round_lines(offset: float, radius: float, height: float, half: float) -> Sweep:
    def lines(angles: Array) -> tuple[Array, Array]:
        points = np.stack(
            [radius * np.sin(angles), np.zeros_like(angles), offset + radius * np.cos(angles)], axis=-1
        )
        up = np.array([0.0, height / 2, 0.0])
        return points - up, points + up

    return Sweep(lines, -half, half, (2, 0), centred=offset == 0.0)
