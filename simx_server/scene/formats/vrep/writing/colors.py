"""Lists of colours."""

from __future__ import annotations

from collections.abc import Sequence

from simx_server.scene.formats.vrep.decoding.colors import OPAQUE

from .record_lists import RecordList

_PARTS = ("diffuse", "light", "specular", "emission", "auxiliary")
"""Colours of a list, three numbers each, in their order."""

_OLD_SHARE = 0.85
"""Factor of diffuse colours in the older record, where the ambient colour is black."""


def put_color(
    records: RecordList, tag: str, *, opacity: float | None = None, **colors: Sequence[float]
) -> None:
    """Write colours into a list of colours; those that are not given stay.

    Args:
        records: the list that contains the list of colours.
        tag: the tag of that list.
        opacity: 1 for an opaque surface.
        colors: red, green, blue by the names of `_PARTS`.
    """
    with records.child(tag) as found:
        values = found.numbers("Cl3") or [0.0] * 15
        for name, color in colors.items():
            place = 3 * _PARTS.index(name)
            values[place : place + 3] = color
        if colors:
            found.put_numbers("Cl3", *values)
        if "diffuse" in colors and found.has("Cl2"):
            old = [_OLD_SHARE * part for part in values[:3]]
            found.put_numbers("Cl2", *old, 0.0, 0.0, 0.0, *values[6:])
        if opacity is not None:
            found.put_bits("Var", OPAQUE, OPAQUE if opacity >= 1 else 0)
            found.put_numbers("Trf", opacity)
