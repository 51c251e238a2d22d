"""Quantities of the physics engine: MuJoCo's own as CoppeliaSim numbers them, and the friction of the others.

A shape's numbers are those of all its geoms. Those of other engines without a counterpart in MuJoCo are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.formats.loader import ITERATIONS, MOST_ITERATIONS
from simx_server.scene.objects import ObjectKind

from .quantity import Getter, Quantity, Setter

if TYPE_CHECKING:
    from simx_server.world.world import World


def find(number: int, *, is_integer: bool) -> Quantity:
    """Return a quantity. Raises CommandError that lists all."""
    found = ENGINE.get(number)
    if found is None or found.is_integer != is_integer:
        kind = "integer" if is_integer else "float"
        known = ", ".join(f"{n} {each.name}" for n, each in ENGINE.items() if each.is_integer == is_integer)
        raise CommandError(
            f"the engine, MuJoCo, has no {kind} parameter {number}; it has {known}; what else there is of friction, "
            "contacts and damping is said in the scene's MJCF"
        )
    return found


def _geoms(world: World, handle: int) -> list[int]:
    world.simulation.scene.get_kind(handle, ObjectKind.SHAPE)
    owned = world.instants.now(with_points=False).surroundings.owned_by([handle])
    return np.flatnonzero(owned).tolist()


def _of_geoms(array: str, index: int | None) -> tuple[Getter, Setter]:
    """Return getter and setter for an array of the model's geoms, or for one column of it."""

    def get(world: World, handle: int) -> float:
        geom = _geoms(world, handle)[0]
        values = getattr(world.simulation.model, array)
        return float(values[geom] if index is None else values[geom, index])

    def put(world: World, handle: int, value: float) -> None:
        if array == "geom_friction" and value < 0:
            raise CommandError(f"a friction must not be below 0, it is {value}")
        if array == "geom_condim" and value not in (1, 3, 4, 6):
            raise CommandError(f"a contact has 1, 3, 4 or 6 dimensions, not {value:g}")
        sim = world.simulation
        values: Any = getattr(sim.model, array)
        for geom in _geoms(world, handle):
            values[geom if index is None else (geom, index)] = value
        sim.model_edited()
        sim.changed()

    return get, put


def _option(name: str, option: str, index: int | None, *, is_integer: bool) -> tuple[Getter, Setter]:
    """Return getter and setter for an option of the whole engine; its handle has no effect."""

    def get(world: World, _handle: int) -> float:
        value = getattr(world.simulation.model.opt, option)
        return float(value if index is None else value[index])

    def put(world: World, _handle: int, value: float) -> None:
        if value < 0 and option != "wind":
            raise CommandError(f"{name} must not be below 0, it is {value}")
        if option in ITERATIONS and value > MOST_ITERATIONS:
            raise CommandError(f"{name} must not be above {MOST_ITERATIONS}, it is {value:.0f}")
        options = world.simulation.model.opt
        if index is None:
            setattr(options, option, int(value) if is_integer else value)
        else:
            getattr(options, option)[index] = value
        world.simulation.changed()

    return get, put


def _quantity(number: int, name: str, field: str) -> Quantity:
    """Return the quantity for an array of geoms or an option, such as ``geom_solref[1]``."""
    array, _, column = field.rstrip("]").partition("[")
    index = int(column) if column else None
    is_integer = array in _INTEGERS
    if array.startswith("geom_"):
        return Quantity(number, name, is_integer, *_of_geoms(array, index))
    get, put = _option(name, array, index, is_integer=is_integer)
    return Quantity(number, name, is_integer, get, None if array == "timestep" else put)


_INTEGERS = ("iterations", "geom_condim", "geom_priority")

_FIELDS = {
    # All frictions of other engines are MuJoCo's sliding friction.
    6002: ("bullet_body_oldfriction", "geom_friction[0]"),
    6003: ("bullet_body_friction", "geom_friction[0]"),
    15001: ("ode_body_friction", "geom_friction[0]"),
    24001: ("vortex_body_primlinearaxisfriction", "geom_friction[0]"),
    24002: ("vortex_body_seclinearaxisfriction", "geom_friction[0]"),
    33001: ("newton_body_staticfriction", "geom_friction[0]"),
    33002: ("newton_body_kineticfriction", "geom_friction[0]"),
    9001: ("ode_global_stepsize", "timestep"),
    18001: ("vortex_global_stepsize", "timestep"),
    27001: ("newton_global_stepsize", "timestep"),
    37001: ("mujoco_global_stepsize", "timestep"),
    37002: ("mujoco_global_impratio", "impratio"),
    **{37003 + axis: (f"mujoco_global_wind{axis + 1}", f"wind[{axis}]") for axis in range(3)},
    37006: ("mujoco_global_density", "density"),
    37007: ("mujoco_global_viscosity", "viscosity"),
    38002: ("mujoco_global_iterations", "iterations"),
    **{43001 + i: (f"mujoco_body_friction{i + 1}", f"geom_friction[{i}]") for i in range(3)},
    **{43004 + i: (f"mujoco_body_solref{i + 1}", f"geom_solref[{i}]") for i in range(2)},
    **{43006 + i: (f"mujoco_body_solimp{i + 1}", f"geom_solimp[{i}]") for i in range(5)},
    43011: ("mujoco_body_solmix", "geom_solmix"),
    43012: ("mujoco_body_margin", "geom_margin"),
    44001: ("mujoco_body_condim", "geom_condim"),
    44002: ("mujoco_body_priority", "geom_priority"),
}
"""Constant and field by CoppeliaSim's numbers."""

ENGINE: Mapping[int, Quantity] = MappingProxyType(
    {number: _quantity(number, *field) for number, field in _FIELDS.items()}
)
"""All quantities by number; scripts know the constants as sim.NAME."""
