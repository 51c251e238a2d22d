"""Proximity and force sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from simx_client.calls.strict import misspelt
from simx_client.protocol import constants as c

from .objects import Object
from .poses import as_array

if TYPE_CHECKING:
    from .poses import Array

_HAS_VALUES, _IS_BROKEN = 1, 2


class Detection(NamedTuple):
    """Detection of a proximity sensor in the last simulation step."""

    point: Array
    """Nearest point, in metres in the sensor's frame."""

    normal: Array
    """Unit normal of the surface at that point, in the sensor's frame."""

    object: Object
    """Detected object."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            raise misspelt(self, name)

    @property
    def distance(self) -> float:
        """Return the distance from the sensor's origin in metres."""
        return float((self.point**2).sum() ** 0.5)


class ProximitySensor(Object):
    """A sensor that finds the nearest point of a surface."""

    __slots__ = ()
    object_type = c.sim_object_proximitysensor_type

    def read(self) -> Detection | None:
        """Return the detection, None without one.

        Raises:
            RemoteError: the sensor was not handled yet: before the first simulation step of a run, or with
                explicit handling.
        """
        is_detecting, point, handle, normal = self._request(
            lambda calls: calls.simxReadProximitySensor(self.handle)
        )
        if not is_detecting:
            return None
        return Detection(as_array(point), as_array(normal), Object(self._scene, handle))


class Wrench(NamedTuple):
    """Force and torque on a force sensor, in its frame."""

    force: Array
    """Force in N."""

    torque: Array
    """Torque in N m."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            raise misspelt(self, name)


class ForceSensor(Object):
    """A sensor for force and torque between two connected parts."""

    __slots__ = ()
    object_type = c.sim_object_forcesensor_type

    def read(self) -> Wrench | None:
        """Return force and torque, None without values, as while stopped."""
        state, force, torque = self._request(lambda calls: calls.simxReadForceSensor(self.handle))
        return Wrench(as_array(force), as_array(torque)) if state & _HAS_VALUES else None

    @property
    def is_broken(self) -> bool:
        """Return whether the sensor's connection has broken."""
        return bool(self._request(lambda calls: calls.simxReadForceSensor(self.handle))[0] & _IS_BROKEN)

    def break_apart(self) -> None:
        """Break the sensor's connection until the simulation stops."""
        self._send(lambda calls: calls.simxBreakForceSensor(self.handle))
