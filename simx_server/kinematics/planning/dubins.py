"""Shortest ways of a car that drives forward and steers: Dubins curves, for one pair of poses or for many.

A way is three pieces: an arc, a straight line or a third arc, and an arc (L. E. Dubins, "On Curves of Minimal Length
with a Constraint on Average Curvature", 1957; the formulas for angles and lengths in a frame along the line between the
two places: A. Shkel and V. Lumelsky, "Classification of the Dubins set", 2001).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simx_server.kinematics.scratch import Array

LEFT, STRAIGHT, RIGHT = 1, 0, -1

_WORDS = (
    (LEFT, STRAIGHT, LEFT),
    (RIGHT, STRAIGHT, RIGHT),
    (RIGHT, STRAIGHT, LEFT),
    (LEFT, STRAIGHT, RIGHT),
    (RIGHT, LEFT, RIGHT),
    (LEFT, RIGHT, LEFT),
)

_TURN = 2 * math.pi
_ROUNDED = 1e-6
"""Angle by which a full turn counts as none: without it, a straight way would sometimes get a circle."""


_NO_LINE = 1e-12
"""Square of the length over radius below which the straight line between two arcs counts as none."""


class Curve:
    """The shortest way from one pose (x, y, angle) to another."""

    def __init__(self, start: Array, end: Array, radius: float, *, is_symmetric: bool = False) -> None:
        """Find the way.

        Args:
            start: (3,) pose, m and rad.
            end: (3,) pose.
            radius: smallest radius of a turn in metres.
            is_symmetric: the car may drive the whole way backwards instead, where that is shorter.
        """
        pieces, word = _shortest(start, end, radius)
        self._is_backward = False
        if is_symmetric:
            others, other = _shortest(end, start, radius)
            if others.sum() < pieces.sum():
                pieces, word, self._is_backward = others, other, True
        self._from, self._to = start, end
        self._radius = radius
        self._pieces = pieces.tolist()
        self._word = _WORDS[int(word)]
        self.length = float(pieces.sum()) * radius
        """Metres."""

        self.turn = float(sum(piece for piece, way in zip(self._pieces, self._word, strict=True) if way))
        """Radians that the car turns, to both sides together."""

    def at(self, share: float) -> Array:
        """Return the pose (3,) after a share, 0 to 1, of the way."""
        if share <= 0.0 or share >= 1.0:
            return self._from if share <= 0.0 else self._to
        first = self._to if self._is_backward else self._from
        left = (1.0 - share if self._is_backward else share) * sum(self._pieces)
        x, y, angle = 0.0, 0.0, float(first[2])
        for piece, way in zip(self._pieces, self._word, strict=True):
            part = min(piece, left)
            left -= part
            if way == STRAIGHT:
                x, y = x + part * math.cos(angle), y + part * math.sin(angle)
                continue
            turned = angle + way * part
            x += way * (math.sin(turned) - math.sin(angle))
            y -= way * (math.cos(turned) - math.cos(angle))
            angle = turned
        angle = math.remainder(angle, _TURN)
        return np.array([first[0] + self._radius * x, first[1] + self._radius * y, angle])


def lengths(starts: Array, ends: Array, radius: float, *, is_symmetric: bool = False) -> Array:
    """Return the lengths (m,) in metres of the shortest ways between poses (m, 3), or one (3,) of them."""
    found = np.min(np.sum(_pieces(starts, ends, radius), axis=-1), axis=0)
    if is_symmetric:
        found = np.minimum(found, np.min(np.sum(_pieces(ends, starts, radius), axis=-1), axis=0))
    return found * radius


def _shortest(start: Array, end: Array, radius: float) -> tuple[Array, np.intp]:
    """Return angles and length over radius (3,) of the pieces of the shortest way, and the number of its word."""
    pieces = _pieces(start, end, radius)
    word = np.argmin(np.sum(pieces, axis=-1))
    return pieces[word], word


def _pieces(starts: Array, ends: Array, radius: float) -> Array:
    """Return the pieces (6, ..., 3) of all words, each in units of the radius; infinite where a word leads nowhere."""
    x, y = (ends[..., axis] - starts[..., axis] for axis in (0, 1))
    d = np.hypot(x, y) / radius
    along = np.arctan2(y, x)
    a, b = starts[..., 2] - along, ends[..., 2] - along
    sin_a, cos_a, sin_b, cos_b = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    cos_ab = np.cos(a - b)
    minus, plus = sin_a - sin_b, sin_a + sin_b

    def both(square: Array, theta: Array, side: int) -> Array:
        """Return the pieces of two arcs to one side with a straight line between them."""
        theta = np.where(square < _NO_LINE, a, theta)  # one arc: the direction of no line is arbitrary
        return _joined(
            square > -_NO_LINE, _full(side * (theta - a)), _root(square), _full(side * (b - theta))
        )

    lsl = both(2 + d * d - 2 * cos_ab + 2 * d * minus, np.arctan2(cos_b - cos_a, d + minus), LEFT)
    rsr = both(2 + d * d - 2 * cos_ab - 2 * d * minus, np.arctan2(cos_a - cos_b, d - minus), RIGHT)
    square = d * d - 2 + 2 * cos_ab - 2 * d * plus
    straight = _root(square)
    theta = np.arctan2(cos_a + cos_b, d - plus) - np.arctan2(2.0, straight)
    rsl = _joined(square > -_NO_LINE, _full(a - theta), straight, _full(b - theta))
    square = d * d - 2 + 2 * cos_ab + 2 * d * plus
    straight = _root(square)
    theta = np.arctan2(-cos_a - cos_b, d + plus) - np.arctan2(-2.0, straight)
    lsr = _joined(square > -_NO_LINE, _full(theta - a), straight, _full(theta - b))
    cosine = (6 - d * d + 2 * cos_ab + 2 * d * minus) / 8
    middle = _TURN - np.arccos(np.clip(cosine, -1.0, 1.0))
    first = _full(a - np.arctan2(cos_a - cos_b, d - minus) + middle / 2)
    rlr = _joined(np.abs(cosine) <= 1 + _NO_LINE, first, middle, _full(a - b - first + middle))
    cosine = (6 - d * d + 2 * cos_ab - 2 * d * minus) / 8
    middle = _TURN - np.arccos(np.clip(cosine, -1.0, 1.0))
    first = _full(np.arctan2(cos_b - cos_a, d + minus) - a + middle / 2)
    lrl = _joined(np.abs(cosine) <= 1 + _NO_LINE, first, middle, _full(b - a - first + middle))
    return np.stack([lsl, rsr, rsl, lsr, rlr, lrl])


def _joined(is_possible: NDArray[np.bool_], first: Array, middle: Array, last: Array) -> Array:
    return np.where(
        np.asarray(is_possible)[..., np.newaxis], np.stack([first, middle, last], axis=-1), np.inf
    )


def _root(square: Array) -> Array:
    return np.sqrt(np.maximum(square, 0.0))


def _full(angle: Array) -> Array:
    """Return an angle in 0..2 pi."""
    turned = np.remainder(angle, _TURN)
    return np.where(turned > _TURN - _ROUNDED, 0.0, turned)
