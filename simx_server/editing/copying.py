"""Copy objects as V-REP's copy and paste does: whole models, or objects alone.

The chosen objects are extracted from the scene's spec together with the elements that act on them, prepared, and added
to the scene. Joints, motors, sensors, tendons and equalities between copied objects therefore work in the copy;
elements that reach outside are left out. Collections, collision and distance objects are copied with their objects.
A copy has the present pose and state of its original; if the parent of an object is not copied, the copy goes to the
top of the tree.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterable, Mapping, Set
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.scene import properties
from simx_server.scene.editing.copies.kept import Kept
from simx_server.scene.editing.copies.straight import Straight
from simx_server.scene.editing.extracting import extract
from simx_server.scene.editing.transplant import move_body, move_leaf
from simx_server.scene.editing.welding import body_name, start_pose
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.placing import body_pose, element_pose, free_joint
from simx_server.scene.poses.poses import Pose, compose, inverse
from simx_server.scene.registered import concerned
from simx_server.scene.spec_elements import bodies_of, leaves_of

from .grafting import Element, Graft, graft

if TYPE_CHECKING:
    from simx_server.scene.formats.annotations import Annotation
    from simx_server.scene.live import LiveScene
    from simx_server.scene.objects import Scene
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

_PREFIX = {"site": "site_", "camera": "cam_", "light": "light_"}
_CARRIER_MASS = 1e-3
"""Mass in kg of the body that replaces a copied joint's missing child, and its inertia in kg m^2."""


def copy_objects(world: World, handles: list[int], kept: Kept | None = None) -> list[int]:
    """Copy objects, stopped or running; return the handle of each copy, of a whole model only its base's.

    Unknown handles are skipped. Raises CommandError when MuJoCo cannot represent the result.
    """
    sim = world.simulation
    kept = kept or Kept()
    about_to_be_copied = _chosen(sim.scene, handles, kept)[1]
    sim.parts.tell(lambda part: part.copying_objects(about_to_be_copied))
    scene = sim.scene
    shown, chosen = _chosen(scene, handles, kept)
    if not chosen:
        return []
    sim.refresh()
    added = graft(sim, _graft(Selection(sim, chosen), kept))
    items = {handle: scene.objects[handle] for handle in sorted(chosen)}
    copies = {
        handle: added[item.element, item.element_name]
        for handle, item in items.items()
        if (item.element, item.element_name) in added
    }
    sim.scene.override_parents(
        {copy: copies.get(items[handle].parent, -1) for handle, copy in copies.items()}
    )
    for handle, copy in copies.items():
        if handle in scene.model_properties:
            sim.scene.set_model_property(copy, scene.model_properties[handle])
    if not kept.textures:
        _color_plainly(sim, copies)
    properties.apply(sim)
    sim.joints.copy_settings(copies)
    sim.parts.tell(lambda part: part.objects_copied(copies, kept))
    sim.changed()
    return [copies[handle] for handle in shown if handle in copies]


def _chosen(scene: Scene, handles: list[int], kept: Kept) -> tuple[list[int], set[int]]:
    """Return the objects whose copies are returned, and all that are copied."""
    wanted = [handle for handle in dict.fromkeys(handles) if handle in scene.objects]
    models = [handle for handle in wanted if kept.models and scene.is_model_base(handle)]
    inside = {below for base in models for below in scene.descendants(base)}
    shown = [handle for handle in wanted if handle not in inside]
    chosen = set(shown).union(inside)
    if not kept.scripts:
        chosen = {handle for handle in chosen if scene.objects[handle].kind != ObjectKind.SCRIPT}
    return shown, chosen


def _graft(selection: Selection, kept: Kept) -> Graft:
    """Return what the copies add to the scene."""
    straight = selection.straight() if kept.textures else None
    if straight is not None:
        return selection.graft(kept, straight, straight.names, {("body_", name) for name in straight.tops})
    pruned = Pruned(selection)
    if not kept.textures:
        _strip_textures(pruned.spec, selection.sim.scene.spec.materials)
    bodies = [body.name for body in bodies_of(pruned.spec)]
    return selection.graft(kept, pruned.spec, bodies, pruned.moved, pruned.carriers)


