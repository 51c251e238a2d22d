"""The objects of a scene in V-REP's terms: kinds, handles, parents.

A Scene is a view on one compiled model: it contains no physics state. Handles are small positive integers given in tree
order (depth first) from 1; they survive stop, reset and edits, and a new object gets a higher one than all before it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import UnknownHandle, WrongKind

from .assets.asset_files import AssetFiles
from .editing.in_place.slots import Slots
from .editing.twins import Names
from .editing.waiting.blueprint import Blueprint, Change
from .formats.annotations import Annotation, Annotations
from .naming.paths import resolve
from .poses.start import Start

if TYPE_CHECKING:
    from .formats.vrep.report import Report
    from .formats.vrep.source import VrepSource

NOT_A_MODEL = 0xF000
"""`sim_modelproperty_not_model`."""


class ObjectKind(IntEnum):
    """Kinds of objects; the values are the legacy `sim_object_*_type` numbers."""

    SHAPE = 0
    JOINT = 1
    GRAPH = 2
    CAMERA = 3
    DUMMY = 4
    PROXIMITY_SENSOR = 5
    PATH = 8
    VISION_SENSOR = 9
    MILL = 11
    FORCE_SENSOR = 12
    LIGHT = 13
    MIRROR = 14
    OCTREE = 15
    POINT_CLOUD = 16
    SCRIPT = 17

    @property
    def text(self) -> str:
        """Return the kind in words, as used in messages."""
        return self.name.lower().replace("_", " ")


ANNOTATED_KINDS = {
    kind.name.lower(): kind
    for kind in (
        ObjectKind.GRAPH,
        ObjectKind.PATH,
        ObjectKind.MILL,
        ObjectKind.MIRROR,
        ObjectKind.OCTREE,
        ObjectKind.POINT_CLOUD,
        ObjectKind.SCRIPT,
    )
}
"""Kinds without an element in MJCF, by the word of the annotation `simx:object type=`; a site or body stands for one.
"""


@dataclass
class SceneObject:
    """One object. `element` is the MuJoCo kind that carries it: body, joint, site, camera, light, tendon or geom."""

    handle: int
    name: str
    kind: ObjectKind
    parent: int
    """Handle of the parent object, -1 for none."""
    element: str
    element_name: str
    """Name of the element in the model, by which it is found after a recompile."""
    id: int
    """MuJoCo id of the element in the current model."""
    body: int
    """MuJoCo id of the body the element belongs to (for a body: itself; for a tendon: that of its first site)."""
    alias: str = ""
    annotations: Mapping[str, Annotation] = field(default_factory=dict[str, Annotation])
    """Annotations of the object in `<custom>`: per kind, checked values, e.g. `annotations["vision"]["near"]` -> 0.01.
    """
    sensors: tuple[int, ...] = ()
    """MuJoCo sensor ids: the rangefinders of a proximity sensor; force, torque of a force sensor."""

    def renumbered(self, element_id: int, body: int, sensors: tuple[int, ...] | None = None) -> SceneObject:
        """Return the same object in a model in which its element and body, and its sensors if given, have these ids."""
        twin = object.__new__(SceneObject)
        twin.__dict__.update(self.__dict__)
        twin.id, twin.body = element_id, body
        if sensors is not None:
            twin.sensors = sensors
        return twin


class Scene:
    """All objects of one loaded scene, by handle."""

    def __init__(
        self,
        objects: Mapping[int, SceneObject],
        spec: mujoco.MjSpec | Blueprint,
        path: Path | None,
        next_handle: int,
        annotations: Annotations | None = None,
    ) -> None:
        self.objects: dict[int, SceneObject] = dict(objects)
        self.blueprint = spec if isinstance(spec, Blueprint) else Blueprint(spec)
        """The source of the next edit's model."""
        self.is_edited_in_place = False
        """The model has edits that were made without a compile: the next one numbers its elements differently."""
        self.path = path
        self.next_handle = next_handle
        self.annotations = annotations if annotations is not None else Annotations()
        self.slots = Slots()
        """Elements of the model that can become objects."""
        self.unseen_sites: frozenset[str] = frozenset()
        """Names of sites of the model that are not objects: free slots, and those of removed objects."""
        self.files = AssetFiles()
        """The spec's files in memory; the scenes that edits make share them."""
        self.start = Start()
        """Positions with which it starts, where they are not those of its bodies in the file."""
        self.import_report: Report | None = None
        """Notes of the import of a V-REP file."""
        self.vrep_source: VrepSource | None = None
        """That file; only the scene that it was made of has it, and not those that edits make."""
        self.parent_overrides: dict[int, int] = {}
        """Handle to parent, where the tree differs from the bodies (a free body under a gripper, a dummy's child)."""
        self.welded_bodies: set[str] = set()
        """Names of bodies that were free until they were put under a force sensor."""
        self.weightless_bodies: set[str] = set()
        """Names of bodies that were static until they were fixed to a moving body: they add no mass to it."""
        self.hidden_bodies: frozenset[str] = frozenset()
        """Names of bodies with children whose object was removed."""
        self.model_properties: dict[int, int] = {}
        """`sim_modelproperty_*` bits by handle, where they were set; else the file defines the model bases.
        Written by `set_model_property`, or before `reindex`.
        """
        self.made_static: set[str] = set()
        """Names of bodies that are fixed because their model is not dynamic."""
        self.withheld: dict[tuple[str, str], int] = {}
        """Values that models' properties replace in geoms: (geom name, model array) to the number to restore."""
        self.owners: np.ndarray = np.zeros(0, dtype=np.int64)
        """MuJoCo body id to the handle of the parent for elements of the body, as far as bodies define it; -1: none."""
        self.names: Names | None = None
        """Names of all elements of the model, if an edit has made them."""
        self.tree = object()
        """Another object after each change of the tree."""
        self._children: defaultdict[int, list[int]] | None = None
        self._leaves_first: dict[int, int] = {}
        self._descendants: dict[int, tuple[int, ...]] = {}
        self.carried_apart: dict[int, tuple[mujoco.MjModel, tuple[int, ...]]] = {}
        """Kept by `poses.placing`: the objects below one that a model does not carry along with it."""
        self.dofs_below: dict[int, tuple[mujoco.MjModel, slice]] = {}
        """Kept by `poses.placing`: the degrees of freedom of a body, and of the bodies below it, in a model."""
        self._of_kind: dict[int, list[int]] = {}
        self._overridden: dict[int, int] = {}
        self.properties_version = 0
        """Increases whenever the answers of `overridden`, or the objects, may have changed."""
        self._by_element: defaultdict[str, dict[int, int]] | None = None
        self._by_name: dict[str, int] | None = None

    def came_from(self, source: VrepSource) -> None:
        """Note the V-REP file that the scene was made of."""
        self.vrep_source = source

    @property
    def spec(self) -> mujoco.MjSpec:
        """Return what the next edit's model is made of; it must not be changed.

        The model may have more: slots, and what is left of objects that were removed without a compile.
        """
        return self.blueprint.spec

    def edited_in_place(self, change: Change, bodies: float = math.inf) -> Scene:
        """Return a twin, in which an edit without a compile can be made.

        Args:
            change: does to the spec what the edit does to the model.
            bodies: how much that is, see `Blueprint.then`.
        """
        twin = self.twin()
        twin.blueprint = twin.blueprint.then(change, bodies)
        twin.is_edited_in_place = True
        return twin

    def twin(self) -> Scene:
        """Return a scene of the same model that can be edited.

        The original is kept, as that of a model before an edit is: the stop may restore it.
        """
        twin = object.__new__(Scene)
        twin.__dict__.update(self.__dict__)
        for name in ("objects", "parent_overrides", "model_properties", "withheld", "welded_bodies"):
            setattr(twin, name, getattr(self, name).copy())
        for name in ("weightless_bodies", "made_static", "owners"):
            setattr(twin, name, getattr(self, name).copy())
        twin._of_kind, twin._overridden = {}, {}
        twin.reindex()
        if self._by_name is not None:  # a copy takes a tenth of the time of another search
            twin._by_name = self._by_name.copy()
        if self._by_element is not None:
            twin._by_element = defaultdict(dict, {kind: ids.copy() for kind, ids in self._by_element.items()})
        return twin

    @property
    def keeps_ids(self) -> bool:
        """Return whether the next compile leaves the ids of the model's elements as they are."""
        return not self.is_edited_in_place and len(self.slots.sites) == self.slots.wanted_sites

    @property
    def name(self) -> str:
        """Return the file stem, or the model's name of a scene without a file."""
        return self.path.stem if self.path is not None else self.blueprint.base.modelname or "empty"

    def reindex(self) -> None:
        """Discard the look-up tables after objects or parents changed. Each is rebuilt at its next use."""
        self._of_kind.clear()
        self._forget_tree()
        self._by_element = None
        self._by_name = None

    def append(self, items: Iterable[SceneObject]) -> None:
        """Add objects with the next handles."""
        for item in items:
            self.objects[item.handle] = item
            self.next_handle = item.handle + 1
            if self._by_element is not None:
                self._by_element[item.element][item.id] = item.handle
            if self._by_name is not None:
                self._by_name[item.name] = item.handle
        self._of_kind.clear()
        self._forget_tree()

    def recall(
        self,
        parent_overrides: Mapping[int, int],
        model_properties: Mapping[int, int],
        withheld: Mapping[tuple[str, str], int],
        annotations: Annotations,
    ) -> None:
        """Restore the tables that change during a run. Objects follow, and then `reindex`."""
        self.parent_overrides = dict(parent_overrides)
        self.model_properties = dict(model_properties)
        self.withheld = dict(withheld)
        self.annotations = annotations

    def override_parent(self, handle: int, parent: int) -> None:
        """Move an object in the tree without changing the model."""
        self.override_parents({handle: parent})

    def override_parents(self, parents: Mapping[int, int]) -> None:
        """Move many objects as `override_parent` does: handle to parent."""
        for handle, parent in parents.items():
            self.parent_overrides[handle] = parent
            self.objects[handle].parent = parent
        self._forget_tree()

    def get(self, handle: int) -> SceneObject:
        """Return the object with this handle. Raises UnknownHandle."""
        try:
            return self.objects[handle]
        except KeyError:
            raise UnknownHandle(handle, self.objects) from None

    def get_kind(self, handle: int, *kinds: ObjectKind) -> SceneObject:
        """Return the object, which must be of one of the kinds. Raises UnknownHandle, WrongKind."""
        item = self.get(handle)
        if item.kind not in kinds:
            raise WrongKind(item.name, item.kind.text, " or ".join(kind.text for kind in kinds))
        return item

    def resolve(self, text: str, origin: int = -1) -> int:
        """Return the handle of a name or path; `./` starts from `origin`. Raises UnknownName."""
        return resolve(self, text, origin)

    def by_name(self, name: str) -> int | None:
        """Return the handle of exactly this object name, or None."""
        return self.by_names().get(name)

    def by_names(self) -> Mapping[str, int]:
        """Return the handles of all objects by name."""
        if self._by_name is None:
            self._by_name = {item.name: handle for handle, item in self.objects.items()}
        return self._by_name

    def by_element(self, element: str, element_id: int) -> int | None:
        """Return the handle of the object that this MuJoCo element carries, or None."""
        return self.by_elements(element).get(element_id)

    def by_elements(self, element: str) -> Mapping[int, int]:
        """Return the handles of all objects that MuJoCo elements of a kind carry, by the element's id."""
        if self._by_element is None:
            self._by_element = defaultdict(dict)
            for handle, item in self.objects.items():
                self._by_element[item.element][item.id] = handle
        return self._by_element[element]

    def owner_of_body(self, body: int, model: mujoco.MjModel) -> int:
        """Return the shape or dummy of a MuJoCo body: itself or the nearest object above; -1: the world."""
        while body > 0:
            handle = self.by_element("body", body)
            if handle is not None:
                return handle
            body = int(model.body_parentid[body])
        return -1

    def owner_of_geom(self, geom: int, model: mujoco.MjModel) -> int:
        """Return the shape a geom belongs to; -1 for an unnamed geom of the world."""
        handle = self.by_element("geom", geom)
        return handle if handle is not None else self.owner_of_body(int(model.geom_bodyid[geom]), model)

    def model_property(self, handle: int) -> int:
        """Return `sim_modelproperty_*` bits of a model base; NOT_A_MODEL for any other object. Raises UnknownHandle."""
        note = self.get(handle).annotations.get("model", {})
        bits = int(note.get("properties", 0))
        return self.model_properties.get(handle, bits if note.get("base", False) else NOT_A_MODEL)

    def set_model_property(self, handle: int, bits: int) -> None:
        """Store `sim_modelproperty_*` bits, or NOT_A_MODEL; `properties.py` applies them."""
        self.model_properties[handle] = bits
        self._forget_overridden()

    def own_model_bits(self, handle: int) -> int:
        """Return the `sim_modelproperty_*` bits of a model base; 0 for any other object. Raises UnknownHandle."""
        own = self.model_property(handle)
        return 0 if own & NOT_A_MODEL else own

    def is_model_base(self, handle: int) -> bool:
        """Return whether the object is the base of a model. Raises UnknownHandle."""
        return not self.model_property(handle) & NOT_A_MODEL

    def _forget_tree(self) -> None:
        self.tree = object()
        self._children = None
        self._leaves_first = {}
        self._descendants, self.carried_apart, self.dofs_below = {}, {}, {}  # a twin shares the present ones
        self._forget_overridden()

    def _forget_overridden(self) -> None:
        self._overridden.clear()
        self.properties_version += 1

    def overridden(self, handle: int) -> int:
        """Return the `sim_modelproperty_*` bits that an object gets from its models. Cached until they change."""
        known = self._overridden
        if (bits := known.get(handle)) is not None:
            return bits
        way = list[int]()
        while handle not in known and handle in self.objects:
            way.append(handle)
            handle = self.objects[handle].parent
        bits = known.get(handle, 0)
        for each in reversed(way):
            bits |= self.own_model_bits(each)
            known[each] = bits
        return bits

    def children(self, handle: int) -> list[int]:
        """Return handles of the direct children in hierarchy order; -1 means the top level."""
        return list(self._lists_of_children().get(handle, ()))

    def _lists_of_children(self) -> Mapping[int, list[int]]:
        if self._children is None:
            self._children = defaultdict(list)
            for handle, item in self.objects.items():
                self._children[item.parent] += [handle]
            placed: dict[int, Any] = {
                handle: item.annotations["object"]["sibling"]
                for handle, item in self.objects.items()
                if "object" in item.annotations and "sibling" in item.annotations["object"]
            }
            for parent in {self.objects[handle].parent for handle in placed}:
                self._children[parent].sort(key=lambda handle: placed.get(handle, math.inf))
        return self._children

    def leaves_first(self) -> Mapping[int, int]:
        """Return handle to position, children before their parents. Cached until the tree changes."""
        places = self._leaves_first
        if not places:
            # Siblings the other way round, and children after their parents, is the whole order the other way round.
            children, waiting, backwards = self._lists_of_children(), [-1], list[int]()
            while waiting:
                handle = waiting.pop()
                backwards.append(handle)
                waiting += children.get(handle, ())
            places.update((handle, place) for place, handle in enumerate(reversed(backwards[1:])))
        return places

    def descendants(self, handle: int) -> list[int]:
        """Return handles of the whole tree below, depth first, without the object itself."""
        found = self._descendants.get(handle)
        if found is None:
            found = self._descendants[handle] = tuple(self._walk(handle))
        return list(found)

    def _walk(self, handle: int) -> Iterator[int]:
        """Yield what is below an object, without recursion: a tree may be deep."""
        children = self._lists_of_children()
        waiting = list(reversed(children.get(handle, ())))
        while waiting:
            each = waiting.pop()
            yield each
            waiting += reversed(children.get(each, ()))

    def of_kind(self, kind: ObjectKind | int) -> list[int]:
        """Return handles of all objects of a kind, in scene order."""
        if kind not in self._of_kind:
            self._of_kind[kind] = [handle for handle, item in self.objects.items() if item.kind == kind]
        return list(self._of_kind[kind])

    def is_below(self, handle: int, ancestor: int) -> bool:
        """Return whether `ancestor` is the object itself or one of its ancestors."""
        while handle != -1:
            if handle == ancestor:
                return True
            handle = self.objects[handle].parent
        return False
