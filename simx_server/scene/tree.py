"""Build the tree of V-REP objects from a compiled model.

Per body, in this order along the chain from its parent: joints, then a force sensor (a site with both force and torque
sensors), then the body itself when it has its own name. Bodies without one are skipped: their children belong to the
nearest object above. Names that start with INTERNAL were given by the loader to find elements again.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass

from .formats.annotations import WORLD, Annotation, Annotations, SceneError, check_objects
from .naming.names import GRAFT_END, INTERNAL, alias_of
from .objects import ANNOTATED_KINDS, ObjectKind, Scene, SceneObject
from .poses.start import Start


@dataclass(frozen=True)
class Addition:
    """Objects that an edit adds to a scene, beside the elements in the spec."""

    prefix: str
    """Prefix of the names of all added elements."""
    names: Mapping[tuple[str, str], str]
    """(element, element name) to the name of the object."""
    annotations: Mapping[str, dict[str, Annotation]]
    """Annotations by object name."""
    copies: bool = False
    """Whether an added element starts with the state of the one with the same name without the prefix."""
    hidden: frozenset[str] = field(default=frozenset())
    """Names of added bodies without an object."""
    registered: Mapping[str, Mapping[str, Annotation]] = field(
        default_factory=dict[str, Mapping[str, Annotation]]
    )
    """Registered entries by kind and name."""
    start: Start = field(default_factory=Start)
    """Positions of added elements, where they are not those of their bodies in the spec."""


def build_scene(
    spec: mujoco.MjSpec, model: mujoco.MjModel, annotations: Annotations, path: Path | None
) -> Scene:
    """Return all objects of a model that was just loaded; they have the names of their elements.

    Raises SceneError when an annotation does not fit an object.
    """
    builder = Builder(model, annotations)
    builder.build()
    check_objects(annotations, {item.name: item.kind.text for item in builder.objects.values()})
    scene = Scene(builder.objects, spec, path, builder.next_handle, annotations)
    scene.owners = np.array([builder.owner[body] for body in range(model.nbody)])
    scene.parent_overrides = builder.annotated_parents()
    for handle, parent in scene.parent_overrides.items():
        scene.objects[handle].parent = parent
    _check_parents(scene)
    return scene


def _check_parents(scene: Scene) -> None:
    """Raise SceneError where annotations make an object its own ancestor."""
    for handle in scene.parent_overrides:
        above, seen = handle, set[int]()
        while above != -1:
            if above in seen:
                name = scene.objects[handle].name
                raise SceneError(f"text 'simx:object:{name}' makes '{name}' an ancestor of itself")
            seen.add(above)
            above = scene.objects[above].parent


class Builder:
    """Make the objects of a whole model. `scene/editing/successor.py` makes only those that an edit concerns."""

    def __init__(
        self,
        model: mujoco.MjModel,
        annotations: Annotations,
        hidden: Collection[str] = (),
        given_names: Mapping[tuple[str, str], str] | None = None,
        unseen_sites: Collection[str] = (),
    ) -> None:
        """Prepare the objects of a model.

        Args:
            hidden: names of bodies that are not objects any more.
            unseen_sites: names of sites that are not objects.
            given_names: object names by (element, element name); other new objects have their element's name.
        """
        self.model = model
        self.hidden = hidden
        self.unseen_sites = unseen_sites
        self.given_names = given_names or {}
        self.annotations = annotations
        self.objects: dict[int, SceneObject] = {}
        self.next_handle = 1
        self._added = 0
        self.owner: dict[int, int] = {0: -1}
        self.site_sensors = _sensors_by_site(model)

    def known(self, element: str, element_id: int, element_name: str) -> SceneObject | None:
        """Return the object as it was before an edit."""
        return None

    @cached_property
    def taken(self) -> set[str]:
        """Return the names that no other object can get."""
        return set()

    @cached_property
    def _leaves(self) -> dict[str, dict[int, list[int]]]:
        model = self.model
        bodies = {"site": model.site_bodyid, "camera": model.cam_bodyid, "light": model.light_bodyid}
        return {element: _by_body(ids) for element, ids in bodies.items()}

    def leaves_of(self, element: str, body: int) -> Sequence[int]:
        """Return the ids of the sites, cameras or lights of a body."""
        return self._leaves[element].get(body, ())

    def build(self) -> None:
        children = _by_body(self.model.body_parentid)
        self.add_world()
        waiting = [child for child in reversed(children.get(0, [])) if child != 0]
        while waiting:
            body = waiting.pop()
            self.add_body(body)
            waiting += reversed(children.get(body, []))
        self.add_tendons()
        self.arrange()

    def arrange(self) -> dict[int, int]:
        """Give the new objects handles in the order of their annotations.

        Objects without such an annotation come after those with one.

        Returns:
            Old handle to new, of those that change.
        """
        first = self.next_handle - self._added
        new = [handle for handle in self.objects if handle >= first]
        orders = {handle: self._note(self.objects[handle].name).get("order") for handle in new}
        changed: dict[int, int] = {}
        if any(order is not None for order in orders.values()):
            wanted = sorted(sorted(new), key=lambda handle: _place_of(orders[handle]))
            changed = {
                handle: first + place for place, handle in enumerate(wanted) if handle != first + place
            }
            for item in self.objects.values():
                item.handle = changed.get(item.handle, item.handle)
                item.parent = changed.get(item.parent, item.parent)
            self.objects = {item.handle: item for item in self.objects.values()}
            self.owner = {body: changed.get(handle, handle) for body, handle in self.owner.items()}
        self.objects = dict(sorted(self.objects.items()))
        return changed

    def annotated_parents(self) -> dict[int, int]:
        """Return the parents that annotations give to new objects, where they differ from those of the bodies."""
        first = self.next_handle - self._added
        by_name = {item.name: handle for handle, item in self.objects.items()}
        found: dict[int, int] = {}
        for handle, item in self.objects.items():
            wanted = self._note(item.name).get("parent") if handle >= first else None
            if wanted is not None:
                parent = -1 if wanted == WORLD else by_name.get(str(wanted), item.parent)
                if parent != item.parent:
                    found[handle] = parent
        return found

    def _note(self, name: str) -> Annotation:
        return self.annotations.objects.get(name, {}).get("object", {})

    def add_world(self) -> None:
        """Add the objects in the world itself."""
        model = self.model
        for geom in range(int(model.body_geomadr[0]), int(model.body_geomadr[0] + model.body_geomnum[0])):
            self.add_world_geom(geom)
        self._add_leaves(0, -1, skip=-1)

    def add_world_geom(self, geom: int) -> None:
        """Add a shape that is a part of the world, if it has its own name."""
        name = self.model.geom(geom).name
        if self._public(name):
            self._add("geom", geom, name, ObjectKind.SHAPE, -1, 0)

    def add_body(self, body: int) -> None:
        """Add a body whose parent was added, with its joints and other elements."""
        model = self.model
        parent = self.owner[int(model.body_parentid[body])]
        first = int(model.body_jntadr[body])
        for joint in range(first, first + int(model.body_jntnum[body])):
            name = model.joint(joint).name
            if model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_FREE.value and self._public(name):
                parent = self._add("joint", joint, name, ObjectKind.JOINT, parent, body)
        force_site = self._force_site(body)
        if force_site >= 0:
            sensors = self.site_sensors[force_site]
            name = model.site(force_site).name
            parent = self._add(
                "site", force_site, name, ObjectKind.FORCE_SENSOR, parent, body, _force_torque(sensors)
            )
        name = model.body(body).name
        if self._public(name) and name not in self.hidden:
            kind = ObjectKind.SHAPE if model.body_geomnum[body] else ObjectKind.DUMMY
            parent = self._add("body", body, name, kind, parent, body)
        self.owner[body] = parent
        self._add_leaves(body, parent, skip=force_site)

    def _add_leaves(self, body: int, parent: int, skip: int) -> None:
        model = self.model
        for site in self.leaves_of("site", body):
            name = model.site(site).name
            if site == skip or not self._public(name) or name in self.unseen_sites:
                continue
            rays = tuple(
                i
                for kind, i in self.site_sensors.get(site, ())
                if kind == mujoco.mjtSensor.mjSENS_RANGEFINDER.value
            )
            if _force_torque(self.site_sensors.get(site, [])):
                sensors = _force_torque(self.site_sensors[site])
                self._add("site", site, name, ObjectKind.FORCE_SENSOR, parent, body, sensors)
            elif rays or self._annotation("site", site, name, "proximity"):
                self._add("site", site, name, ObjectKind.PROXIMITY_SENSOR, parent, body, rays)
            else:
                self._add("site", site, name, ObjectKind.DUMMY, parent, body)
        for camera in self.leaves_of("camera", body):
            name = model.camera(camera).name
            view = self._annotation("camera", camera, name, "camera").get("view", False)
            kind = ObjectKind.CAMERA if view else ObjectKind.VISION_SENSOR
            self._add("camera", camera, name, kind, parent, body)
        for light in self.leaves_of("light", body):
            self._add("light", light, model.light(light).name, ObjectKind.LIGHT, parent, body)

    def add_tendons(self) -> None:
        """Add the joints on tendons."""
        model = self.model
        on_tendons = np.flatnonzero(model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON.value).tolist()
        driven = sorted({int(model.actuator_trnid[a, 0]) for a in on_tendons if drives_tendon(model, a)})
        for tendon in driven:
            name = model.tendon(tendon).name
            if not self._public(name):
                continue
            body = tendon_body(model, tendon)
            parent = self.owner_of(body)
            wanted = self._annotation("tendon", tendon, name, "joint").get("parent")
            if isinstance(wanted, str):
                parent = self.named_parent(name, wanted, parent)
            self._add("tendon", tendon, name, ObjectKind.JOINT, parent, body)

    def owner_of(self, body: int) -> int:
        """Return the handle of the parent for elements of a body."""
        return self.owner.get(body, -1)

    def named_parent(self, tendon: str, name: str, otherwise: int) -> int:
        """Return the handle of the parent in a tendon's annotation. Raises SceneError: the object does not exist."""
        for handle, item in self.objects.items():
            if item.name == name:
                return handle
        raise SceneError(f"text 'simx:joint:{tendon}' has parent={name}, which is no object of the scene")

    def _add(
        self,
        element: str,
        element_id: int,
        element_name: str,
        kind: ObjectKind,
        parent: int,
        body: int,
        sensors: tuple[int, ...] = (),
    ) -> int:
        known = self.known(element, element_id, element_name)
        if known is not None:
            handle, name = known.handle, known.name
        else:
            handle, name = self.next_handle, self._name_of(element, element_name)
            self.next_handle += 1
            self._added += 1
        self.taken.add(name)
        note = self._note(name)
        kind = ANNOTATED_KINDS.get(str(note.get("type")), kind)
        self.objects[handle] = SceneObject(
            handle=handle,
            name=name,
            kind=kind,
            parent=parent,
            element=element,
            element_name=element_name,
            id=element_id,
            body=body,
            alias=known.alias if known is not None else str(note.get("alias", alias_of(name))),
            annotations=self.annotations.objects.get(name, {}),
            sensors=sensors,
        )
        return handle

    def _free_name(self, name: str, element: str) -> str:
        """Return a free name; the second object with a name gets its kind appended.

        V-REP's names are unique over all kinds of objects, MuJoCo's per kind.
        """
        candidate, count = name, 0
        while candidate in self.taken:
            alias = alias_of(name)  # the copy number stays at the end
            candidate = f"{alias}_{element}{count or ''}{name.removeprefix(alias)}"
            count += 1
        return candidate

    def _name_of(self, element: str, element_name: str) -> str:
        given = self.given_names.get((element, element_name))
        return given if given is not None else self._free_name(element_name, element)

    def _annotation(self, element: str, element_id: int, element_name: str, kind: str) -> Annotation:
        known = self.known(element, element_id, element_name)
        name = (
            known.name if known is not None else self.given_names.get((element, element_name), element_name)
        )
        return self.annotations.objects.get(name, {}).get(kind, {})

    def _force_site(self, body: int) -> int:
        """Return the site whose force sensor links the body to its parent, or -1."""
        for site in self.leaves_of("site", body):
            if self._public(self.model.site(site).name) and _force_torque(self.site_sensors.get(site, [])):
                return site
        return -1

    @staticmethod
    def _public(name: str) -> bool:
        return bool(name) and not name.rpartition(GRAFT_END)[2].startswith(INTERNAL)


