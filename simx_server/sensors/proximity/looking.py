"""Find the nearest of surfaces and dummies, for proximity sensors with equal optics.

Dummies are points, which only volumes contain: rays detect none, as in V-REP. The sides of surfaces and the angles of
their normals do not concern them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.objects import SceneObject
from simx_server.sensors.instant import Instant
from simx_server.sensors.points import Points

from .detection import Detection, are_quick_alone, detect, detect_all, unblinded
from .optics import Optics
from .random_rays import detect_randomly
from .volume import Array


@dataclass(frozen=True, eq=False)
class Targets:
    """The surfaces and dummies that a sensor is to detect."""

    geoms: NDArray[np.bool_]
    """(ngeom,) the geoms whose surfaces it detects."""
    points: Points


def look(
    instant: Instant,
    items: Sequence[SceneObject],
    looks: Optics,
    targets: Sequence[Targets],
    dice: Callable[[int], np.random.Generator],
) -> list[Detection | None]:
    """Return the results of sensors with equal optics. The carrier's surface is left out, unless annotated.

    Args:
        instant: the world.
        items: the sensors.
        looks: their optics.
        targets: what each is to detect.
        dice: gives the randomness of a sensor's next reading, by its handle.
    """
    if not looks.detects_points or not any(each.points.handles for each in targets):
        return _on_surfaces(instant, items, looks, targets, dice)
    # The least distance is for the nearest of all, which blinds the sensor for the others.
    unlimited = replace(looks, least_distance=0.0) if looks.least_distance else looks
    surfaces = _on_surfaces(instant, items, unlimited, targets, dice)
    points = [
        _of_points(instant, looks, item, each.points) for item, each in zip(items, targets, strict=True)
    ]
    return [unblinded(looks, _nearer(*pair)) for pair in zip(surfaces, points, strict=True)]


def along(instant: Instant, item: SceneObject, looks: Optics, geoms: NDArray[np.bool_]) -> Detection | None:
    """Return the result of one sensor that is a ray; `geoms`: what it is to detect, without regard to its carrier."""
    if looks.faces == "none":
        return None
    wanted = _without_carrier(instant, item, geoms)
    return detect(instant, looks, instant.site_xpos[item.id], turn_of(instant, item), wanted)


def _without_carrier(instant: Instant, item: SceneObject, geoms: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return geoms without those of the shape that carries a sensor, unless it is annotated to see them."""
    carrier = instant.scene.owner_of_body(item.body, instant.model)
    if carrier == -1 or note_of(item).get("carrier", False):
        return geoms
    return instant.surroundings.without(geoms, carrier)


def note_of(item: SceneObject) -> Annotation:
    """Return the annotation of a sensor."""
    return item.annotations.get("proximity", {})


def turn_of(instant: Instant, item: SceneObject) -> Array:
    """Return (3, 3) the rotation of a sensor: the columns are its axes."""
    return instant.site_xmat[item.id].reshape(3, 3)


def _on_surfaces(
    instant: Instant,
    items: Sequence[SceneObject],
    looks: Optics,
    targets: Sequence[Targets],
    dice: Callable[[int], np.random.Generator],
) -> list[Detection | None]:
    wanted = [each.geoms for each in targets]
    if looks.kind == "ray" and are_quick_alone(instant, len(items)):
        return [along(instant, item, looks, geoms) for item, geoms in zip(items, wanted, strict=True)]
    if looks.faces == "none":
        return [None] * len(items)
    if looks.throw is None and not any(geoms.any() for geoms in wanted):
        return [None] * len(items)
    wanted = [_without_carrier(instant, item, geoms) for item, geoms in zip(items, wanted, strict=True)]
    sites = [item.id for item in items]
    origins, rotations = instant.site_xpos[sites], instant.site_xmat[sites].reshape(-1, 3, 3)
    if looks.throw is None:
        return detect_all(instant, looks, origins, rotations, np.array(wanted))
    return [
        detect_randomly(instant, looks, origins[row], rotations[row], wanted[row], dice(item.handle))
        for row, item in enumerate(items)
    ]


def _of_points(instant: Instant, looks: Optics, item: SceneObject, points: Points) -> Detection | None:
    """Return the nearest point within the volume; its normal is the direction from the sensor, as V-REP gives it."""
    if not points.handles:
        return None
    places = (points.places(instant.site_xpos, instant.xpos) - instant.site_xpos[item.id]) @ turn_of(
        instant, item
    )
    within = looks.volume.contains(places).nonzero()[0]
    if not len(within):
        return None
    row = int(within[np.einsum("ni,ni->n", places[within], places[within]).argmin()])
    x, y, z = places[row].tolist()
    away = math.hypot(x, y, z)
    normal = (x / away, y / away, z / away) if away else (0.0, 0.0, 0.0)
    return Detection((x, y, z), normal, points.handles[row])


def _nearer(one: Detection | None, other: Detection | None) -> Detection | None:
    if one is None or other is None:
        return one if other is None else other
    return other if math.hypot(*other.point) < math.hypot(*one.point) else one
