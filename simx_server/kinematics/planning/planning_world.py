"""The parts of the world that a search for a path reads. The world has the searches: its type would close a circle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import ENTITY_PREFIX

if TYPE_CHECKING:
    from simx_server.kinematics.groups import IkGroups
    from simx_server.kinematics.searching import Searching
    from simx_server.parts.paths.paths import Paths
    from simx_server.scene.collection import Collections
    from simx_server.sensors.distance.meters import Meters
    from simx_server.sensors.instant import Instants
    from simx_server.simulation.simulation import Simulation


class PlanningWorld(Protocol):
    """The parts that a search reads."""

    @property
    def simulation(self) -> Simulation: ...
    @property
    def instants(self) -> Instants: ...
    @property
    def meters(self) -> Meters: ...
    @property
    def searching(self) -> Searching: ...
    @property
    def ik_groups(self) -> IkGroups: ...
    @property
    def paths(self) -> Paths: ...
    @property
    def collections(self) -> Collections: ...


def entity(world: PlanningWorld, name: str) -> int:
    """Return the handle of an object or a collection that a task names. Raises CommandError."""
    found = world.simulation.scene.by_name(name)
    if found is None:
        found = world.collections.find(name.removeprefix(ENTITY_PREFIX))
    if found is None:
        raise CommandError(f"the task names '{name}', which is no object or collection any more")
    return found
