"""The scene after an edit: the objects of the scene before it, except for those that the edit concerns.

One new object must not cost a search of the whole scene. The bodies whose objects may have another place in the tree
are found from the arrays of both models; only their objects are made again, as `tree.py` makes them. All others stay,
with new ids where elements before them were added or removed.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import compress

import mujoco
import numpy as np

from simx_server.scene.formats.annotations import Annotations
from simx_server.scene.objects import Scene, SceneObject
from simx_server.scene.tree import Builder

from .twins import Twins
from .waiting.blueprint import Blueprint

_KINDS = {"geom": "geom", "site": "site", "camera": "cam", "light": "light", "joint": "jnt"}
"""Kinds of elements in a body: object's term to the prefix of the model's arrays."""

_SENSOR = mujoco.mjtSensor
_SENSED = (_SENSOR.mjSENS_RANGEFINDER.value, _SENSOR.mjSENS_FORCE.value, _SENSOR.mjSENS_TORQUE.value)


def succeed(
    old_scene: Scene,
    old_model: mujoco.MjModel,
    blueprint: Blueprint,
    model: mujoco.MjModel,
    twins: Twins,
    annotations: Annotations,
    hidden: frozenset[str],
    given_names: Mapping[tuple[str, str], str] | None = None,
    unseen_sites: frozenset[str] = frozenset(),
) -> tuple[Scene, set[int]]:
    """Return the scene of the edited model, with handles, names and parents kept; and the handles with a new place.

    Args:
        hidden: names of bodies that are not objects any more.
        given_names: object names by (element, element name); other new objects have their element's name.
        unseen_sites: names of sites that are not objects.
    """
    successor = _Successor(old_scene, old_model, model, twins, annotations, hidden, given_names, unseen_sites)
    successor.build()
    scene = Scene(successor.all, blueprint, old_scene.path, successor.next_handle, annotations)
    scene.hidden_bodies, scene.unseen_sites = hidden, unseen_sites
    scene.owners = successor.owners
    scene.parent_overrides = successor.overrides()
    for handle in successor.objects.keys() & scene.parent_overrides.keys():
        scene.objects[handle].parent = scene.parent_overrides[handle]
    return scene, set(successor.objects)


class _Successor(Builder):
    def __init__(
        self,
        old_scene: Scene,
        old_model: mujoco.MjModel,
        model: mujoco.MjModel,
        twins: Twins,
        annotations: Annotations,
        hidden: frozenset[str],
        given_names: Mapping[tuple[str, str], str] | None,
        unseen_sites: frozenset[str],
    ) -> None:
        super().__init__(model, annotations, hidden, given_names, unseen_sites)
        self._hidden_now = hidden
        self.old = old_scene
        self.old_model = old_model
        self.twins = twins
        self.next_handle = old_scene.next_handle
        self.all = dict(old_scene.objects)
        """All objects of the new scene, by handle; `objects` are those among them that were made again."""
        before = twins.before("body")
        self.owners = np.where(before >= 0, old_scene.owners[before], -1)
        self._gone: list[int] = []
        self._world: dict[str, list[int]] = {}
        """Elements of the world that are made again, by kind."""

    def known(self, element: str, element_id: int, element_name: str) -> SceneObject | None:
        before = self.twins.before(_KINDS.get(element, element))[element_id]
        handle = self.old.by_element(element, int(before)) if before >= 0 else None
        return self.old.objects[handle] if handle is not None else None

    @cached_property
    def taken(self) -> set[str]:
        return set(self.old.by_names())

    def leaves_of(self, element: str, body: int) -> Sequence[int]:
        if body == 0:
            return self._world.get(element, ())
        bodies = self._bodies_of(self.model, element)
        if not len(bodies):
            return ()
        found: list[int] = np.flatnonzero(bodies == body).tolist()
        return found

    def build(self) -> None:
        self._renumber()
        self._drop()
        waiting = sorted({*self._changed_bodies(), *self._orphans()})
        if waiting and waiting[0] == 0:
            waiting.pop(0)
        self.add_world()
        done = -1
        while waiting:
            body = heapq.heappop(waiting)
            if body == done:
                continue
            done = body
            self.owner[int(self.model.body_parentid[body])] = int(self.owners[self.model.body_parentid[body]])
            self.add_body(body)
            if self.owner[body] != self.owners[body]:
                self.owners[body] = self.owner[body]
                for child in np.flatnonzero(self.model.body_parentid == body).tolist():
                    heapq.heappush(waiting, child)
        self.add_tendons()
        changed = self.arrange()
        for old, new in changed.items():
            self.owners[self.owners == old] = -2 - new
        self.owners = np.where(self.owners <= -2, -2 - self.owners, self.owners)
        self.all |= self.objects

    def add_world(self) -> None:
        for geom in self._world.get("geom", ()):
            self.add_world_geom(geom)
        self._add_leaves(0, -1, skip=-1)

    def owner_of(self, body: int) -> int:
        return int(self.owners[body])

    def named_parent(self, tendon: str, name: str, otherwise: int) -> int:
        for handle, item in self.objects.items():
            if item.name == name:
                return handle
        handle = self.old.by_names().get(name)
        return handle if handle is not None and handle in self.all else otherwise

    def overrides(self) -> dict[int, int]:
        """Return the parents that differ from the bodies' tree, without those of and in removed objects."""
        kept = self.old.parent_overrides
        if self._gone:
            kept = {
                handle: parent
                for handle, parent in kept.items()
                if handle in self.all and (parent == -1 or parent in self.all)
            }
        return {**kept, **self.annotated_parents()}

    # --- objects that stay -----------------------------------------------------------------------

    def _renumber(self) -> None:
        """Give the remaining objects their new ids, and note the removed ones."""
        bodies = self.twins.after("body")
        for element in ("body", *_KINDS):
            body = self._bodies_of(self.old_model, element)
            if not len(body):
                continue
            after = bodies if element == "body" else self.twins.after(_KINDS[element])
            changed = (after != np.arange(len(after))) | (bodies[body] != body)
            if element == "geom":  # geoms of other bodies are not objects
                changed &= body == 0
            if not changed.any():
                continue
            handles = self.old.by_elements(element)
            places = zip(after.tolist(), bodies[body].tolist(), strict=True)
            for old_id, (new_id, new_body) in compress(enumerate(places), changed):
                if (handle := handles.get(old_id)) is None:
                    continue
                if new_id < 0:
                    self._gone.append(handle)
                else:
                    self.all[handle] = self.all[handle].renumbered(new_id, new_body)

    def _drop(self) -> None:
        """Drop all tendons, and sites with sensors, whose numbers change with any other sensor: they are made again."""
        for handle, item in self._tendons():
            if self.twins.after("tendon")[item.id] < 0:
                self._gone.append(handle)
        for name in self._hidden_now - self.old.hidden_bodies:
            body = mujoco.mj_name2id(self.old_model, mujoco.mjtObj.mjOBJ_BODY, name)
            hidden = self.old.by_element("body", body) if body >= 0 else None
            if hidden is not None:
                self._gone.append(hidden)
        for handle in set(self._gone):
            del self.all[handle]

    def _tendons(self) -> Iterator[tuple[int, SceneObject]]:
        for tendon in range(self.old_model.ntendon):
            handle = self.old.by_element("tendon", tendon)
            if handle is not None:
                yield handle, self.old.objects[handle]

    # --- objects that are made again -------------------------------------------------------------

    def _changed_bodies(self) -> set[int]:
        """Return the ids of bodies that are new, have another parent, or have other elements than before."""
        before, after = self.twins.before("body"), self.twins.after("body")
        parent = np.where(before >= 0, after[self.old_model.body_parentid[before]], -1)
        found = set(np.flatnonzero(parent != self.model.body_parentid).tolist())
        for element in _KINDS:
            found |= self._with_other(element)
        filled, was_filled = self.model.body_geomnum > 0, self.old_model.body_geomnum[before] > 0
        found.update(np.flatnonzero((before >= 0) & (filled != was_filled)).tolist())
        for name in self._hidden_now ^ self.old.hidden_bodies:
            body = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, name)
            if body >= 0:
                found.add(body)
        return found

    def _with_other(self, element: str) -> set[int]:
        """Return the bodies that have got or lost elements of a kind, or have sites with sensors."""
        kind = _KINDS[element]
        bodies, were = self._bodies_of(self.model, element), self._bodies_of(self.old_model, element)
        if not len(bodies) and not len(were):
            return set()
        before, after = self.twins.before(kind), self.twins.after(kind)
        new_body = self.twins.after("body")
        came = (before < 0) | (new_body[were[before]] != bodies) if len(were) else before < 0
        if element == "site":
            came[_sensed_sites(self.model)] = True
            stayed = before[before >= 0]
            lost = np.zeros(len(were), dtype=bool)
            lost[_sensed_sites(self.old_model)] = True
            came[np.flatnonzero(before >= 0)[lost[stayed]]] = True
        found = set(bodies[came].tolist())
        if 0 in found:
            self._world[element] = np.flatnonzero(came & (bodies == 0)).tolist()
        left = (after < 0) | (bodies[after] != new_body[were]) if len(bodies) else after < 0
        found.update(new_body[were[left]].tolist())
        return found - {-1} if element != "geom" else found & {0}

    def _orphans(self) -> set[int]:
        """Return the bodies of objects whose parent was removed."""
        children = {child for handle in self._gone for child in self.old.children(handle)}
        orphans = [self.all[child] for child in children & self.all.keys()]
        for item in orphans:
            if item.body == 0 and item.element in _KINDS:
                self._world[item.element] = sorted({item.id, *self._world.get(item.element, ())})
        return {item.body for item in orphans}

    @staticmethod
    def _bodies_of(model: mujoco.MjModel, element: str) -> np.ndarray:
        """Return the body id of each element, by element id."""
        if element == "body":
            count: int = model.nbody
            return np.arange(count)
        found: np.ndarray = getattr(model, f"{_KINDS[element]}_bodyid")
        return found


def _sensed_sites(model: mujoco.MjModel) -> np.ndarray:
    sensed = (model.sensor_objtype == mujoco.mjtObj.mjOBJ_SITE.value) & np.isin(model.sensor_type, _SENSED)
    found: np.ndarray = model.sensor_objid[sensed]
    return found
