"""THE TABLE: every function of the legacy remote API, once.

From it follow the client's functions and stubs, the server's dispatch and argument checks, the coverage
listing and the reference pages. A function that is not here does not exist; a handler without an entry
is refused at start-up.

An entry reads: name, what it takes and gives back as ``name:kind`` words (kinds are in ``kinds.py``),
the arguments that make two calls *the same command* (``key``), other names, the number the original wire
gave it, its twin in the regular API, and one sentence. ``clientID`` comes first and ``operationMode``
last in every remote function, so neither is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Any

from .kinds import KINDS, Kind


class Place(Enum):
    """Where a function does its work."""

    REMOTE = "remote"
    """In the server, in any operation mode."""

    WAITING = "waiting"
    """In the server, always blocking: the function takes no operation mode."""

    LOCAL = "local"
    """In the client, written by hand in ``simx_client/legacy/local.py``, perhaps out of remote ones."""

    CARRIED = "carried"
    """In the server, for a function of the client's: no public name, and no line in the listing."""


@dataclass(frozen=True, slots=True)
class Value:
    """One argument or result: its legacy name and its kind."""

    name: str
    kind: Kind


def _values(words: str) -> tuple[Value, ...]:
    return tuple(Value(name, KINDS[kind]) for name, kind in (word.split(":") for word in words.split()))


TRIGGER = "simxSynchronousTrigger"
"""The one command that is answered after a pass."""

_READING = ("simxGet", "simxRead", "simxCheck", "simxJointGet")
"""Begins the names of commands that read. What is called otherwise counts as changing something, also a new one."""


@dataclass(frozen=True)
class Command:
    """One entry of the table."""

    name: str
    arguments: tuple[Value, ...]
    results: tuple[Value, ...]
    key: tuple[str, ...]
    doc: str
    aliases: tuple[str, ...] = ()
    legacy_id: int | None = None
    twin: str = ""
    place: Place = Place.REMOTE
    keeps_every_call: bool = False
    """Calls with equal keys are all executed, even when they wait in one paused batch."""

    takes_what_it_reads: bool = False
    """Each successful read empties the inbox; unread data is put together, none is lost."""

    never_blocking: bool = False
    """Blocking mode is refused with the illegal-mode code."""

    stream_ends_with_hit: bool = False
    """A stream of it ends by itself with the first hit; read in buffer mode, that value is gone."""

    no_hit: int | None = None
    """First result of a success that says there was nothing; None: every success is a hit."""

    large: bool = False
    """Its result is a picture: streams of it travel by themselves, newest only."""

    parameters: tuple[str, ...] = field(default=())
    """Python parameter names in order, as the original binding spells them."""

    may_be_here: bool = False
    """Bit 0 of its second argument says that the file named by the first lies on the client's side."""

    takes_away: bool = False
    """What it reads for one client is gone for all others."""

    waits_for_scripts: bool = False
    """It runs a script, steps, or replaces what a pass or an edit works on (parameters may do so too): while a script
    runs it has to wait. Others may do what a script can find done between two of its own calls."""

    @cached_property
    def answers_soon(self) -> bool:
        """No picture is drawn, no pass is made, before there is an answer."""
        return not self.large and self.name != TRIGGER

    @cached_property
    def only_reads(self) -> bool:
        """Whether it changes nothing that another client could notice, so that viewers may call it."""
        return self.name.startswith(_READING) and not self.takes_away

    def is_hit(self, values: Sequence[Any]) -> bool:
        """Whether a success with these results ends a stream of this command."""
        return self.stream_ends_with_hit and (self.no_hit is None or values[:1] != [self.no_hit])

    @cached_property
    def names(self) -> tuple[str, ...]:
        return (self.name, *self.aliases)

    @cached_property
    def checks(self) -> tuple[Callable[[Any], Any], ...]:
        """What the server has each argument pass."""
        return tuple(argument.kind.check for argument in self.arguments)

    @cached_property
    def key_positions(self) -> tuple[int, ...]:
        order = [argument.name for argument in self.arguments]
        return tuple(order.index(name) for name in self.key)


