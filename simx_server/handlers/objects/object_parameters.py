"""Read and set numbered parameters of single objects. `parameter_tables.py` defines the meaning of the numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.errors import Unsupported
from simx_server.service.calls.registry import handler

from .parameter_tables import Entry, entries_of

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World


NOT_THERE = 0
"""Result of V-REP's functions for a parameter that an object does not have."""


def _find(sim: Simulation, handle: int, number: int, *, integer: bool, setting: bool) -> Entry:
    item = sim.scene.get(handle)
    known = entries_of(item.kind)
    entry = known.get(number)
    if (
        entry is not None
        and entry.is_integer == integer
        and (entry.set if setting else entry.get) is not None
    ):
        return entry
    verb = "set" if setting else "read"
    if entry is not None and entry.is_integer != integer:
        other = "Int" if entry.is_integer else "Float"
        raise Unsupported(
            f"parameter {number} ({entry.name}) is no {_kind(integer)}; use the {other} command", NOT_THERE
        )
    listed = ", ".join(
        f"{n} {e.name}"
        for n, e in sorted(known.items())
        if e.is_integer == integer and (e.set if setting else e.get) is not None
    )
    raise Unsupported(
        f"parameter {number} of '{item.name}', a {item.kind.text}, cannot be {verb}; {_kind(integer)} parameters that "
        f"can: {listed or 'none'}",
        NOT_THERE,
    )


def _kind(integer: bool) -> str:
    return "integer" if integer else "float"


@handler("simxGetObjectFloatParameter")
def get_object_float_parameter(world: World, handle: int, number: int) -> float:
    get = _find(world.simulation, handle, number, integer=False, setting=False).get
    assert get is not None
    return float(get(world, handle))


@handler("simxSetObjectFloatParameter")
def set_object_float_parameter(world: World, handle: int, number: int, value: float) -> None:
    put = _find(world.simulation, handle, number, integer=False, setting=True).set
    assert put is not None
    put(world, handle, value)


@handler("simxGetObjectIntParameter")
def get_object_int_parameter(world: World, handle: int, number: int) -> int:
    get = _find(world.simulation, handle, number, integer=True, setting=False).get
    assert get is not None
    return int(get(world, handle))


@handler("simxSetObjectIntParameter")
def set_object_int_parameter(world: World, handle: int, number: int, value: int) -> None:
    put = _find(world.simulation, handle, number, integer=True, setting=True).set
    assert put is not None
    put(world, handle, value)
