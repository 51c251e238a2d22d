"""Whether joints may be somewhere: which geoms must not meet, and quick checks of that on a scratch state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..errors import CommandError
from ..sensors.measuring import geoms_meet
from .chain import Joints
from .scratch import Array, Scratch

if TYPE_CHECKING:
    from ..simulation import Simulation

Pairs = list[tuple[int, int]]
"""Entities (objects, collections, or sim.handle_all as second) that must not meet."""

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)


def as_pairs(entities: Sequence[int] | None) -> Pairs:
    """Of a flat list {first, second, first, second, ...}. Raises CommandError for an odd count."""
    listed = list(entities or [])
    if len(listed) % 2:
        raise CommandError("collision pairs are entities two by two: {first, second, first, second, ...}")
    return list(zip(listed[::2], listed[1::2], strict=True))


class Validity:
    """Called with joint values (n,): True when nothing of the pairs meets there. One model's lifetime.

    Left out are geoms that the joints do not move against each other (a robot's foot on the floor), and those of bodies
    that a joint connects, which overlap in nearly every robot. Everything else stands where the scene has it now.
    """

    def __init__(self, sim: Simulation, joints: Joints, pairs: Pairs) -> None:
        self._sim = sim
        self._joints = joints
        self._scratch = Scratch(sim)
        self._scratch.load()
        self._instants = sim.instants
        self.checks = 0
        """How often it was called."""
        instant = sim.instants.now()
        chosen: set[tuple[int, int]] = set()
        for first, second in pairs:
            mine, theirs = sim.meters.collisions.entities(first, second)
            others = instant.geoms_of(theirs).tolist()
            for one in instant.geoms_of(mine).tolist():
                chosen.update((min(one, other), max(one, other)) for other in others if other != one)
        owners, model = instant.surroundings.owners, sim.model
        parts = _rigid_parts(sim, joints)
        kept = [
            (one, other)
            for one, other in sorted(chosen)
            if owners[one] != owners[other]
            and not (model.geom_type[one] == model.geom_type[other] == _PLANE)
            and not _are_neighbours(parts, model, int(model.geom_bodyid[one]), int(model.geom_bodyid[other]))
        ]
        self._first = np.array([one for one, _ in kept], dtype=np.intp)
        self._second = np.array([other for _, other in kept], dtype=np.intp)
        # Planes stand second; they are everywhere and have the radius 0.
        flipped = model.geom_type[self._first] == _PLANE
        self._first[flipped], self._second[flipped] = self._second[flipped], self._first[flipped]
        self._on_plane = model.geom_type[self._second] == _PLANE
        self._reach = model.geom_rbound[self._first] + model.geom_rbound[self._second]

    def __call__(self, values: Array) -> bool:
        self.checks += 1
        if len(self._first) == 0:
            return True
        data = self._scratch.place(self._joints.addresses, values)
        places = data.geom_xpos
        away = places[self._first] - places[self._second]
        normals = data.geom_xmat[self._second, 2::3]
        distance = np.where(
            self._on_plane, np.einsum("ni,ni->n", away, normals), np.sqrt(np.einsum("ni,ni->n", away, away))
        )
        near = np.flatnonzero(distance <= self._reach)
        if len(near) == 0:
            return True
        instant = self._instants.of(data)
        return not any(
            geoms_meet(instant, int(self._first[index]), int(self._second[index])) for index in near
        )


def _rigid_parts(sim: Simulation, joints: Joints) -> NDArray[np.intp]:
    """(nbody,) for each body the one below a moved joint that it is fixed to; 0: no joint moves it."""
    model = sim.model
    moved = {int(model.jnt_bodyid[model.dof_jntid[dof]]) for dof in joints.dofs}
    parts = np.zeros(model.nbody, dtype=np.intp)
    for body in range(1, model.nbody):
        parts[body] = body if body in moved else parts[model.body_parentid[body]]
    return parts


def _are_neighbours(parts: NDArray[np.intp], model: mujoco.MjModel, one: int, other: int) -> bool:
    """Whether two bodies do not move against each other, or only by one joint between them."""
    first, second = int(parts[one]), int(parts[other])
    if first == second:
        return True
    if _root(model, one) != _root(model, other):
        return False
    above = {int(parts[model.body_parentid[part]]): part for part in (first, second) if part}
    return (second in above and above[second] == first) or (first in above and above[first] == second)


def _root(model: mujoco.MjModel, body: int) -> int:
    return int(model.body_rootid[body])