def _command(
    name: str,
    takes: str = "",
    gives: str = "",
    doc: str = "",
    *,
    key: str = "",
    aliases: str = "",
    id: int | None = None,
    twin: str = "",
    place: Place = Place.REMOTE,
    keeps_every_call: bool = False,
    takes_what_it_reads: bool = False,
    never_blocking: bool = False,
    stream_ends_with_hit: bool = False,
    no_hit: int | None = None,
    may_be_here: bool = False,
    takes_away: bool = False,
    waits_for_scripts: bool = False,
) -> Command:
    arguments, results = _values(takes), _values(gives)
    names = tuple(argument.name for argument in arguments)
    if place is not Place.LOCAL:
        names = ("clientID", *names)
    if place is Place.REMOTE:
        names = (*names, "operationMode")
    return Command(
        name,
        arguments,
        results,
        tuple(key.split()),
        doc,
        tuple(aliases.split()),
        id,
        twin,
        place,
        keeps_every_call,
        takes_what_it_reads,
        never_blocking,
        stream_ends_with_hit,
        no_hit,
        any(result.kind.name in ("pixels", "depths") for result in results),
        names,
        may_be_here,
        takes_away,
        waits_for_scripts,
    )


def _connection() -> Iterator[Command]:
    def local(name: str, takes: str, gives: str, doc: str) -> Command:
        return _command(name, takes, gives, doc, place=Place.LOCAL)

    yield local(
        "simxStart",
        "connectionAddress:text connectionPort:int waitUntilConnected:bool doNotReconnectOnceDisconnected:bool "
        "timeOutInMs:int commThreadCycleInMs:int",
        "clientID:int",
        "Connect to a server; the lowest free client id from 0, or -1 with the reason in the log.",
    )
    yield local("simxFinish", "clientID:int", "", "Close one connection, or all of them with -1.")
    yield local(
        "simxGetConnectionId",
        "clientID:int",
        "connectionId:int",
        "1 after the first connection, one more after each reconnection, -1 while not connected.",
    )
    yield local(
        "simxGetPingTime",
        "clientID:int",
        "rc:int pingTime:int",
        "Milliseconds of one blocking exchange; when it returns, everything sent before has been executed.",
    )
    yield local(
        "simxGetLastCmdTime",
        "clientID:int",
        "cmdTime:int",
        "Simulation time in ms of the reply that this client fetched last, 0 while stopped.",
    )
    yield local(
        "simxPauseCommunication",
        "clientID:int enable:bool",
        "rc:int",
        "Hold calls back, then send them as one batch that is applied in one pass.",
    )
    yield local(
        "simxGetInMessageInfo",
        "clientID:int infoType:int",
        "result:int info:int",
        "A field of the newest reply's header; 1 and the value, or -1 and 0.",
    )
    yield local(
        "simxGetOutMessageInfo",
        "clientID:int infoType:int",
        "result:int info:int",
        "A field of the next outgoing message's header; 1 and the value, or -1 and 0.",
    )
    yield local(
        "simxCreateBuffer", "bufferSize:int", "buffer:bytes", "A ctypes pointer to so many unsigned bytes."
    )
    yield local("simxReleaseBuffer", "buffer:bytes", "", "Let go of a buffer of simxCreateBuffer.")
    yield local("simxPackInts", "intList:ints", "packed:bytes", "Little-endian int32 each.")
    yield local("simxUnpackInts", "intsPackedInString:bytes", "values:ints", "The inverse of simxPackInts.")
    yield local("simxPackFloats", "floatList:floats", "packed:bytes", "Little-endian float32 each.")
    yield local(
        "simxUnpackFloats", "floatsPackedInString:bytes", "values:floats", "The inverse of simxPackFloats."
    )
    yield local(
        "simxQuery",
        "clientID:int signalName:text signalValue:bytes retSignalName:text timeOutInMs:int",
        "rc:int retValue:bytes",
        "Set one string signal and wait for the answer in another.",
    )
    yield local(
        "simxTransferFile",
        "clientID:int filePathAndName:text fileName_serverSide:text timeOut:int operationMode:int",
        "rc:int",
        "Copy a local file into the server's workspace.",
    )
    yield _command(
        "simxSynchronous",
        "enable:bool",
        doc="Turn stepped mode on or off for this client.",
        id=0x0001,
        twin="sim.setStepping",
        place=Place.WAITING,
        waits_for_scripts=True,
    )
    yield _command(
        "simxSynchronousTrigger",
        doc="Let one simulation pass happen; the reply comes after the pass.",
        id=0x0003,
        twin="sim.step",
        place=Place.WAITING,
        waits_for_scripts=True,
    )


