"""The geometry of a shape: leaves, alone or in groups."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .record_lists import END, RecordList, parse_list, split

Change = Callable[[int, RecordList, RecordList], None]
"""Changes a leaf: its number, the records that it has in common with groups, and those of a leaf."""


@dataclass(frozen=True)
class Mass:
    """Mass, and inertia relative to the shape's frame."""

    mass: float
    position: Sequence[float]
    """Centre of mass."""
    turn: Sequence[float]
    """Frame of the principal moments: w, x, y, z."""
    moments: Sequence[float]
    """Divided by the mass."""
    matrix: Sequence[float]
    """The same as a matrix of nine numbers in the shape's axes."""

    def put(self, wrapper: RecordList) -> None:
        """Write them into the outermost list of a geometry."""
        wrapper.put_numbers("Mas", self.mass)
        wrapper.put_numbers("Ine", *self.position, *self.turn, *self.moments)
        if wrapper.has("Com"):
            wrapper.put_numbers("Com", *self.position)
        if wrapper.has("Imx"):
            wrapper.put_numbers("Imx", *self.matrix)


def change_outermost(own: RecordList, change: Callable[[RecordList], None]) -> None:
    """Change the records of the outermost list, be it a leaf's or a group's."""
    geometry = parse_list("geometry", own.raw("Ge2") or b"", own.serialization)
    for tag in ("Gst", "Gsg"):
        payload = geometry.raw(tag)
        if payload is None:
            continue
        names = ["group", "leaf"] if tag == "Gst" else ["group"]
        outer, *leaf = split(names, payload, own.serialization)
        change(outer)
        geometry.put(tag, b"".join(bytes(each) + END for each in (outer, *leaf)))
    own.put("Ge2", bytes(geometry) + END)


def change_leaves(own: RecordList, change: Change) -> int:
    """Change all leaves in the order of the file; return how many there are."""
    geometry = parse_list("geometry", own.raw("Ge2") or b"", own.serialization)
    count = 0
    for tag in ("Gst", "Gsg"):
        payload = geometry.raw(tag)
        if payload is not None:
            changed, count = _changed(tag == "Gsg", payload, own.serialization, change, count)
            geometry.put(tag, changed)
    own.put("Ge2", bytes(geometry) + END)
    return count


def _changed(
    is_group: bool, payload: bytes, serialization: int, change: Change, count: int
) -> tuple[bytes, int]:
    if not is_group:
        wrapper, leaf = split(["group", "leaf"], payload, serialization)
        change(count, wrapper, leaf)
        return bytes(wrapper) + END + bytes(leaf) + END, count + 1
    records = list[tuple[str, bytes]]()
    for tag, inner in split(["group"], payload, serialization)[0]:
        if tag in ("Geo", "Wrp"):
            inner, count = _changed(tag == "Wrp", inner, serialization, change, count)
        records.append((tag, inner))
    return bytes(RecordList("group", serialization, records)) + END, count


def put_leaves(own: RecordList, leaves: Sequence[RecordList], mass: Mass) -> None:
    """Replace the whole geometry by new leaves, of which each has the records of a leaf alone."""
    wrapper = RecordList("group", own.serialization)
    mass.put(wrapper)
    wrapper.put_numbers("Dmi", -1)
    if len(leaves) == 1:
        wrapper.put_numbers("Var", 0)
        payload = ("Gst", bytes(wrapper) + END + bytes(leaves[0]) + END)
    else:
        inner = bytes(wrapper) + END
        parts = [("Geo", inner + bytes(leaf) + END) for leaf in leaves]
        payload = ("Gsg", bytes(wrapper) + bytes(RecordList("group", own.serialization, parts)) + END)
    own.put("Ge2", bytes(RecordList("geometry", own.serialization, [payload])) + END)
