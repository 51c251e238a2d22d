"""Numbered parameters of the physics engine: MuJoCo's own as CoppeliaSim numbers them, and the friction of the others.

A shape's numbers are those of all its geoms. Parameters of other engines without a counterpart in MuJoCo are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.scene.formats.loader import ITERATIONS, MOST_ITERATIONS
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation


@dataclass(frozen=True, slots=True)
class EngineParameter:
    """Getter and setter of one parameter; their `handle` is an object's, or -1 for the engine."""

    name: str
    is_integer: bool
    get: Callable[[Simulation, int], float]
    set: Callable[[Simulation, int, float], None] | None


def find(number: int, *, is_integer: bool) -> EngineParameter:
    """Return a parameter. Raises CommandError that lists the parameters."""
    found = PARAMETERS.get(number)
    if found is None or found.is_integer != is_integer:
        kind = "integer" if is_integer else "float"
        known = ", ".join(
            f"{n} {each.name}" for n, each in PARAMETERS.items() if each.is_integer == is_integer
        )
        raise CommandError(
            f"the engine, MuJoCo, has no {kind} parameter {number}; it has {known}; what else there is of friction, "
            "contacts and damping is said in the scene's MJCF"
        )
    return found


def _geoms(sim: Simulation, handle: int) -> list[int]:
    sim.scene.get_kind(handle, ObjectKind.SHAPE)
    return [g for g in range(sim.model.ngeom) if sim.scene.owner_of_geom(g, sim.model) == handle]


def _of_geoms(name: str, array: str, index: int | None, *, is_integer: bool = False) -> EngineParameter:
    """Return the parameter for an array of the model's geoms, or for one column of it."""

    def get(sim: Simulation, handle: int) -> float:
        geom = _geoms(sim, handle)[0]
        values = getattr(sim.model, array)
        return float(values[geom] if index is None else values[geom, index])

    def put(sim: Simulation, handle: int, value: float) -> None:
        if array == "geom_friction" and value < 0:
            raise CommandError(f"a friction must not be below 0, it is {value}")
        if array == "geom_condim" and value not in (1, 3, 4, 6):
            raise CommandError(f"a contact has 1, 3, 4 or 6 dimensions, not {value:g}")
        values: Any = getattr(sim.model, array)
        for geom in _geoms(sim, handle):
            values[geom if index is None else (geom, index)] = value
        sim.model_edited()
        sim.changed()

    return EngineParameter(name, is_integer, get, put)


def _option(name: str, option: str, index: int | None = None, *, is_integer: bool = False) -> EngineParameter:
    """Return the parameter for an option of the whole engine; its handle has no effect."""

    def get(sim: Simulation, _handle: int) -> float:
        value = getattr(sim.model.opt, option)
        return float(value if index is None else value[index])

    def put(sim: Simulation, _handle: int, value: float) -> None:
        if value < 0 and option != "wind":
            raise CommandError(f"{name} must not be below 0, it is {value}")
        if option in ITERATIONS and value > MOST_ITERATIONS:
            raise CommandError(f"{name} must not be above {MOST_ITERATIONS}, it is {value:.0f}")
        if index is None:
            setattr(sim.model.opt, option, int(value) if is_integer else value)
        else:
            getattr(sim.model.opt, option)[index] = value
        sim.changed()

    return EngineParameter(name, is_integer, get, put)


def _step(engine: str) -> EngineParameter:
    return EngineParameter(
        f"{engine}_global_stepsize", False, lambda sim, _: float(sim.model.opt.timestep), None
    )


_FRICTIONS = {
    "bullet_body_oldfriction": 6002,
    "bullet_body_friction": 6003,
    "ode_body_friction": 15001,
    "vortex_body_primlinearaxisfriction": 24001,
    "vortex_body_seclinearaxisfriction": 24002,
    "newton_body_staticfriction": 33001,
    "newton_body_kineticfriction": 33002,
}
"""Friction parameters; all of them are MuJoCo's sliding friction."""

PARAMETERS: Mapping[int, EngineParameter] = MappingProxyType(
    {
        **{number: _of_geoms(name, "geom_friction", 0) for name, number in _FRICTIONS.items()},
        9001: _step("ode"),
        18001: _step("vortex"),
        27001: _step("newton"),
        37001: _step("mujoco"),
        37002: _option("mujoco_global_impratio", "impratio"),
        **{37003 + axis: _option(f"mujoco_global_wind{axis + 1}", "wind", axis) for axis in range(3)},
        37006: _option("mujoco_global_density", "density"),
        37007: _option("mujoco_global_viscosity", "viscosity"),
        38002: _option("mujoco_global_iterations", "iterations", is_integer=True),
        **{43001 + i: _of_geoms(f"mujoco_body_friction{i + 1}", "geom_friction", i) for i in range(3)},
        **{43004 + i: _of_geoms(f"mujoco_body_solref{i + 1}", "geom_solref", i) for i in range(2)},
        **{43006 + i: _of_geoms(f"mujoco_body_solimp{i + 1}", "geom_solimp", i) for i in range(5)},
        43011: _of_geoms("mujoco_body_solmix", "geom_solmix", None),
        43012: _of_geoms("mujoco_body_margin", "geom_margin", None),
        44001: _of_geoms("mujoco_body_condim", "geom_condim", None, is_integer=True),
        44002: _of_geoms("mujoco_body_priority", "geom_priority", None, is_integer=True),
    }
)
"""Parameters by CoppeliaSim's numbers, which scripts know as sim.NAME."""
