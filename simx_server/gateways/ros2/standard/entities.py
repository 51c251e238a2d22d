"""The entities of the scene: what other nodes may look at, move and remove as a whole.

An entity is a model, or an object at the top level that is a shape or has objects below it. Its name is that of the
object. Other dummies at the top level are named poses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from simx_client.protocol.nearest import did_you_mean
from simx_server.editing.shape_properties import is_static
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.simulation.simulation import Simulation

from .results import NOT_FOUND, Refused

OBJECT, ROBOT, HUMAN, DYNAMIC_OBJECT, STATIC_OBJECT = 0, 1, 2, 4, 5
"""Values of ``simulation_interfaces/EntityCategory``."""

CATEGORIES = (OBJECT, ROBOT, HUMAN, DYNAMIC_OBJECT, STATIC_OBJECT)

MOST_TAGS = 100
"""Tags of one entity."""

MOST_TEXT = 4000
"""Characters of a description, and of all tags of an entity."""


@dataclass(frozen=True, slots=True)
class Info:
    """Category, description and tags of an entity."""

    category: int
    description: str = ""
    tags: tuple[str, ...] = ()


class Entities:
    """The entities of the present scene. Physics thread."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._infos: dict[int, Info] = {}
        """Set by nodes, by handle."""

    def forget(self) -> None:
        """Forget everything: another scene is there."""
        self._infos.clear()

    def all(self) -> Iterator[SceneObject]:
        """Yield the entities in the order of the scene."""
        for item in self._simulation.scene.objects.values():
            if self.is_entity(item):
                yield item

    def is_entity(self, item: SceneObject) -> bool:
        """Return whether an object is an entity."""
        scene = self._simulation.scene
        if scene.is_model_base(item.handle):
            return True
        return item.parent == -1 and (item.kind is ObjectKind.SHAPE or bool(scene.children(item.handle)))

    def named_poses(self) -> Iterator[SceneObject]:
        """Yield the dummies that do not belong to an entity."""
        for handle in self._simulation.scene.of_kind(ObjectKind.DUMMY):
            item = self._simulation.scene.objects[handle]
            if item.parent == -1 and not self.is_entity(item):
                yield item

    def find(self, name: str) -> SceneObject:
        """Return an entity. Raises Refused."""
        return self._find(name, self.is_entity, self.all, "entity")

    def find_named_pose(self, name: str) -> SceneObject:
        """Return a dummy that is a named pose. Raises Refused."""
        return self._find(name, lambda item: item in [*self.named_poses()], self.named_poses, "named pose")

    def _find(
        self,
        name: str,
        is_one: Callable[[SceneObject], bool],
        others: Callable[[], Iterator[SceneObject]],
        what: str,
    ) -> SceneObject:
        scene = self._simulation.scene
        handle = scene.by_name(name)
        item = None if handle is None else scene.objects[handle]
        if item is None or not is_one(item):
            hint = did_you_mean(name, [each.name for each in others()])
            raise Refused(NOT_FOUND, f"there is no {what} '{name[:80]}'{hint}")
        return item

    def info(self, item: SceneObject) -> Info:
        """Return what is known about an entity; its category is guessed until a node sets it."""
        return self._infos.get(item.handle) or Info(self._category(item))

    def set_info(self, item: SceneObject, info: Info) -> None:
        """Keep what a node says about an entity, and forget what belongs to objects that have gone."""
        objects = self._simulation.scene.objects
        self._infos = {handle: each for handle, each in self._infos.items() if handle in objects}
        self._infos[item.handle] = info

    def _category(self, item: SceneObject) -> int:
        scene = self._simulation.scene
        below = [scene.objects[handle] for handle in (item.handle, *scene.descendants(item.handle))]
        if any(each.kind is ObjectKind.JOINT for each in below):
            return ROBOT
        shapes = [each for each in below if each.kind is ObjectKind.SHAPE]
        if shapes and all(is_static(self._simulation, each.handle) for each in shapes):
            return STATIC_OBJECT
        return OBJECT


def info_message(info: Info) -> Mapping[str, Any]:
    """Return an ``EntityInfo``."""
    return {
        "category": {"category": info.category},
        "description": info.description,
        "tags": list(info.tags),
    }


def read_info(message: Mapping[str, Any]) -> Info:
    """Return what an ``EntityInfo`` says. Raises Refused: it is not valid, or too long."""
    category, description, tags = message["category"]["category"], message["description"], message["tags"]
    if category not in CATEGORIES:
        raise Refused(
            4,
            f"there is no category {category}; valid: 0 object, 1 robot, 2 human, 4 dynamic, 5 static object",
        )
    if len(tags) > MOST_TAGS or len(description) > MOST_TEXT or sum(map(len, tags)) > MOST_TEXT:
        raise Refused(
            4,
            f"an entity has at most {MOST_TAGS} tags, and {MOST_TEXT} characters of description and of tags",
        )
    return replace(Info(category), description=description, tags=tuple(tags))
