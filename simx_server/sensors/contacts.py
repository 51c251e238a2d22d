"""The contacts of physics steps, and their forces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.poses.poses import Vector
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.simulation.simulation import Simulation


_NAME = "contacts"
"""Among those that accompany physics steps."""


@dataclass(frozen=True, slots=True)
class Contact:
    """One point in which two objects push each other."""

    objects: tuple[int, int]
    """Handles of the shapes; -1 for a part of the world without a name."""
    point: Vector
    """Position in metres, in the world."""
    force: Vector
    """Force in newtons, in the world: what the second object exerts on the first, as in V-REP."""
    normal: Vector
    """Unit vector in the world, from the second object to the first."""


class Contacts(Part):
    """The contacts of the physics steps of the last simulation step.

    Once a program has asked for contacts, those of each physics step are kept; the first answer has those of the last
    physics step.
    """

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._steps: list[_Step] = []
        """By physics step of the last simulation step."""
        self._are_kept = False
        self._found: tuple[object, Sequence[Contact]] = None, ()
        """The last answer, and what it belongs to."""

    def model_changed(self, twins: Twins | None) -> None:
        self._steps.clear()
        self._found = None, ()

    def run_stopped(self) -> None:
        self._steps.clear()

    def scene_changed(self) -> None:
        self._are_kept = False
        self._sim.joints.controllers.accompany(None, _NAME)

    def find(self, physics_step: int | None, handle: int | None = None) -> Sequence[Contact]:
        """Return the contacts of an object, as the first of the two, or of all objects.

        Args:
            physics_step: one of those of the last simulation step, from 0; None for all, in order.
            handle: the object; None for all.
        """
        if not self._are_kept:
            self._are_kept = True
            self._sim.joints.controllers.accompany(self._note, _NAME)
        key = self._sim.version, len(self._steps), physics_step, handle
        if self._found[0] != key:  # a program asks for one after the other
            self._found = key, tuple(self._find(physics_step, handle))
        return self._found[1]

    def _find(self, physics_step: int | None, handle: int | None) -> Iterator[Contact]:
        data = self._sim.sleepers.data_with_all_contacts()
        if not self._steps:
            yield from self._of(_Step.of(self._sim.model, data), handle)
            return
        asleep = _Step.of(self._sim.model, data).where(self._sleeping(data))
        for step in self._steps if physics_step is None else self._steps[physics_step : physics_step + 1]:
            yield from self._of(step, handle)
            yield from self._of(asleep, handle)

    def _note(self, index: int, _count: int, is_after: bool) -> None:
        if is_after:
            if index == 0:
                self._steps.clear()
            self._steps.append(_Step.of(self._sim.model, self._sim.data))

    def _sleeping(self, data: mujoco.MjData) -> NDArray[np.bool_]:
        """Return which contacts are between bodies that sleep, or do not move; a physics step leaves them out."""
        model, asleep = self._sim.model, self._sim.data.tree_asleep >= 0
        trees = model.body_treeid[model.geom_bodyid[np.maximum(data.contact.geom, 0)]]
        if not asleep.any():
            return np.zeros(len(trees), np.bool_)
        return np.all((trees < 0) | asleep[trees], axis=1) & np.any(trees >= 0, axis=1)

    def _of(self, step: _Step, handle: int | None) -> Iterator[Contact]:
        scene, model = self._sim.scene, self._sim.model
        for geoms, point, frame, force in zip(
            step.geoms.tolist(), step.points, step.frames, step.forces, strict=True
        ):
            first, second = (scene.owner_of_geom(geom, model) if geom >= 0 else -1 for geom in geoms)
            if handle is not None and handle not in (first, second):
                continue
            # MuJoCo gives the force on the second, with a normal towards it.
            axes = frame.reshape(3, 3)
            pushed, normal = -force @ axes, -axes[0]
            if second == handle:
                first, second, pushed, normal = second, first, -pushed, -normal
            yield Contact((first, second), _vector(point), _vector(pushed), _vector(normal))


@dataclass(frozen=True, eq=False, slots=True)
class _Step:
    """The contacts of one physics step that push, as MuJoCo has them."""

    geoms: NDArray[np.int32]
    """(n, 2)"""
    points: NDArray[np.float64]
    frames: NDArray[np.float64]
    """(n, 9)"""
    forces: NDArray[np.float64]
    """(n, 3) N, along the axes of the frames."""

    @classmethod
    def of(cls, model: mujoco.MjModel, data: mujoco.MjData) -> _Step:
        """Return those of the present data."""
        contact = data.contact
        forces, force = np.zeros((data.ncon, 3)), np.zeros(6)
        pushing = contact.efc_address >= 0
        for index in np.flatnonzero(pushing):
            mujoco.mj_contactForce(model, data, index, force)
            forces[index] = force[:3]
        return cls(contact.geom.copy(), contact.pos.copy(), contact.frame.copy(), forces).where(pushing)

    def where(self, chosen: NDArray[np.bool_]) -> _Step:
        """Return some of the contacts."""
        return _Step(self.geoms[chosen], self.points[chosen], self.frames[chosen], self.forces[chosen])


def _vector(values: np.ndarray) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
