"""Parameters of the simulator. `parameters.py` of the server defines the meaning of each number."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World


@handler("simxGetBooleanParameter")
def get_boolean_parameter(world: World, parameter: int) -> bool:
    """Differs: parameters of a window are False here, where the original without a window returned an error."""
    return world.parameters.booleans.get(parameter)


@handler("simxSetBooleanParameter")
def set_boolean_parameter(world: World, parameter: int, value: bool) -> None:
    world.parameters.booleans.set(parameter, value)


@handler("simxGetIntegerParameter")
def get_integer_parameter(world: World, parameter: int) -> int:
    return world.parameters.integers.get(parameter)


@handler("simxSetIntegerParameter")
def set_integer_parameter(world: World, parameter: int, value: int) -> None:
    world.parameters.integers.set(parameter, value)


@handler("simxGetFloatingParameter")
def get_floating_parameter(world: World, parameter: int) -> float:
    return world.parameters.floats.get(parameter)


@handler("simxSetFloatingParameter")
def set_floating_parameter(world: World, parameter: int, value: float) -> None:
    world.parameters.floats.set(parameter, value)


@handler("simxGetStringParameter")
def get_string_parameter(world: World, parameter: int) -> str:
    return world.parameters.strings.get(parameter)


@handler("simxGetArrayParameter")
def get_array_parameter(world: World, parameter: int) -> list[float]:
    """Differs: fog (its colour is the background of images), background and ambient light are errors."""
    return world.parameters.arrays.get(parameter)


@handler("simxSetArrayParameter")
def set_array_parameter(world: World, parameter: int, values: list[float]) -> None:
    """Differs: as for reading."""
    world.parameters.arrays.set(parameter, values)
