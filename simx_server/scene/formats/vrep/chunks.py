"""Records in the body: three bytes of tag, an int32 length, the payload; and lists of them.

Only the places of payloads are kept, and of these only those that `records.py` lists: what a file is made of may be
many times as many Python objects as it has bytes.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache

from simx_server.scene.formats.annotations import SceneError

from .records import RECORDS

MARKERS = (b"NXT", b"EOO", b"EOF")
"""Tags without a length, each of which ends a section."""
DEEPEST = 32
"""Levels of lists within each other; files have up to 10."""
DAMAGED = "; the file is damaged"
MOST_NOTES = 100
MOST_LISTS = 300_000
"""Lists in a file; each becomes an object of up to a kilobyte, and may be written in seven bytes."""

Place = tuple[int, int]
"""Start and end of a payload."""


class MissingRecord(SceneError):
    """Error for a record that is needed and not there; programs of some version may say the same with another one."""


@dataclass
class Body:
    """The uncompressed bytes, and what is known about them for messages."""

    data: memoryview
    writer: str
    """The program that saved the file."""
    lists: int = 0
    """Number of lists read so far."""
    notes: list[str] = field(default_factory=list[str])
    """Sentences about values that cannot be what the author meant, and that were left out."""

    def note(self, sentence: str) -> None:
        """Keep a sentence; of very many, only that there are others."""
        if len(self.notes) <= MOST_NOTES:
            self.notes.append(sentence if len(self.notes) < MOST_NOTES else "and others")

    @contextmanager
    def tolerant(self, what: str, faults: type[SceneError] = MissingRecord) -> Generator[None]:
        """Make a note of a missing record, or of other faults, within the block instead of an error; `what` tells
        what is done then.
        """
        try:
            yield
        except faults as error:
            self.note(f"{what}: {str(error).removesuffix(DAMAGED)}")

    def error(self, place: int, what: str) -> SceneError:
        """Return the error for a fault at a place."""
        return SceneError(f"{what}, at byte {place} of the body, saved by {self.writer}{DAMAGED}")


@dataclass(frozen=True)
class _Form:
    """A payload's form, as `struct` reads it."""

    single: struct.Struct
    """With float32 for `r`."""
    double: struct.Struct
    ints: tuple[int, ...]
    reals: tuple[int, ...]
    checked: bool
    """Whether the reals must be finite."""
    rest: str
    """Letter of as many further numbers as there are, or empty."""


@cache
def form_of(text: str) -> _Form:
    """Return the parsed form of a record."""
    letters, rest, ints, reals = "", "", list[int](), list[int]()
    for count, letter in re.findall(r"(\*|\d*)([a-zA-Z])", text):
        if count == "*":
            rest = letter
            continue
        for _ in range(int(count or 1)):
            (reals if letter in "rxfd" else ints).append(len(letters))
            letters += letter
    single, double = ("<" + re.sub("[rx]", real, letters) for real in "fd")
    return _Form(
        struct.Struct(single), struct.Struct(double), tuple(ints), tuple(reals), "x" not in text, rest
    )


def has_twin(form: str) -> bool:
    """Return whether a record with this form has a twin with float64."""
    return form == "array" or (not form.startswith(("list", "raw")) and bool(re.search("[rx]", form)))


def twin(tag: str) -> str:
    """Return the tag of the record that says the same with float64."""
    return "_" + tag[1:]


@cache
def _tags(name: str) -> frozenset[bytes]:
    forms = RECORDS[name]
    twins = [twin(tag) for tag, form in forms.items() if has_twin(form)]
    return frozenset(tag.encode() for tag in [*forms, *twins])


