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
from simx_server.kinematics.scratch import Array, Snapshot
from simx_server.sensors.distance.meeting import GeomPairs, Indices
from simx_server.simulation.sleepers import kinematics

if TYPE_CHECKING:
    from simx_server.sensors.instant import Instant

    from .planning_world import PlanningWorld

Pairs = list[tuple[int, int]]
"""Entities (objects, collections, or sim.handle_all as second) that must not collide."""

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
        self._positions = Snapshot(sim.data)
        self._trials = world.ik_groups.trials
        self._own_data: mujoco.MjData | None = None
        if own_model:
            self._own_data = mujoco.MjData(self.model)
            self._positions.write(self._own_data)
        self._instants = world.instants
        self.checks = 0
        """Number of calls."""
        parts = _rigid_parts(sim.model, moved)
        first, second = _of_geoms(world, instant, pairs)
        kept = ~_are_neighbours(parts, sim.model, first, second)
        self._pairs = GeomPairs(instant, first[kept], second[kept])

    def at(self, place: Callable[[mujoco.MjData], None], margin: float = 0.0) -> bool:
        """Return whether nothing collides in a state.

        Args:
            place: writes the state (qpos, mocap poses; body positions in `model`).
            margin: minimum distance in metres.
        """
        self.checks += 1
        if not len(self._pairs):
            return True
        data = self._own_data
        if data is None:
            data = self._trials.of(self, self.model, self._positions)
        place(data)
        kinematics(self.model, data)
        return not self._pairs.meet(self._instants.of(data), margin)


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


def _rigid_parts(model: mujoco.MjModel, moved: Collection[int]) -> Indices:
    """Return for each body (nbody,) the moved body that it is, or is fixed to; 0: it does not move."""
    parts: list[int] = []
    above: int
    for body, above in enumerate(model.body_parentid.tolist()):
        parts.append(body if body in moved else parts[above] if body else 0)
    return np.array(parts, dtype=np.intp)


def _of_geoms(world: PlanningWorld, instant: Instant, pairs: Pairs) -> tuple[Indices, Indices]:
    """Return the pairs of geoms (n,) and (n,) of pairs of entities, each once and in the order of their ids.

    Raises UnknownHandle, CommandError: an entity cannot be measured.
    """
    count = instant.model.ngeom
    found = np.zeros(0, dtype=np.intp)
    for first, second in pairs:
        some = [instant.geoms_of(each) for each in world.meters.collisions.entities(first, second)]
        mine, theirs = (each.ravel() for each in np.meshgrid(*some, indexing="ij"))
        found = np.union1d(found, np.minimum(mine, theirs) * count + np.maximum(mine, theirs))
    first, second = found // max(count, 1), found % max(count, 1)
    owners = instant.surroundings.owners
    differ = owners[first] != owners[second]
    return first[differ], second[differ]


def _are_neighbours(
    parts: Indices, model: mujoco.MjModel, first: Indices, second: Indices
) -> NDArray[np.bool_]:
    """Return (n,) whether the bodies of geoms (n,) move against each other by one joint between them, or not at all."""
    bodies, others = model.geom_bodyid[first], model.geom_bodyid[second]
    mine, theirs = parts[bodies], parts[others]
    above = parts[model.body_parentid]
    joined = ((mine != 0) & (above[mine] == theirs)) | ((theirs != 0) & (above[theirs] == mine))
    return (mine == theirs) | (joined & (model.body_rootid[bodies] == model.body_rootid[others]))
