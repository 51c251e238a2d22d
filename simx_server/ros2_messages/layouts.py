"""Layouts of messages, read from the texts in `definitions/`.

A text holds the messages of one package. A line without indentation names a message; the indented lines below it are
its fields, as in ROS 2's own files: `type name`, `type name default`, `type NAME=VALUE` for a constant. A type that
ends in `[]` is a sequence, in `[9]` an array of nine. In a service a line `---` parts request and response.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from .primitives import PRIMITIVES, Primitive

_FIELD = re.compile(
    r"(?P<kind>[\w/]+)(?P<array>\[(?P<count>\d*)\])?\s+(?P<name>\w+)(?:(?P<constant>=)|\s+|$)(?P<value>\S*)$"
)
_FOLDER = Path(__file__).parent / "definitions"
_PACKAGES = (
    "builtin_interfaces",
    "std_msgs",
    "geometry_msgs",
    "sensor_msgs",
    "nav_msgs",
    "tf2_msgs",
    "rosgraph_msgs",
    "trajectory_msgs",
    "diagnostic_msgs",
    "unique_identifier_msgs",
    "std_srvs",
    "example_interfaces",
    "simulation_interfaces",
)
"""A package comes after those whose messages it uses."""

HUMBLE = ("humble/sensor_msgs",)
"""Definitions that replace others for ROS 2 Humble."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    Attributes:
        kind: a plain type, `str`, or the layout of another message.
        count: None for one value, 0 for a sequence of any length, else the length of an array.
        default: value of a field of one plain value that is not set.
    """

    name: str
    kind: Kind
    count: int | None
    default: bool | int | float


@dataclass(frozen=True)
class Layout:
    """The fields of a message in their order on the wire.

    Attributes:
        name: such as `geometry_msgs/msg/Twist`.
        constants: numbers that the definition names.
    """

    name: str
    fields: tuple[Field, ...]
    constants: Mapping[str, int]


Kind: TypeAlias = Primitive | type[str] | Layout


def read_layouts(*, humble: bool = False) -> dict[str, Layout]:
    """Return all layouts by name; a service `std_srvs/srv/Trigger` gives two, ending in `_Request` and `_Response`."""
    found: dict[str, Layout] = {}
    for text in (*_PACKAGES, *(HUMBLE if humble else ())):
        package = text.rpartition("/")[2]
        for name, lines in _sections((_FOLDER / f"{text}.txt").read_text(encoding="utf-8")):
            _read_section(package, name, lines, found)
    return found


def _sections(text: str) -> Iterator[tuple[str, list[str]]]:
    name, lines = "", list[str]()
    for line in text.splitlines():
        content = line.partition("#")[0].rstrip()
        if content.startswith(" "):
            lines.append(content.strip())
        elif content:
            if name:
                yield name, lines
            name, lines = content, []
    yield name, lines


def _read_section(package: str, name: str, lines: list[str], found: dict[str, Layout]) -> None:
    if "---" not in lines:
        full = f"{package}/msg/{name}"
        found[full] = _layout(full, lines, found)
        return
    at = lines.index("---")
    for end, part in (("Request", lines[:at]), ("Response", lines[at + 1 :])):
        full = f"{package}/srv/{name}_{end}"
        found[full] = _layout(full, part, found)


def _layout(name: str, lines: list[str], known: Mapping[str, Layout]) -> Layout:
    fields = list[Field]()
    constants = dict[str, int]()
    for line in lines:
        match = _FIELD.fullmatch(line)
        if match is None:
            raise ValueError(f"{name}: {line!r} is not the definition of a field")
        if match["constant"]:
            constants[match["name"]] = int(match["value"])
            continue
        kind = _kind(name.partition("/")[0], match["kind"], known)
        count = None if match["array"] is None else int(match["count"] or 0)
        default = kind.default if isinstance(kind, Primitive) else 0
        fields.append(Field(match["name"], kind, count, type(default)(match["value"] or default)))
    return Layout(name, tuple(fields), constants)


def _kind(package: str, written: str, known: Mapping[str, Layout]) -> Kind:
    if written == "string":
        return str
    if written in PRIMITIVES:
        return PRIMITIVES[written]
    owner, _, short = written.rpartition("/")
    return known[f"{owner or package}/msg/{short}"]
