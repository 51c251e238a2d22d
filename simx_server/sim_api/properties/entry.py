"""One property: its name and type, and how it is read and set."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError, Unsupported
from simx_server.handlers.quantities.engine import ENGINE
from simx_server.handlers.quantities.objects import OBJECTS
from simx_server.handlers.quantities.quantity import Getter, Quantity, Setter
from simx_server.handlers.quantities.simulator import SIMULATOR
from simx_server.parts.object_settings import DrawnSize

from .property_types import BOOL, FLOAT, INT, PropertyType

if TYPE_CHECKING:
    from simx_server.world.world import World


@dataclass(frozen=True, slots=True)
class Property:
    """A property; None where reading or setting is not possible."""

    name: str
    type: PropertyType
    get: Getter | None
    set: Setter | None = None
    is_large: bool = False
    """Whether `sim.getProperties` may leave it out."""
    waits: bool = False
    """Whether reading it waits for an image."""


_QUANTITIES: Mapping[str, Quantity] = {
    **OBJECTS,
    **SIMULATOR,
    **{each.name: each for each in ENGINE.values()},
}


def numbered(
    name: str, type_: PropertyType, *constants: str, can_be_set: bool = True, inverted: bool = False
) -> Property:
    """Return the property that is a numbered quantity, or several of them as a table.

    Args:
        name: of the property.
        type_: of the property.
        constants: of the quantities, without ``sim.``.
        can_be_set: as a property; otherwise only its number sets it.
        inverted: whether the property is true where the quantity is 0.
    """
    quantities = [_QUANTITIES[constant] for constant in constants]
    is_table = len(quantities) > 1

    def get(world: World, handle: int) -> Any:
        values = [each.get(world, handle) for each in quantities if each.get is not None]
        if is_table:
            return values
        value = int(values[0]) if type_.family == INT.family else values[0]
        return bool(value) != inverted if type_ is BOOL else value

    def put(world: World, handle: int, value: Any) -> None:
        values = value if is_table else [value != inverted if type_ is BOOL else value]
        if len(values) != len(quantities):
            raise CommandError(f"'{name}' has {len(quantities)} numbers, not {len(values)}")
        for each, number in zip(quantities, values, strict=True):
            assert each.set is not None
            each.set(world, handle, number)

    is_settable = can_be_set and all(each.set is not None for each in quantities)
    return Property(name, type_, get, put if is_settable else None)


def fixed(name: str, type_: PropertyType, value: Any, why: str) -> Property:
    """Return a property with one value; setting another one is refused with this reason."""

    def put(_world: World, _handle: int, wanted: Any) -> None:
        if wanted != value:
            raise Unsupported(f"'{name}' stays {_shown(value)}: {why}")

    return Property(name, type_, lambda _world, _handle: value, put)


def bit_of(flags: Property, name: str, bit: int, *, inverted: bool = False) -> Property:
    """Return the switch for one bit of a property of flags.

    Args:
        flags: the property that has all bits.
        name: of the switch.
        bit: the bit.
        inverted: whether the switch is on while the bit is 0.
    """
    get, put = flags.get, flags.set
    assert get is not None
    assert put is not None

    def is_on(world: World, handle: int) -> bool:
        return bool(get(world, handle) & bit) != inverted

    def switch(world: World, handle: int, on: bool) -> None:
        present = get(world, handle)
        put(world, handle, present | bit if on != inverted else present & ~bit)

    return Property(name, BOOL, is_on, switch)


def renamed(one: Property, name: str, type_: PropertyType | None = None) -> Property:
    """Return the same property under another name, and perhaps with another type of the same family."""
    return Property(name, type_ or one.type, one.get, one.set, one.is_large, one.waits)


def _shown(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def drawn_size(name: str, size: DrawnSize, first: float) -> Property:
    """Return a size (m) with which V-REP's window draws an object; it is kept, and scaled with the object."""

    def put(world: World, handle: int, value: float) -> None:
        if not 0 < value < math.inf:
            raise CommandError(f"'{name}' is a length in metres above 0, not {value:g}")
        world.object_settings.keep(handle, size, value)

    return Property(name, FLOAT, lambda world, handle: world.object_settings.kept(handle, size, first), put)
