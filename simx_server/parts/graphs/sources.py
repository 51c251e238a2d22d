"""Measurements of a graph's stream: a coordinate of an object, a detected point, the length of a distance object."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.formats.texts.graph_streams import DETECTED, DISTANCE, POSITION
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.poses import NO_TURN, compose

if TYPE_CHECKING:
    from simx_server.sensors.distance.meters import Meters
    from simx_server.sensors.proximity.proximity import ProximitySensors
    from simx_server.simulation.simulation import Simulation

Source = Callable[[], float | None]
"""Returns the present value; None when there is none, such as without a detection."""


class Sources:
    """Makes the sources of one simulation's streams."""

    def __init__(self, sim: Simulation, proximity: ProximitySensors, meters: Meters) -> None:
        self._sim = sim
        self._proximity = proximity
        self._meters = meters

    def find(self, measures: str, name: str) -> Source | None:
        """Return the source of a stream; None for one whose values scripts set.

        Args:
            measures: a word of `graph_streams.MEASURES`.
            name: the object, or the distance object; from now on it may be renamed, or removed and restored.
        """
        if measures == DISTANCE:
            return lambda: self._distance(name)
        handle = self._sim.scene.by_name(name)
        if handle is None:
            return None
        if measures in POSITION:
            return lambda: self._position(handle, POSITION.index(measures))
        if measures in DETECTED:
            return lambda: self._detected(handle, DETECTED.index(measures))
        return None

    def _position(self, handle: int, axis: int) -> float | None:
        return get_pose(self._sim, handle)[0][axis] if handle in self._sim.scene.objects else None

    def _detected(self, sensor: int, axis: int) -> float | None:
        """Return a world coordinate of the point that a proximity sensor detects."""
        try:
            detection = self._proximity.read(sensor)
        except CommandError:  # it does not exist any more, or was not handled yet
            return None
        if detection is None:
            return None
        return compose(get_pose(self._sim, sensor), (detection.point, NO_TURN))[0][axis]

    def _distance(self, name: str) -> float | None:
        distances = self._meters.distances
        try:
            return distances.read(distances.find(name))
        except CommandError:  # as above
            return None
