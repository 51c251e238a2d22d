"""Names, aliases and paths of objects, and V-REP 3's numbers of copies."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from simx_server.errors import CommandError
from simx_server.scene.editing import renaming
from simx_server.scene.naming import paths
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_MODELS_ABOVE: Mapping[int, int | None] = MappingProxyType({6: 0, 7: 1, 8: 2, 9: None})
"""How many models above the object a form of sim.getObjectAlias names; None: all."""


class ObjectNameFunctions(ApiPart, effect="changes"):
    """Functions for names. Old names are unique (``name``, ``name#0``); aliases may repeat."""

    _name_suffix: int | None = None
    """Suffix of names that the script has set; None: the suffix of its object's name."""

    @reads
    def getObjectName(self, handle: int) -> str:
        return self._sim.scene.get(self._self(handle)).name

    def setObjectName(self, handle: int, name: str) -> int:
        """Set the old name, and the alias to the same without its number. The stop resets names set during a run."""
        renaming.rename(self._sim, self._self(handle), name)
        return 1

    @reads
    def getObjectAlias(self, handle: int, options: int = -1) -> str:
        """Return the alias in the form that `options` selects: -1 the alias; 0 with its index where siblings have the
        same one; 1 the shortest path that means this object; 2 the full path; 3 ``alias__handle__`` where it is not
        unique, 4 always; 5 a short path for people; 6 to 9 a path with a number in
        braces in each part, which starts at the object itself, or at the first, second or outermost model above it.
        """
        scene, handle = self._sim.scene, self._self(handle)
        alias = scene.get(handle).alias
        match options:
            case -1:
                return alias
            case 0:
                return paths.path_of(scene, handle).rsplit("/", 1)[1]
            case 1:
                return self._short_path(handle)
            case 2:
                return paths.path_of(scene, handle)
            case 3 | 4:
                alone = sum(item.alias == alias for item in scene.objects.values()) == 1
                return alias if alone and options == 3 else f"{alias}__{handle}__"
            case 5:
                parts = paths.path_of(scene, handle).split("/")[1:]
                return "/" + ("/".join(parts) if len(parts) < 3 else f"{parts[0]}/ ... /{parts[-1]}")
            case 6 | 7 | 8 | 9:
                return paths.indexed_path(scene, handle, _MODELS_ABOVE[options])
            case _:
                raise CommandError(f"the form of an alias is -1 to 9, not {options}")

    def setObjectAlias(self, handle: int, alias: str) -> None:
        """Set the alias; the old name stays. A change during a run is reset at the stop."""
        renaming.set_alias(self._sim, self._self(handle), alias)

    @reads
    def getNameSuffix(self, name: str | None = None) -> tuple[int, str] | int:
        """Return the number after # (-1: none) and the name without it; without a name, the script's number."""
        if name is None:
            if self._name_suffix is not None:
                return self._name_suffix
            item = self._sim.scene.objects.get(self._owner)
            return _split(item.name)[0] if item is not None else -1
        return _split(name)

    def setNameSuffix(self, suffix: int) -> int:
        """Set the number that this script's names without # end in; -1: none."""
        self._name_suffix = max(suffix, -1)
        return 1

    def _adjusted(self, name: str) -> str:
        if self._name_suffix is None or "#" in name or name.startswith(("/", ".", ":")):
            return super()._adjusted(name)
        plain, at, rest = name.partition("@")
        return name if self._name_suffix == -1 else f"{plain}#{self._name_suffix}{at}{rest}"

    def _short_path(self, handle: int) -> str:
        parts = paths.path_of(self._sim.scene, handle).split("/")[1:]
        for count in range(1, len(parts)):
            path = "/" + "/".join(parts[-count:])
            if self._sim.scene.resolve(path) == handle:
                return path
        return "/" + "/".join(parts)


def _split(name: str) -> tuple[int, str]:
    plain, mark, digits = name.rpartition("#")
    if mark and digits.isdigit():
        return int(digits), plain
    return -1, plain if mark and not digits else name