def _simulation() -> Iterator[Command]:
    yield _command(
        "simxStartSimulation",
        doc="Start the simulation, or resume it when paused.",
        id=0x1007,
        twin="sim.startSimulation",
        waits_for_scripts=True,
    )
    yield _command(
        "simxPauseSimulation",
        doc="Pause the simulation.",
        id=0x1007,
        twin="sim.pauseSimulation",
        waits_for_scripts=True,
    )
    yield _command(
        "simxStopSimulation",
        doc="Stop the simulation and restore the state it was started from; stepped mode ends.",
        id=0x1007,
        twin="sim.stopSimulation",
        waits_for_scripts=True,
    )
    yield _command(
        "simxLoadScene",
        "scenePathAndName:text options:int",
        doc="Load a scene while stopped; option bit 0 takes the file from the client's side.",
        key="scenePathAndName",
        id=0x3002,
        twin="sim.loadScene",
        may_be_here=True,
        waits_for_scripts=True,
    )
    yield _command(
        "simxCloseScene",
        doc="Close the scene while stopped.",
        id=0x0005,
        twin="sim.closeScene",
        waits_for_scripts=True,
    )


def _objects() -> Iterator[Command]:
    yield _command(
        "simxGetObjectHandle",
        "objectName:text",
        "handle:int",
        "The handle of the object with this name or path.",
        key="objectName",
        id=0x3001,
        twin="sim.getObject",
    )
    yield _command(
        "simxGetObjects",
        "objectType:int",
        "handles:ints",
        "All objects of a type, or of every type with sim_handle_all.",
        key="objectType",
        id=0x102A,
        twin="sim.getObjects",
    )
    yield _command(
        "simxGetObjectParent",
        "childObjectHandle:int",
        "parentHandle:int",
        "The parent's handle, -1 for none.",
        key="childObjectHandle",
        id=0x1012,
        twin="sim.getObjectParent",
    )
    yield _command(
        "simxGetObjectChild",
        "parentObjectHandle:int childIndex:int",
        "childHandle:int",
        "The child at a zero-based index, -1 when there is none.",
        key="parentObjectHandle childIndex",
        id=0x200B,
        twin="sim.getObjectChild",
    )
    yield _command(
        "simxSetObjectParent",
        "objectHandle:int parentObject:int keepInPlace:bool",
        doc="Attach an object to another, or to the world with -1.",
        key="objectHandle",
        id=0x101C,
        twin="sim.setObjectParent",
        waits_for_scripts=True,
    )
    for what, get_id, set_id, kind, argument, unit in (
        ("Position", 0x200E, 0x101B, "vector3", "position", "metres"),
        ("Orientation", 0x200D, 0x101A, "vector3", "eulerAngles", "Euler angles in radians, R = Rx Ry Rz"),
        ("Quaternion", 0x2801, 0x1801, "vector4", "quaternion", "x, y, z, w"),
    ):
        yield _command(
            f"simxGetObject{what}",
            "objectHandle:int relativeToObjectHandle:int",
            f"{argument}:{kind}",
            f"The pose of an object relative to the world (-1), its parent (-11) or another object: {unit}.",
            key="objectHandle relativeToObjectHandle",
            id=get_id,
            twin=f"sim.getObject{what}",
        )
        yield _command(
            f"simxSetObject{what}",
            f"objectHandle:int relativeToObjectHandle:int {argument}:{kind}",
            doc=f"Place an object relative to the world (-1), its parent (-11) or another object: {unit}.",
            key="objectHandle",
            id=set_id,
            twin=f"sim.setObject{what}",
        )
    yield _command(
        "simxGetObjectVelocity",
        "objectHandle:int",
        "linearVelocity:vector3 angularVelocity:vector3",
        "Velocity measured over the last pass, world axes; angular part as Euler rates, or as the physical "
        "angular velocity when 0x400000 is added to the handle.",
        key="objectHandle",
        id=0x1036,
        twin="sim.getObjectVelocity",
    )
    yield _command(
        "simxGetObjectGroupData",
        "objectType:int dataType:int",
        "handles:ints intData:ints floatData:floats stringData:texts",
        "One kind of data of all objects of a type at one instant.",
        key="objectType dataType",
        id=0x200C,
    )
    yield _command(
        "simxRemoveObject",
        "objectHandle:int",
        doc="Remove an object; its children move up to its parent.",
        key="objectHandle",
        id=0x1028,
        twin="sim.removeObjects",
        waits_for_scripts=True,
    )
    yield _command(
        "simxRemoveModel",
        "objectHandle:int",
        doc="Remove a model base with everything under it.",
        key="objectHandle",
        id=0x1037,
        twin="sim.removeModel",
        waits_for_scripts=True,
    )
    yield _command(
        "simxLoadModel",
        "modelPathAndName:text options:int",
        "baseHandle:int",
        "Add a model to the scene, the handle of its base; option bit 0 takes the file from the client's side.",
        key="modelPathAndName",
        id=0x3003,
        twin="sim.loadModel",
        may_be_here=True,
        waits_for_scripts=True,
    )
    yield _command(
        "simxCopyPasteObjects",
        "objectHandles:ints",
        "newObjectHandles:ints",
        "Copy objects, models whole: the handles of the copies, of a model its base's.",
        id=0x102E,
        twin="sim.copyPasteObjects",
        keeps_every_call=True,
        waits_for_scripts=True,
    )
    yield _command(
        "simxCreateDummy",
        "size:float color:optional_ints12",
        "dummyHandle:int",
        "Add a dummy at the origin.",
        id=0x0009,
        twin="sim.createDummy",
        keeps_every_call=True,
        waits_for_scripts=True,
    )
    yield _command(
        "simxGetObjectSelection",
        gives="handles:ints",
        doc="The selected objects.",
        id=0x0006,
        twin="sim.getObjectSel",
    )
    yield _command(
        "simxSetObjectSelection",
        "objectHandles:ints",
        doc="Replace the selection.",
        id=0x102F,
        twin="sim.setObjectSel",
    )