def heads(body: Body, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """Yield tag, start and end of each payload between two places; a marker has none."""
    data, place = body.data, start
    while place < end:
        tag = bytes(data[place : place + 3])
        if tag in MARKERS:
            place += 3
            yield tag, place, place
            continue
        if end - place < 7:
            raise body.error(place, f"a record with the tag {tag!r} does not fit into its list")
        length = int.from_bytes(data[place + 3 : place + 7], "little")
        if length > end - place - 7:
            raise body.error(
                place, f"record {tag!r} wants {length} bytes where {end - place - 7} are left in its list"
            )
        yield tag, place + 7, place + 7 + length
        place += 7 + length


def sections(
    body: Body, names: Sequence[str], start: int, end: int, *, level: int = 0, owner: str = ""
) -> list[Chunks]:
    """Return the sections of a list, which markers end, each read as a list of one of the names.

    Sections that the payload lacks are empty; those beyond the names are skipped.

    Args:
        body: the file's body.
        names: lists of RECORDS.
        start: place of the first record.
        end: place after the last one.
        level: how many lists this one is in.
        owner: what the list belongs to, for messages.
    """
    body.lists += 1
    if body.lists > MOST_LISTS:
        raise body.error(start, f"there are more than {MOST_LISTS} lists in the file")
    if level > DEEPEST:
        raise body.error(start, f"lists are nested more than {DEEPEST} deep")
    found = [Chunks(body, name, start, start, level, owner) for name in names]
    number, section_start = 0, start
    for tag, first, last in heads(body, start, end):
        if number >= len(found):
            break
        chunks = found[number]
        if tag in MARKERS:
            chunks.start, chunks.end = section_start, first
            number, section_start = number + 1, first
        elif tag in _tags(chunks.name):
            chunks.places.setdefault(tag.decode(), (first, last))
    else:
        if number < len(found):
            found[number].start, found[number].end = section_start, end
    return found


@dataclass
class Chunks:
    """One list of records. A record that occurs several times is found as the first one, or with `each`."""

    body: Body
    name: str
    """Which list of RECORDS it is."""
    start: int
    end: int
    level: int
    owner: str
    places: dict[str, Place] = field(default_factory=dict[str, Place])

    def has(self, tag: str) -> bool:
        """Return whether the record is there, or its twin."""
        return tag in self.places or (self._has_twin(tag) and twin(tag) in self.places)

    def error(self, tag: str, what: str) -> SceneError:
        """Return the error for a fault in a record."""
        found = self._find(tag)
        of = f" of {self.owner}" if self.owner else ""
        return self.body.error(
            found[1][0] if found else self.start, f"record '{tag}' ({self.name}){of} {what}"
        )

    def note(self, tag: str, what: str) -> None:
        """Note a value that is left out."""
        of = f" of {self.owner}" if self.owner else ""
        self.body.note(f"record '{tag}' ({self.name}){of} {what}")

    def reals(self, tag: str, *default: float) -> tuple[float, ...]:
        """Return the record's real numbers; without a default the record must be there, and finite."""
        return self._numbers(tag, 1, default)

    def ints(self, tag: str, *default: int) -> tuple[int, ...]:
        """Return the record's whole numbers; without a default the record must be there."""
        return tuple(map(int, self._numbers(tag, 0, default)))

    def text(self, tag: str, default: str = "") -> str:
        """Return the text of a record of the form `s`."""
        if tag not in self.places:
            return default
        start, end = self.places[tag]
        text, _ = self.text_at(tag, start, end)
        return text

    def text_at(self, tag: str, start: int, end: int) -> tuple[str, int]:
        """Return a text of length and bytes within a record, and the place after it."""
        (length,) = self.whole(tag, start, end, "i")
        if not 0 <= length <= end - start - 4:
            raise self.error(tag, f"has a text of {length} bytes where {end - start - 4} are left")
        return decoded(bytes(self.body.data[start + 4 : start + 4 + length])), start + 4 + length

    def whole(self, tag: str, start: int, end: int, form: str) -> tuple[int, ...]:
        """Return whole numbers that lie at a place within a record."""
        size = struct.calcsize("<" + form)
        if start < 0 or size > end - start:
            raise self.error(tag, f"ends too early: {size} bytes are needed where {end - start} are left")
        return struct.unpack_from("<" + form, self.body.data, start)

    def raw(self, tag: str) -> bytes:
        """Return the record's bytes; none when it is not there."""
        start, end = self.places.get(tag, (0, 0))
        return bytes(self.body.data[start:end])

    def array(self, tag: str) -> tuple[list[float], list[int]] | None:
        """Return the reals and ints of an engine's parameters, None when they are not there or not finite."""
        found = self._find(tag)
        if found is None:
            return None
        is_twin, (start, end) = found
        reals, ints = self.whole(tag, start, end, "2i")
        size = 8 if is_twin else 4
        if reals < 0 or ints < 0 or reals * size + ints * 4 > end - start - 8:
            raise self.error(tag, f"has {reals} real and {ints} whole numbers in {end - start} bytes")
        values = struct.unpack_from(f"<{reals}{'d' if is_twin else 'f'}{ints}i", self.body.data, start + 8)
        if not all(map(math.isfinite, values[:reals])):
            self.note(tag, "has a number that is not finite")
            return None
        return list(values[:reals]), list(values[reals:])

    def child(self, tag: str, owner: str = "") -> Chunks | None:
        """Return the list in the record, None when it is not there."""
        return next(self.each(tag, owner), None)

    def each(self, tag: str, owner: str = "") -> Iterator[Chunks]:
        """Yield the list in each record with this tag."""
        name = RECORDS[self.name][tag].removeprefix("list ")
        for start, end in self.all_places(tag):
            yield sections(self.body, [name], start, end, level=self.level + 1, owner=owner or self.owner)[0]

    def in_order(self, *tags: str) -> Iterator[tuple[str, int, int]]:
        """Yield tag, start and end of each record that has one of the tags."""
        if any(tag in self.places for tag in tags):
            for found, start, end in heads(self.body, self.start, self.end):
                if (tag := found.decode("latin-1")) in tags:
                    yield tag, start, end

    def all_places(self, tag: str) -> Iterator[Place]:
        """Yield the place of each record with this tag."""
        for _, start, end in self.in_order(tag):
            yield start, end

    def _has_twin(self, tag: str) -> bool:
        return has_twin(RECORDS[self.name][tag])

    def _find(self, tag: str) -> tuple[bool, Place] | None:
        """Return whether the twin is taken, and its place; the twin is preferred, being more precise."""
        if self._has_twin(tag) and twin(tag) in self.places:
            return True, self.places[twin(tag)]
        return (False, self.places[tag]) if tag in self.places else None

    def _numbers(self, tag: str, which: int, default: Sequence[float]) -> tuple[float, ...]:
        form = form_of(RECORDS[self.name][tag])
        found = self._find(tag)
        if found is None:
            if not default:
                raise MissingRecord(*self.error(tag, "is missing").args)
            return tuple(default)
        is_twin, (start, end) = found
        fixed = form.double if is_twin else form.single
        if end - start < fixed.size:
            raise self.error(tag, f"has {end - start} bytes where {fixed.size} are needed")
        values = fixed.unpack_from(self.body.data, start)
        numbers = tuple(values[index] for index in (form.reals if which else form.ints))
        if form.rest and which == (form.rest != "i"):
            letter = form.rest.replace("r", "d" if is_twin else "f")
            count = (end - start - fixed.size) // struct.calcsize(letter)
            numbers += struct.unpack_from(f"<{count}{letter}", self.body.data, start + fixed.size)
        if which and form.checked and not all(map(math.isfinite, numbers)):
            if not default:
                raise self.error(tag, "has a number that is not finite")
            self.note(tag, "has a number that is not finite")
            return tuple(default)
        return numbers


def decoded(data: bytes) -> str:
    """Return a text of the file: UTF-8, or Windows' Latin characters."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")
