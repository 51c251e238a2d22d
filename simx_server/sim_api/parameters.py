"""Numbered parameters of the simulator. `parameters.py` of the server defines the numbers."""

from __future__ import annotations

from types import MappingProxyType

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers import parameters
from simx_server.parts.custom_data import APPLICATION, NAMED

from .base import ApiPart

_ERRORS = c.sim_api_errormessage_report | c.sim_api_errormessage_output
"""Bits of the error report mode; with one of them an error of ``sim`` stops the script."""


class ParameterFunctions(ApiPart):
    """Functions for parameters by sim.boolparam_, sim.intparam_, ... An unknown number is an error that lists the
    known ones.
    """

    CONSTANTS = MappingProxyType(
        {
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
        return parameters.get_boolean_parameter(self._world, number)

    def setBoolParam(self, number: int, value: bool) -> int:
        parameters.set_boolean_parameter(self._world, number, value)
        return 1

    def getInt32Param(self, number: int) -> int:
        """Return an integer parameter. sim.intparam_error_report_mode is the script's own: 0 when errors of ``sim`` do
        not stop it.
        """
        if number == c.sim_intparam_error_report_mode:
            return int(self._script.raises_errors)
        return parameters.get_integer_parameter(self._world, number)

    def setInt32Param(self, number: int, value: int) -> int:
        """Set an integer parameter. With sim.intparam_error_report_mode 0, calls of this script that fail return -1 or
        nil instead of stopping it, until its end.
        """
        if number == c.sim_intparam_error_report_mode:
            self._script.raises_errors = bool(value & _ERRORS)
            return 1
        parameters.set_integer_parameter(self._world, number, value)
        return 1

    def getFloatParam(self, number: int) -> float:
        return parameters.get_floating_parameter(self._world, number)

    def setFloatParam(self, number: int, value: float) -> int:
        parameters.set_floating_parameter(self._world, number, value)
        return 1

    def getStringParam(self, number: int) -> str:
        return parameters.get_string_parameter(self._world, number)

    def setStringParam(self, number: int, value: str) -> int:
        self._world.parameters.strings.set(number, value)
        return 1

    def getArrayParam(self, number: int) -> list[float]:
        return parameters.get_array_parameter(self._world, number)

    def setArrayParam(self, number: int, values: list[float]) -> int:
        """Set a parameter of three numbers."""
        if len(values) < 3:
            raise CommandError(f"an array parameter is 3 numbers, not {len(values)}")
        parameters.set_array_parameter(self._world, number, values[:3])
        return 1

    def getNamedStringParam(self, name: str) -> bytes | None:
        """Return the value that a script of this server stored under a name; nil when there is none."""
        return self._world.custom_data.read(APPLICATION, f"{NAMED}{name}")

    def setNamedStringParam(self, name: str, value: bytes) -> int:
        """Store a value until the server exits; '' removes it."""
        self._world.custom_data.write(APPLICATION, f"{NAMED}{name}", value)
        return 1

    # Names of V-REP 3.

    getBoolParameter = getBoolParam
    setBoolParameter = setBoolParam
    getBooleanParameter = getBoolParam
    setBooleanParameter = setBoolParam
    getInt32Parameter = getInt32Param
    setInt32Parameter = setInt32Param
    getIntegerParameter = getInt32Param
    setIntegerParameter = setInt32Param
    getFloatParameter = getFloatParam
    setFloatParameter = setFloatParam
    getFloatingParameter = getFloatParam
    setFloatingParameter = setFloatParam
    getStringParameter = getStringParam
    setStringParameter = setStringParam
    getArrayParameter = getArrayParam
    setArrayParameter = setArrayParam