def _joints() -> Iterator[Command]:
    def of_joint(
        name: str, more: str, gives: str, doc: str, id: int, twin: str, aliases: str = ""
    ) -> Command:
        takes = f"jointHandle:int {more}"
        return _command(name, takes, gives, doc, key="jointHandle", id=id, twin=twin, aliases=aliases)

    yield of_joint(
        "simxGetJointPosition", "", "position:float", "Radians or metres.", 0x1001, "sim.getJointPosition"
    )
    yield of_joint(
        "simxSetJointPosition",
        "position:float",
        "",
        "Put a joint at a position, within its limits.",
        0x1002,
        "sim.setJointPosition",
    )
    yield of_joint(
        "simxGetJointMatrix",
        "",
        "matrix:matrix12",
        "The transformation that the joint's value makes, 3x4 row by row.",
        0x100A,
        "sim.getJointMatrix",
    )
    yield of_joint(
        "simxSetSphericalJointMatrix",
        "matrix:matrix12",
        "",
        "Turn a ball joint to a rotation, 3x4 row by row.",
        0x100B,
        "sim.setSphericalJointMatrix",
    )
    yield of_joint(
        "simxSetJointTargetVelocity",
        "targetVelocity:float",
        "",
        "rad/s or m/s for a motor whose control loop is off.",
        0x1008,
        "sim.setJointTargetVelocity",
    )
    yield of_joint(
        "simxSetJointTargetPosition",
        "targetPosition:float",
        "",
        "rad or m for a motor whose control loop is on.",
        0x100C,
        "sim.setJointTargetPosition",
    )
    yield of_joint(
        "simxGetJointForce",
        "",
        "force:float",
        "N m or N, mean of the last simulation step; negative while the motor pushes along +z; 0 while stopped.",
        0x100D,
        "sim.getJointForce",
        "simxJointGetForce",
    )
    yield of_joint(
        "simxGetJointMaxForce",
        "",
        "force:float",
        "The largest force or torque of the motor.",
        0x1038,
        "sim.getJointTargetForce",
    )
    yield of_joint(
        "simxSetJointForce",
        "force:float",
        "",
        "Set the largest force or torque of the motor.",
        0x100E,
        "sim.setJointTargetForce",
        "simxSetJointMaxForce",
    )


