"""Records of groups of inverse kinematics. The targets of their tips are links of dummies, which those have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import WORLD, Annotation
from simx_server.scene.formats.vrep.chunks import decoded
from simx_server.scene.formats.vrep.conversion.facts.ik_groups import CONSTRAINTS, METHODS
from simx_server.scene.formats.vrep.decoding.registered import (
    EXPLICIT,
    LIMITS_STEPS,
    RESTORES_ORIENTATION,
    RESTORES_POSITION,
)
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list

from .field import NotInVrepFiles, Writing

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.top_level import TopRecord

    from .facts import Facts

IK_GROUP = "IKO"
"""Tag of the record."""

_FIRST_NUMBER = 2_030_000
_ENABLED = 1
_FLAGS = _ENABLED | RESTORES_POSITION | RESTORES_ORIENTATION | LIMITS_STEPS | EXPLICIT
_NUMBERS = {word: number for number, word in METHODS.items()}
_BITS = {word: bit for bit, word in CONSTRAINTS.items()}


def ik_numbers(
    records: Iterable[TopRecord], registered: Mapping[str, Mapping[str, Annotation]], serialization: int
) -> dict[str, int]:
    """Return the numbers in the file of all groups by name: those that they have there, or new ones."""
    found: dict[str, int] = {}
    for tag, payload in records:
        if tag == IK_GROUP:
            group = parse_list(tag, payload, serialization)
            (number,) = group.numbers("Oid") or [_FIRST_NUMBER]
            found[decoded((group.raw("Nme") or b"")[4:])] = int(number)
    free = max([_FIRST_NUMBER - 1, *found.values()]) + 1
    for name in registered.get("ik", {}):
        if name not in found:
            found[name], free = free, free + 1
    return found


def ik_group(
    payload: bytes, name: str, note: Annotation, facts: Facts, writing: Writing, numbers: Mapping[str, int]
) -> bytes:
    """Return the payload of a group.

    Args:
        payload: that of the file; empty for a new group.
        name: of the group.
        note: the group as an annotation.
        facts: those of the present world.
        writing: the numbers of objects.
        numbers: those of groups by name.

    Raises:
        NotInVrepFiles: a tip is missing in the file, or V-REP's groups have no such setting.
    """
    group = parse_list(IK_GROUP, payload, writing.serialization)
    for key, what in (("margins", "margins from the limits of joints"), ("axes", "frames of constraints")):
        if not _is_usual(str(note.get(key, ""))):
            raise NotInVrepFiles(f"{what} of the group of inverse kinematics '{name}'")
    if not payload:
        group.put_numbers("Oid", numbers[name])
        group.put_text("Nme", name)
    group.put_numbers("Mit", int(note.get("iterations", 6)))
    group.put_numbers("Dpg", float(note.get("damping", 0.0)))
    group.put_numbers("Cmt", _NUMBERS[str(note.get("method", "pseudo_inverse"))])
    group.put_numbers("Doo", numbers.get(str(note.get("after", "")), -1))
    restore = str(note.get("restore", "")).split(",")
    bits = _ENABLED * bool(note.get("enabled", True)) | EXPLICIT * (note.get("handling") == "explicit")
    bits |= RESTORES_POSITION * ("position" in restore) | RESTORES_ORIENTATION * ("orientation" in restore)
    bits |= LIMITS_STEPS * (not note.get("ignores_steps", False))
    group.put_bits("Var", _FLAGS, bits)
    group.put("Ike", *(_element(name, note, place, facts, writing) for place in range(_count(note))))
    return bytes(group) + END


def _is_usual(text: str) -> bool:
    """Return whether a list of words has only the usual one: the world, or 0."""
    return all(each in ("", WORLD, "0", "0.0") for each in text.replace(",", ";").split(";"))


def _count(note: Annotation) -> int:
    return len(str(note["tip"]).split(";")) if note.get("tip") else 0


def _element(name: str, note: Annotation, place: int, facts: Facts, writing: Writing) -> bytes:
    def value(key: str, usual: str) -> str:
        words = str(note.get(key, usual)).split(";")
        return words[place] if len(words) > 1 else words[0]

    handles = {each: handle for handle, each in facts.saved.names.items()}

    def number(word: str) -> int:
        if word == WORLD:
            return -1
        if word not in handles or handles[word] not in writing.numbers:
            raise NotInVrepFiles(f"'{word}', which the group of inverse kinematics '{name}' needs")
        return writing.numbers[handles[word]]

    element = RecordList("IK element", writing.serialization)
    element.put_numbers("Ik2", number(value("tip", "")), number(value("base", WORLD)))
    words = value("constraints", "pose").split(",")
    element.put_numbers("Ctr", sum(_bits(word) for word in words))
    linear, angular = map(float, value("precision", "0.0005,0.0017453292519943296").split(","))
    element.put_numbers("Pr2", angular, linear)
    element.put_numbers("Wgt", *map(float, value("weights", "1,1").split(",")))
    element.put_numbers("Var", int(value("active", "yes") in ("yes", "on", "true")))
    return bytes(element) + END


_TOGETHER = {"pose": 31, "position": 7, "orientation": 24, "none": 0}


def _bits(word: str) -> int:
    return _TOGETHER[word] if word in _TOGETHER else _BITS[word]
