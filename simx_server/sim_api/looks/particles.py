"""Particle objects: jets of air and water in V-REP's scenes."""

from __future__ import annotations

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.parts.particles import ParticleObject
from simx_server.sim_api.base import ApiPart


class ParticleFunctions(ApiPart):
    """Functions for particles, which the physics engine here does not have."""

    def addParticleObject(
        self,
        kind: int,
        _size: float,
        _density: float,
        _parameters: list[float] | None = None,
        seconds: float = 0.0,
        most: int = 0,
        _ambient: list[float] | None = None,
        _specular: list[float] | None = None,
        _emission: list[float] | None = None,
    ) -> int:
        """Add a particle object and return its handle. Stand-in: its particles are neither drawn nor moved, and push
        nothing.
        """
        particles = ParticleObject(kind, seconds, most)
        handle = self._world.particles.add(particles)
        self._say_once(
            "particles of a script are not simulated: those that push shapes in V-REP do not push here"
            if particles.is_respondable
            else "particles of a script are not shown: in V-REP they are decoration"
        )
        return handle

    def addParticleObjectItem(self, handle: int, item: list[float] | None = None) -> int:
        """Add a particle: start, a point a second later, and what its kind says; nil removes all. Stand-in: as
        sim.addParticleObject.
        """
        wanted = self._world.particles.get(handle).numbers
        if item is not None and len(item) < wanted:
            raise CommandError(f"a particle of this kind has {wanted} numbers, not {len(item)}")
        return 1

    def removeParticleObject(self, handle: int) -> int:
        """Remove a particle object, or all with sim.handle_all."""
        if handle == c.sim_handle_all:
            self._world.particles.remove_all()
        else:
            self._world.particles.remove(handle)
        return 1