def _sensors() -> Iterator[Command]:
    def of_sensor(name: str, gives: str, doc: str, id: int, twin: str) -> Command:
        return _command(name, "sensorHandle:int", gives, doc, key="sensorHandle", id=id, twin=twin)

    yield of_sensor(
        "simxReadProximitySensor",
        "detectionState:bool detectedPoint:vector3 detectedObjectHandle:int detectedSurfaceNormalVector:vector3",
        "Point and unit normal in the sensor's frame, metres.",
        0x1009,
        "sim.readProximitySensor",
    )
    yield _command(
        "simxReadForceSensor",
        "forceSensorHandle:int",
        "state:int forceVector:vector3 torqueVector:vector3",
        "Force and torque in the sensor's frame; state bit 0: data available, bit 1: broken.",
        key="forceSensorHandle",
        id=0x100F,
        twin="sim.readForceSensor",
    )
    yield _command(
        "simxBreakForceSensor",
        "forceSensorHandle:int",
        doc="Break a force sensor.",
        key="forceSensorHandle",
        id=0x1010,
        twin="sim.breakForceSensor",
        waits_for_scripts=True,
    )
    yield of_sensor(
        "simxReadVisionSensor",
        "detectionState:bool auxPackets:packets",
        "Statistics of the picture: least, greatest and mean intensity, red, green, blue and depth.",
        0x1011,
        "sim.readVisionSensor",
    )
    yield _command(
        "simxGetVisionSensorImage",
        "sensorHandle:int options:int",
        "resolution:resolution image:pixels",
        "The picture as signed bytes, bottom row first, RGB or grey with option bit 0.",
        key="sensorHandle options",
        id=0x1004,
        twin="sim.getVisionSensorImg",
    )
    yield _command(
        "simxSetVisionSensorImage",
        "sensorHandle:int image:pixels options:int",
        doc="Replace a sensor's picture.",
        key="sensorHandle options",
        id=0x1006,
        twin="sim.setVisionSensorImg",
    )
    yield of_sensor(
        "simxGetVisionSensorDepthBuffer",
        "resolution:resolution buffer:depths",
        "Depth 0..1, linear between the clipping planes along the view axis, bottom row first.",
        0x1017,
        "sim.getVisionSensorDepth",
    )
    for what, result, id_check, id_read, id_handle in (
        ("Collision", "collisionState:bool", 0x200F, 0x1026, 0x300A),
        ("Distance", "minimumDistance:float", 0x2010, 0x1027, 0x300B),
    ):
        yield _command(
            f"simxCheck{what}",
            "entity1:int entity2:int",
            result,
            f"{what} between two objects or collections, computed now.",
            key="entity1 entity2",
            id=id_check,
            twin=f"sim.check{what}",
        )
        yield _command(
            f"simxRead{what}",
            f"{what.lower()}ObjectHandle:int",
            result,
            f"The result of a registered {what.lower()} object.",
            key=f"{what.lower()}ObjectHandle",
            id=id_read,
        )
        yield _command(
            f"simxGet{what}Handle",
            f"{what.lower()}ObjectName:text",
            "handle:int",
            f"The handle of a registered {what.lower()} object.",
            key=f"{what.lower()}ObjectName",
            id=id_handle,
        )
    yield _command(
        "simxGetCollectionHandle",
        "collectionName:text",
        "handle:int",
        "The handle of a collection.",
        key="collectionName",
        id=0x3019,
    )


