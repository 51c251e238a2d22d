"""Numbered parameters and properties of objects. `handlers/quantities/` defines the numbers."""

from __future__ import annotations

from contextlib import suppress
from types import MappingProxyType

from simx_server.editing import object_flags
from simx_server.errors import CommandError, Unsupported, WrongKind
from simx_server.handlers.objects import object_parameters as parameters
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads


class ObjectParameterFunctions(ApiPart, effect="changes"):
    """Functions for parameters. Reading returns nil if objects of this kind do not have the parameter; the names of
    V-REP 3, which end in Parameter, return 1 and the value, or 0.
    """

    CONSTANTS = MappingProxyType(
        {
            "objectspecialproperty_detectable": 496,
        }
    )

    @reads
    def getObjectInt32Param(self, handle: int, parameter: int) -> int | None:
        with suppress(Unsupported):
            return parameters.get_object_int_parameter(self._world, self._self(handle), parameter)
        return None

    def setObjectInt32Param(self, handle: int, parameter: int, value: int) -> int:
        parameters.set_object_int_parameter(self._world, self._self(handle), parameter, value)
        return 1

    @reads
    def getObjectFloatParam(self, handle: int, parameter: int) -> float | None:
        with suppress(Unsupported):
            return parameters.get_object_float_parameter(self._world, self._self(handle), parameter)
        return None

    def setObjectFloatParam(self, handle: int, parameter: int, value: float) -> int:
        parameters.set_object_float_parameter(self._world, self._self(handle), parameter, value)
        return 1

    @reads
    def getObjectFloatArrayParam(self, handle: int, parameter: int) -> list[float] | None:
        """Return a list of numbers; nil, since objects here have no parameters that are lists."""
        self._sim.scene.get(self._self(handle))
        return None

    def setObjectFloatArrayParam(self, handle: int, parameter: int, _values: list[float]) -> int:
        """Raise an error. Not here: objects have no parameters that are lists."""
        self._sim.scene.get(self._self(handle))
        raise CommandError(f"objects have no parameter {parameter} that is a list of numbers")

    @reads
    def getObjectBoolParam(self, handle: int, parameter: int) -> bool | None:
        """Return an integer parameter that is a switch."""
        value = self.getObjectInt32Param(handle, parameter)
        return None if value is None else value != 0

    def setObjectBoolParam(self, handle: int, parameter: int, value: bool) -> int:
        return self.setObjectInt32Param(handle, parameter, int(value))

    @reads
    def getObjectStringParam(self, handle: int, _parameter: int) -> None:
        """Return nil. Stand-in: objects have no string parameters."""
        self._no_text(handle)

    def setObjectStringParam(self, handle: int, _parameter: int, _value: bytes) -> int:
        """Return 0. Stand-in: objects have no string parameters."""
        self._no_text(handle)
        return parameters.NOT_THERE

    @reads
    def getObjectInt32Parameter(self, handle: int, parameter: int) -> tuple[int, int | None]:
        value = self.getObjectInt32Param(handle, parameter)
        return int(value is not None), value

    def setObjectInt32Parameter(self, handle: int, parameter: int, value: int) -> int:
        self.setObjectInt32Param(handle, parameter, value)
        return 1

    getObjectIntParameter = getObjectInt32Parameter
    setObjectIntParameter = setObjectInt32Parameter

    @reads
    def getObjectFloatParameter(self, handle: int, parameter: int) -> tuple[int, float | None]:
        value = self.getObjectFloatParam(handle, parameter)
        return int(value is not None), value

    def setObjectFloatParameter(self, handle: int, parameter: int, value: float) -> int:
        self.setObjectFloatParam(handle, parameter, value)
        return 1

    getObjectStringParameter = getObjectStringParam

    setObjectStringParameter = setObjectStringParam

    @reads
    def getObjectSpecialProperty(self, handle: int) -> int:
        """Return bits sim.objectspecialproperty_*: whether the object itself is collidable, measurable, detectable
        and renderable, without the properties of its models.
        """
        return object_flags.special_flags(self._world, self._self(handle))

    def setObjectSpecialProperty(self, handle: int, bits: int) -> int:
        """Set bits sim.objectspecialproperty_* until the simulation stops.

        Partly: a shape that the scene file hides from images stays hidden.
        """
        try:
            object_flags.set_special_flags(self._world, self._self(handle), bits)
        except WrongKind as problem:
            raise Unsupported(f"{problem}: nothing measures other objects") from None
        return 1

    @reads
    def getObjectProperty(self, handle: int) -> int:
        """Return bits sim.objectproperty_* for viewers of the scene; the default is that
        of the file, else sim.objectproperty_selectable."""
        return object_flags.flags(self._world, self._self(handle))

    def setObjectProperty(self, handle: int, bits: int) -> int:
        """Set bits sim.objectproperty_*. Partly: only 0x100, not in the box of its model, has an effect."""
        object_flags.set_flags(self._world, self._self(handle), bits)
        return 1

    def _no_text(self, handle: int) -> None:
        self._sim.scene.get(self._self(handle))
        self._say_once(
            "objects have no parameters here that are text; names are read with sim.getObjectName, text of your own "
            "with sim.readCustomDataBlock"
        )