class Selection:
    """The chosen objects, and the bodies that are copied for them."""

    def __init__(self, sim: Simulation, chosen: set[int]) -> None:
        self.sim = sim
        self.items = [sim.scene.objects[handle] for handle in sorted(chosen)]
        self.chosen = {(item.element, item.element_name) for item in self.items}
        self.kept = self._kept_bodies()

    def graft(
        self,
        kept: Kept,
        part: mujoco.MjSpec | Straight,
        names: Iterable[str],
        moved: Set[Element],
        carriers: Set[str] = frozenset(),
    ) -> Graft:
        """Return the objects, ready to be added.

        Args:
            kept: the settings of the copies.
            part: what is added to the scene's spec.
            names: of its bodies.
            moved: elements with a new place, as in `Graft`.
            carriers: names of its bodies that replace missing children of joints.
        """
        dropped = set[str]() if kept.scripts else set(SCRIPT_NOTES)
        if not kept.data:
            dropped.add("data")
        if not kept.references:
            dropped.add("references")
        scene, bodies = self.sim.scene, set(names)
        placed = {name for array, name in moved if array == "body_"}
        return Graft(
            part=part,
            names={(item.element, item.element_name): item.name for item in self.items},
            annotations={
                item.name: {kind: note for kind, note in item.annotations.items() if kind not in dropped}
                for item in self.items
                if item.annotations
            },
            registered=_concerning(self.sim, {item.name for item in self.items}),
            copies=True,
            moved=moved,
            hidden=(bodies & scene.hidden_bodies) | carriers,
            welded=(bodies & scene.welded_bodies) - placed,
            weightless=bodies & scene.weightless_bodies,
        )

    def straight(self) -> Straight | None:
        """Return the bodies as they are, if they can be copied so: nothing of them is left out but other objects."""
        sim, model = self.sim, self.sim.model
        if not all(self.kept.values()):
            return None
        if any(
            item.element == "tendon" or item.body not in self.kept or item.element == "geom"
            for item in self.items
        ):
            return None
        tops: dict[str, Pose] = {}
        for body in self.kept:
            name, above = model.body(body).name, int(model.body_parentid[body])
            is_top = above not in self.kept
            if self.lost_joints(body) or (is_top and name in sim.scene.welded_bodies):
                return None
            if is_top and above != 0:
                tops[name] = start_pose(sim, body)
        bodies = {
            model.body(body).name: body_name(sim, int(model.body_parentid[body]))
            for body in sorted(self.kept)
        }
        return Straight(sim.scene.blueprint.having(bodies), bodies, tops, self.left_out())

    def _kept_bodies(self) -> dict[int, bool]:
        """Return kept body id to whether its object is copied; False: it only carries a joint or force sensor."""
        model, scene = self.sim.model, self.sim.scene
        whole = {item.id for item in self.items if item.element == "body"}
        kept = dict.fromkeys(whole, True)
        # Bodies without an object belong to the copied body that carries them.
        parts: list[int] = []
        waiting = sorted(whole)
        while waiting:
            for body in np.flatnonzero(model.body_parentid == heapq.heappop(waiting)).tolist():
                if scene.by_element("body", body) is None and not self.lost_joints(body):
                    parts.append(body)
                    heapq.heappush(waiting, body)
        kept |= dict.fromkeys(sorted(parts), True)
        for item in self.items:
            if item.element == "joint":
                kept.setdefault(item.body, False)
        return kept

    def left_out(self) -> set[Element]:
        """Return the elements in the copied bodies, and the tendons, that must not be copied."""
        model, scene = self.sim.model, self.sim.scene
        tendons = {item.element_name for item in scene.objects.values() if item.element == "tendon"}
        left_out = {("tendon", name) for name in tendons if ("tendon", name) not in self.chosen}
        for body, whole in self.kept.items():
            left_out.update(("joint", joint) for joint in self.lost_joints(body))
            if not whole:  # a carrier, without shapes
                left_out.update(("geom", geom.name) for geom in scene.spec.body(model.body(body).name).geoms)
        for element, bodies in (
            ("site", model.site_bodyid),
            ("camera", model.cam_bodyid),
            ("light", model.light_bodyid),
        ):
            for index in np.flatnonzero(np.isin(bodies, list(self.kept))).tolist():
                handle = scene.by_element(element, index)
                if handle is not None and (element, scene.objects[handle].element_name) not in self.chosen:
                    left_out.add((element, scene.objects[handle].element_name))
        return left_out

    def lost_joints(self, body: int) -> list[str]:
        """Return the joints of a body that are not copied."""
        return [joint for joint in _joints(self.sim, body) if ("joint", joint) not in self.chosen]


