"""The objects of a scene as a sequence that also takes names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TypeVar, overload

from simx_client.calls.strict import Strict
from simx_client.errors import Failure, NoSuchObject
from simx_client.protocol import constants as c
from simx_client.protocol.nearest import did_you_mean

from .objects import SceneObject

S = TypeVar("S", bound=SceneObject, covariant=True)

_SHOWN = 8
"""Number of objects in a repr."""


class Objects(Strict, Sequence[S]):
    """Objects in the scene's order, as they were when they were listed.

    ``objects[0]`` and ``objects["UR5_joint1"]`` return one object, ``"UR5" in objects`` whether it is listed.
    """

    __slots__ = ("_by_name", "_objects", "_where")

    def __init__(self, objects: Sequence[S], where: str) -> None:
        self._objects = tuple(objects)
        self._by_name = {each.name: each for each in reversed(self._objects)}
        self._where = where

    def __len__(self) -> int:
        return len(self._objects)

    @overload
    def __getitem__(self, index: int | str) -> S: ...
    @overload
    def __getitem__(self, index: slice) -> Objects[S]: ...
    def __getitem__(self, index: int | str | slice) -> S | Objects[S]:
        """Return an object by index or name. Raises IndexError, or NoSuchObject with the nearest name."""
        if isinstance(index, slice):
            return Objects(self._objects[index], self._where)
        if not isinstance(index, str):
            return self._objects[index]
        if (found := self._by_name.get(index)) is None:
            reason = f"no object named {index!r}{did_you_mean(index, self._by_name)}"
            code = c.simx_return_remote_error_flag
            raise NoSuchObject([Failure(0, self._where, f"objects[{index!r}]", code, reason)])
        return found

    def __contains__(self, item: object) -> bool:
        return item in self._by_name if isinstance(item, str) else item in self._objects

    def __iter__(self) -> Iterator[S]:
        return iter(self._objects)

    @property
    def names(self) -> list[str]:
        """Return the names, in this order."""
        return [each.name for each in self._objects]

    def __repr__(self) -> str:
        kinds = Counter(each.kind for each in self._objects)
        counted = ", ".join(f"{count} × {kind}" for kind, count in kinds.items()) or "none"
        names = ", ".join(map(str, self._objects[:_SHOWN]))
        return f"<Objects at {self._where}: {counted}: {names}{', …' if len(self) > _SHOWN else ''}>"
