"""The content of a recording: records, each a msgpack list of a kind and its fields."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, cast

BEHAVIOUR = 9
"""Counts up when the same calls may lead to other states than before.

2: imported meshes rest, a URDF's joints and contacts are as V-REP's importer made them, the joint force has V-REP's
sign, long loops of scripts serve other clients.
3: motors are constraints as in V-REP's engines, deep overlaps part slowly, and what slides does not hop; files of V-REP
have physics steps of 5 ms, wheels that roll on one point, and concave static shapes that collide as they are.
4: each blocking call that changes something takes a step at the pace `repeat`, functions of `sim` return as many values
as in CoppeliaSim, and closed fingers press with no more than their friction.
5: loops of V-REP's files are rigid and solved with the full matrix, stiff springs are motors, the velocity of a shape
is that of its mass centre, an old joint call-back that returns nothing leaves its joint free, images, which scripts may
use, have V-REP's light, and physics steps with hundreds of shapes that all touch each other are solved by other means.
6: joints without a motor in V-REP's files rest where they are almost balanced, sensors detect dummies, and searches of
inverse kinematics and planners count their work in place of their time.
7: static shapes that are reset before they are moved drag nothing, free bodies below free bodies in the tree move along
with what is above them, a target position does not move a joint that is locked in velocity control, inverse
kinematics adds in a fixed order, not in that of a library of linear algebra, and `sysCall_joint` controls joints.
8: groups of inverse kinematics of V-REP's files keep or ignore the greatest steps of joints as the file says, shapes
of `sim.createPureShape` are not collidable, measurable or detectable, dependencies that scripts set carry forces, main
scripts call other scripts where they want, ZeroMQ clients get texts of signals as text, and robots of URDF files are
lifted from below the floor, do not collide where links overlap, have the motors and frictions of their files, and
damping and inertia of joints with light links that the physics can hold; scenes of Bullet 2.83 have its friction, and
an operator's files that clients name are read beside the physics thread.
9: a thread of a script that calls functions without end is left at the stop, in place of an error.
"""


class Kind(IntEnum):
    """The kind of a record; each member lists its fields.

    `point` is -1, or the position in a script's run (`recorder`).
    """

    HEADER = 0
    """dict: versions, scene, workspace, settings."""

    FILE = 1
    """path, SHA-256, content or nil: a file as it was when it was read."""

    FOUND = 2
    """text, whether a model was looked for, path: the file that a name referred to."""

    JOINED = 3
    """point, number of the client in this recording, its id, name, port."""

    LEFT = 4
    """point, number."""

    BATCH = 5
    """point, number, the message as it came."""

    WENT_ON = 6
    """number: the calls behind the trigger in this client's last batch were executed."""

    STARTED = 7
    """The server started the simulation, at its own start or for a client on the temporary port."""

    PASS = 8
    """CRC-32 of the positions and of the velocities after it."""

    IDLE = 9
    """Streams were executed, and scripts that run while no simulation step comes."""

    STATE = 10
    """whether at a stop, digests of the quantities of `state`."""

    ENDING = 11
    """The server was requested to end and stopped the simulation."""

    END = 12
    """The last record."""

    JOINED_ZMQ = 13
    """point, number, its id, name, port: a client of the ZeroMQ remote API. In front of its messages (BATCH) stands the
    number of the connection."""

    CONTINUED = 14
    """number, connection: a call of such a client that waited was continued."""

    WITHIN = 15
    """number, the next message of such a client that runs a function for the server, or why none was waited for."""

    RESUMED = 16
    """what happened, blocks of a journal (kind, number, content): the server crashed, and its successor continued from
    there; what the first one recorded last may be missing. See `simx_server.history.succession`."""

    STEPPING_LOST = 17
    """point, number: the server ended the stepped mode of a client that was silent."""

    OUTSIDE = 18
    """values: what a script or client got from outside, such as bytes of a serial port; see `Outside`."""


Record = list[Any]


def checked(record: Any) -> Record:
    """Return an unpacked value as a record. Raises ValueError."""
    if not isinstance(record, list) or not record:
        raise ValueError("no list")
    fields = cast(Record, record)
    if (fields[0], len(fields)) not in _LENGTHS:
        raise ValueError(f"no record begins with {fields[0]!r:.40} and has {len(fields)} fields")
    if any(type(field) not in kinds for field, kinds in zip(fields[1:], _FIELDS[fields[0]], strict=True)):
        raise ValueError(f"fields of a {Kind(fields[0]).name} are of other types")
    return fields


_NUMBER, _TEXT, _BYTES = (int,), (str,), (bytes,)
_FIELDS: dict[int, tuple[tuple[type, ...], ...]] = {
    Kind.HEADER: ((dict,),),
    Kind.FILE: (_TEXT, _BYTES, (bytes, type(None))),
    Kind.FOUND: (_TEXT, (bool,), _TEXT),
    Kind.JOINED: (_NUMBER, _NUMBER, _TEXT, _TEXT, _NUMBER),
    Kind.LEFT: (_NUMBER, _NUMBER),
    Kind.BATCH: (_NUMBER, _NUMBER, _BYTES),
    Kind.WENT_ON: (_NUMBER,),
    Kind.STARTED: (),
    Kind.PASS: (_BYTES,),
    Kind.IDLE: (),
    Kind.STATE: ((bool,), (list,)),
    Kind.ENDING: (),
    Kind.END: (),
    Kind.JOINED_ZMQ: (_NUMBER, _NUMBER, _TEXT, _TEXT, _NUMBER),
    Kind.CONTINUED: (_NUMBER, _NUMBER),
    Kind.WITHIN: (_NUMBER, (bytes, str)),
    Kind.RESUMED: (_TEXT, (list,)),
    Kind.STEPPING_LOST: (_NUMBER, _NUMBER),
    Kind.OUTSIDE: ((list,),),
}
_LENGTHS = {(int(kind), 1 + len(fields)) for kind, fields in _FIELDS.items()}
