"""Objects: handles, hierarchy, poses, velocities."""

from __future__ import annotations

from ..kinds import BOOL, FLOATS, INT, INTS, TEXTS, VECTOR3
from .command import Command, Effect
from .meanings import (
    EULER_ANGLES,
    FOUND_HANDLE,
    HANDLE_OR_NONE,
    OBJECT_HANDLE,
    OBJECT_NAME,
    OBJECT_TYPE,
    POSITION,
    QUATERNION,
    REFERENCE_FRAME,
    Meaning,
)

OBJECTS = (
    Command(
        name="simxGetObjectHandle",
        takes={"objectName": OBJECT_NAME},
        gives={"handle": FOUND_HANDLE},
        doc="Return the handle of the object with this name or path.",
        remark="Code 8: there is none; the error text has the nearest names.",
        effect=Effect.READS,
        key=("objectName",),
        legacy_id=0x3001,
        twin="sim.getObject",
    ),
    Command(
        name="simxGetObjects",
        takes={"objectType": OBJECT_TYPE},
        gives={"handles": Meaning(INTS, "handles")},
        doc="Return all objects of a type, or of every type with sim_handle_all.",
        effect=Effect.READS,
        key=("objectType",),
        legacy_id=0x102A,
        twin="sim.getObjects",
    ),
    Command(
        name="simxGetObjectParent",
        takes={"childObjectHandle": OBJECT_HANDLE},
        gives={"parentHandle": HANDLE_OR_NONE},
        doc="Return the parent's handle, -1 for none.",
        effect=Effect.READS,
        key=("childObjectHandle",),
        legacy_id=0x1012,
        twin="sim.getObjectParent",
    ),
    Command(
        name="simxGetObjectChild",
        takes={
            "parentObjectHandle": OBJECT_HANDLE.but(sample="base"),
            "childIndex": Meaning(INT, "index, from 0", sample="0"),
        },
        gives={"childHandle": HANDLE_OR_NONE},
        doc="Return the child at a zero-based index, -1 when there is none.",
        effect=Effect.READS,
        key=("parentObjectHandle", "childIndex"),
        legacy_id=0x200B,
        twin="sim.getObjectChild",
    ),
    Command(
        name="simxSetObjectParent",
        takes={
            "objectHandle": OBJECT_HANDLE,
            "parentObject": OBJECT_HANDLE.but("handle of an object, -1 for the world", sample="base"),
            "keepInPlace": Meaning(
                BOOL,
                "True: its pose in the world stays; False: its pose relative to the parent stays",
                sample="True",
            ),
        },
        doc="Attach an object to another, or to the world with -1.",
        effect=Effect.EDITS,
        key=("objectHandle",),
        legacy_id=0x101C,
        twin="sim.setObjectParent",
    ),
    Command(
        name="simxGetObjectPosition",
        takes={"objectHandle": OBJECT_HANDLE, "relativeToObjectHandle": REFERENCE_FRAME},
        gives={"position": POSITION},
        doc=(
            "Return the position of an object relative to the world (-1), its parent (-11) or another "
            "object, in metres."
        ),
        effect=Effect.READS,
        key=("objectHandle", "relativeToObjectHandle"),
        legacy_id=0x200E,
        twin="sim.getObjectPosition",
    ),
    Command(
        name="simxSetObjectPosition",
        takes={
            "objectHandle": OBJECT_HANDLE,
            "relativeToObjectHandle": REFERENCE_FRAME,
            "position": POSITION,
        },
        doc=(
            "Set the position of an object relative to the world (-1), its parent (-11) or another "
            "object, in metres."
        ),
        effect=Effect.CHANGES,
        key=("objectHandle",),
        legacy_id=0x101B,
        twin="sim.setObjectPosition",
    ),
    Command(
        name="simxGetObjectOrientation",
        takes={"objectHandle": OBJECT_HANDLE, "relativeToObjectHandle": REFERENCE_FRAME},
        gives={"eulerAngles": EULER_ANGLES},
        doc=(
            "Return the orientation of an object relative to the world (-1), its parent (-11) or another "
            "object: Euler angles in radians, R = Rx Ry Rz."
        ),
        effect=Effect.READS,
        key=("objectHandle", "relativeToObjectHandle"),
        legacy_id=0x200D,
        twin="sim.getObjectOrientation",
    ),
    Command(
        name="simxSetObjectOrientation",
        takes={
            "objectHandle": OBJECT_HANDLE,
            "relativeToObjectHandle": REFERENCE_FRAME,
            "eulerAngles": EULER_ANGLES,
        },
        doc=(
            "Set the orientation of an object relative to the world (-1), its parent (-11) or another "
            "object: Euler angles in radians, R = Rx Ry Rz."
        ),
        effect=Effect.CHANGES,
        key=("objectHandle",),
        legacy_id=0x101A,
        twin="sim.setObjectOrientation",
    ),
    Command(
        name="simxGetObjectQuaternion",
        takes={"objectHandle": OBJECT_HANDLE, "relativeToObjectHandle": REFERENCE_FRAME},
        gives={"quaternion": QUATERNION},
        doc=(
            "Return the orientation of an object relative to the world (-1), its parent (-11) or another "
            "object: x, y, z, w."
        ),
        effect=Effect.READS,
        key=("objectHandle", "relativeToObjectHandle"),
        legacy_id=0x2801,
        twin="sim.getObjectQuaternion",
    ),
    Command(
        name="simxSetObjectQuaternion",
        takes={
            "objectHandle": OBJECT_HANDLE,
            "relativeToObjectHandle": REFERENCE_FRAME,
            "quaternion": QUATERNION,
        },
        doc=(
            "Set the orientation of an object relative to the world (-1), its parent (-11) or another "
            "object: x, y, z, w."
        ),
        effect=Effect.CHANGES,
        key=("objectHandle",),
        legacy_id=0x1801,
        twin="sim.setObjectQuaternion",
    ),
    Command(
        name="simxGetObjectVelocity",
        takes={"objectHandle": OBJECT_HANDLE},
        gives={
            "linearVelocity": Meaning(VECTOR3, "m/s, world axes"),
            "angularVelocity": Meaning(VECTOR3, "rad/s, world axes"),
        },
        doc=(
            "Return the velocity measured over the last simulation step, in world axes; the angular part "
            "as Euler rates, or as the physical angular velocity when 0x400000 is added to the handle."
        ),
        effect=Effect.READS,
        key=("objectHandle",),
        legacy_id=0x1036,
        twin="sim.getObjectVelocity",
    ),
    Command(
        name="simxGetObjectGroupData",
        takes={
            "objectType": OBJECT_TYPE,
            "dataType": Meaning(INT, "which data, 0..19 as in V-REP's manual", sample="0"),
        },
        gives={
            "handles": Meaning(INTS, "handles"),
            "intData": Meaning(INTS, "flat list, see dataType"),
            "floatData": Meaning(FLOATS, "flat list, see dataType"),
            "stringData": Meaning(TEXTS, "flat list, see dataType"),
        },
        doc="Return one kind of data of all objects of a type at one instant.",
        remark=(
            "Handles, then flat lists; an unknown data type gives the handles alone. Code 8: `objectType` "
            "is neither an object type nor a collection."
        ),
        effect=Effect.READS,
        key=("objectType", "dataType"),
        legacy_id=0x200C,
    ),
)
