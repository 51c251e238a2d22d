"""Properties that programs make: ``customData.NAME``, ``signal.NAME``, ``refs.NAME`` and ``namedParam.NAME``.

Custom data of type buffer are the blocks of sim.writeCustomDataBlock. The scene's signals of the types int, float,
string and buffer are those of sim.setInt32Signal and its like, which clients see too; others are known to scripts
only.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol

from simx_server.errors import CommandError
from simx_server.parts.custom_data import APPLICATION, HIDDEN, NAMED, REFERENCES, SCENE

from .property_types import (
    BUFFER,
    BY_TAG,
    FLOAT,
    HANDLE_ARRAY,
    INT,
    INT_ARRAY,
    STRING,
    TYPES,
    PropertyType,
)

if TYPE_CHECKING:
    from simx_server.world.world import World

Found = tuple[PropertyType, Any]
"""Type and value."""


class Store(Protocol):
    """One kind of properties that programs make."""

    prefix: str
    targets: str
    """The targets that have them, in words."""

    def has_target(self, target: int) -> bool:
        """Return whether a target has such properties."""
        ...

    def get(self, world: World, target: int, name: str, wanted: PropertyType | None) -> Found | None:
        """Return type and value, of several with this name the one of the wanted type; None: there is none."""
        ...

    def set(
        self, world: World, target: int, name: str, kind: PropertyType, value: Any, owner: Hashable
    ) -> None:
        """Create or replace a property. `owner`: the script, whose signals are cleared when it ends."""
        ...

    def remove(self, world: World, target: int, name: str) -> bool:
        """Remove a property; return whether there was one."""
        ...

    def names(self, world: World, target: int) -> list[str]:
        """Return the names of all properties of a target, without the prefix."""
        ...


def _check_name(prefix: str, name: str) -> None:
    if not name or name.startswith(HIDDEN):
        raise CommandError(f"'{prefix}' needs a name after the dot, such as '{prefix}myData'")


class _CustomData:
    prefix = "customData."
    targets = "every target"

    def has_target(self, target: int) -> bool:
        return True

    def get(self, world: World, target: int, name: str, wanted: PropertyType | None) -> Found | None:
        found = world.custom_data.read_typed(target, name)
        if found is None:
            return None
        kind = BY_TAG.get(found[0], BUFFER)  # files may hold data of later types
        return kind, kind.decode(found[1])

    def set(
        self, world: World, target: int, name: str, kind: PropertyType, value: Any, owner: Hashable
    ) -> None:
        _check_name(self.prefix, name)
        world.custom_data.write_typed(target, name, kind.tag, kind.encode(value))

    def remove(self, world: World, target: int, name: str) -> bool:
        return world.custom_data.erase(target, name)

    def names(self, world: World, target: int) -> list[str]:
        return world.custom_data.typed_names(target)


class _Signals:
    prefix = "signal."
    targets = "every target"

    def has_target(self, target: int) -> bool:
        return True

    def get(self, world: World, target: int, name: str, wanted: PropertyType | None) -> Found | None:
        candidates = [*self._of_scene(world, name)] if target == SCENE else []
        if (typed := world.signals.typed.get(target, name)) is not None:
            kind = TYPES[typed[0]]
            candidates.append((kind, kind.decode(typed[1])))
        fitting = [each for each in candidates if wanted is not None and each[0].family == wanted.family]
        return next(iter([*fitting, *candidates]), None)

    @staticmethod
    def _of_scene(world: World, name: str) -> list[Found]:
        signals = world.signals
        tables: list[tuple[PropertyType, Mapping[str, Any]]] = [
            (INT, signals.integers),
            (FLOAT, signals.floats),
            (BUFFER, signals.strings),
        ]
        return [(kind, values[name]) for kind, values in tables if name in values]

    def set(
        self, world: World, target: int, name: str, kind: PropertyType, value: Any, owner: Hashable
    ) -> None:
        _check_name(self.prefix, name)
        signals = world.signals
        if target != SCENE or kind not in (INT, FLOAT, STRING, BUFFER):
            signals.typed.set(target, name, kind.name, kind.encode(value), owner)
        elif kind is INT:
            signals.set_integer(name, value, owner)
        elif kind is FLOAT:
            signals.set_float(name, value, owner)
        else:
            signals.set_string(name, kind.encode(value), owner)

    def remove(self, world: World, target: int, name: str) -> bool:
        signals, found = world.signals, False
        if target == SCENE and name:
            found = any(name in table for table in (signals.integers, signals.floats, signals.strings))
            signals.clear_integer(name)
            signals.clear_float(name)
            signals.clear_string(name)
        return signals.typed.clear(target, name) or found

    def names(self, world: World, target: int) -> list[str]:
        signals = world.signals
        of_scene = [*signals.integers, *signals.floats, *signals.strings] if target == SCENE else []
        return list(dict.fromkeys([*of_scene, *signals.typed.names(target)]))


class _References:
    prefix = "refs."
    targets = "every object"

    def has_target(self, target: int) -> bool:
        return target >= 0

    def get(self, world: World, target: int, name: str, wanted: PropertyType | None) -> Found | None:
        packed = world.custom_data.read(target, f"{REFERENCES}{name}")
        if packed is None:
            return None
        objects = world.simulation.scene.objects
        return HANDLE_ARRAY, [each if each in objects else -1 for each in INT_ARRAY.decode(packed)]

    def set(
        self, world: World, target: int, name: str, kind: PropertyType, value: Any, owner: Hashable
    ) -> None:
        if kind.family != HANDLE_ARRAY.family:
            raise CommandError(f"'{self.prefix}{name}' is a table of handles: use sim.setHandleArrayProperty")
        world.custom_data.write(target, f"{REFERENCES}{name}", INT_ARRAY.encode(value))

    def remove(self, world: World, target: int, name: str) -> bool:
        return world.custom_data.erase(target, f"{REFERENCES}{name}")

    def names(self, world: World, target: int) -> list[str]:
        known = world.custom_data.names(target)
        return [each.removeprefix(REFERENCES) for each in known if each.startswith(REFERENCES)]


class _NamedParameters:
    prefix = "namedParam."
    targets = "the server (sim.handle_app)"

    def has_target(self, target: int) -> bool:
        return target == APPLICATION

    def get(self, world: World, target: int, name: str, wanted: PropertyType | None) -> Found | None:
        found = world.custom_data.read(APPLICATION, f"{NAMED}{name}")
        return None if found is None else (STRING, STRING.decode(found))

    def set(
        self, world: World, target: int, name: str, kind: PropertyType, value: Any, owner: Hashable
    ) -> None:
        _check_name(self.prefix, name)
        if kind.family != STRING.family:
            raise CommandError("a named parameter is a string: use sim.setStringProperty")
        world.custom_data.write(APPLICATION, f"{NAMED}{name}", kind.encode(value))

    def remove(self, world: World, target: int, name: str) -> bool:
        return world.custom_data.erase(APPLICATION, f"{NAMED}{name}")

    def names(self, world: World, target: int) -> list[str]:
        known = world.custom_data.names(APPLICATION)
        return [each.removeprefix(NAMED) for each in known if each.startswith(NAMED)]


STORES: Mapping[str, Store] = MappingProxyType(
    {each.prefix: each for each in (_CustomData(), _Signals(), _References(), _NamedParameters())}
)
"""All kinds by prefix."""


def store_of(name: str) -> Store | None:
    """Return the store of a property's name; None for a property of the table."""
    start, dot, _ = name.partition(".")
    return STORES.get(start + dot)
