"""Proximity, vision and force sensors: 1 or 0, then what a client gets."""

from __future__ import annotations

from ...handlers import sensors
from .base import ApiPart


class SensorFunctions(ApiPart):
    """Reading, and handling at once."""

    def readProximitySensor(self, sensor: int) -> tuple[int, float, list[float], int, list[float]]:
        detected, point, handle, normal = sensors.read_proximity_sensor(self._sim, self._self(sensor))
        return int(detected), sum(value * value for value in point) ** 0.5, point, handle, normal

    def handleProximitySensor(self, sensor: int) -> tuple[int, float, list[float], int, list[float]]:
        """Compute an explicitly handled sensor now."""
        self._sim.proximity.handle(self._self(sensor))
        return self.readProximitySensor(sensor)

    def handleVisionSensor(self, sensor: int) -> None:
        """Make an explicitly handled sensor's picture now; its statistics are not known yet and not returned."""
        self._sim.vision.handle(self._self(sensor))

    def readForceSensor(self, sensor: int) -> tuple[int, list[float], list[float]]:
        return sensors.read_force_sensor(self._sim, self._self(sensor))

    def breakForceSensor(self, sensor: int) -> None:
        sensors.break_force_sensor(self._sim, self._self(sensor))
