"""Cubic splines through points: a curve whose first and second derivatives are continuous."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BOUNDARIES = ("not-a-knot", "clamped", "natural", "periodic")
"""Conditions at the ends: the third derivative is continuous at the second and the last but one point; the first
derivative is 0; the second derivative is 0; both ends have equal derivatives. The names are those of SciPy.
"""


@dataclass(frozen=True)
class CubicSpline:
    """A spline over a parameter, by its values and slopes at the knots.

    Reference: C. de Boor, A Practical Guide to Splines, chapter IV.
    """

    knots: Array
    """(points,) increasing."""
    values: Array
    """(points, dimensions)"""
    slopes: Array
    """(points, dimensions)"""

    def at(self, parameters: Array) -> tuple[Array, Array, Array]:
        """Return value, first and second derivative, each (parameters, dimensions)."""
        index = np.clip(np.searchsorted(self.knots, parameters, side="right") - 1, 0, len(self.knots) - 2)
        start, end = self.knots[index], self.knots[index + 1]
        width = (end - start)[:, None]
        t = (parameters - start)[:, None]
        slope = (self.values[index + 1] - self.values[index]) / width
        first, last = self.slopes[index], self.slopes[index + 1]
        cubic = (first + last - 2 * slope) / width**2
        square = (3 * slope - 2 * first - last) / width
        value = self.values[index] + t * (first + t * (square + t * cubic))
        return value, first + t * (2 * square + 3 * t * cubic), 2 * square + 6 * t * cubic


def cubic_spline(knots: Array, values: Array, boundary: str) -> CubicSpline:
    """Return the spline through points.

    Args:
        knots: (points,) increasing, at least two.
        values: (points, dimensions)
        boundary: one of `BOUNDARIES`. As in SciPy, not-a-knot makes a line of two points and a parabola of three.
    """
    count = len(knots)
    width = np.diff(knots)
    slope = np.diff(values, axis=0) / width[:, None]
    if boundary == "not-a-knot" and count <= 3:
        return CubicSpline(knots, values, _slopes_of_parabola(width, slope))
    matrix, right = np.zeros((count, count)), np.zeros_like(values)
    inner = np.arange(1, count - 1)
    matrix[inner, inner - 1] = width[1:]
    matrix[inner, inner] = 2 * (width[:-1] + width[1:])
    matrix[inner, inner + 1] = width[:-1]
    right[inner] = 3 * (width[1:, None] * slope[:-1] + width[:-1, None] * slope[1:])
    match boundary:
        case "clamped":
            matrix[0, 0] = matrix[-1, -1] = 1.0
        case "natural":
            matrix[0, :2] = matrix[-1, :-3:-1] = 2.0, 1.0
            right[0], right[-1] = 3 * slope[0], 3 * slope[-1]
        case "periodic":
            matrix[0, 0] = 2 * (width[0] + width[-1])
            matrix[0, 1] += width[-1]
            matrix[0, -2] += width[0]
            right[0] = 3 * (width[-1] * slope[0] + width[0] * slope[-1])
            matrix[-1, [0, -1]] = 1.0, -1.0
        case _:
            _set_end(matrix[0], right[0], width, slope)
            _set_end(matrix[-1, ::-1], right[-1], width[::-1], slope[::-1])
    slopes: Array = np.linalg.solve(matrix, right).astype(float)
    return CubicSpline(knots, values, slopes)


def _slopes_of_parabola(width: Array, slope: Array) -> Array:
    """Return the slopes at two or three points of the line or parabola through them."""
    if len(width) == 1:
        return np.repeat(slope, 2, axis=0)
    change = (slope[1] - slope[0]) / (width[0] + width[1])
    return np.array(
        [slope[0] - width[0] * change, slope[0] + width[0] * change, slope[1] + width[1] * change]
    )


def _set_end(row: Array, right: Array, width: Array, slope: Array) -> None:
    """Write the condition that the third derivative is continuous at the second point into a row of the system."""
    both = width[0] + width[1]
    row[0], row[1] = width[1], both
    right[:] = ((width[0] + 2 * both) * width[1] * slope[0] + width[0] ** 2 * slope[1]) / both
