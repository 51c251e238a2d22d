"""One numbered quantity: its constant, and how it is read and set."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.constant_tables import number_of
from simx_server.errors import Unsupported

if TYPE_CHECKING:
    from simx_server.world.world import World

Getter = Callable[["World", int], Any]
"""Return the value for the handle of an object, -1 for the engine. Raises CommandError."""

Setter = Callable[["World", int, Any], object]
"""Set a value. Raises CommandError."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """One quantity; None where reading or setting is not possible."""

    number: int
    name: str
    """Constant without ``sim_``, such as ``shapefloatparam_mass``."""
    is_integer: bool
    """As in V-REP, integers and floats have separate functions."""
    get: Getter | None
    set: Setter | None = None


def quantity(name: str, get: Getter | None, put: Setter | None = None) -> Quantity:
    """Return the quantity of a constant, whose name says whether it is an integer."""
    return Quantity(number_of(name), name, "intparam" in name, get, put)


def only(name: str, value: float, why: str) -> Quantity:
    """Return a quantity with one fixed value; setting another value is an error."""

    def put(_world: World, _handle: int, wanted: float) -> None:
        if wanted != value:
            raise Unsupported(f"{why}; it stays {value:g}")

    return quantity(name, lambda _world, _handle: value, put)


def kept(name: str, first: float) -> Quantity:
    """Return a quantity without effect: each object keeps what was set."""
    number = number_of(name)

    def get(world: World, handle: int) -> float:
        return world.object_settings.kept(handle, number, first)

    def put(world: World, handle: int, value: float) -> None:
        world.scripts.told_once.tell(f"{name} ({number}) has no effect here; objects only keep its value")
        world.object_settings.keep(handle, number, value)

    return quantity(name, get, put)


def of_simulator(
    kind: str,
    name: str | int,
    get: Callable[[World], Any] | None,
    put: Callable[[World, Any], object] | None = None,
) -> Quantity:
    """Return the quantity of the simulator that has a constant, or a number without a name.

    Args:
        kind: bool, int, float, string or array.
        name: of the constant after its kind, such as ``headless`` of ``sim_boolparam_headless``; or the number.
        get: returns the value.
        put: sets the value.
    """
    constant = f"{kind}param_{name}"
    return Quantity(
        name if isinstance(name, int) else number_of(constant),
        constant,
        kind == "int",
        get and (lambda world, _handle: get(world)),
        put and (lambda world, _handle, value: put(world, value)),
    )
