"""Proximity and force sensors: a state, then the measured values."""

from __future__ import annotations

import math

import numpy as np

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers import sensors
from simx_server.scene.objects import ObjectKind
from simx_server.sensors.proximity.detection import Detection
from simx_server.sensors.proximity.given import Items
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import no_edit, reads

Detected = tuple[int, float, list[float], int, list[float]]
"""1, distance, point and object, outward normal; point and normal in the sensor's frame."""

_NOTHING = 0
_NOT_HANDLED = -1

_ZERO = (0.0, 0.0, 0.0)

_FRONT, _BACK, _LIMITED_ANGLE = 1, 2, 8
"""Bits of the mode of sim.checkProximitySensorEx. 4, fast detection, is ignored: detection is always exact."""


class SensorFunctions(ApiPart, effect="changes"):
    """Functions for sensors. A detection has five results; no detection has one in Lua scripts, as in V-REP 3, and
    five, `0, 0.0, {0, 0, 0}, -1, {0, 0, 0}`, in Python, in files since CoppeliaSim 4.3 and for clients.
    """

    @reads
    def readProximitySensor(self, sensor: int) -> Detected | int:
        """Return a detection, 0 for none, -1 (with five results 0) before the first handling."""
        handle = self._proximity_sensor(sensor)
        try:
            found = self._world.proximity.read(handle)
        except CommandError:
            return self._without(_NOT_HANDLED)  # the handle is valid, so this is the only reason
        return self._results(found)

    @no_edit
    def handleProximitySensor(self, sensor: int) -> Detected | int:
        """Compute a sensor now; with sim.handle_all or sim.handle_all_except_explicit return the nearest detection of
        all.
        """
        if sensor not in (c.sim_handle_all, c.sim_handle_all_except_explicit):
            return self._results(self._world.proximity.handle(self._proximity_sensor(sensor)))
        found = [self._world.proximity.handle(handle) for handle in self._proximity_sensors(sensor)]
        return self._results(min(filter(None, found), key=lambda each: math.hypot(*each.point), default=None))

    @no_edit
    def resetProximitySensor(self, sensor: int) -> int:
        """Delete the detection until the next handling; also for sim.handle_all and sim.handle_all_except_explicit."""
        if sensor in (c.sim_handle_all, c.sim_handle_all_except_explicit):
            for handle in self._proximity_sensors(sensor):
                self._world.proximity.reset(handle)
        else:
            self._world.proximity.reset(self._proximity_sensor(sensor))
        return 1

    @reads
    def checkProximitySensor(self, sensor: int, entity: int) -> Detected | int:
        """Return whether the sensor detects an object, a collection or sim.handle_all now; the result of handling is
        kept. Both faces at any angle count, whatever the sensor's own limits are.

        The object and the normal are results of CoppeliaSim 4 only.
        """
        return self.checkProximitySensorEx(sensor, entity, _FRONT | _BACK, math.inf, 0.0)

    @reads
    def checkProximitySensorEx(
        self, sensor: int, entity: int, mode: int, threshold: float, max_angle: float
    ) -> Detected | int:
        """Check a sensor with a mode: 1 front faces, 2 back faces, 8 angle of the normal below `max_angle` (rad).

        `threshold`: greatest distance in metres. A mode without faces means front faces.
        """
        if not self._world.proximity.enabled:
            return self._without(_NOTHING)
        found = self._world.proximity.check(
            self._proximity_sensor(sensor),
            self._self(entity),
            farthest=max(0.0, threshold),
            faces=_faces(mode),
            least_cosine=_least_cosine(mode, max_angle),
        )
        return self._results(found)

    @reads
    def checkProximitySensorEx2(
        self,
        sensor: int,
        vertices: list[float],
        kind: int,
        count: int,
        mode: int,
        threshold: float,
        max_angle: float,
    ) -> tuple[int, float, list[float], list[float]] | int:
        """Check a sensor against points (`kind` 0), segments (1) or triangles (2) in the world, metres; return 1,
        distance, point and normal in the sensor's frame, or 0.

        `mode`, `threshold` and `max_angle`: as in sim.checkProximitySensorEx; the faces and the angle are those of
        triangles. A ray detects triangles only.
        """
        if kind not in tuple(Items):
            raise CommandError(f"items are 0 points, 1 segments or 2 triangles, not {kind}")
        needed = 3 * (kind + 1) * max(0, count)
        if len(vertices) < needed:
            raise CommandError(
                f"{count} {Items(kind).name.lower()} have {needed} coordinates, not {len(vertices)}"
            )
        nothing = (_NOTHING, 0.0, [*_ZERO], [*_ZERO]) if self._script.full_results else _NOTHING
        if not self._world.proximity.enabled:
            return nothing
        found = self._world.proximity.check_given(
            self._proximity_sensor(sensor),
            np.array(vertices[:needed], np.float64).reshape(-1, kind + 1, 3),
            farthest=max(0.0, threshold),
            faces=_faces(mode),
            least_cosine=_least_cosine(mode, max_angle),
        )
        if found is None:
            return nothing
        return 1, math.hypot(*found.point), list(found.point), list(found.normal)

    @reads
    def readForceSensor(self, sensor: int) -> tuple[int, list[float], list[float]]:
        """Return the state (bit 0: values available, bit 1: broken), force (N) and torque (N m); zeros where V-REP
        returned no values.
        """
        return sensors.read_force_sensor(self._world, self._self(sensor))

    def breakForceSensor(self, sensor: int) -> int:
        """Break the connection that the sensor holds until the stop."""
        sensors.break_force_sensor(self._world, self._self(sensor))
        return 1

    @reads
    def getExplicitHandling(self, sensor: int) -> int:
        """Return 1 when scripts must handle a sensor, an IK group or a graph themselves; else 0."""
        handle = self._self(sensor)
        if handle in self._world.graphs.handles():
            return int(self._world.graphs.get(handle).is_explicit)
        if handle in self._world.ik_groups:
            return int(self._world.ik_groups.get(handle).explicit)
        if self._sim.scene.get(handle).kind == ObjectKind.VISION_SENSOR:
            return int(self._world.vision.settings(handle).explicit)
        return int(self._world.proximity.is_explicit(handle))

    def setExplicitHandling(self, sensor: int, flags: int) -> int:
        """Set with bit 0 that scripts must handle a proximity or vision sensor, an IK group or a graph themselves."""
        handle, explicit = self._self(sensor), bool(flags & 1)
        if handle in self._world.graphs.handles():
            self._world.graphs.get(handle).is_explicit = explicit
        elif handle in self._world.ik_groups:
            self._world.ik_groups.get(handle).explicit = explicit
        elif self._sim.scene.get(handle).kind == ObjectKind.VISION_SENSOR:
            self._world.vision.set_explicit(handle, explicit)
        else:
            self._world.proximity.set_explicit(handle, explicit)
        return 1

    def _results(self, found: Detection | None) -> Detected | int:
        if found is None:
            return self._without(_NOTHING)
        return 1, math.hypot(*found.point), list(found.point), found.handle, list(found.normal)

    def _without(self, result: int) -> Detected | int:
        """Return the results where nothing is detected: `result` is that of V-REP 3."""
        return (_NOTHING, 0.0, [*_ZERO], -1, [*_ZERO]) if self._script.full_results else result

    def _proximity_sensor(self, sensor: int) -> int:
        return self._sim.scene.get_kind(self._self(sensor), ObjectKind.PROXIMITY_SENSOR).handle

    def _proximity_sensors(self, which: int) -> list[int]:
        handles = self._sim.scene.of_kind(ObjectKind.PROXIMITY_SENSOR)
        everything = which == c.sim_handle_all
        return [handle for handle in handles if everything or not self._world.proximity.is_explicit(handle)]


def _faces(mode: int) -> str:
    """Return which sides of surfaces a mode of sim.checkProximitySensorEx sees."""
    return {_BACK: "back", _FRONT | _BACK: "both"}.get(mode & (_FRONT | _BACK), "front")


def _least_cosine(mode: int, max_angle: float) -> float:
    """Return the least cosine of the angle between the line of sight and a normal."""
    limited = mode & _LIMITED_ANGLE and max_angle < math.pi / 2
    return math.cos(max(0.0, max_angle)) if limited else 0.0
