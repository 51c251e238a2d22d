"""Parameters of the physics engine, see `physics_engine_parameters.py` of the server."""

from __future__ import annotations

from types import MappingProxyType
from typing import NoReturn

from simx_server.parts import physics_engine_parameters

from ...errors import CommandError
from .base import ApiPart


class EngineFunctions(ApiPart):
    """Parameters of a shape, or with handle -1 of the engine: sim.mujoco_, and the friction of other engines."""

    CONSTANTS = MappingProxyType(
        {entry.name: number for number, entry in physics_engine_parameters.PARAMETERS.items()}
    )

    def getEngineFloatParam(self, number: int, handle: int = -1) -> float:
        """Return a floating-point parameter.

        Partly: only friction and step size of the other engines are available.
        """
        entry = physics_engine_parameters.find(number, is_integer=False)
        return entry.get(self._sim, self._self(handle))

    def setEngineFloatParam(self, number: int, handle: int, value: float) -> int:
        """Set a floating-point parameter until the simulation stops; return 1. Of two touching shapes, the greater
        friction counts.

        Partly: only friction of the other engines is available.
        """
        self._set(physics_engine_parameters.find(number, is_integer=False), handle, value)
        return 1

    def getEngineInt32Param(self, number: int, handle: int = -1) -> int:
        """Return an integer parameter. Partly: those of the other engines are not available."""
        entry = physics_engine_parameters.find(number, is_integer=True)
        return int(entry.get(self._sim, self._self(handle)))

    def setEngineInt32Param(self, number: int, handle: int, value: int) -> int:
        """Set an integer parameter until the simulation stops; return 1.

        Partly: those of the other engines are not available.
        """
        self._set(physics_engine_parameters.find(number, is_integer=True), handle, value)
        return 1

    def getEngineBoolParam(self, number: int, _handle: int = -1) -> NoReturn:
        """Raise an error. Not here: MuJoCo has none of these switches."""
        raise _no_switch(number)

    def setEngineBoolParam(self, number: int, _handle: int, _value: bool) -> NoReturn:
        """Raise an error. Not here: MuJoCo has none of these switches."""
        raise _no_switch(number)

    # Names of V-REP 3.

    getEngineFloatParameter = getEngineFloatParam
    setEngineFloatParameter = setEngineFloatParam
    getEngineInt32Parameter = getEngineInt32Param
    setEngineInt32Parameter = setEngineInt32Param
    getEngineBoolParameter = getEngineBoolParam
    setEngineBoolParameter = setEngineBoolParam

    def _set(self, entry: physics_engine_parameters.EngineParameter, handle: int, value: float) -> None:
        if entry.set is None:
            raise CommandError(
                f"{entry.name} can only be read; it follows from the scene's timestep and pass"
            )
        entry.set(self._sim, self._self(handle), value)


def _no_switch(number: int) -> CommandError:
    return CommandError(
        f"engine parameter {number} is not there: the engine is MuJoCo, which has none of the switches of Bullet, ODE, "
        "Vortex and Newton; leave it out"
    )
