"""One property: its name and type, and how it is read and set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from simx_server.errors import Unsupported

from .property_types import BOOL, PropertyType

if TYPE_CHECKING:
    from simx_server.world.world import World

Getter = Callable[["World", int], Any]
"""Return the value for the handle of a target. Raises CommandError."""

Setter = Callable[["World", int, Any], object]
"""Set a value, which is of the property's type. Raises CommandError."""


@dataclass(frozen=True, slots=True)
class Property:
    """A property; None where reading or setting is not possible."""

    name: str
    type: PropertyType
    get: Getter | None
    set: Setter | None = None
    is_large: bool = False
    """Whether `sim.getProperties` may leave it out."""


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
    return Property(name, type_ or one.type, one.get, one.set, one.is_large)


def _shown(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
