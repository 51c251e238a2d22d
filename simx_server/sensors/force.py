"""Force sensors: sites with a force and a torque sensor.

Axes are the site's. The sign is V-REP's: what the far side (the child) exerts on the near side, so a weight that hangs
on a sensor whose z points up reads -m g. MuJoCo's sensors give the opposite; V-REP's own MuJoCo engine negates them.
The values are those of the last physics step, not filtered.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..scene.objects import ObjectKind
from ..scene.poses import Vector, scale

if TYPE_CHECKING:
    from ..simulation import Simulation


@dataclass(frozen=True, slots=True)
class ForceReading:
    """Newtons and newton metres in the sensor's axes."""

    force: Vector
    torque: Vector


class ForceSensors:
    """All force sensors of the scene."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    def read(self, handle: int) -> ForceReading | None:
        """What the last pass measured; None before the first pass and while stopped.

        Raises UnknownHandle, WrongKind.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.FORCE_SENSOR)
        if self._sim.pass_count == 0:
            return None
        force, torque = (self._vector(sensor) for sensor in item.sensors)
        return ForceReading(scale(force, -1.0), scale(torque, -1.0))

    def _vector(self, sensor: int) -> list[float]:
        start = int(self._sim.model.sensor_adr[sensor])
        return self._sim.data.sensordata[start : start + 3].tolist()
