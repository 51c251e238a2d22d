"""Parameters of the simulator. `quantities/simulator.py` defines the meaning of each number."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

from .quantities.simulator import ARRAYS, BOOLEANS, FLOATS, INTEGERS, STRINGS

if TYPE_CHECKING:
    from simx_server.world.world import World


@handler("simxGetBooleanParameter")
def get_boolean_parameter(world: World, parameter: int) -> bool:
    """Differs: parameters of a window are False here, where the original without a window returned an error."""
    return BOOLEANS.get(world, parameter)


@handler("simxSetBooleanParameter")
def set_boolean_parameter(world: World, parameter: int, value: bool) -> None:
    BOOLEANS.set(world, parameter, value)


@handler("simxGetIntegerParameter")
def get_integer_parameter(world: World, parameter: int) -> int:
    return INTEGERS.get(world, parameter)


@handler("simxSetIntegerParameter")
def set_integer_parameter(world: World, parameter: int, value: int) -> None:
    INTEGERS.set(world, parameter, value)


@handler("simxGetFloatingParameter")
def get_floating_parameter(world: World, parameter: int) -> float:
    return FLOATS.get(world, parameter)


@handler("simxSetFloatingParameter")
def set_floating_parameter(world: World, parameter: int, value: float) -> None:
    FLOATS.set(world, parameter, value)


@handler("simxGetStringParameter")
def get_string_parameter(world: World, parameter: int) -> str:
    return STRINGS.get(world, parameter)


@handler("simxGetArrayParameter")
def get_array_parameter(world: World, parameter: int) -> list[float]:
    """Differs: fog (its colour is the background of images), background and ambient light are errors."""
    return ARRAYS.get(world, parameter)


@handler("simxSetArrayParameter")
def set_array_parameter(world: World, parameter: int, values: list[float]) -> None:
    """Differs: as for reading."""
    ARRAYS.set(world, parameter, values)
