"""Find, read, set, list and remove properties: one place for their rules and error texts."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError, Unsupported
from simx_server.parts.custom_data import APPLICATION, SCENE
from simx_server.scripting.conversion.signature import describe

from . import missing
from .entry import Property
from .named import STORES, Store, store_of
from .property_types import BUFFER, FLOAT, INT, LONG, TABLE, PropertyType, type_of
from .table import is_common, kinds_with, of_kind, of_target
from .tables.objects import kind_word

if TYPE_CHECKING:
    from simx_server.world.world import World

_MOST_COMPARED, _MOST_LISTED = 200, 100
"""Names that a message suggests from, and that it lists; a program may make thousands."""

NOT_WRITABLE, NOT_READABLE, REMOVABLE, LARGE = 1, 2, 4, 0x100
"""sim.propertyinfo_*."""


@dataclass(frozen=True, slots=True)
class Target:
    """An object, the scene or the server, as the target of one call."""

    world: World
    handle: int
    owner: Hashable
    """Key of the calling script, whose signals are cleared when it ends."""

    @property
    def table(self) -> Mapping[str, Property]:
        """Return its properties of the table. Raises UnknownHandle."""
        if self.handle in (SCENE, APPLICATION):
            return of_target(self.handle)
        return of_kind(self.world.simulation.scene.get(self.handle).kind)

    def lacks(self, name: str) -> CommandError:
        """Return why it has no property of a name, with the names that it has."""
        if elsewhere := kinds_with(name):
            return CommandError(f"{self} has no property '{name}'; that is one of {', '.join(elsewhere)}")
        if (why := missing.reason(name)) is not None:
            return Unsupported(f"CoppeliaSim's property '{name}' is not available here: {why}")
        return CommandError(f"{self} has no property '{name}'; {some_of([*self.table, *STORES], name)}")

    def __str__(self) -> str:
        if self.handle == SCENE:
            return "the scene"
        if self.handle == APPLICATION:
            return "the server"
        item = self.world.simulation.scene.get(self.handle)
        return f"'{item.name}' ({item.kind.text})"


def read(target: Target, name: str, wanted: PropertyType | None) -> Any:
    """Return the value of a property.

    Args:
        target: what has it.
        name: its name.
        wanted: the type of the function that reads it; None: any.

    Raises:
        CommandError: no such property, of another type, or it can only be set.
    """
    table = target.table
    store = store_of(name)
    if store is not None:
        _check_target(target, store)
        key = name.removeprefix(store.prefix)
        found = store.get(target.world, target.handle, key, wanted)
        if found is None:
            raise _not_made(target, store, key)
        _check_type(target, name, found[0], wanted, "get")
        return _as_wanted(*found, wanted)
    entry = _find(target, table, name)
    _check_type(target, name, entry.type, wanted, "get")
    if entry.get is None:
        raise CommandError(f"property '{name}' of {target} can only be set")
    return _as_wanted(entry.type, entry.get(target.world, target.handle), wanted)


def write(target: Target, name: str, value: Any, kind: PropertyType | None) -> None:
    """Set a property.

    Args:
        target: what has it.
        name: its name.
        value: the script's value.
        kind: the type of the function that sets it; None: that of the property, or else of the value.

    Raises:
        CommandError: no such property, of another type, or it can only be read; an invalid value.
    """
    table = target.table
    store = store_of(name)
    if store is None:
        entry = _find(target, table, name)
        _check_type(target, name, entry.type, kind, "set")
        if entry.set is None:
            raise CommandError(f"property '{name}' of {target} can only be read")
        entry.set(target.world, target.handle, _converted(name, value, entry.type))
        return
    _check_target(target, store)
    key = name.removeprefix(store.prefix)
    if kind is None:
        present = store.get(target.world, target.handle, key, None)
        kind = _fitting(name, value, None if present is None else present[0])
    store.set(target.world, target.handle, key, kind, _converted(name, value, kind), target.owner)


def remove(target: Target, name: str) -> None:
    """Remove a property that a program has made.

    Raises:
        CommandError: no such property, or it belongs to the target.
    """
    table = target.table
    store = store_of(name)
    if store is None:
        _find(target, table, name)
        raise CommandError(
            f"property '{name}' of {target} cannot be removed; those that can start with {', '.join(STORES)}"
        )
    _check_target(target, store)
    key = name.removeprefix(store.prefix)
    if not store.remove(target.world, target.handle, key):
        raise _not_made(target, store, key)


def information(target: Target, name: str) -> tuple[int, int] | None:
    """Return type (`sim.propertytype_*`) and flags (`sim.propertyinfo_*`) of a property; None: there is none.

    Raises:
        UnknownHandle: the target does not exist.
    """
    table = target.table
    if name in table:
        entry = table[name]
        flags = LARGE if entry.is_large else 0
        flags |= 0 if entry.set is not None else NOT_WRITABLE
        return entry.type.number, flags | (0 if entry.get is not None else NOT_READABLE)
    store = store_of(name)
    if store is None or not store.has_target(target.handle):
        return None
    found = store.get(target.world, target.handle, name.removeprefix(store.prefix), None)
    return None if found is None else (found[0].number, REMOVABLE)


def names(target: Target) -> list[str]:
    """Return the names of all properties: those of the table, then those that programs made.

    Raises:
        UnknownHandle: the target does not exist.
    """
    found = list(target.table)
    for prefix, store in STORES.items():
        if store.has_target(target.handle):
            found += [prefix + each for each in store.names(target.world, target.handle)]
    return found


def group(target: Target, name: str) -> str:
    """Return what a property belongs to: app, scene, object, or a kind of object such as shape."""
    if target.handle in (SCENE, APPLICATION):
        return "scene" if target.handle == SCENE else "app"
    kind = target.world.simulation.scene.get(target.handle).kind
    return kind_word(kind) if name in of_kind(kind) and not is_common(name) else "object"


def _find(target: Target, table: Mapping[str, Property], name: str) -> Property:
    """Return a property of the table. Raises CommandError."""
    if name in table:
        return table[name]
    raise target.lacks(name)


def _not_made(target: Target, store: Store, key: str) -> CommandError:
    listed = store.names(target.world, target.handle)
    return CommandError(
        f"{target} has no property '{store.prefix}{key}' now; {some_of(listed, key)} ({store.prefix}...)"
    )


def some_of(listed: list[str], name: str) -> str:
    """Return the end of a message: similar names, or all of them."""
    if similar := did_you_mean(name, listed[:_MOST_COMPARED]):
        return similar.removeprefix("; ")
    more = f" and {len(listed) - _MOST_LISTED} more" if len(listed) > _MOST_LISTED else ""
    return f"it has {', '.join(sorted(listed)[:_MOST_LISTED]) or 'none'}{more}"


def _check_target(target: Target, store: Store) -> None:
    if not store.has_target(target.handle):
        raise CommandError(f"{target} has no properties '{store.prefix}...'; {store.targets} has")


def _check_type(
    target: Target, name: str, kind: PropertyType, wanted: PropertyType | None, verb: str
) -> None:
    if wanted is not None and wanted.family != kind.family:
        raise CommandError(
            f"property '{name}' of {target} is of type {kind.name.lower()}, not {wanted.name.lower()}; "
            f"use sim.{verb}{kind.name}Property"
        )


def _converted(name: str, value: Any, kind: PropertyType) -> Any:
    try:
        return kind.convert(value)
    except TypeError as problem:
        raise CommandError(f"the value of '{name}' must be {problem}, got {describe(value)}") from None


def _as_wanted(kind: PropertyType, value: Any, wanted: PropertyType | None) -> Any:
    """Return a value as another type of the same family holds it."""
    if wanted is None or wanted is kind:
        return value
    try:
        return wanted.convert(value)
    except TypeError as problem:
        raise CommandError(
            f"the property is of type {kind.name.lower()}, and its value is not {problem}; use "
            f"sim.get{kind.name}Property"
        ) from None


def _fitting(name: str, value: Any, present: PropertyType | None) -> PropertyType:
    """Return the type for a value that is set without one: the present one if it fits, else that of the value."""
    try:
        own = type_of(value)
    except TypeError as problem:
        raise CommandError(f"the value of '{name}' must be {problem}, got {describe(value)}") from None
    if present is None or own in (LONG, BUFFER):
        return own
    if own.family == present.family:
        return present
    may_hold = (present is FLOAT and own.family == INT.family) or own is TABLE
    try:
        if may_hold:
            present.convert(value)
    except TypeError:
        return own
    return present if may_hold else own
