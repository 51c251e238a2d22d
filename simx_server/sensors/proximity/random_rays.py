"""Randomized detection: rays in random directions within a cone, instead of a search of the whole cone.

V-REP's sensors of this kind detect when enough of their rays meet something. The nearest of those points counts.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from simx_server.sensors.instant import Instant

from .detection import Detection, are_quick_alone, detect, detect_all
from .optics import Optics, Throw
from .volume import Array, ray

_AT_ONCE = 200
"""Rays that are computed together: more need much memory in a large scene."""


def detect_randomly(
    instant: Instant,
    looks: Optics,
    origin: Array,
    rotation: Array,
    wanted: NDArray[np.bool_],
    dice: np.random.Generator,
) -> Detection | None:
    """Return what a sensor with random rays detects.

    Args:
        instant: the world.
        looks: the sensor's optics, with a throw.
        origin: (3,) position of the sensor in the world.
        rotation: (3, 3) in the world; the columns are the sensor's axes.
        wanted: (ngeom,) the geoms to detect.
        dice: chooses the directions.
    """
    throw = looks.throw
    assert throw is not None
    turns = _turns(throw, dice)
    apex = origin + looks.offset * rotation[:, 2]
    along = replace(
        looks,
        kind="ray",
        offset=throw.blind,
        volume=ray(looks.reach, throw.blind),
        throw=None,
        least_distance=0.0,
    )
    found: list[Detection | None] = []
    if are_quick_alone(instant, len(turns)):
        found = [detect(instant, along, apex, some, wanted) for some in rotation @ turns]
    else:
        for first in range(0, len(turns), _AT_ONCE):
            some = rotation @ turns[first : first + _AT_ONCE]
            apexes, shapes = np.tile(apex, (len(some), 1)), np.repeat(wanted[np.newaxis], len(some), axis=0)
            found += detect_all(instant, along, apexes, some, shapes)
    hits = [
        _in_sensor(one, turn, looks.offset) for one, turn in zip(found, turns, strict=True) if one is not None
    ]
    if len(hits) < throw.needed:
        return None
    nearest = min(hits, key=_distance)
    return nearest if _distance(nearest) >= looks.least_distance else None


def _turns(throw: Throw, dice: np.random.Generator) -> Array:
    """Return (rays, 3, 3) frames in the sensor's frame; their z axes are spread evenly over the cone's directions."""
    heights = dice.uniform(math.cos(throw.greatest_angle), math.cos(throw.least_angle), throw.rays)
    around = dice.uniform(0.0, 2 * math.pi, throw.rays)
    sines = np.sqrt(np.maximum(1.0 - heights**2, 0.0))
    along = np.stack([sines * np.cos(around), sines * np.sin(around), heights], axis=1)
    aside = np.stack([-np.sin(around), np.cos(around), np.zeros(throw.rays)], axis=1)
    return np.stack([aside, np.cross(along, aside), along], axis=2)


def _in_sensor(hit: Detection, turn: Array, offset: float) -> Detection:
    """Return a detection in a ray's frame in the sensor's frame."""
    x, y, z = (turn @ np.array(hit.point)).tolist()
    return Detection((x, y, z + offset), tuple((turn @ np.array(hit.normal)).tolist()), hit.handle)  # type: ignore[arg-type]


def _distance(hit: Detection) -> float:
    return math.dist(hit.point, (0.0, 0.0, 0.0))
