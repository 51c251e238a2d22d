"""An object of API 2 as the target of property functions, which are those of API 1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from simx_client.protocol.api2.objects import GROUP, METHOD
from simx_server.errors import CommandError
from simx_server.sim_api.properties import access
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.access import Target
from simx_server.sim_api.properties.entry import Property
from simx_server.sim_api.properties.named import STORES, store_of
from simx_server.sim_api.properties.property_types import PropertyType

from .classes import class_of, script_at
from .enumerations import word_of
from .instances.custom import CustomObject, method_at
from .tables.custom import own_properties
from .tables.detached_scripts import detached_script
from .tables.table import groups_of, of_class, with_object
from .types import COLOR, MATRIX, EnumType, presented, type_of
from .values import plain, to_matrix

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_SIGNALS = "signal."

_NOT_HASHED, _CONSTANT = 8, 64
"""sim.propertyinfo_*."""


@dataclass(frozen=True, slots=True)
class ModelTarget(Target):
    """An object, as the target of one call of API 2."""

    caller: Script

    @staticmethod
    def of(world: World, handle: int, caller: Script) -> ModelTarget:
        """Return an object as a target. Raises CommandError: there is none."""
        class_of(world, handle, caller)
        return ModelTarget(world, handle, caller.signal_owner, caller)

    @property
    def kind(self) -> str:
        """Return its class. Raises CommandError: it was removed."""
        return class_of(self.world, self.handle, self.caller)

    @property
    def table(self) -> Mapping[str, Property]:
        kind = self.kind
        if (own := self.custom) is not None:
            return with_object(kind, own_properties(own))
        if kind != "detachedScript":
            return of_class(kind)
        script = script_at(self.world, self.handle, self.caller)
        assert script is not None
        return with_object(kind, detached_script(script))

    @property
    def custom(self) -> CustomObject | None:
        """Return it as an object of a program's own class, or as such a class; None: it is none."""
        found = self.world.instances.find(self.handle)
        return found if isinstance(found, CustomObject) else None

    def lacks(self, name: str) -> CommandError:
        known = [*self.table, *STORES]
        return CommandError(f"property is unknown: {self} has no '{name}'; {access.some_of(known, name)}")

    def __str__(self) -> str:
        item = self.world.simulation.scene.objects.get(self.handle)
        return f"'{item.name}' ({self.kind})" if item else f"the {self.kind}"


def read(target: ModelTarget, name: str, wanted: PropertyType | None) -> Any:
    """Return the value of a property as API 2 has it. Raises CommandError; see `access.read`."""
    entry = target.table.get(name)
    if entry is not None and isinstance(entry.type, EnumType) and wanted is not None:
        as_it_is = wanted.family == "text" or isinstance(wanted, EnumType)
        number = access.read(target, name, None if as_it_is else wanted)
        return word_of(entry.type.enumeration, number) if wanted.family == "text" else number
    if wanted is COLOR and _kind_now(target, name) is t.COLOR:
        wanted = None
    kind = _kind_now(target, name) if wanted is None else wanted
    value = access.read(target, name, t.STRING if kind is t.STRING else wanted)
    return presented(kind, value) if kind is not None else value


def write(target: ModelTarget, name: str, value: Any, kind: PropertyType | None) -> None:
    """Set a property to a value of API 2. Raises CommandError; see `access.write`."""
    entry = target.table.get(name)
    if entry is None and (own := target.custom) is not None and own.may_define(name):
        own.put(target.world, name, *_typed(name, value, kind))
        return
    if entry is None and store_of(name) is not None:
        _write_made(target, name, value, kind)
        return
    if entry is not None and isinstance(entry.type, EnumType):
        kind = None  # a name or a number
    taken = entry.type if entry is not None else kind
    access.write(target, name, value if taken in (COLOR, MATRIX) else plain(value), kind)


def _typed(name: str, value: Any, kind: PropertyType | None) -> tuple[PropertyType, Any]:
    """Return the type of a new property of a program's own class, and its value. Raises CommandError."""
    try:
        chosen = type_of(value) if kind is None else kind
        return chosen, chosen.convert(value if chosen in (COLOR, MATRIX) else plain(value))
    except TypeError as problem:
        raise CommandError(f"the value of '{name}' must be {problem}") from None


def remove(target: ModelTarget, name: str) -> None:
    """Remove a property that a program has made. Raises CommandError; see `access.remove`."""
    own = target.custom
    if own is not None and own.may_define(name):
        own.drop(target.world, name)
        return
    access.remove(target, name)


def _write_made(target: ModelTarget, name: str, value: Any, kind: PropertyType | None) -> None:
    """Set a property that programs make."""
    try:
        kind = type_of(value) if kind is None else kind
        if kind is COLOR:
            value, kind = COLOR.convert(value).parts, t.COLOR
        elif kind in (MATRIX, t.MATRIX):
            value, kind = to_matrix(value).in_rows(), t.MATRIX
    except TypeError as problem:
        raise CommandError(f"the value of '{name}' must be {problem}") from None
    access.write(target, name, plain(value), kind)


def _kind_now(target: ModelTarget, name: str) -> PropertyType | None:
    """Return the type of a property; None: there is none."""
    entry = target.table.get(name)
    if entry is not None:
        return entry.type
    store = store_of(name)
    if store is None or not store.has_target(target.handle):
        return None
    found = store.get(target.world, target.handle, name.removeprefix(store.prefix), None)
    if found is None:
        return None
    kind, value = found
    is_text = kind is t.BUFFER and store.prefix == _SIGNALS and t.type_of(value) is t.STRING
    return t.STRING if is_text else kind  # API 1 does not tell them apart in the scene's signals


def information(
    target: ModelTarget, name: str, methods: Mapping[str, object], groups: frozenset[str] = frozenset()
) -> tuple[int, int] | None:
    """Return type and flags of a property, a method or a group; None: there is none of this name.

    Args:
        target: the object.
        name: the name.
        methods: those of its class.
        groups: of these methods.
    """
    if name in methods:
        return METHOD, access.NOT_WRITABLE | _NOT_HASHED | _CONSTANT
    if method_at(target.world, target.handle, name) is not None:
        return METHOD, access.NOT_WRITABLE | access.REMOVABLE  # clients do not keep this for other objects
    if name in groups_of(target.kind) or name in groups or name in _own_groups(target):
        return GROUP, access.NOT_WRITABLE | access.NOT_READABLE | _NOT_HASHED | _CONSTANT
    kind = _kind_now(target, name)
    found = access.information(target, name)
    if found is None or kind is None:
        return None
    own = target.custom
    removable = access.REMOVABLE if own is not None and name in own.values else 0
    return (COLOR.number if kind is t.COLOR else kind.number), found[1] | removable


def _own_groups(target: ModelTarget) -> set[str]:
    """Return the starts of the names of properties that programs gave to an object of their class."""
    own = target.custom
    return (
        set()
        if own is None
        else {*own.spaces, *(name.partition(".")[0] for name in own.values if "." in name)}
    )
