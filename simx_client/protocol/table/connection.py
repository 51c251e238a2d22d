"""Functions of the connection, and what the binding keeps in the client."""

from __future__ import annotations

from ..kinds import BOOL, BYTES, FLOATS, INT, INTS, TEXT
from .command import Command, Effect, Place
from .meanings import (
    CLIENT_FILE,
    CLIENT_ID,
    OPERATION_MODE,
    PORT,
    RETURN_CODE,
    SWITCH,
    TIME_OUT,
    WORKSPACE_FILE,
    Meaning,
    Role,
    signal_name,
)

CONNECTION = (
    Command(
        name="simxStart",
        takes={
            "connectionAddress": Meaning(TEXT, "host name or address; REALM@ROUTER", sample="'127.0.0.1'"),
            "connectionPort": PORT,
            "waitUntilConnected": Meaning(
                BOOL, "False: return at once and connect in the background", sample="True"
            ),
            "doNotReconnectOnceDisconnected": Meaning(
                BOOL, "True: one attempt only, and none after a connection is lost", sample="True"
            ),
            "timeOutInMs": TIME_OUT.but(
                "ms to keep trying; negative: the time-out of blocking calls instead"
            ),
            "commThreadCycleInMs": Meaning(INT, "accepted, without effect", sample="5"),
        },
        gives={"clientID": Meaning(INT, "lowest free number from 0, -1 for none")},
        doc=(
            "Connect to a server; returns the lowest free client id from 0, or -1 with the reason in the log."
        ),
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxFinish",
        takes={"clientID": CLIENT_ID.but("client id that simxStart returned; -1 for all")},
        doc="Close one connection, or all of them with -1.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxGetConnectionId",
        takes={"clientID": CLIENT_ID},
        gives={"connectionId": Meaning(INT, "number of the connection, -1 while there is none")},
        doc=(
            "Return the number of the connection: 1 at first, one more after each reconnection, -1 while "
            "not connected."
        ),
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxGetPingTime",
        takes={"clientID": CLIENT_ID},
        gives={"rc": RETURN_CODE, "pingTime": Meaning(INT, "ms")},
        doc=(
            "Return the milliseconds of one blocking exchange; when it returns, everything sent before "
            "has been executed."
        ),
        effect=Effect.READS,
        place=Place.LOCAL,
    ),
    Command(
        name="simxGetLastCmdTime",
        takes={"clientID": CLIENT_ID},
        gives={"cmdTime": Meaning(INT, "ms of simulation time")},
        doc="Return the simulation time in ms of the reply that this client fetched last, 0 while stopped.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxPauseCommunication",
        takes={"clientID": CLIENT_ID, "enable": SWITCH},
        gives={"rc": RETURN_CODE},
        doc="Hold calls back, then send them as one batch that is executed between two simulation steps.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxGetInMessageInfo",
        takes={
            "clientID": CLIENT_ID,
            "infoType": Meaning(
                INT, "a `simx_headeroffset_` constant", sample="vrep.simx_headeroffset_server_state"
            ),
        },
        gives={
            "result": Meaning(INT, "1, or -1 when there is none"),
            "info": Meaning(INT, "the field's value"),
        },
        doc="Return 1 and a field of the newest reply's header, or -1 and 0.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxGetOutMessageInfo",
        takes={
            "clientID": CLIENT_ID,
            "infoType": Meaning(
                INT, "a `simx_headeroffset_` constant", sample="vrep.simx_headeroffset_server_state"
            ),
        },
        gives={
            "result": Meaning(INT, "1, or -1 when there is none"),
            "info": Meaning(INT, "the field's value"),
        },
        doc="Return 1 and a field of the next outgoing message's header, or -1 and 0.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxCreateBuffer",
        takes={"bufferSize": Meaning(INT, "bytes", sample="16")},
        gives={"buffer": Meaning(BYTES, "a ctypes pointer")},
        doc="Return a ctypes pointer to this many unsigned bytes.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxReleaseBuffer",
        takes={"buffer": Meaning(BYTES, "what simxCreateBuffer returned", sample="buffer")},
        doc="Release a buffer of simxCreateBuffer.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxPackInts",
        takes={"intList": Meaning(INTS, "whole numbers", sample="[1, 2]")},
        gives={"packed": Meaning(BYTES, "the bytes")},
        doc="Pack integers as little-endian int32.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxUnpackInts",
        takes={"intsPackedInString": Meaning(BYTES, "little-endian int32 each", sample="b'\\1\\0\\0\\0'")},
        gives={"values": Meaning(INTS, "the numbers")},
        doc="Unpack what simxPackInts packed.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxPackFloats",
        takes={"floatList": Meaning(FLOATS, "numbers", sample="[0.5]")},
        gives={"packed": Meaning(BYTES, "the bytes")},
        doc="Pack numbers as little-endian float32.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxUnpackFloats",
        takes={
            "floatsPackedInString": Meaning(BYTES, "little-endian float32 each", sample="b'\\0\\0\\0\\77'")
        },
        gives={"values": Meaning(FLOATS, "the numbers")},
        doc="Unpack what simxPackFloats packed.",
        effect=Effect.NOTHING,
        place=Place.LOCAL,
    ),
    Command(
        name="simxQuery",
        takes={
            "clientID": CLIENT_ID,
            "signalName": signal_name("string", Role.MAKES),
            "signalValue": Meaning(BYTES, "value of the signal", sample="b'data'"),
            "retSignalName": signal_name("string").but(
                "name of the signal that will hold the answer", sample="'answer'"
            ),
            "timeOutInMs": TIME_OUT,
        },
        gives={"rc": RETURN_CODE, "retValue": Meaning(BYTES, "the answer")},
        doc="Set one string signal and wait for the answer in another.",
        effect=Effect.CHANGES,
        place=Place.LOCAL,
    ),
    Command(
        name="simxTransferFile",
        takes={
            "clientID": CLIENT_ID,
            "filePathAndName": CLIENT_FILE,
            "fileName_serverSide": WORKSPACE_FILE,
            "timeOut": TIME_OUT.but("ms; 0 or less: the time-out of blocking calls", sample="0", omitted=0),
            "operationMode": OPERATION_MODE,
        },
        gives={"rc": RETURN_CODE},
        doc="Copy a local file into the server's workspace.",
        effect=Effect.CHANGES,
        place=Place.LOCAL,
    ),
    Command(
        name="simxSynchronous",
        takes={"enable": SWITCH},
        doc="Turn stepped mode on or off for this client.",
        effect=Effect.CONTROLS,
        place=Place.WAITING,
        legacy_id=0x0001,
        twin="sim.setStepping",
    ),
    Command(
        name="simxSynchronousTrigger",
        doc="Make one simulation step; the reply comes after the step.",
        effect=Effect.STEPS,
        place=Place.WAITING,
        legacy_id=0x0003,
        twin="sim.step",
    ),
)
