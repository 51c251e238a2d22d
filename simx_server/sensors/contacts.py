"""The contacts of the last physics step, and their forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.poses.poses import Vector

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation


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


def contacts(sim: Simulation, handle: int | None = None) -> Iterator[Contact]:
    """Yield the contacts of an object, as the first of the two, or of all objects.

    These are the contacts of the last physics step; V-REP would list those of every physics step in the simulation
    step.
    """
    scene, model, data = sim.scene, sim.model, sim.sleepers.data_with_all_contacts()
    force = np.zeros(6)
    for index in range(data.ncon):
        contact = data.contact[index]
        first, second = (scene.owner_of_geom(int(geom), model) if geom >= 0 else -1 for geom in contact.geom)
        if contact.efc_address < 0 or (handle is not None and handle not in (first, second)):
            continue
        # MuJoCo gives the force on the second, with a normal towards it.
        mujoco.mj_contactForce(model, data, index, force)
        axes = contact.frame.reshape(3, 3)
        pushed, normal = -force[:3] @ axes, -axes[0]
        if second == handle:
            first, second, pushed, normal = second, first, -pushed, -normal
        yield Contact((first, second), _vector(contact.pos), _vector(pushed), _vector(normal))


def _vector(values: np.ndarray) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
