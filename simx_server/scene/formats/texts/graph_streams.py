"""Streams and curves of a graph in an annotation: `streams=height,z,ball,1,0,0;speed,user` and `curves=path,x,y,z`.

A stream has a name, what it measures, the object concerned, and perhaps a colour (red, green, blue from 0 to 1); the
values of one that measures `user` are set by scripts. A curve has a name and the names of two or three streams.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from simx_client.protocol.python.light_dataclass import dataclass

POSITION = ("x", "y", "z")
"""World coordinates of an object."""

DETECTED = ("detected_x", "detected_y", "detected_z")
"""World coordinates of the point that a proximity sensor detects."""

DISTANCE, USER = "distance", "user"

MEASURES = (*POSITION, *DETECTED, DISTANCE, USER)

MOST_STREAMS = 100
"""Most streams and curves of a graph."""

_VALID_STREAMS = f"streams such as height,z,ball,1,0,0;speed,user, each of {', '.join(MEASURES)}"
_VALID_CURVES = (
    "curves such as path,x,y or path,x,y,z with semicolons between them, each of the graph's own streams"
)
_FREE_OF_SIGNS = re.compile(r"[,;]")


@dataclass(frozen=True)
class StreamNote:
    """One stream."""

    name: str
    measures: str = USER
    object: str = ""
    """The object, proximity sensor or distance object; empty for `user`."""
    color: tuple[float, float, float] = (1.0, 0.0, 0.0)


@dataclass(frozen=True)
class CurveNote:
    """Two or three streams against each other."""

    name: str
    streams: tuple[str, ...]


def check_streams(text: str) -> str:
    """Check streams. Raises ValueError with what is valid."""
    try:
        found = read_streams(text)
    except ValueError:
        raise ValueError(_VALID_STREAMS) from None
    names = {each.name for each in found}
    are_valid = all(
        each.name and each.measures in MEASURES and bool(each.object) == (each.measures != USER)
        for each in found
    )
    if not found or not are_valid or len(names) < len(found):
        raise ValueError(_VALID_STREAMS)
    return text


def check_curves(text: str) -> str:
    """Check the form of curves. Raises ValueError with what is valid."""
    if not all(len(each.streams) in (2, 3) and each.name for each in read_curves(text)):
        raise ValueError(_VALID_CURVES)
    return text


def read_streams(text: str) -> list[StreamNote]:
    """Return the streams of a value; '' for none. Raises ValueError for parts that are not numbers, and where
    one is missing or too many.
    """
    found: list[StreamNote] = []
    for part in text.split(";") if text else ():
        name, measures, *rest = part.split(",")
        thing, *color = rest if measures != USER else ["", *rest]
        if len(color) not in (0, 3):
            raise ValueError
        red, green, blue = (min(max(float(value), 0.0), 1.0) for value in color or ("1", "0", "0"))
        found.append(StreamNote(name, measures, thing, (red, green, blue)))
    return found


def read_curves(text: str) -> list[CurveNote]:
    """Return the curves of a value; '' for none."""
    found: list[CurveNote] = []
    for part in text.split(";") if text else ():
        name, *streams = part.split(",")
        found.append(CurveNote(name, tuple(streams)))
    return found


def write_streams(streams: list[StreamNote]) -> str:
    """Return the value that `read_streams` reads."""
    return ";".join(
        ",".join(
            [each.name, each.measures, *([each.object] if each.object else []), *map(_number, each.color)]
        )
        for each in streams
    )


def write_curves(curves: list[CurveNote]) -> str:
    """Return the value that `read_curves` reads."""
    return ";".join(",".join([each.name, *each.streams]) for each in curves)


def plain_name(name: str) -> str:
    """Return a name without the signs that separate names here."""
    return _FREE_OF_SIGNS.sub("_", name)


def renamed_streams(text: str, names: Mapping[str, str]) -> str:
    """Return streams that measure the objects by their new names."""
    return write_streams(
        [StreamNote(e.name, e.measures, names.get(e.object, e.object), e.color) for e in read_streams(text)]
    )


def _number(value: float) -> str:
    return f"{value:.6g}"
