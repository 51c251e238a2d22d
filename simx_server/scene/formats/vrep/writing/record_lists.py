"""A list of records that can be changed. Records that stay keep their bytes and places."""

from __future__ import annotations

import struct
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from simx_server.scene.formats.vrep.chunks import MARKERS, Body, form_of, has_twin, heads, twin
from simx_server.scene.formats.vrep.records import RECORDS

END = b"EOO"

FIRST_WITH_TWINS, FIRST_WITHOUT_SINGLES = 24, 25
"""Versions of the format from which reals are written as float64 too, and only so."""

_LARGEST_SINGLE = np.finfo(np.float32).max

_HEAD = struct.Struct("<3sI")


def record(tag: str, payload: bytes) -> bytes:
    """Return one record."""
    return _HEAD.pack(tag.encode("latin-1"), len(payload)) + payload


def text_bytes(text: str) -> bytes:
    """Return a text with its length."""
    data = text.encode("utf-8", "surrogateescape")
    return struct.pack("<i", len(data)) + data


class RecordList:
    """One list, up to the mark that ends it.

    Values are written under the tags that the list has already: reals as float32, as float64 under the twin's tag, or
    both. A record that is missing is added before the end, in the form of the file's version.
    """

    def __init__(self, name: str, serialization: int, records: Sequence[tuple[str, bytes]] = ()) -> None:
        """Make a list.

        Args:
            name: which list of RECORDS it is.
            serialization: version of the file's format.
            records: tag and payload of each record.
        """
        self.name, self.serialization = name, serialization
        self._records = list(records)

    def __bytes__(self) -> bytes:
        return b"".join(record(tag, payload) for tag, payload in self._records)

    def __iter__(self) -> Iterator[tuple[str, bytes]]:
        return iter(self._records)

    def has(self, tag: str) -> bool:
        """Return whether there is a record with exactly this tag."""
        return any(each == tag for each, _ in self._records)

    def raw(self, tag: str) -> bytes | None:
        """Return the payload of the first record with exactly this tag; None without one."""
        return next((payload for each, payload in self._records if each == tag), None)

    def each(self, tag: str) -> list[bytes]:
        """Return the payloads of all records with exactly this tag."""
        return [payload for each, payload in self._records if each == tag]

    def put(self, tag: str, *payloads: bytes) -> None:
        """Replace all records with this tag by these, at the place of the first one, or else at the end."""
        place = next((at for at, (each, _) in enumerate(self._records) if each == tag), len(self._records))
        rest = [each for each in self._records[place:] if each[0] != tag]
        self._records[place:] = [*((tag, payload) for payload in payloads), *rest]

    def add(self, tag: str, payload: bytes) -> None:
        """Add a record at the end."""
        self._records.append((tag, payload))

    def remove(self, *tags: str) -> None:
        """Remove all records with these tags."""
        self._records = [each for each in self._records if each[0] not in tags]

    def put_text(self, tag: str, text: str) -> None:
        """Write a record of the form `s`."""
        self.put(tag, text_bytes(text))

    def numbers(self, tag: str) -> list[float] | None:
        """Return the numbers of a record in the order of its form; None without one."""
        form = form_of(RECORDS[self.name][tag])
        doubles = self.raw(twin(tag)) if has_twin(RECORDS[self.name][tag]) else None
        singles = self.raw(tag)
        for layout, payload in ((form.double, doubles), (form.single, singles)):
            if payload is not None and len(payload) >= layout.size:
                return list(layout.unpack_from(payload))
        return None

    def put_numbers(self, tag: str, *values: float | None) -> None:
        """Write the numbers of a record; None keeps the present number, or writes 0."""
        text = RECORDS[self.name][tag]
        form = form_of(text)
        present = self.numbers(tag) or [0.0] * (len(form.ints) + len(form.reals))
        new = [old if value is None else value for value, old in zip(values, present, strict=True)]
        for place in form.ints:
            new[place] = int(new[place])
        rounded = list(new)
        for place in form.reals:
            rounded[place] = _single(new[place])
        self._put_real_forms(
            tag, text, form.single.pack(*rounded), form.double.pack(*new), is_exact=rounded == new
        )

    def put_bits(self, tag: str, mask: int, bits: int) -> None:
        """Change some bits of a record that is one whole number."""
        (present,) = self.numbers(tag) or [0]
        self.put_numbers(tag, int(present) & ~mask | bits & mask)

    def array(self, tag: str) -> tuple[list[float], list[int]] | None:
        """Return reals and ints of an engine's parameters; None without them."""
        for payload, letter, size in ((self.raw(twin(tag)), "d", 8), (self.raw(tag), "f", 4)):
            if payload is None or len(payload) < 8:
                continue
            reals, ints = struct.unpack_from("<2i", payload)
            if reals < 0 or ints < 0 or 8 + reals * size + ints * 4 > len(payload):
                continue
            values = struct.unpack_from(f"<{reals}{letter}{ints}i", payload, 8)
            return list(values[:reals]), list(values[reals:])
        return None

    def put_array(self, tag: str, reals: Sequence[float], ints: Sequence[int]) -> None:
        """Write the parameters of an engine."""
        rounded = list(map(_single, reals))
        single, double = (
            struct.pack(f"<2i{len(reals)}{letter}{len(ints)}i", len(reals), len(ints), *values, *ints)
            for letter, values in (("f", rounded), ("d", reals))
        )
        self._put_real_forms(tag, "array", single, double, is_exact=rounded == list(reals))

    def put_list(self, tag: str, ints: Sequence[int], reals: Sequence[float]) -> None:
        """Write a record of whole numbers and then as many reals as these say."""
        rounded = list(map(_single, reals))
        single, double = (
            struct.pack(f"<{len(ints)}i{len(reals)}{letter}", *ints, *values)
            for letter, values in (("f", rounded), ("d", reals))
        )
        form = RECORDS[self.name][tag]
        self._put_real_forms(tag, form, single, double, is_exact=rounded == list(reals))

    @contextmanager
    def child(self, tag: str) -> Generator[RecordList]:
        """Give the list in the first record with this tag, new or not, and write it back."""
        found = parse_list(
            RECORDS[self.name][tag].removeprefix("list "), self.raw(tag) or b"", self.serialization
        )
        yield found
        others = self.each(tag)[1:]
        self.put(tag, bytes(found) + END, *others)

    def _put_real_forms(self, tag: str, form: str, single: bytes, double: bytes, *, is_exact: bool) -> None:
        """Write a record, its twin, or both.

        Args:
            is_exact: whether float32 holds the numbers; else old files get a twin too, which V-REP 3 skips.
        """
        if not has_twin(form):
            self.put(tag, single)
            return
        has_single, has_double = self.has(tag), self.has(twin(tag))
        if not has_single and not has_double:
            has_single = self.serialization < FIRST_WITHOUT_SINGLES
            has_double = self.serialization >= FIRST_WITH_TWINS
        has_double = has_double or not is_exact
        if has_single:
            self.put(tag, single)
        if has_double:
            self.put(twin(tag), double)


def _single(value: float) -> float:
    """Return the nearest number that float32 holds."""
    with np.errstate(over="ignore"):
        return float(np.clip(np.float32(value), -_LARGEST_SINGLE, _LARGEST_SINGLE))


def split(names: Sequence[str], payload: bytes, serialization: int) -> list[RecordList]:
    """Return the lists of a payload, each of which a mark ends.

    Args:
        names: which lists of RECORDS they are; there are as many.

    Raises:
        SceneError: the payload is damaged.
    """
    body = Body(memoryview(payload), "")
    found: list[list[tuple[str, bytes]]] = [[] for _ in names]
    number = 0
    for tag, start, end in heads(body, 0, len(payload)):
        if number >= len(found):
            break
        if tag in MARKERS:
            number += 1
        else:
            found[number].append((tag.decode("latin-1"), payload[start:end]))
    return [RecordList(name, serialization, records) for name, records in zip(names, found, strict=True)]


def parse_list(name: str, payload: bytes, serialization: int) -> RecordList:
    """Return the only list of a payload. Raises SceneError."""
    return split([name], payload, serialization)[0]
