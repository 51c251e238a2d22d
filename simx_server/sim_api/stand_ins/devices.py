"""``simMTB`` and ``simCHAI3D``: a robot language's program and haptic devices, which are not there."""

from __future__ import annotations

from .answers import StandIn, answer

_NO_PROGRAM = "the program mtbServer is not there"
_NO_DEVICE = "no haptic device is connected"


class SimMtb(StandIn):
    """The functions of ``simMTB``, which starts V-REP's example of a robot language."""

    NOTE = "simMTB: V-REP's example program mtbServer is not there, so its robots do not move"

    startServer = answer(-1, _NO_PROGRAM, reason=_NO_PROGRAM)
    stopServer = answer(False, reason=_NO_PROGRAM)
    step = answer(-1, _NO_PROGRAM, reason=_NO_PROGRAM)
    getJoints = answer([0, 0, 0, 0], reason=_NO_PROGRAM)
    getOutput = answer([0, 0, 0, 0], reason=_NO_PROGRAM)
    getInput = answer([0, 0, 0, 0], reason=_NO_PROGRAM)
    setInput = answer(-1, reason=_NO_PROGRAM)
    connectInput = answer(False, reason=_NO_PROGRAM)
    disconnectInput = answer(False, reason=_NO_PROGRAM)


class SimChai3d(StandIn):
    """The functions of ``simCHAI3D``, for haptic devices."""

    NOTE = "simCHAI3D: no haptic device is connected"

    start = answer(-1, reason=_NO_DEVICE)
    reset = answer(reason=_NO_DEVICE)
    addShape = answer(-1, reason=_NO_DEVICE)
    updateShape = answer(reason=_NO_DEVICE)
    removeObject = answer(reason=_NO_DEVICE)
    addConstraintPoint = answer(-1, reason=_NO_DEVICE)
    addConstraintSegment = answer(-1, reason=_NO_DEVICE)
    addConstraintPlane = answer(-1, reason=_NO_DEVICE)
    updateConstraint = answer(reason=_NO_DEVICE)
    readPosition = answer([0, 0, 0], reason=_NO_DEVICE)
    readDirection = answer([0, 0, 0], reason=_NO_DEVICE)
    readForce = answer([0, 0, 0], reason=_NO_DEVICE)
    readButtons = answer(0, reason=_NO_DEVICE)
