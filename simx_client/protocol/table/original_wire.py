"""How commands travel in the original's TCP protocol: which arguments stand where, and in which form.

An entry of the table has the number of its command, ``legacy_id``. The range of the number decides about the
*identification data*, which both sides compare to find equal commands; these are the arguments of the entry's key. All
other arguments make the payload of the request, all results that of the reply, in the order of the table and in the
form of their kind. `EXCEPTIONS` lists the commands that differ.

A form is one word:

=========  ========================================================================================
``i``      int32; also for a bool
``b``      one byte, for a bool or an int
``f``      float32
``3f``     this many float32 (``2i``: int32)
``3f?``    the same; None where the first is below -5
``2i?``    the same; None where the first is 98765
``z``      a text and a zero byte
``z?``     the same; None without any byte
``*``      all bytes that follow
``n*i``    a count and that number of int32
``*i``     int32 up to the end
``n*z``    a count and that number of texts
``colour`` a byte that says whether colours follow, and 12 bytes of them
``sizes``  a count, that number of int32, and lists of float32 of these sizes
``lists``  the counts of ints, floats and texts, and of bytes; then the four lists
``group``  the counts of handles, ints, floats and texts; then the four lists
=========  ========================================================================================

All numbers are little-endian and follow each other without gaps.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..kinds import Kind
from .command import Command, Place

_FORMS = {
    "int": "i",
    "bool": "i",
    "float": "f",
    "text": "z",
    "bytes": "*",
    "ints": "n*i",
    "texts": "n*z",
    "vector3": "3f",
    "vector4": "4f",
    "matrix12": "12f",
    "resolution": "2i",
    "pixels": "*",
    "depths": "*",
    "int_pair": "2i",
    "packets": "sizes",
}
"""The form of a kind, where no exception says otherwise."""


@dataclass(frozen=True)
class Wire:
    """One command of the original's protocol."""

    id: int
    command: str
    """Its name in the table."""

    ident: tuple[str, ...]
    """The arguments in the identification data, in order; an empty name stands for a number without a meaning."""

    request: tuple[tuple[tuple[str, ...], str], ...]
    """The parts of the request's payload: the arguments (several for ``lists``) and their form."""

    reply: tuple[str, ...]
    """The forms of the reply's payload."""

    fixed: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Arguments whose values follow from the number."""

    number: int | None = None
    """The identification number that selects this command among those with the same id."""


@dataclass(frozen=True)
class _Exception:
    """The deviations of a command from the rule; None: there is none."""

    id: int | None = None
    ident: tuple[str, ...] | None = None
    request: tuple[tuple[str, str], ...] | None = None
    reply: tuple[str, ...] | None = None
    fixed: Mapping[str, Any] = field(default_factory=dict[str, Any])
    number: int | None = None


_LISTS = (("inputInts inputFloats inputStrings inputBuffer", "lists"),)
_NO_NUMBER = ("",)

EXCEPTIONS: Mapping[str, tuple[_Exception, ...]] = {
    "simxSynchronous": (
        _Exception(request=(), fixed={"enable": True}),
        _Exception(id=0x0002, request=(), fixed={"enable": False}),
    ),
    "simxStartSimulation": (_Exception(ident=_NO_NUMBER, number=0),),
    "simxPauseSimulation": (_Exception(ident=_NO_NUMBER, number=1),),
    "simxStopSimulation": (_Exception(ident=_NO_NUMBER, number=2),),
    "simxCreateDummy": (_Exception(request=(("size", "f"), ("color", "colour"))),),
    "simxSetObjectParent": (_Exception(request=(("parentObject", "i"), ("keepInPlace", "b"))),),
    "simxCopyPasteObjects": (_Exception(ident=_NO_NUMBER, request=(("objectHandles", "*i"),)),),
    "simxSetObjectSelection": (_Exception(ident=_NO_NUMBER, request=(("objectHandles", "*i"),)),),
    "simxReadProximitySensor": (_Exception(reply=("b", "3f", "i", "3f")),),
    "simxReadForceSensor": (_Exception(reply=("b", "3f", "3f")),),
    "simxReadVisionSensor": (_Exception(reply=("b", "sizes")),),
    "simxGetVisionSensorImage": (
        _Exception(ident=("sensorHandle",), fixed={"options": 0}),
        _Exception(id=0x1003, ident=("sensorHandle",), fixed={"options": 1}),
    ),
    "simxSetVisionSensorImage": (
        _Exception(ident=("sensorHandle",), fixed={"options": 0}),
        _Exception(id=0x1005, ident=("sensorHandle",), fixed={"options": 1}),
    ),
    # The second numbers are of libraries of V-REP before 3.3, which send the reference frame in the payload.
    "simxGetObjectOrientation": (
        _Exception(),
        _Exception(id=0x1018, ident=("objectHandle",), request=(("relativeToObjectHandle", "i"),)),
    ),
    "simxGetObjectPosition": (
        _Exception(),
        _Exception(id=0x1019, ident=("objectHandle",), request=(("relativeToObjectHandle", "i"),)),
    ),
    "simxGetObjectGroupData": (_Exception(reply=("group",)),),
    "simxCallScriptFunction": (_Exception(request=_LISTS, reply=("lists",)),),
    # The original sends four bytes too few here, and gets eight.
    "simxGetUIEventButton": (_Exception(ident=("uiHandle", "")),),
    "simxAuxiliaryConsolePrint": (_Exception(request=(("txt", "z?"),)),),
    "simxAuxiliaryConsoleOpen": (
        _Exception(
            request=(
                ("maxLines", "i"),
                ("mode", "i"),
                ("position", "2i?"),
                ("size", "2i?"),
                ("textColor", "3f?"),
                ("backgroundColor", "3f?"),
            )
        ),
    ),
    "simxDisplayDialog": (
        _Exception(
            request=(
                ("mainText", "z"),
                ("dialogType", "i"),
                ("initialText", "z"),
                ("titleColors", "6f?"),
                ("dialogColors", "6f?"),
            )
        ),
    ),
    # A file of the client's side is sent before, with a name that says so: see the gateway's `transfers.py`.
    "simxLoadScene": (_Exception(request=(), fixed={"options": 0}),),
    "simxLoadModel": (_Exception(request=(), fixed={"options": 0}),),
    "simxLoadUI": (_Exception(request=(), fixed={"options": 0}),),
}
"""The commands that differ from the rule, by name; one with several entries has several numbers."""

RESERVED = (0x0007, 0x0008, 0x1013, 0x1030, 0x1031, 0x1032, 0x1033)
"""Numbers that the original reserves; it answers them with an error."""

KILL_CONNECTION = 0x000A
"""The number that ends a connection."""


def wires(commands: Iterable[Command]) -> list[Wire]:
    """Return how these commands travel; those without a number of the original's are left out."""
    return [
        _wire(command, exception)
        for command in commands
        if command.legacy_id is not None and command.name != "lendFile" and command.place is not Place.LOCAL
        for exception in EXCEPTIONS.get(command.name, (_Exception(),))
    ]


def _wire(command: Command, exception: _Exception) -> Wire:
    ident = command.key if exception.ident is None else exception.ident
    if exception.request is None:
        request = tuple(
            (name, _form(meaning.kind))
            for name, meaning in command.takes.items()
            if name not in ident and name not in exception.fixed
        )
    else:
        request = exception.request
    reply = exception.reply
    assert command.legacy_id is not None
    return Wire(
        id=command.legacy_id if exception.id is None else exception.id,
        command=command.name,
        ident=ident,
        request=tuple((tuple(names.split()), form) for names, form in request),
        reply=tuple(_form(meaning.kind) for meaning in command.gives.values()) if reply is None else reply,
        fixed=exception.fixed,
        number=exception.number,
    )


def _form(kind: Kind) -> str:
    return _FORMS[kind.name]
