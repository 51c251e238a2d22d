"""Hold all that programs open and know by a handle: consoles, dialogs, windows. A handle is never used twice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar, Generic, Protocol, TypeVar

from simx_server.errors import CommandError
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation


class Opened(Protocol):
    """One of them. `Registry.add` sets ``handle``."""

    handle: int
    title: str


T = TypeVar("T", bound=Opened)


class Registry(Part, Generic[T]):
    """All of one kind. Physics thread only."""

    KIND: ClassVar[str]
    """Name of the kind in errors."""
    LIMIT: ClassVar[str]
    """Name of the server's limit of their number."""
    WAY_OUT: ClassVar[str]
    """How a program makes room for others, as an imperative."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._opened: dict[int, T] = {}
        self._next_handle = 1

    def __iter__(self) -> Iterator[T]:
        return iter(tuple(self._opened.values()))

    def __len__(self) -> int:
        return len(self._opened)

    def __contains__(self, handle: object) -> bool:
        return handle in self._opened

    def add(self, *new: T) -> list[int]:
        """Add some, all or none, and return their handles. Raises CommandError: there would be too many."""
        self.check_room(len(new))
        for each in new:
            self._prepare(each)
            each.handle, self._next_handle = self._next_handle, self._next_handle + 1
            self._opened[each.handle] = each
        return [each.handle for each in new]

    def check_room(self, count: int) -> None:
        """Check that `count` more can be added. Raises CommandError."""
        self._sim.limits.check(self.LIMIT, len(self._opened) + count, self.WAY_OUT)

    def _prepare(self, new: T) -> None:
        """Complete one before it is added."""

    def _is_alive(self, opened: T) -> bool:
        """Return whether programs may still use one that was not removed."""
        return True

    def get(self, handle: int) -> T:
        """Return one of them. Raises CommandError that lists the existing ones."""
        found = self._opened.get(handle)
        if found is None or not self._is_alive(found):
            raise CommandError(f"no {self.KIND} with handle {handle}; there are: {self.listed()}")
        return found

    def remove(self, handle: int) -> None:
        """Remove one of them. Raises CommandError as `get`."""
        del self._opened[self.get(handle).handle]

    def listed(self) -> str:
        """Return their handles and titles for errors."""
        return ", ".join(f"{each.handle} ('{each.title}')" for each in self) or "none"