def drives_tendon(model: mujoco.MjModel, actuator: int) -> bool:
    """Return whether an actuator is a servo (velocity or position) on a tendon, which is then a prismatic joint."""
    return (
        model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_TENDON.value
        and model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED.value
        and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_AFFINE.value
        and model.actuator_ctrlnum[actuator] == 1
    )


def tendon_body(model: mujoco.MjModel, tendon: int) -> int:
    """Return the body of a tendon's first site, or of its first joint."""
    for wrap in range(
        int(model.tendon_adr[tendon]), int(model.tendon_adr[tendon] + model.tendon_num[tendon])
    ):
        if model.wrap_type[wrap] == mujoco.mjtWrap.mjWRAP_SITE.value:
            return int(model.site_bodyid[model.wrap_objid[wrap]])
        if model.wrap_type[wrap] == mujoco.mjtWrap.mjWRAP_JOINT.value:
            return int(model.jnt_bodyid[model.wrap_objid[wrap]])
    return 0


def _place_of(order: object) -> float:
    return float(order) if isinstance(order, (int, float)) else float("inf")


def _by_body(bodies: np.ndarray) -> dict[int, list[int]]:
    found: dict[int, list[int]] = {}
    for index, body in enumerate(bodies.tolist()):
        found.setdefault(body, []).append(index)
    return found


def _sensors_by_site(model: mujoco.MjModel) -> dict[int, list[tuple[int, int]]]:
    found: dict[int, list[tuple[int, int]]] = {}
    for sensor in np.flatnonzero(model.sensor_objtype == mujoco.mjtObj.mjOBJ_SITE.value).tolist():
        entry = (int(model.sensor_type[sensor]), sensor)
        found.setdefault(int(model.sensor_objid[sensor]), []).append(entry)
    return found


def _force_torque(sensors: list[tuple[int, int]]) -> tuple[int, ...]:
    """Return (force sensor id, torque sensor id), or () unless the site has both."""
    by_type = dict(reversed(sensors))
    force = by_type.get(int(mujoco.mjtSensor.mjSENS_FORCE))
    torque = by_type.get(int(mujoco.mjtSensor.mjSENS_TORQUE))
    return () if force is None or torque is None else (force, torque)
