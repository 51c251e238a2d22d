"""Validity of states: which geoms must not collide, and fast checks of that on a scratch state."""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.kinematics.chain import Joints
from simx_server.kinematics.scratch import Array, copy_positions
from simx_server.sensors.distance.measuring import geoms_meet
from simx_server.simulation.sleepers import kinematics

if TYPE_CHECKING:
    from .planning_world import PlanningWorld

Pairs = list[tuple[int, int]]
"""Entities (objects, collections, or sim.handle_all as second) that must not collide."""

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)


MOST_PAIRS = 1000
"""Collision pairs: each state of a search is checked for all of them at once."""


def as_pairs(entities: Sequence[int] | None) -> Pairs:
    """Return the pairs of a flat list {first, second, first, second, ...}.

    Raises:
        CommandError: the count is odd, or there are too many.
    """
    listed = list(entities or [])
    if len(listed) > 2 * MOST_PAIRS:
        raise CommandError(
            f"at most {MOST_PAIRS} collision pairs are checked; use collections for more objects"
        )
    if len(listed) % 2:
        raise CommandError("collision pairs are entities two by two: {first, second, first, second, ...}")
    return list(zip(listed[::2], listed[1::2], strict=True))


class Validity:
    """Checks whether any of the pairs collide in a state. Valid as long as the model stays the same.

    Pairs of geoms that do not move against each other (a robot's foot and the floor) are left out, and those of two
    bodies with one joint between them, which overlap in nearly every robot. Everything else is where the scene has
    it now.
    """

    def __init__(
        self, world: PlanningWorld, moved: Collection[int], pairs: Pairs, *, own_model: bool = False
    ) -> None:
        """Prepare the pairs of geoms.

        Args:
            world: the world.
            moved: MuJoCo ids of the bodies that are moved against their parents.
            pairs: entities that must not collide.
            own_model: use a copy of the model, because positions of bodies are written too.
        """
        sim = world.simulation
        instant = world.instants.now()  # first: it may renew the model
        self.model = copy.copy(sim.model) if own_model else sim.model
        self._data = mujoco.MjData(self.model)
        copy_positions(sim.data, self._data)
        self._instants = world.instants
        self.checks = 0
        """Number of calls."""
        chosen: set[tuple[int, int]] = set()
        for first, second in pairs:
            mine, theirs = world.meters.collisions.entities(first, second)
            others = instant.geoms_of(theirs).tolist()
            for one in instant.geoms_of(mine).tolist():
                chosen.update((min(one, other), max(one, other)) for other in others if other != one)
        owners, model = instant.surroundings.owners, sim.model
        parts = _rigid_parts(sim.model, moved)
        kept = [
            (one, other)
            for one, other in sorted(chosen)
            if owners[one] != owners[other]
            and not (model.geom_type[one] == model.geom_type[other] == _PLANE)
            and not _are_neighbours(parts, model, int(model.geom_bodyid[one]), int(model.geom_bodyid[other]))
        ]
        self._first = np.array([one for one, _ in kept], dtype=np.intp)
        self._second = np.array([other for _, other in kept], dtype=np.intp)
        # Planes come second; they are infinite and have the radius 0.
        flipped = model.geom_type[self._first] == _PLANE
        self._first[flipped], self._second[flipped] = self._second[flipped], self._first[flipped]
        self._on_plane: NDArray[np.bool_] = model.geom_type[self._second] == _PLANE
        self._reach = model.geom_rbound[self._first] + model.geom_rbound[self._second]

    def at(self, place: Callable[[mujoco.MjData], None], margin: float = 0.0) -> bool:
        """Return whether nothing collides in a state.

        Args:
            place: writes the state (qpos, mocap poses; body positions in `model`).
            margin: minimum distance in metres.
        """
        self.checks += 1
        if len(self._first) == 0:
            return True
        data = self._data
        place(data)
        kinematics(self.model, data)
        places = data.geom_xpos
        away = places[self._first] - places[self._second]
        normals = data.geom_xmat[self._second, 2::3]
        above: Array = np.einsum("ni,ni->n", away, normals)
        between: Array = np.sqrt(np.einsum("ni,ni->n", away, away))
        distance = np.where(self._on_plane, above, between)
        near = np.flatnonzero(distance <= self._reach + margin)
        if len(near) == 0:
            return True
        instant = self._instants.of(data)
        return not any(
            geoms_meet(instant, int(self._first[index]), int(self._second[index]), margin) for index in near
        )


def of_joints(
    world: PlanningWorld, joints: Joints, pairs: Pairs, margin: float = 0.0
) -> Callable[[Array], bool]:
    """Return the same as a function of joint values (n,)."""
    model = world.simulation.model
    moved = {int(model.jnt_bodyid[model.dof_jntid[dof]]) for dof in joints.dofs}
    validity = Validity(world, moved, pairs)

    def is_valid(values: Array) -> bool:
        def place(data: mujoco.MjData) -> None:
            data.qpos[joints.addresses] = values

        return validity.at(place, margin)

    return is_valid


def _rigid_parts(model: mujoco.MjModel, moved: Collection[int]) -> NDArray[np.intp]:
    """Return for each body (nbody,) the moved body that it is, or is fixed to; 0: it does not move."""
    parts = np.zeros(model.nbody, dtype=np.intp)
    for body in range(1, model.nbody):
        parts[body] = body if body in moved else parts[model.body_parentid[body]]
    return parts


def _are_neighbours(parts: NDArray[np.intp], model: mujoco.MjModel, one: int, other: int) -> bool:
    """Return whether two bodies do not move against each other, or only by one joint between them."""
    first, second = int(parts[one]), int(parts[other])
    if first == second:
        return True
    if _root(model, one) != _root(model, other):
        return False
    above = {int(parts[model.body_parentid[part]]): part for part in (first, second) if part}
    return (second in above and above[second] == first) or (first in above and above[first] == second)


def _root(model: mujoco.MjModel, body: int) -> int:
    return int(model.body_rootid[body])
