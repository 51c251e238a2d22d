"""Numbered parameters of the simulator. `handlers/quantities/simulator.py` defines the numbers."""

from __future__ import annotations

from types import MappingProxyType

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers import parameters
from simx_server.handlers.quantities.simulator import STRINGS

from .base import ApiPart
from .effects import reads
from .verbosity import BAR, CONSOLE, INTEGER_OF, get_level, level_of, name_of, set_level

_ERRORS = c.sim_api_errormessage_report | c.sim_api_errormessage_output
"""Bits of the error report mode; with one of them an error of ``sim`` stops the script."""

_OF_SCRIPT = (CONSOLE, BAR)
"""Levels of messages that each script has for itself."""

_SHORTEST_STEP, _LONGEST_STEP = 1e-4, 10.0
"""V-REP's limits of a simulation step, seconds."""


class ParameterFunctions(ApiPart, effect="changes"):
    """Functions for parameters by sim.boolparam_, sim.intparam_, ... An unknown number is an error that lists the
    known ones.
    """

    CONSTANTS = MappingProxyType(
        {
            "physics_bullet": 0,
            "physics_ode": 1,
            "physics_vortex": 2,
            "physics_newton": 3,
            "physics_mujoco": 4,
        }
    )

    @reads
    def getBoolParam(self, number: int) -> bool:
        return parameters.get_boolean_parameter(self._world, number)

    def setBoolParam(self, number: int, value: bool) -> int:
        parameters.set_boolean_parameter(self._world, number, value)
        return 1

    @reads
    def getInt32Param(self, number: int) -> int:
        """Return an integer parameter. sim.intparam_error_report_mode is the script's own: 0 when errors of ``sim`` do
        not stop it. So are sim.intparam_verbosity and sim.intparam_statusbarverbosity: the greatest level of what it
        writes with sim.addLog.
        """
        if number == c.sim_intparam_error_report_mode:
            return int(self._script.raises_errors)
        if number in _OF_SCRIPT:
            return get_level(self._script, number)
        return parameters.get_integer_parameter(self._world, number)

    def setInt32Param(self, number: int, value: int) -> int:
        """Set an integer parameter. With sim.intparam_error_report_mode 0, calls of this script that fail return -1 or
        nil instead of stopping it, until its end.
        """
        if number == c.sim_intparam_error_report_mode:
            self._script.raises_errors = bool(value & _ERRORS)
            return 1
        if number in _OF_SCRIPT:
            set_level(self._script, number, value)
            return 1
        parameters.set_integer_parameter(self._world, number, value)
        return 1

    @reads
    def getFloatParam(self, number: int) -> float:
        return parameters.get_floating_parameter(self._world, number)

    def setFloatParam(self, number: int, value: float) -> int:
        """Set a float parameter. sim.floatparam_simulation_time_step becomes the nearest possible value; as in V-REP it
        stays, with the result 1, in a scene without a custom step, and with 0 during a run.
        """
        if number == c.sim_floatparam_simulation_time_step:
            return self._set_time_step(value)
        parameters.set_floating_parameter(self._world, number, value)
        return 1

    def _set_time_step(self, seconds: float) -> int:
        if self._sim.is_running:
            return 0
        if self._sim.scene.annotations.scene.get("custom_step", True):
            nearest = min(max(seconds, _SHORTEST_STEP), _LONGEST_STEP)
            parameters.set_floating_parameter(self._world, c.sim_floatparam_simulation_time_step, nearest)
        return 1

    @reads
    def getStringParam(self, number: int) -> str:
        """Return a string parameter. sim.stringparam_verbosity and the like name the level of the integer parameter."""
        if number in INTEGER_OF:
            return name_of(self.getInt32Param(INTEGER_OF[number]))
        return parameters.get_string_parameter(self._world, number)

    def setStringParam(self, number: int, value: str) -> int:
        """Set a string parameter. Levels of sim.stringparam_verbosity and the like are none, errors, warnings, ..."""
        if number in INTEGER_OF:
            return self.setInt32Param(INTEGER_OF[number], level_of(value))
        STRINGS.set(self._world, number, value)
        return 1

    @reads
    def getArrayParam(self, number: int) -> list[float]:
        return parameters.get_array_parameter(self._world, number)

    def setArrayParam(self, number: int, values: list[float]) -> int:
        """Set a parameter of three numbers."""
        if len(values) < 3:
            raise CommandError(f"an array parameter is 3 numbers, not {len(values)}")
        parameters.set_array_parameter(self._world, number, values[:3])
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
