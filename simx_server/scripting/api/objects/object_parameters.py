"""Numbered parameters and properties of objects. `handlers/parameter_tables.py` defines the numbers."""

from __future__ import annotations

from types import MappingProxyType

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers.objects import bounding_box
from simx_server.handlers.objects import object_parameters as parameters
from simx_server.handlers.objects.parameter_tables import entries_of
from simx_server.parts.custom_data import HIDDEN
from simx_server.scene import properties
from simx_server.scene.editing import renaming
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.api.base import ApiPart

_SPECIAL = {
    "collidable": c.sim_objectspecialproperty_collidable,
    "measurable": c.sim_objectspecialproperty_measurable,
    "detectable": c.sim_objectspecialproperty_detectable_all,
}
"""Annotations of a shape in the scene and the bits with the same meaning."""

_PROPERTY = HIDDEN + "property"
"""Name under which the bits of setObjectProperty are stored."""


class ObjectParameterFunctions(ApiPart):
    """Functions for parameters. Reading returns nil if objects of this kind do not have the parameter; the names of
    V-REP 3, which end in Parameter, return 1 and the value, or 0.
    """

    CONSTANTS = MappingProxyType(
        {
            "objectspecialproperty_detectable": 496,
            "objintparam_visible": 36,
            "jointintparam_dynctrlmode": 2039,
            "dummyfloatparam_size": 10002,
            "rendermode_opengl": 0,
            "rendermode_auxchannels": 1,
            "rendermode_colorcoded": 2,
            "rendermode_povray": 3,
            "rendermode_opengl3": 7,
        }
    )

    def getObjectInt32Param(self, handle: int, parameter: int) -> int | None:
        own = self._self(handle)
        if self._is_of_another_kind(own, parameter):
            return None
        return parameters.get_object_int_parameter(self._world, own, parameter)

    def setObjectInt32Param(self, handle: int, parameter: int, value: int) -> int:
        parameters.set_object_int_parameter(self._world, self._self(handle), parameter, value)
        return 1

    def getObjectFloatParam(self, handle: int, parameter: int) -> float | None:
        own = self._self(handle)
        if self._is_of_another_kind(own, parameter):
            return None
        return parameters.get_object_float_parameter(self._world, own, parameter)

    def setObjectFloatParam(self, handle: int, parameter: int, value: float) -> int:
        parameters.set_object_float_parameter(self._world, self._self(handle), parameter, value)
        return 1

    def getObjectBoolParam(self, handle: int, parameter: int) -> bool | None:
        """Return an integer parameter that is a switch."""
        value = self.getObjectInt32Param(handle, parameter)
        return None if value is None else value != 0

    def setObjectBoolParam(self, handle: int, parameter: int, value: bool) -> int:
        return self.setObjectInt32Param(handle, parameter, int(value))

    def getObjectStringParam(self, handle: int, parameter: int) -> str:
        """Raise an error. Not here: objects have no string parameters."""
        raise self._no_text(handle, parameter)

    def setObjectStringParam(self, handle: int, parameter: int, _value: bytes) -> None:
        """Raise an error. Not here: objects have no string parameters."""
        raise self._no_text(handle, parameter)

    def getObjectInt32Parameter(self, handle: int, parameter: int) -> tuple[int, int | None]:
        value = self.getObjectInt32Param(handle, parameter)
        return int(value is not None), value

    def setObjectInt32Parameter(self, handle: int, parameter: int, value: int) -> int:
        self.setObjectInt32Param(handle, parameter, value)
        return 1

    getObjectIntParameter = getObjectInt32Parameter
    setObjectIntParameter = setObjectInt32Parameter

    def getObjectFloatParameter(self, handle: int, parameter: int) -> tuple[int, float | None]:
        value = self.getObjectFloatParam(handle, parameter)
        return int(value is not None), value

    def setObjectFloatParameter(self, handle: int, parameter: int, value: float) -> int:
        self.setObjectFloatParam(handle, parameter, value)
        return 1

    getObjectStringParameter = getObjectStringParam

    def setObjectStringParameter(self, handle: int, parameter: int, value: bytes) -> None:
        """Raise an error. Not here: objects have no string parameters."""
        self.setObjectStringParam(handle, parameter, value)

    def getObjectSpecialProperty(self, handle: int) -> int:
        """Return bits sim.objectspecialproperty_*: whether the object itself is collidable, measurable, detectable
        and renderable, without the properties of its models.
        """
        own = self._self(handle)
        item = self._sim.scene.get(own)
        if item.kind != ObjectKind.SHAPE:
            return c.sim_objectspecialproperty_measurable if item.kind == ObjectKind.DUMMY else 0
        note = item.annotations.get("shape", {})
        bits = sum(bit for name, bit in _SPECIAL.items() if note.get(name, True))
        seen = self._world.object_settings.is_drawn(own) and not properties.is_unseen(item)
        return bits | (c.sim_objectspecialproperty_renderable if seen else 0)

    def setObjectSpecialProperty(self, handle: int, bits: int) -> int:
        """Set bits sim.objectspecialproperty_* until the simulation stops.

        Partly: the five kinds of detection are a single one here, on when any of them is; a shape that the scene file
        hides from images stays hidden.
        """
        own = self._self(handle)
        self._sim.scene.get_kind(own, ObjectKind.SHAPE)
        said = {name: bool(bits & bit) for name, bit in _SPECIAL.items()}
        said["renderable"] = bool(bits & c.sim_objectspecialproperty_renderable)
        renaming.annotate(self._sim, own, "shape", dict(said))
        properties.apply(self._sim)
        self._sim.changed()
        return 1

    def getObjectProperty(self, handle: int) -> int:
        """Return bits sim.objectproperty_* for viewers of the scene; the default is sim.objectproperty_selectable."""
        kept = self._world.custom_data.read(self._self(handle), _PROPERTY)
        return int(kept) if kept else c.sim_objectproperty_selectable

    def setObjectProperty(self, handle: int, bits: int) -> int:
        """Set bits sim.objectproperty_*. Partly: the bits are stored, but have no effect."""
        self._world.custom_data.write(self._self(handle), _PROPERTY, str(bits).encode())
        return 1

    def getObjectSizeValues(self, handle: int) -> list[float]:
        """Return the size in metres along the axes of the object's frame."""
        least, greatest = bounding_box.of_object(self._sim, self._self(handle))
        return [high - low for low, high in zip(least, greatest, strict=True)]

    def getShapeBB(self, handle: int) -> tuple[list[float], list[float]]:
        """Return the size of a shape's bounding box in metres, and the pose of its centre in the shape's frame."""
        own = self._self(handle)
        self._sim.scene.get_kind(own, ObjectKind.SHAPE)
        least, greatest = bounding_box.of_object(self._sim, own)
        middle = [(low + high) / 2 for low, high in zip(least, greatest, strict=True)]
        return self.getObjectSizeValues(own), [*middle, 0.0, 0.0, 0.0, 1.0]

    def getModelBB(self, handle: int) -> list[float]:
        """Return the size of the bounding box of an object and all below it, in metres along the axes of the object's
        frame.
        """
        least, greatest = bounding_box.of_object(self._sim, self._self(handle), whole_model=True)
        return [high - low for low, high in zip(least, greatest, strict=True)]

    def getObjectSizeFactor(self, handle: int) -> float:
        """Return 1: objects are never scaled."""
        self._sim.scene.get(self._self(handle))
        return 1.0

    def _is_of_another_kind(self, handle: int, parameter: int) -> bool:
        kind = self._sim.scene.get(handle).kind
        return parameter not in entries_of(kind) and any(parameter in entries_of(each) for each in ObjectKind)

    def _no_text(self, handle: int, parameter: int) -> CommandError:
        name = self._sim.scene.get(self._self(handle)).name
        return CommandError(
            f"string parameter {parameter} of '{name}': objects have no parameters here that are text; names are read "
            "with sim.getObjectName, text of your own with sim.readCustomDataBlock"
        )