def _parameters() -> Iterator[Command]:
    for what, short, kind, get_id, set_id in (
        ("FloatParameter", "FloatParam", "float", 0x2007, 0x2009),
        ("IntParameter", "Int32Param", "int", 0x2008, 0x200A),
    ):
        yield _command(
            f"simxGetObject{what}",
            "objectHandle:int parameterID:int",
            f"parameterValue:{kind}",
            "A parameter of an object.",
            key="objectHandle parameterID",
            aliases=f"simxGetObject{short}",
            id=get_id,
            twin=f"sim.getObject{short}",
        )
        yield _command(
            f"simxSetObject{what}",
            f"objectHandle:int parameterID:int parameterValue:{kind}",
            doc="Set a parameter of an object.",
            key="objectHandle parameterID",
            aliases=f"simxSetObject{short}",
            id=set_id,
            twin=f"sim.setObject{short}",
            waits_for_scripts=True,
        )
    yield _command(
        "simxGetModelProperty",
        "objectHandle:int",
        "prop:int",
        "The model bits of an object.",
        key="objectHandle",
        id=0x1034,
        twin="sim.getModelProperty",
    )
    yield _command(
        "simxSetModelProperty",
        "objectHandle:int prop:int",
        doc="Set the model bits of an object.",
        key="objectHandle",
        id=0x1035,
        twin="sim.setModelProperty",
        waits_for_scripts=True,
    )
    for what, short, kind, get_id, set_id in (
        ("BooleanParameter", "BoolParam", "bool", 0x101F, 0x1020),
        ("IntegerParameter", "Int32Param", "int", 0x1021, 0x1022),
        ("FloatingParameter", "FloatParam", "float", 0x1023, 0x1024),
        ("StringParameter", "StringParam", "text", 0x1025, None),
        ("ArrayParameter", "ArrayParam", "vector3", 0x101D, 0x101E),
    ):
        value = "paramValues" if kind == "vector3" else "paramValue"
        yield _command(
            f"simxGet{what}",
            "paramIdentifier:int",
            f"{value}:{kind}",
            "A parameter of the simulator.",
            key="paramIdentifier",
            aliases=f"simxGet{short}",
            id=get_id,
            twin=f"sim.get{short}",
        )
        if set_id is not None:
            yield _command(
                f"simxSet{what}",
                f"paramIdentifier:int {value}:{kind}",
                doc="Set a parameter of the simulator.",
                key="paramIdentifier",
                aliases=f"simxSet{short}",
                id=set_id,
                twin=f"sim.set{short}",
                waits_for_scripts=True,
            )


