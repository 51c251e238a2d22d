"""Particle objects of V-REP, such as jets of air and water: drawn, and moved by gravity and drag.

Each particle is a sphere that flies on its own: it pushes nothing, and nothing stops it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

_BASE, _KINDS = 6, 5
"""Numbers of each particle: start and a second point, whose difference is the velocity; kinds of particles."""

_RESPONDABLE = (
    c.sim_particle_respondable1to4 | c.sim_particle_respondable5to8 | c.sim_particle_particlerespondable
)
_FIRST_HANDLE = 1

MOST = 10_000
"""Most particles of an object; an object for any number of them has as many."""

_LINEAR, _QUADRATIC, _LINEAR_IN_AIR, _QUADRATIC_IN_AIR = 5, 6, 7, 8
"""Numbers of parameters: drag forces in N per m/s, and per (m/s)²."""

_LEAST_MASS = 1e-9
"""kg"""

Array = NDArray[np.float64]


@dataclass(eq=False)
class ParticleObject:
    """One particle object and its particles."""

    kind: int
    """A sim.particle_* with its flags."""
    seconds: float
    """Lifetime of a particle; 0: unlimited."""
    most: int
    size: float = 0.01
    """Diameter in metres."""
    density: float = 1000.0
    """kg/m³"""
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    parameters: dict[int, float] = field(default_factory=dict[int, float])
    places: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(n, 3), metres in the world."""
    velocities: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(n, 3), m/s."""
    ages: Array = field(default_factory=lambda: np.zeros(0))
    """(n,), seconds."""
    masses: Array = field(default_factory=lambda: np.zeros(0))
    """(n,), kg."""
    sizes: Array = field(default_factory=lambda: np.zeros(0))
    """(n,), diameters in metres."""

    @property
    def numbers(self) -> int:
        """Return how many numbers a particle has."""
        extra = {
            c.sim_particle_itemsizes: 1,
            c.sim_particle_itemdensities: 1,
            c.sim_particle_itemcolors: 3,
        }
        return _BASE + sum(count for bit, count in extra.items() if self.kind & bit)

    @property
    def is_respondable(self) -> bool:
        """Return whether V-REP's particles of this kind push shapes or each other."""
        return bool(self.kind & _RESPONDABLE)

    @property
    def is_visible(self) -> bool:
        return not self.kind & c.sim_particle_invisible

    def add(self, item: Sequence[float]) -> bool:
        """Add a particle; return False if the object is full. Raises CommandError: too few numbers."""
        if len(item) < self.numbers:
            raise CommandError(f"a particle of this kind has {self.numbers} numbers, not {len(item)}")
        if len(self.ages) >= self.most:
            if not self.kind & c.sim_particle_cyclic:
                return False
            self._keep(np.arange(len(self.ages)) > 0)  # the oldest one makes room
        extra = iter(item[_BASE:])
        size = next(extra) if self.kind & c.sim_particle_itemsizes else self.size
        density = next(extra) if self.kind & c.sim_particle_itemdensities else self.density
        start = np.array(item[:3], float)
        self.places = np.vstack([self.places, start])
        self.velocities = np.vstack([self.velocities, np.array(item[3:6], float) - start])
        self.ages = np.append(self.ages, 0.0)
        self.sizes = np.append(self.sizes, size)
        self.masses = np.append(self.masses, max(_LEAST_MASS, density * math.pi / 6 * size**3))
        return True

    def clear(self) -> None:
        """Remove all particles."""
        self._keep(np.zeros(len(self.ages), np.bool_))

    def move(self, seconds: float, gravity: Array) -> None:
        """Let the particles fly on."""
        if not len(self.ages):
            return
        is_water, falls = (
            bool(self.kind & c.sim_particle_water),
            not self.kind & c.sim_particle_ignoresgravity,
        )
        in_water = self.places[:, 2] < 0 if is_water else np.ones(len(self.ages), np.bool_)
        if falls:
            self.velocities[~in_water if is_water else slice(None)] += (
                gravity * seconds
            )  # water carries its own
        speed = np.linalg.norm(self.velocities, axis=1)
        linear = np.where(in_water, self._parameter(_LINEAR), self._parameter(_LINEAR_IN_AIR))
        quadratic = np.where(in_water, self._parameter(_QUADRATIC), self._parameter(_QUADRATIC_IN_AIR))
        # Implicit, so that a strong drag stops a particle and does not turn it round.
        self.velocities /= (1.0 + seconds * (linear + quadratic * speed) / self.masses)[:, None]
        self.places = self.places + self.velocities * seconds
        self.ages = self.ages + seconds
        if self.seconds > 0:
            self._keep(self.ages < self.seconds - 1e-9)

    def _parameter(self, number: int) -> float:
        return max(0.0, self.parameters.get(number, 0.0))

    def _keep(self, chosen: NDArray[np.bool_]) -> None:
        self.places, self.velocities = self.places[chosen], self.velocities[chosen]
        self.ages, self.masses, self.sizes = self.ages[chosen], self.masses[chosen], self.sizes[chosen]


class Particles(Part):
    """All particle objects of the run; its end removes them."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._known: dict[int, ParticleObject] = {}
        self._next = _FIRST_HANDLE

    def run_stopped(self) -> None:
        self.remove_all()

    def scene_changed(self) -> None:
        self.remove_all()

    @property
    def has_work(self) -> bool:
        """Return whether there are particle objects."""
        return bool(self._known)

    def move(self) -> None:
        """Let all particles fly for the time of a simulation step, in its physics steps."""
        model = self._sim.model
        step, gravity = float(model.opt.timestep), np.array(model.opt.gravity)
        for each in self._known.values():
            for _ in range(self._sim.substeps):
                each.move(step, gravity)

    def shown(self, most: int) -> list[tuple[int, ParticleObject]]:
        """Return the visible objects with particles by handle, with at most `most` particles in total."""
        found: list[tuple[int, ParticleObject]] = []
        for handle, each in self._known.items():
            if each.is_visible and len(each.ages) and (most := most - len(each.ages)) >= 0:
                found.append((handle, each))
        return found

    def add(self, particles: ParticleObject) -> int:
        """Add a particle object and return its handle. Raises CommandError, LimitReached."""
        if particles.kind & 0x1F >= _KINDS:
            raise CommandError(
                f"{particles.kind & 0x1F} is no kind of particles; those are 0 to {_KINDS - 1}, see sim.particle_*"
            )
        self._sim.limits.check("drawings", len(self._known) + 1, "remove some")
        handle = self._next
        self._next += 1
        self._known[handle] = particles
        self._sim.parts.replan()
        return handle

    def get(self, handle: int) -> ParticleObject:
        """Return a particle object. Raises CommandError."""
        found = self._known.get(handle)
        if found is None:
            raise CommandError(f"no particle object with handle {handle}; they end with the run")
        return found

    def remove(self, handle: int) -> None:
        """Remove a particle object. Raises CommandError."""
        self.get(handle)
        del self._known[handle]

    def remove_all(self) -> None:
        """Remove all particle objects."""
        self._known.clear()
