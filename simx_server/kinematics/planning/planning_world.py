"""The parts of the world that a search for a path reads. The world has the searches: its type would close a circle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from simx_server.kinematics.groups import IkGroups
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
    def ik_groups(self) -> IkGroups: ...
    @property
    def paths(self) -> Paths: ...
    @property
    def collections(self) -> Collections: ...