def _signals() -> Iterator[Command]:
    for what, short, kind, set_id, get_id, clear_id in (
        ("Float", "", "float", 0x3013, 0x3010, 0x300D),
        ("Integer", "Int32", "int", 0x3014, 0x3011, 0x300E),
        ("String", "", "bytes", 0x3015, 0x3012, 0x300F),
    ):

        def alias(verb: str, short: str = short) -> str:
            return f"simx{verb}{short}Signal" if short else ""

        twin = short or what
        yield _command(
            f"simxSet{what}Signal",
            f"signalName:text signalValue:{kind}",
            doc="Set a signal.",
            key="signalName",
            aliases=alias("Set"),
            id=set_id,
            twin=f"sim.set{twin}Signal",
        )
        yield _command(
            f"simxGet{what}Signal",
            "signalName:text",
            f"signalValue:{kind}",
            "The value of a signal; a missing one is a remote error.",
            key="signalName",
            aliases=alias("Get"),
            id=get_id,
            twin=f"sim.get{twin}Signal",
        )
        yield _command(
            f"simxClear{what}Signal",
            "signalName:text",
            doc="Remove a signal, or all signals of this type with an empty name.",
            key="signalName",
            aliases=alias("Clear"),
            id=clear_id,
            twin=f"sim.clear{twin}Signal",
        )
    yield _command(
        "simxAppendStringSignal",
        "signalName:text signalValue:bytes",
        doc="Append to a string signal; every call counts.",
        key="signalName",
        aliases="simxWriteStringStream",
        id=0x3016,
        keeps_every_call=True,
    )
    yield _command(
        "simxReadStringStream",
        "signalName:text",
        "signalValue:bytes",
        "What was written since the last read, nothing lost; not in blocking mode.",
        key="signalName",
        id=0x3018,
        takes_what_it_reads=True,
        takes_away=True,
        never_blocking=True,
    )
    yield _command(
        "simxGetAndClearStringSignal",
        "signalName:text",
        "signalValue:bytes",
        "The value of a string signal, which is then removed.",
        key="signalName",
        id=0x3017,
        takes_away=True,
        stream_ends_with_hit=True,
    )


def _scripts() -> Iterator[Command]:
    yield _command(
        "simxCallScriptFunction",
        "scriptDescription:text options:int functionName:text inputInts:ints inputFloats:floats "
        "inputStrings:texts inputBuffer:bytes",
        "outputInts:ints outputFloats:floats outputStrings:texts outputBuffer:bytes",
        "Call a function of a script in the scene.",
        key="options scriptDescription functionName",
        id=0x3401,
        twin="sim.callScriptFunction",
        keeps_every_call=True,
        waits_for_scripts=True,
    )
    yield _command(
        "simxGetLastErrors",
        gives="errors:texts",
        doc="What went wrong in commands of this client, oldest first, at most 50; reading clears the list.",
        id=0x0004,
        takes_what_it_reads=True,
    )
    yield _command(
        "simxAddStatusbarMessage",
        "message:text",
        doc="Add a line to the status bar.",
        key="message",
        id=0x3008,
        twin="sim.addLog",
        keeps_every_call=True,
    )
    yield _command(
        "simxEraseFile",
        "fileName_serverSide:text",
        doc="Delete a file in the server's workspace.",
        key="fileName_serverSide",
        id=0x3006,
    )


