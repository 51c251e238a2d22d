"""Parameters of the physics engine, see `physics_engine_parameters.py` of the server."""

from __future__ import annotations

from types import MappingProxyType

from simx_server.errors import Unsupported
from simx_server.parts import physics_engine_parameters

from .base import ApiPart
from .constant_tables.engines import ENGINES

OTHER_ENGINES = frozenset(ENGINES.values())


class EngineFunctions(ApiPart):
    """Parameters of a shape, or with handle -1 of the engine: sim.mujoco_, and the friction of other engines."""

    CONSTANTS = MappingProxyType(
        {entry.name: number for number, entry in physics_engine_parameters.PARAMETERS.items()}
    )

    def getEngineFloatParam(self, number: int, handle: int = -1) -> float:
        """Return a floating-point parameter.

        Partly: the other engines' parameters, but for friction and step size, are only kept.
        """
        return self._get(number, handle, is_integer=False)

    def setEngineFloatParam(self, number: int, handle: int, value: float) -> int:
        """Set a floating-point parameter until the simulation stops; return 1. Of two touching shapes, the greater
        friction counts.

        Partly: the other engines' parameters, but for friction, have no effect.
        """
        return self._set(number, handle, value, is_integer=False)

    def getEngineInt32Param(self, number: int, handle: int = -1) -> int:
        """Return an integer parameter. Partly: those of the other engines are only kept."""
        return int(self._get(number, handle, is_integer=True))

    def setEngineInt32Param(self, number: int, handle: int, value: int) -> int:
        """Set an integer parameter until the simulation stops; return 1.

        Partly: those of the other engines have no effect.
        """
        return self._set(number, handle, value, is_integer=True)

    def getEngineBoolParam(self, number: int, handle: int = -1) -> bool:
        """Return a switch as it was set. Stand-in: MuJoCo has none of the other engines' switches."""
        return bool(self._get(number, handle, is_integer=True))

    def setEngineBoolParam(self, number: int, handle: int, value: bool) -> int:
        """Keep a switch; return 1. Stand-in: MuJoCo has none of the other engines' switches."""
        return self._set(number, handle, value, is_integer=True)

    # Names of V-REP 3.

    getEngineFloatParameter = getEngineFloatParam
    setEngineFloatParameter = setEngineFloatParam
    getEngineInt32Parameter = getEngineInt32Param
    setEngineInt32Parameter = setEngineInt32Param
    getEngineBoolParameter = getEngineBoolParam
    setEngineBoolParameter = setEngineBoolParam

    def _get(self, number: int, handle: int, *, is_integer: bool) -> float:
        own = self._self(handle)
        if self._is_of_others(number):
            return self._world.object_settings.kept(own, number, 0.0)
        return physics_engine_parameters.find(number, is_integer=is_integer).get(self._sim, own)

    def _set(self, number: int, handle: int, value: float, *, is_integer: bool) -> int:
        own = self._self(handle)
        if self._is_of_others(number):
            self._say_once(
                f"engine parameter {number} has no effect here: the engine is MuJoCo; its value is only kept"
            )
            self._world.object_settings.keep(own, number, value)
            return 1
        entry = physics_engine_parameters.find(number, is_integer=is_integer)
        if entry.set is None:
            raise Unsupported(f"{entry.name} can only be read; it follows from the scene's timestep and pass")
        entry.set(self._sim, own, value)
        return 1

    @staticmethod
    def _is_of_others(number: int) -> bool:
        """Return whether a parameter of V-REP's engines has no counterpart in MuJoCo."""
        return number in OTHER_ENGINES and number not in physics_engine_parameters.PARAMETERS
