"""The points of a path in its annotation: numbers with commas between them, and semicolons between points."""

from __future__ import annotations

import math

LEAST, MOST = 7, 17
"""Numbers of a point: its pose needs 7."""

DEFAULTS = (0.5, 0.5, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Those after the pose: two Bezier factors, number of points, virtual distance, velocity, flags, four channels."""

MOST_POINTS = 100_000


def check_points(text: str) -> str:
    """Return the text of a path's points. Raises ValueError that says what is valid."""
    points_of(text)
    return text


def points_of(text: str) -> list[tuple[float, ...]]:
    """Return the MOST numbers of each point. Raises ValueError that says what is valid."""
    words = text.split(";")
    if len(words) > MOST_POINTS:
        raise ValueError(f"at most {MOST_POINTS} points")
    return [_point(word) for word in words]


def text_of(points: list[tuple[float, ...]]) -> str:
    """Return the points as text, without the numbers at their ends that are defaults."""
    return ";".join(_text(point) for point in points)


def _text(point: tuple[float, ...]) -> str:
    kept = len(point)
    while kept > LEAST and point[kept - 1] == DEFAULTS[kept - LEAST - 1]:
        kept -= 1
    return ",".join(f"{number:.9g}" for number in point[:kept])


def _point(text: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    is_valid = LEAST <= len(numbers) <= MOST and all(map(math.isfinite, numbers)) and any(numbers[3:7])
    numbers += DEFAULTS[len(numbers) - LEAST :]
    if not is_valid or not all(0 <= factor <= 1 for factor in numbers[7:9]) or not 1 <= numbers[9] <= 1000:
        raise ValueError(
            f"points with semicolons between them, each {LEAST} to {MOST} finite numbers with commas: "
            "x,y,z,qw,qx,qy,qz, two Bezier factors from 0 to 1, number of Bezier points from 1 to 1000, "
            "virtual distance, velocity, flags, four channels"
        )
    return numbers
