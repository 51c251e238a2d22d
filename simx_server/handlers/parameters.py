"""Parameters of the simulator. What each number means is in `parameters.py` of the server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .registry import handler

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation


@handler("simxGetBooleanParameter")
def get_boolean_parameter(sim: Simulation, parameter: int) -> bool:
    """Differs: what needs a window is False here, where the original without one answered with an error."""
    return sim.parameters.booleans.get(parameter)


@handler("simxSetBooleanParameter")
def set_boolean_parameter(sim: Simulation, parameter: int, value: bool) -> None:
    sim.parameters.booleans.set(parameter, value)


@handler("simxGetIntegerParameter")
def get_integer_parameter(sim: Simulation, parameter: int) -> int:
    return sim.parameters.integers.get(parameter)


@handler("simxSetIntegerParameter")
def set_integer_parameter(sim: Simulation, parameter: int, value: int) -> None:
    sim.parameters.integers.set(parameter, value)


@handler("simxGetFloatingParameter")
def get_floating_parameter(sim: Simulation, parameter: int) -> float:
    return sim.parameters.floats.get(parameter)


@handler("simxSetFloatingParameter")
def set_floating_parameter(sim: Simulation, parameter: int, value: float) -> None:
    sim.parameters.floats.set(parameter, value)


@handler("simxGetStringParameter")
def get_string_parameter(sim: Simulation, parameter: int) -> str:
    return sim.parameters.strings.get(parameter)


@handler("simxGetArrayParameter")
def get_array_parameter(sim: Simulation, parameter: int) -> list[float]:
    """Differs: fog (its colour is the background of pictures), background and ambient light are errors."""
    return sim.parameters.arrays.get(parameter)


@handler("simxSetArrayParameter")
def set_array_parameter(sim: Simulation, parameter: int, values: list[float]) -> None:
    """Differs: as for reading."""
    sim.parameters.arrays.set(parameter, values)
