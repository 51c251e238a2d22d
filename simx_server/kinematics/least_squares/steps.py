"""The change of the joints in one step, and the linear algebra of it."""

from __future__ import annotations

import math
from collections.abc import Sequence

Row = list[float]

TRANSPOSE, DAMPED, ADAPTIVE = range(3)
"""Ways to compute a step: along the transpose, with a damping, or with one that depends on the error."""

_LEAST_DAMPING = 1e-3
"""Minimum of the adaptive damping.

Sugihara, "Solvability-Unconcerned Inverse Kinematics by the Levenberg-Marquardt Method", IEEE T-RO 27 (2011),
recommends about 1e-3 of the squared length of the links, which is near 1 here.
"""


def change(rows: list[Row], error: Row, method: int, damping: float, columns: int) -> Row:
    """Return how far the joints move: J^T (J J^T + damping)^-1 e, or the best step along the transpose."""
    if method == TRANSPOSE:
        change = _transposed(rows, error, columns)
        moved = [dot(row, change) for row in rows]
        square = dot(moved, moved)
        factor = dot(error, moved) / square if square > 0 else 1.0
        return [each * factor for each in change]
    if method == ADAPTIVE:
        damping = 0.5 * dot(error, error) + _LEAST_DAMPING
    square = [[0.0] * len(rows) for _ in rows]
    for number, row in enumerate(rows):
        for other in range(number + 1):
            square[number][other] = square[other][number] = dot(row, rows[other])
        square[number][number] += damping
    return _transposed(rows, _solved(square, error), columns)


def _transposed(rows: list[Row], vector: Row, columns: int) -> Row:
    """Return J^T times a vector."""
    found = [0.0] * columns
    for row, factor in zip(rows, vector, strict=True):
        for column, each in enumerate(row):
            found[column] += each * factor
    return found


def _solved(rows: list[Row], right: Row) -> Row:
    """Return the solution of a system of equations; zeros where it is singular. Elimination with partial pivoting."""
    found = list(right)
    count = len(found)
    for i in range(count):
        pivot = i
        for j in range(i + 1, count):
            if abs(rows[j][i]) > abs(rows[pivot][i]):
                pivot = j
        rows[i], rows[pivot] = rows[pivot], rows[i]
        found[i], found[pivot] = found[pivot], found[i]
        first = rows[i]
        if first[i] == 0.0:
            return [0.0] * count
        for j in range(i + 1, count):
            row = rows[j]
            factor = row[i] / first[i]
            for k in range(i + 1, count):
                row[k] -= factor * first[k]
            found[j] -= factor * found[i]
    for i in reversed(range(count)):
        row, value = rows[i], found[i]
        for k in range(i + 1, count):
            value -= row[k] * found[k]
        found[i] = value / row[i]
    return found


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    total = 0.0
    for x, y in zip(a, b, strict=True):
        total += x * y
    return total


def length(vector: Sequence[float]) -> float:
    """Return the square root of the sum of squares, added in their order."""
    square = 0.0
    for each in vector:
        square += each * each
    return math.sqrt(square)
