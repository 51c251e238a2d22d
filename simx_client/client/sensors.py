"""Proximity and force sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from simx_client.connection.strict import misspelt
from simx_client.protocol import constants as c

from .objects import Object
from .poses import as_array

if TYPE_CHECKING:
    from .poses import Array

_HAS_VALUES, _IS_BROKEN = 1, 2


class Detection(NamedTuple):
    """What a proximity sensor sees, as of the last pass."""

    point: Array
    """The nearest one, metres in the sensor's frame."""

    normal: Array
    """Of the surface there, of unit length, in the sensor's frame."""

    object: Object
    """Whose surface it is."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            raise misspelt(self, name)

    @property
    def distance(self) -> float:
        """Metres from the sensor's origin."""
        return float((self.point**2).sum() ** 0.5)


class ProximitySensor(Object):
    """A sensor that finds the nearest point of a surface."""

    __slots__ = ()
    object_type = c.sim_object_proximitysensor_type

    def read(self) -> Detection | None:
        """What it sees; None when there is nothing.

        Raises:
            RemoteError: it was not handled yet, in the first pass of a run or for an explicitly handled one.
        """
        is_detecting, point, handle, normal = self._ask(
            lambda calls: calls.simxReadProximitySensor(self.handle)
        )
        if not is_detecting:
            return None
        return Detection(as_array(point), as_array(normal), Object(self._scene, handle))


class Wrench(NamedTuple):
    """What a force sensor feels, in its frame."""

    force: Array
    """N."""

    torque: Array
    """N m."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            raise misspelt(self, name)


class ForceSensor(Object):
    """A sensor of what one part exerts on another."""

    __slots__ = ()
    object_type = c.sim_object_forcesensor_type

    def read(self) -> Wrench | None:
        """What it feels; None when there are no values, as while stopped."""
        state, force, torque = self._ask(lambda calls: calls.simxReadForceSensor(self.handle))
        return Wrench(as_array(force), as_array(torque)) if state & _HAS_VALUES else None

    @property
    def is_broken(self) -> bool:
        """Whether what it held together has come apart."""
        return bool(self._ask(lambda calls: calls.simxReadForceSensor(self.handle))[0] & _IS_BROKEN)

    def break_apart(self) -> None:
        """Let what it holds come apart until the simulation stops."""
        self._tell(lambda calls: calls.simxBreakForceSensor(self.handle))
