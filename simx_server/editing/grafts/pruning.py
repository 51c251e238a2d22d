"""A spec that contains only some objects of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import mujoco

from simx_server.scene.editing.extracting import extract
from simx_server.scene.editing.transplant import move_body, move_leaf
from simx_server.scene.editing.welding import start_pose
from simx_server.scene.poses.placing import body_pose, element_pose
from simx_server.scene.poses.poses import compose, inverse
from simx_server.scene.spec_elements import leaves_of

from .selecting import LEAVES, joints_of

if TYPE_CHECKING:
    from .grafting import Element
    from .selecting import Selection

_CARRIER_MASS = 1e-3
"""Mass in kg of the body that replaces a copied joint's missing child, and its inertia in kg m^2."""


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
            if item.element in ("geom", *LEAVES) and item.body not in kept
        ]
        loose.sort(key=lambda item: (item.body != 0, item.id if item.body == 0 else 0))
        return extract(
            sim.scene.spec,
            {model.body(body).name: model.body(above).name for body, above in parents.items()},
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
            was_dynamic = welded or (bool(lost) and len(lost) == len(joints_of(model, body)))
            # In V-REP a shape without its joint or sensor is a free dynamic shape.
            free = True if was_dynamic and whole and not stays else None
            move_body(self.spec, name, model.body(above).name if stays else "world", pose, free=free)
            if free:
                _let_fall(self.spec.body(name))
            self.moved.add(("body_", name))
        for item in self._selection.items:
            if item.element in LEAVES and item.body not in kept and item.body != 0:
                size = model.site_size[item.id] if item.element == "site" else None
                pose = element_pose(sim, item)
                move_leaf(self.spec, item.element, item.element_name, "world", pose, size)
                self.moved.add((LEAVES[item.element], item.element_name))

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


def strip_textures(spec: mujoco.MjSpec, materials: Iterable[Any]) -> None:
    """Take the textured materials from the shapes of a spec."""
    textured = {material.name for material in materials if any(material.textures)}
    for geom in leaves_of(spec, "geoms"):
        if geom.material in textured:
            geom.material = ""


def _let_fall(body: Any) -> None:
    """Remove the gravity compensation from a body and all fixed to it: only its motors had made it weightless."""
    body.gravcomp = 0.0
    for child in body.bodies:
        if not list(child.joints):
            _let_fall(child)
