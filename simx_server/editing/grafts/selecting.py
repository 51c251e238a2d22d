"""The objects that are copied, and the bodies that are copied for them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Set
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.editing.copies.kept import Kept
from simx_server.scene.editing.copies.straight import Straight
from simx_server.scene.editing.waiting.basis import Basis
from simx_server.scene.editing.waiting.templates import Template
from simx_server.scene.editing.welding import start_pose
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scene.poses.placing import free_joint
from simx_server.scene.poses.poses import Pose
from simx_server.scene.registered import concerned

from .grafting import Element, Graft

if TYPE_CHECKING:
    from simx_server.scene.formats.annotations import Annotation
    from simx_server.simulation.simulation import Simulation

LEAVES = {"site": "site_", "camera": "cam_", "light": "light_"}
"""Kinds of elements that a body may have beside its shapes and joints, and the prefix of the model's arrays."""


class Selection:
    """The chosen objects, and the bodies that are copied for them."""

    def __init__(self, sim: Simulation, basis: Basis, chosen: Collection[int]) -> None:
        """Find the bodies.

        Args:
            sim: the simulation.
            basis: the scene as its model has it.
            chosen: handles of the objects.
        """
        self.sim = sim
        self.basis = basis
        self.items = [basis.item(sim.scene.objects[handle]) for handle in sorted(chosen)]
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
        objects = {(item.element, item.element_name): item.name for item in self.items}
        notes = {
            item.name: {kind: note for kind, note in item.annotations.items() if kind not in dropped}
            for item in self.items
            if item.annotations
        }
        hidden = (bodies & scene.hidden_bodies) | carriers

        def template() -> Template | None:
            if not isinstance(part, Straight) or part.refers_outside:
                return None
            return Template.of_copies(self.basis.model, part, objects, notes, hidden)

        return Graft(
            part=part,
            names=objects,
            annotations=notes,
            registered=_concerning(self.sim, {item.name for item in self.items}),
            copies=True,
            moved=moved,
            hidden=hidden,
            welded=(bodies & scene.welded_bodies) - placed,
            weightless=bodies & scene.weightless_bodies,
            template=template,
        )

    def straight(self) -> Straight | None:
        """Return the bodies as they are, if they can be copied so: nothing of them is left out but other objects."""
        basis, model = self.basis, self.basis.model
        if not all(self.kept.values()):
            return None
        if any(
            item.element == "tendon" or item.body not in self.kept or item.element == "geom"
            for item in self.items
        ):
            return None
        tops: dict[str, Pose] = {}
        names: dict[int, str] = {}
        for body in self.kept:
            name, above = model.body(body).name, int(model.body_parentid[body])
            is_top = above not in self.kept
            if self.lost_joints(body) or (is_top and name in basis.scene.welded_bodies):
                return None
            if is_top and above != 0:
                tops[name] = start_pose(basis, body)
            names[body] = name
        parents = model.body_parentid.tolist()
        bodies = {
            names[body]: names.get(parents[body]) or model.body(parents[body]).name for body in sorted(names)
        }
        return Straight(basis.scene.blueprint.having(bodies), bodies, tops, self.left_out())

    def _kept_bodies(self) -> dict[int, bool]:
        """Return kept body id to whether its object is copied; False: it only carries a joint or force sensor."""
        model, scene = self.basis.model, self.basis.scene
        whole = {item.id for item in self.items if item.element == "body"}
        kept = dict.fromkeys(whole, True)
        # Bodies without an object belong to the copied body that carries them.
        parts: list[int] = []
        carriers = list(whole)
        while carriers:
            below = np.flatnonzero(np.isin(model.body_parentid, carriers)).tolist()
            carriers = [
                body
                for body in below
                if scene.by_element("body", body) is None and not self.lost_joints(body)
            ]
            parts += carriers
        kept |= dict.fromkeys(sorted(parts), True)
        for item in self.items:
            if item.element == "joint":
                kept.setdefault(item.body, False)
        return kept

    def left_out(self) -> set[Element]:
        """Return the elements in the copied bodies, and the tendons, that must not be copied."""
        model, scene = self.basis.model, self.basis.scene
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
        return [joint for joint in joints_of(self.basis.model, body) if ("joint", joint) not in self.chosen]


def _concerning(sim: Simulation, objects: Collection[str]) -> dict[str, dict[str, Annotation]]:
    """Return the registered entries that concern objects with these names and are alive, as `concerned`."""
    present = sim.scene.annotations.registered
    alive = {
        kind: {name: present[kind][name] for name in names if name in present.get(kind, {})}
        for kind, names in sim.parts.registered_names().items()
    }
    return concerned(alive, objects)


def joints_of(model: mujoco.MjModel, body: int) -> list[str]:
    """Return the names of a body's hinges, slides and balls."""
    count = int(model.body_jntnum[body])
    if not count or free_joint(model, body) >= 0:
        return []
    first = int(model.body_jntadr[body])
    return [model.joint(joint).name for joint in range(first, first + count)]
