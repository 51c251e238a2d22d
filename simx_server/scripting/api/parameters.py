"""Numbered parameters of the simulator. What each number means: `parameters.py` of the server."""

from __future__ import annotations

from types import MappingProxyType

from simx_server.parts.custom_data import APPLICATION, HIDDEN

from ...errors import CommandError
from ...handlers import parameters
from .base import ApiPart

_NAMED = HIDDEN + "named/"
"""Begins the names under which named parameters are kept."""


class ParameterFunctions(ApiPart):
    """By sim.boolparam_, sim.intparam_, ... Unknown ones are errors that list the known."""

    CONSTANTS = MappingProxyType(
        {
            "floatparam_physicstimestep": 3,
            "intparam_program_full_version": 39,
            "stringparam_scene_path": 14,
            "stringparam_scene_name": 15,
            "stringparam_remoteapi_temp_file_dir": 16,
            "physics_bullet": 0,
            "physics_ode": 1,
            "physics_vortex": 2,
            "physics_newton": 3,
            "physics_mujoco": 4,
        }
    )

    def getBoolParam(self, number: int) -> bool:
        return parameters.get_boolean_parameter(self._sim, number)

    def setBoolParam(self, number: int, value: bool) -> int:
        parameters.set_boolean_parameter(self._sim, number, value)
        return 1

    def getInt32Param(self, number: int) -> int:
        return parameters.get_integer_parameter(self._sim, number)

    def setInt32Param(self, number: int, value: int) -> int:
        parameters.set_integer_parameter(self._sim, number, value)
        return 1

    def getFloatParam(self, number: int) -> float:
        return parameters.get_floating_parameter(self._sim, number)

    def setFloatParam(self, number: int, value: float) -> int:
        parameters.set_floating_parameter(self._sim, number, value)
        return 1

    def getStringParam(self, number: int) -> str:
        return parameters.get_string_parameter(self._sim, number)

    def setStringParam(self, number: int, value: str) -> int:
        self._sim.parameters.strings.set(number, value)
        return 1

    def getArrayParam(self, number: int) -> list[float]:
        return parameters.get_array_parameter(self._sim, number)

    def setArrayParam(self, number: int, values: list[float]) -> int:
        """Three numbers."""
        if len(values) != 3:
            raise CommandError(f"an array parameter is 3 numbers, not {len(values)}")
        parameters.set_array_parameter(self._sim, number, values)
        return 1

    def getNamedStringParam(self, name: str) -> bytes | None:
        """Return the value that a script of this server stored under a name; nil for an unknown name."""
        return self._sim.custom_data.read(APPLICATION, f"{_NAMED}{name}")

    def setNamedStringParam(self, name: str, value: bytes) -> int:
        """Kept until the server ends; '' removes it."""
        self._sim.custom_data.write(APPLICATION, f"{_NAMED}{name}", value)
        return 1

    # Names of V-REP 3.

    def getBoolParameter(self, number: int) -> bool:
        return self.getBoolParam(number)

    def setBoolParameter(self, number: int, value: bool) -> int:
        return self.setBoolParam(number, value)

    def getBooleanParameter(self, number: int) -> bool:
        return self.getBoolParam(number)

    def setBooleanParameter(self, number: int, value: bool) -> int:
        return self.setBoolParam(number, value)

    def getInt32Parameter(self, number: int) -> int:
        return self.getInt32Param(number)

    def setInt32Parameter(self, number: int, value: int) -> int:
        return self.setInt32Param(number, value)

    def getIntegerParameter(self, number: int) -> int:
        return self.getInt32Param(number)

    def setIntegerParameter(self, number: int, value: int) -> int:
        return self.setInt32Param(number, value)

    def getFloatParameter(self, number: int) -> float:
        return self.getFloatParam(number)

    def setFloatParameter(self, number: int, value: float) -> int:
        return self.setFloatParam(number, value)

    def getFloatingParameter(self, number: int) -> float:
        return self.getFloatParam(number)

    def setFloatingParameter(self, number: int, value: float) -> int:
        return self.setFloatParam(number, value)

    def getStringParameter(self, number: int) -> str:
        return self.getStringParam(number)

    def setStringParameter(self, number: int, value: str) -> int:
        return self.setStringParam(number, value)

    def getArrayParameter(self, number: int) -> list[float]:
        return self.getArrayParam(number)

    def setArrayParameter(self, number: int, values: list[float]) -> int:
        return self.setArrayParam(number, values)
