"""The functions of the C library that are one of ``sim`` with other forms of arguments and results: a table.

A row has a letter for each argument, and one for the result behind the colon:

    i integer   f float   s text   p file   y bytes   I integers   F floats   B truth values   _ reserved, or a length
    >   receives the next result of ``sim``'s function; >2: its result number 2, from 0
    #   receives the number of elements of the returned array

    1   success, whatever the function returns       i   its first result, an integer; the next ones are received
    ?   1 if it has a result, which is received, else 0                f   a float
    s   a text, NULL for nil                         I, F   an array, NULL for nil
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from . import c_values as c

FAILED = -1

Call = Callable[[str, list[Any]], tuple[Any, ...]]
"""Calls a function of ``sim`` by its name."""

ROWS: Mapping[str, str] = MappingProxyType(
    {
        # --- simulation
        "simStartSimulation": ": 1",
        "simStopSimulation": ": 1",
        "simPauseSimulation": ": 1",
        "simGetSimulationTime": ": f",
        "simGetSimulationTimeStep": ": f",
        "simLoadScene": "p : 1",
        "simCloseScene": ": 1",
        "simSaveScene": "p : i",
        "simLoadModel": "p : i",
        "simSaveModel": "i p : i",
        "simAddStatusbarMessage": "s : 1",
        # --- parameters
        "simGetArrayParameter": "i > : 1",
        "simSetArrayParameter": "i F : 1",
        "simGetBoolParameter": "i : i",
        "simSetBoolParameter": "i i : 1",
        "simGetInt32Parameter": "i : i",
        "simSetInt32Parameter": "i i : 1",
        "simGetFloatParameter": "i : f",
        "simSetFloatParameter": "i f : 1",
        "simGetStringParameter": "i : s",
        "simGetEngineFloatParameter": "i i _ _ : f",
        "simSetEngineFloatParameter": "i i _ f : 1",
        # --- objects
        "simGetObjectHandle": "s : i",
        "simGetObjectName": "i : s",
        "simSetObjectName": "i s : 1",
        "simGetObjectType": "i : i",
        "simGetObjects": "i i : i",
        "simGetObjectsInTree": "i i i # : I",
        "simGetObjectChild": "i i : i",
        "simGetObjectParent": "i : i",
        "simSetObjectParent": "i i i : 1",
        "simResetDynamicObject": "i : 1",
        "simRemoveObject": "i : 1",
        "simRemoveModel": "i : i",
        "simCreateDummy": "f F : i",
        "simGetModelProperty": "i : i",
        "simSetModelProperty": "i i : 1",
        "simGetObjectSpecialProperty": "i : i",
        "simSetObjectSpecialProperty": "i i : 1",
        "simGetExtensionString": "i i s : s",
        "simGetExplicitHandling": "i : i",
        "simSetExplicitHandling": "i i : 1",
        "simGetObjectInt32Parameter": "i i > : i",
        "simSetObjectInt32Parameter": "i i i : i",
        "simGetObjectFloatParameter": "i i > : i",
        "simSetObjectFloatParameter": "i i f : i",
        "simScaleObject": "i f f f i : 1",
        "simScaleObjects": "I _ f i : 1",
        "simGetObjectSizeFactor": "i : f",
        # --- poses
        "simGetObjectPosition": "i i > : 1",
        "simSetObjectPosition": "i i F : 1",
        "simGetObjectOrientation": "i i > : 1",
        "simSetObjectOrientation": "i i F : 1",
        "simGetObjectQuaternion": "i i > : 1",
        "simSetObjectQuaternion": "i i F : 1",
        "simGetObjectMatrix": "i i > : 1",
        "simSetObjectMatrix": "i i F : 1",
        "simGetObjectVelocity": "i > > : 1",
        "simRotateAroundAxis": "F F F f > : 1",
        "simMultiplyMatrices": "F F > : 1",
        "simGetEulerAnglesFromMatrix": "F > : 1",
        # --- joints
        "simGetJointType": "i : i",
        "simGetJointMode": "i > : i",
        "simSetJointMode": "i i i : 1",
        "simGetJointPosition": "i > : 1",
        "simSetJointPosition": "i f : 1",
        "simGetJointMatrix": "i > : 1",
        "simSetSphericalJointMatrix": "i F : 1",
        "simGetJointTargetPosition": "i > : 1",
        "simSetJointTargetPosition": "i f : 1",
        "simGetJointTargetVelocity": "i > : 1",
        "simSetJointTargetVelocity": "i f : 1",
        "simGetJointForce": "i > : 1",
        "simSetJointForce": "i f : 1",
        "simGetJointMaxForce": "i > : 1",
        "simSetJointMaxForce": "i f : 1",
        "simSetJointInterval": "i i F : 1",
        # --- inverse kinematics and planning
        "simGetIkGroupHandle": "s : i",
        "simHandleIkGroup": "i : i",
        "simSetIkElementProperties": "i i i F F _ : 1",
        "simSetIkGroupProperties": "i i i f _ : 1",
        "simCheckIkGroup": "i _ I > _ : i",
        "simComputeJacobian": "i i _ : 1",
        "simGetConfigForTipPose": "i _ I f i > F _ I I F F _ : ?",
        "simGenerateIkPath": "i _ I i _ I I _ : F",
        "simRMLPos": "i f i F F B F _ : i",
        "simRMLVel": "i f i F F B F _ : i",
        "simRMLStep": "i f > _ _ : i",
        "simRMLRemove": "i : 1",
        # --- collisions and distances
        "simCheckCollision": "i i : i",
        "simCheckDistance": "i i f > : i",
        "simGetCollisionHandle": "s : i",
        "simGetCollectionHandle": "s : i",
        "simGetDistanceHandle": "s : i",
        "simReadCollision": "i : i",
        "simReadDistance": "i > : i",
        "simHandleDistance": "i > : i",
        # --- sensors
        "simGetVisionSensorResolution": "i > : 1",
        "simCreateVisionSensor": "i I F F : i",
        "simReadProximitySensor": "i >2 >3 >4 : i",
        "simCheckProximitySensor": "i i >2 : i",
        "simReadForceSensor": "i > > : i",
        "simCreateForceSensor": "i I F F : i",
        "simBreakForceSensor": "i : 1",
        # --- shapes and looks
        "simCreatePureShape": "i i F f I : i",
        "simImportShape": "i p i f f : i",
        "simCreateMeshShape": "i f F _ I _ _ : i",
        "simConvexDecompose": "i i I F : i",
        "simUngroupShape": "i # : I",
        "simReorientShapeBoundingBox": "i i i : 1",
        "simGetShapeColor": "i s i > : i",
        "simSetShapeColor": "i s i F : 1",
        "simCreateTexture": "p i _ _ _ _ _ _ _ : i",
        "simSetShapeTexture": "i i i i F F F : 1",
        "simGetShapeTextureId": "i : i",
        "simApplyTexture": "i F _ y I i : 1",
        "simComputeMassAndInertia": "i f : 1",
        "simAddForce": "i F F : 1",
        "simAddForceAndTorque": "i F F : 1",
        "simGetLightParameters": "i _ >2 >3 : i",
        "simSetLightParameters": "i i F F F : 1",
        "simAddDrawingObject": "i f f i i F _ F F : i",
        "simAddDrawingObjectItem": "i F : 1",
        "simRemoveDrawingObject": "i : 1",
        # --- octrees and paths
        "simCreateOctree": "f i f _ : i",
        "simInsertVoxelsIntoOctree": "i i F _ F I _ : i",
        "simRemoveVoxelsFromOctree": "i i F _ _ : i",
        "simInsertObjectIntoOctree": "i i i F i _ : i",
        "simSubtractObjectFromOctree": "i i i _ : i",
        "simCheckOctreePointOccupancy": "i i F _ _ _ _ : i",
        "simCreatePath": "i I F _ : i",
        "simGetPositionOnPath": "i f > : 1",
        "simGetOrientationOnPath": "i f > : 1",
        # --- signals
        "simSetIntegerSignal": "s i : 1",
        "simGetIntegerSignal": "s > : ?",
        "simClearIntegerSignal": "s : i",
        "simSetFloatSignal": "s f : 1",
        "simGetFloatSignal": "s > : ?",
        "simClearFloatSignal": "s : i",
        "simSetDoubleSignal": "s f : 1",
        "simGetDoubleSignal": "s > : ?",
        "simClearDoubleSignal": "s : i",
        "simClearStringSignal": "s : i",
        # --- scripts
        "simAddScript": "i : i",
        "simAssociateScriptWithObject": "i i : 1",
        "simSetScriptText": "i s : 1",
        "simGetScriptText": "i : s",
        "simGetScriptAssociatedWithObject": "i : i",
    }
)


def _integer(value: Any) -> int:
    return 0 if value is None else int(value)


def _code(value: Any) -> int:
    return FAILED if value is None else int(value)


_ARGUMENTS: Mapping[str, Callable[[Any], Any]] = {
    "i": _integer, "f": float, "s": c.text, "p": c.path, "y": c.content,
    "I": c.integers, "F": c.floats, "B": c.flags,
}  # fmt: skip


def failure_of(name: str) -> Any:
    """Return what a function of the table returns when it fails, as the C library does."""
    if re.match(r"sim[GS]etObject(Int32|Float)Parameter", name):
        return 0
    return c.NULL if ROWS[name][-1] in "sIF" else FAILED


def sim_name(name: str) -> str:
    """Return the full name in ``sim`` of a function of the C library: ``simRMLPos`` is ``sim.rmlPos``."""
    start = re.match(r"sim([A-Z]+(?=[A-Z][a-z])|[A-Z])", name)
    assert start is not None
    return f"sim.{start[1].lower()}{name[start.end() :]}"


def plain_function(name: str, call: Call) -> Callable[..., Any]:
    """Return the function of a row."""
    given, _, kind = ROWS[name].partition(":")
    letters, kind, full_name = given.split(), kind.strip(), sim_name(name)
    taken = [(place, _ARGUMENTS[each]) for place, each in enumerate(letters) if each in _ARGUMENTS]
    received = _received(letters, 1 if kind in "ifsIF" else 0)
    counted = letters.index("#") if "#" in letters else None

    def function(*arguments: Any) -> Any:
        results = call(full_name, [take(arguments[place]) for place, take in taken])
        for place, number in received:
            if number < len(results):
                c.fill(arguments[place], results[number])
        if kind == "1":
            return 1
        first = results[0] if results else None
        if counted is not None:
            arguments[counted][0] = len(first or ())
        return _RESULTS[kind](first)

    function.__name__ = name
    return function


def _received(letters: Sequence[str], first: int) -> list[tuple[int, int]]:
    """Return the places of arguments that receive a result, with the result's number."""
    places = [(place, each[1:]) for place, each in enumerate(letters) if each.startswith(">")]
    return [(place, int(number) if number else first + at) for at, (place, number) in enumerate(places)]


def _whether(value: Any) -> int:
    return 0 if value is None else 1


def _integers(values: Any) -> Any:
    return c.NULL if values is None else c.array("int", list(values))


def _floats(values: Any) -> Any:
    return c.NULL if values is None else c.array("float", list(values))


_RESULTS: Mapping[str, Callable[[Any], Any]] = {
    "i": _code, "f": c.single, "s": c.string, "I": _integers, "F": _floats, "?": _whether,
}  # fmt: skip
