"""Proximity and force sensors, and the statistics of vision sensors."""

from __future__ import annotations

from concurrent.futures import Future
from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.world.world import World

NOTHING = -1
"""Handle returned when nothing is detected; in V-REP it was undefined."""

_HAS_VALUES = 1
_BROKEN = 2


@handler("simxReadProximitySensor")
def read_proximity_sensor(world: World, sensor: int) -> tuple[bool, list[float], int, list[float]]:
    """Return state, point, object and normal; zeros when nothing is detected.

    Differs: a sensor does not detect the shape that carries it, unless its annotation has `carrier=yes`, as sensors
    of V-REP's own files have.
    """
    detection = world.proximity.read(sensor)
    if detection is None:
        return False, [0.0] * 3, NOTHING, [0.0] * 3
    return True, list(detection.point), detection.handle, list(detection.normal)


@handler("simxReadForceSensor")
def read_force_sensor(world: World, sensor: int) -> tuple[int, list[float], list[float]]:
    """Return zeros when no data are available, as when stopped."""
    reading = world.force.read(sensor)
    broken = _BROKEN if world.force.is_broken(sensor) else 0
    if reading is None:
        return broken, [0.0] * 3, [0.0] * 3
    return _HAS_VALUES | broken, list(reading.force), list(reading.torque)


@handler("simxBreakForceSensor")
def break_force_sensor(world: World, sensor: int) -> None:
    """Separate the objects that the sensor holds until the simulation stops.

    Raises:
        CommandError: the simulation is stopped.
    """
    world.force.break_apart(sensor)


@handler("simxReadVisionSensor", with_client=True)
def read_vision_sensor(
    world: World, client: ClientSession, sensor: int
) -> Future[tuple[bool, list[list[float]]]]:
    """Return whether the sensor detects, and packets: 15 statistics of the image, then those of the sensor's script."""
    return world.vision.read(sensor, asker=client.client)
