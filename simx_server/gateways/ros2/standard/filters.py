"""Filters of entities, worlds and named poses: by name, category, tags and bounds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.handlers.objects import bounding_box
from simx_server.scene.objects import SceneObject
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import matrix

from .entities import MOST_TAGS, Entities
from .patterns import BadPattern, Pattern
from .results import FAILED, UNSUPPORTED, Refused

if TYPE_CHECKING:
    from simx_server.world.world import World

EMPTY, BOX, CONVEX_HULL, SPHERE = range(4)
"""Types of ``simulation_interfaces/Bounds``."""

ANY, ALL = 0, 1
"""Modes of ``simulation_interfaces/TagsFilter``."""

MOST_COST = 3_000_000
"""Steps that the search for a pattern in all names may take, which is about half a second."""


def has_tags(tags: Sequence[str], wanted: Mapping[str, Any]) -> bool:
    """Return whether tags pass a ``TagsFilter``. Raises Refused: its mode is not valid, or it has too many tags."""
    names: Sequence[str] = wanted["tags"]
    if wanted["filter_mode"] not in (ANY, ALL):
        raise Refused(
            FAILED, f"there is no filter_mode {wanted['filter_mode']}; valid: 0 any tag, 1 all tags"
        )
    if not names:
        return True
    if len(names) > MOST_TAGS:  # each is sought in each entity
        raise Refused(FAILED, f"a filter has at most {MOST_TAGS} tags, not {len(names)}")
    return (any if wanted["filter_mode"] == ANY else all)(name in tags for name in names)


def filtered(world: World, entities: Entities, wanted: Mapping[str, Any]) -> Iterator[SceneObject]:
    """Yield the entities that pass an ``EntityFilters``. Raises Refused: it is not valid."""
    found = list(entities.all())
    if text := wanted["filter"]:
        try:
            pattern = Pattern(text)
        except BadPattern as problem:
            raise Refused(FAILED, str(problem)) from None
        if pattern.cost(sum(len(item.name) + 1 for item in found)) > MOST_COST:
            raise Refused(FAILED, "the filter takes too long for the names of this scene; use a simpler one")
        found = [item for item in found if pattern.is_in(item.name)]
    categories = {each["category"] for each in wanted["categories"]}
    infos = {item.handle: entities.info(item) for item in found}
    found = [item for item in found if not categories or infos[item.handle].category in categories]
    found = [item for item in found if has_tags(infos[item.handle].tags, wanted["tags"])]
    bounds = _read_bounds(wanted["bounds"])
    for item in found:
        if bounds is None or _overlaps(world, item, *bounds):
            yield item


def box_of(world: World, item: SceneObject) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the least and greatest corner of an entity in its own frame, metres; None without a form."""
    try:
        low, high = bounding_box.of_object(world, item.handle, whole_model=True, with_volumes=False)
    except CommandError:
        return None
    return np.array(low), np.array(high)


def _read_bounds(bounds: Mapping[str, Any]) -> tuple[int, NDArray[np.float64]] | None:
    """Return the type and the points of ``Bounds``; None if they are empty. Raises Refused."""
    kind = bounds["type"]
    points = np.array([[each["x"], each["y"], each["z"]] for each in bounds["points"]]).reshape(-1, 3)
    if kind == EMPTY:
        return None
    if kind not in (BOX, SPHERE):
        raise Refused(UNSUPPORTED, "bounds filter by TYPE_BOX (1) or TYPE_SPHERE (3)")
    if len(points) != 2 or not np.isfinite(points[0]).all() or not math.isfinite(points[1][0]):
        raise Refused(
            FAILED, f"the bounds have {len(points)} points; a box or a sphere has two, of finite numbers"
        )
    if kind == BOX and not np.isfinite(points[1]).all():
        raise Refused(FAILED, "a box has two corners of finite numbers")
    return kind, points


def _overlaps(world: World, item: SceneObject, kind: int, points: NDArray[np.float64]) -> bool:
    """Return whether the box of an entity meets bounds of the world.

    A sphere is compared with the box exactly, a box by the axes of both (separating axes).
    """
    box = box_of(world, item)
    place, turn = frames.get_pose(world.simulation, item.handle)
    axes = np.array(matrix(turn))
    if box is None:
        box = np.zeros(3), np.zeros(3)
    half, middle = (box[1] - box[0]) / 2, axes @ ((box[0] + box[1]) / 2) + place
    if kind == SPHERE:
        inside = axes.T @ (points[0] - middle)
        return float(np.linalg.norm(inside - np.clip(inside, -half, half))) <= abs(points[1][0])
    low, high = points.min(axis=0), points.max(axis=0)
    other_half, gap = (high - low) / 2, middle - (low + high) / 2
    directions = [*np.eye(3), *axes.T, *(np.cross(one, other) for one in np.eye(3) for other in axes.T)]
    return all(
        abs(float(each @ gap)) <= float(np.abs(each) @ other_half + np.abs(each @ axes) @ half) + 1e-12
        for each in directions
    )