class Pruned:
    """A spec that contains only the chosen objects, those without a carrier at the top."""

    def __init__(self, selection: Selection) -> None:
        self._selection = selection
        self.moved: set[Element] = set()
        self.carriers: set[str] = set()
        self.spec = self._extracted()
        self._move_to_the_top()
        for body, whole in selection.kept.items():
            if not whole:
                self._make_carrier(selection.sim.model.body(body).name)

    def _extracted(self) -> mujoco.MjSpec:
        sim, model, kept = self._selection.sim, self._selection.sim.model, self._selection.kept
        parents = {body: int(model.body_parentid[body]) for body in sorted(kept)}
        loose = [
            item
            for item in self._selection.items
            if item.element in ("geom", *_PREFIX) and item.body not in kept
        ]
        loose.sort(key=lambda item: (item.body != 0, item.id if item.body == 0 else 0))
        return extract(
            sim.scene.spec,
            {model.body(body).name: body_name(sim, above) for body, above in parents.items()},
            [(item.element, item.element_name) for item in loose],
            self._selection.left_out(),
        )

    def _move_to_the_top(self) -> None:
        sim, model, kept = self._selection.sim, self._selection.sim.model, self._selection.kept
        for body, whole in kept.items():
            name, lost = model.body(body).name, self._selection.lost_joints(body)
            above = int(model.body_parentid[body])
            welded = name in sim.scene.welded_bodies
            if (above in kept and not lost) or (above == 0 and not lost and not welded):
                continue
            pose = body_pose(sim, body) if lost else start_pose(sim, body)
            stays = above in kept
            if stays:
                pose = compose(inverse(body_pose(sim, above)), pose)
            was_dynamic = welded or (bool(lost) and len(lost) == len(_joints(sim, body)))
            # In V-REP a shape without its joint or sensor is a free dynamic shape.
            free = True if was_dynamic and whole and not stays else None
            move_body(self.spec, name, model.body(above).name if stays else "world", pose, free=free)
            if free:
                _let_fall(self.spec.body(name))
            self.moved.add(("body_", name))
        for item in self._selection.items:
            if item.element in _PREFIX and item.body not in kept and item.body != 0:
                size = model.site_size[item.id] if item.element == "site" else None
                pose = element_pose(sim, item)
                move_leaf(self.spec, item.element, item.element_name, "world", pose, size)
                self.moved.add((_PREFIX[item.element], item.element_name))

    def _make_carrier(self, name: str) -> None:
        """Add a light body that a copied joint moves when its child is not copied."""
        body = self.spec.body(name)
        body.explicitinertial = True
        body.mass = _CARRIER_MASS
        body.inertia[:] = _CARRIER_MASS
        body.ipos[:], body.iquat[:] = 0.0, (1.0, 0.0, 0.0, 0.0)
        body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
        body.fullinertia[:] = float("nan")
        self.carriers.add(name)


def _strip_textures(spec: mujoco.MjSpec, materials: Iterable[Any]) -> None:
    """Take the textured materials from the shapes of a spec."""
    textured = {material.name for material in materials if any(material.textures)}
    for geom in leaves_of(spec, "geoms"):
        if geom.material in textured:
            geom.material = ""


def _color_plainly(sim: LiveScene, copies: Mapping[int, int]) -> None:
    """Give copied shapes that lost a textured material its plain colour."""
    model, objects = sim.model, sim.scene.objects
    for original, copy in copies.items():
        if objects[original].element != "body":
            continue
        first, other = (int(model.body_geomadr[objects[handle].id]) for handle in (original, copy))
        for index in range(int(model.body_geomnum[objects[original].id])):
            material = int(model.geom_matid[first + index])
            if material >= 0 and model.geom_matid[other + index] < 0:
                model.geom_rgba[other + index] = model.mat_rgba[material]


def _let_fall(body: Any) -> None:
    """Remove the gravity compensation from a body and all fixed to it: only its motors had made it weightless."""
    body.gravcomp = 0.0
    for child in body.bodies:
        if not list(child.joints):
            _let_fall(child)


def _concerning(sim: Simulation, objects: Collection[str]) -> dict[str, dict[str, Annotation]]:
    """Return the registered entries that concern objects with these names and are alive, as `concerned`."""
    present = sim.scene.annotations.registered
    alive = {
        kind: {name: present[kind][name] for name in names if name in present.get(kind, {})}
        for kind, names in sim.parts.registered_names().items()
    }
    return concerned(alive, objects)


def _joints(sim: LiveScene, body: int) -> list[str]:
    """Return the names of a body's hinges, slides and balls."""
    if free_joint(sim.model, body) >= 0:
        return []
    first = int(sim.model.body_jntadr[body])
    return [sim.model.joint(joint).name for joint in range(first, first + int(sim.model.body_jntnum[body]))]
