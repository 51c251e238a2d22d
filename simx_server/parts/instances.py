"""Objects of API 2 that programs make beside the scene: paths, worlds of inverse kinematics, objects of own classes.

They end with the script or the client that made them, and with the scene.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, ClassVar, TypeVar

from simx_server.errors import CommandError
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

FIRST_HANDLE = 20_000_000


class Instance:
    """One such object."""

    kind: ClassVar[str] = "object"
    """Its class in API 2."""

    handle: int = -1
    """Set when it is added."""

    owner: Hashable = None
    """The script or client with which it ends; None: it ends with the scene."""

    size: int = 0
    """Bytes of what programs keep with it; set by `Instances.resize`."""

    @property
    def type(self) -> str:
        """Return its property `type`: the class, or the name of a program's own class."""
        return self.kind

    def gone(self) -> None:
        """React to its removal."""


_Instance = TypeVar("_Instance", bound=Instance)


class Instances(Part):
    """All of them, by handle."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._all: dict[int, Instance] = {}
        self._next = FIRST_HANDLE
        self._bytes = 0

    def add(self, instance: _Instance) -> _Instance:
        """Keep an object and give it a handle. Raises LimitReached."""
        self._sim.limits.check(
            "instances", len(self._all) + 1, "remove some paths, IK worlds or custom objects"
        )
        instance.handle, self._next = self._next, self._next + 1
        self._all[instance.handle] = instance
        self._bytes += instance.size
        return instance

    def find(self, handle: int) -> Instance | None:
        """Return an object; None: there is none."""
        return self._all.get(handle)

    def get(self, handle: int, kind: type[_Instance]) -> _Instance:
        """Return an object of a kind. Raises CommandError: there is none."""
        found = self._all.get(handle)
        if not isinstance(found, kind):
            raise CommandError(f"{handle} is the handle of no {kind.kind}, or it was removed")
        return found

    def all(self, kind: type[_Instance]) -> list[_Instance]:
        """Return the objects of a kind."""
        return [each for each in self._all.values() if isinstance(each, kind)]

    def resize(self, instance: Instance, size: int) -> None:
        """Let an object keep this number of bytes. Raises LimitReached: all together would keep too many."""
        wanted = self._bytes + size - instance.size
        if size > instance.size:
            self._sim.limits.check("custom_data", wanted, "remove some custom objects")
        instance.size = size
        if instance.handle in self._all:
            self._bytes = wanted

    def remove(self, handle: int) -> None:
        """Remove an object, if it exists."""
        gone = self._all.pop(handle, None)
        if gone is not None:
            self._bytes -= gone.size
            gone.gone()

    def script_ended(self, owner: Hashable) -> None:
        for handle in [handle for handle, each in self._all.items() if each.owner == owner]:
            self.remove(handle)

    def scene_changed(self) -> None:
        for handle in list(self._all):
            self.remove(handle)
        self._next = FIRST_HANDLE