def _user_interface() -> Iterator[Command]:
    yield _command(
        "simxAuxiliaryConsoleOpen",
        "title:text maxLines:int mode:int position:optional_ints2 size:optional_ints2 "
        "textColor:optional_floats3 backgroundColor:optional_floats3",
        "consoleHandle:int",
        "Open a text console.",
        key="title",
        id=0x3009,
        twin="sim.auxiliaryConsoleOpen",
    )
    yield _command(
        "simxAuxiliaryConsoleClose",
        "consoleHandle:int",
        doc="Close a text console.",
        key="consoleHandle",
        id=0x1014,
        twin="sim.auxiliaryConsoleClose",
    )
    yield _command(
        "simxAuxiliaryConsolePrint",
        "consoleHandle:int txt:optional_text",
        doc="Print to a text console, or clear it with None.",
        key="consoleHandle",
        id=0x1015,
        twin="sim.auxiliaryConsolePrint",
        keeps_every_call=True,
    )
    yield _command(
        "simxAuxiliaryConsoleShow",
        "consoleHandle:int showState:bool",
        doc="Show or hide a text console.",
        key="consoleHandle",
        id=0x1016,
        twin="sim.auxiliaryConsoleShow",
    )
    yield _command(
        "simxDisplayDialog",
        "titleText:text mainText:text dialogType:int initialText:text titleColors:optional_floats6 "
        "dialogColors:optional_floats6",
        "dialogHandle:int uiHandle:int",
        "Show a dialog while the simulation runs.",
        key="titleText",
        id=0x300C,
    )
    yield _command("simxEndDialog", "dialogHandle:int", doc="Close a dialog.", key="dialogHandle", id=0x102B)
    yield _command(
        "simxGetDialogResult",
        "dialogHandle:int",
        "result:int",
        "How a dialog was answered.",
        key="dialogHandle",
        id=0x102D,
    )
    yield _command(
        "simxGetDialogInput",
        "dialogHandle:int",
        "inputText:text",
        "What was typed into a dialog.",
        key="dialogHandle",
        id=0x102C,
    )
    yield _command("simxGetUIHandle", "uiName:text", "handle:int", "A custom UI.", key="uiName", id=0x3007)
    button = "uiHandle:int uiButtonID:int"
    yield _command(
        "simxGetUISlider", button, "position:int", "Slider, 0..1000.", key="uiHandle uiButtonID", id=0x2001
    )
    yield _command(
        "simxSetUISlider",
        f"{button} position:int",
        doc="Move a slider, 0..1000.",
        key="uiHandle uiButtonID",
        id=0x2002,
    )
    yield _command(
        "simxGetUIEventButton",
        "uiHandle:int",
        "uiEventButtonID:int auxValues:int_pair",
        "The button pressed last, -1 for none.",
        key="uiHandle",
        id=0x2003,
        takes_away=True,
        stream_ends_with_hit=True,
        no_hit=-1,
    )
    yield _command(
        "simxGetUIButtonProperty",
        button,
        "prop:int",
        "The property bits of a button.",
        key="uiHandle uiButtonID",
        id=0x2004,
    )
    yield _command(
        "simxSetUIButtonProperty",
        f"{button} prop:int",
        doc="Set the property bits of a button.",
        key="uiHandle uiButtonID",
        id=0x2005,
    )
    yield _command(
        "simxSetUIButtonLabel",
        f"{button} upStateLabel:text downStateLabel:text",
        doc="Set the labels of a button.",
        key="uiHandle uiButtonID",
        id=0x2006,
    )
    yield _command(
        "simxLoadUI",
        "uiPathAndName:text options:int",
        "uiHandles:ints",
        "Load a UI.",
        key="uiPathAndName",
        id=0x3005,
        may_be_here=True,
        waits_for_scripts=True,
    )
    yield _command(
        "simxRemoveUI",
        "uiHandle:int",
        doc="Remove a custom UI.",
        key="uiHandle",
        id=0x1029,
        waits_for_scripts=True,
    )


TABLE: tuple[Command, ...] = (
    *_connection(),
    *_simulation(),
    *_objects(),
    *_joints(),
    *_sensors(),
    *_parameters(),
    *_signals(),
    *_scripts(),
    *_user_interface(),
)
"""Every command, in the order of the reference."""

BY_NAME: dict[str, Command] = {name: command for command in TABLE for name in command.names}
"""Every public name, aliases included, to its command."""

CARRIED: tuple[Command, ...] = (
    _command(
        "storeFile",
        "fileName_serverSide:text data:bytes",
        doc="Write a file into the server's workspace.",
        key="fileName_serverSide",
        id=0x3004,
        place=Place.CARRIED,
    ),
    _command(
        "lendFile",
        "path:text fileName:text data:bytes",
        doc="Keep a file for the call that follows and loads this path from the client's side.",
        key="path",
        id=0x3004,
        place=Place.CARRIED,
    ),
)
"""What travels for the sake of a function in the client."""

ANSWERED: dict[str, Command] = {
    name: command
    for command in (*TABLE, *CARRIED)
    if command.place is not Place.LOCAL
    for name in command.names
}
"""Every name that a server may be sent to its command."""
