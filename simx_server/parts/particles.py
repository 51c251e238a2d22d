"""Particle objects of V-REP, such as the jets of a propeller: kept and counted, but neither drawn nor moved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

_BASE, _KINDS = 6, 5
"""Numbers of each particle: start and a second point, whose difference is the velocity; kinds of particles."""

_SIZES, _DENSITIES, _COLORS = 0x0400, 0x0800, 0x1000
_RESPONDABLE = 0x0020 | 0x0040 | 0x0080
_FIRST_HANDLE = 1


@dataclass(frozen=True)
class ParticleObject:
    """One particle object."""

    kind: int
    """A sim.particle_* with its flags."""
    seconds: float
    """Lifetime of a particle; 0: unlimited."""
    most: int

    @property
    def numbers(self) -> int:
        """Return how many numbers a particle has."""
        extra = {_SIZES: 1, _DENSITIES: 1, _COLORS: 3}
        return _BASE + sum(count for bit, count in extra.items() if self.kind & bit)

    @property
    def is_respondable(self) -> bool:
        """Return whether V-REP's particles of this kind push shapes or each other."""
        return bool(self.kind & _RESPONDABLE)


class Particles(Part):
    """All particle objects of the run; its end removes them."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._known: dict[int, ParticleObject] = {}
        self._next = _FIRST_HANDLE

    def run_stopped(self) -> None:
        self._known.clear()

    def scene_changed(self) -> None:
        self._known.clear()

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
