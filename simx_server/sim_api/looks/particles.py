"""Particle objects: jets of air and water in V-REP's scenes."""

from __future__ import annotations

import math

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.parts.particles import MOST, ParticleObject
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import no_edit

_FIRST_PARAMETERS = 100
"""Most numbers of parameters."""


class ParticleFunctions(ApiPart, effect="changes"):
    """Functions for particles: spheres that fly on their own."""

    def addParticleObject(
        self,
        kind: int,
        size: float,
        density: float,
        parameters: list[float] | None = None,
        seconds: float = 0.0,
        most: int = 0,
        color: list[float] | None = None,
        _specular: list[float] | None = None,
        _emission: list[float] | None = None,
    ) -> int:
        """Add a particle object and return its handle. `kind`: a sim.particle_* plus flags; `size`: diameter (m);
        `density`: kg/m³; `parameters`: pairs of a number and a value, 5 to 8 drag; `seconds`: lifetime of a particle, 0
        any; `most`: particles. Viewers of the scene display them. Gravity and drag move them.

        Partly: they push nothing and nothing stops them, all of an object have its colour, and images of vision sensors
        do not show them.
        """
        numbers = list(parameters or ())
        if len(numbers) % 2 or len(numbers) > _FIRST_PARAMETERS:
            raise CommandError(f"parameters are pairs of a number and a value, not {len(numbers)} numbers")
        if not all(0 < value < math.inf for value in (size, density)):
            raise CommandError(f"size and density of particles are above 0, not {size:g} and {density:g}")
        red, green, blue = (*(color or ()), 1.0, 1.0, 1.0)[:3]
        particles = ParticleObject(
            kind,
            seconds,
            min(most, MOST) if most > 0 else MOST,
            size,
            density,
            (red, green, blue),
            {int(number): value for number, value in zip(numbers[::2], numbers[1::2], strict=True)},
        )
        handle = self._world.particles.add(particles)
        if particles.is_respondable:
            self._say_once("particles push nothing here: those that push shapes in V-REP fly through them")
        return handle

    @no_edit
    def addParticleObjectItem(self, handle: int, item: list[float] | None = None) -> int:
        """Add a particle: start, a point a second later, and what its kind says; nil removes all. Return 1, or 0 if the
        object is full.

        Partly: as sim.addParticleObject.
        """
        particles = self._world.particles.get(handle)
        if item is None:
            particles.clear()
            return 1
        if not all(map(math.isfinite, item)):
            raise CommandError("the numbers of a particle are finite")
        return int(particles.add(item))

    def removeParticleObject(self, handle: int) -> int:
        """Remove a particle object, or all with sim.handle_all."""
        if handle == c.sim_handle_all:
            self._world.particles.remove_all()
        else:
            self._world.particles.remove(handle)
        return 1
