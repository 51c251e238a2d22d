"""Layouts of messages, read from the texts in `definitions/`.

A text holds the messages of one package. A line without indentation names a message; the indented lines below it are
its fields, as in ROS 2's own files: `type name`, `type name default`, `type NAME=VALUE` for a constant. A type that
ends in `[]` is a sequence, in `[<=9]` one of at most nine values, in `[9]` an array of nine. In a service a line `---`
parts request and response; an action has two of them, which part goal, result and feedback.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from .primitives import PRIMITIVES, Primitive

_FIELD = re.compile(
    r"(?P<kind>[\w/]+)(?P<array>\[(?P<most><=)?(?P<count>\d*)\])?\s+(?P<name>\w+)(?:(?P<constant>=)|\s+|$)(?P<value>\S*)$"
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
    "action_msgs",
    "control_msgs",
    "rcl_interfaces",
)
"""A package comes after those whose messages it uses."""

OLDER = ("older/simulation_interfaces", "older/control_msgs")
"""Definitions of earlier releases of packages. Distributions from Iron on have them or the newer ones."""

HUMBLE = ("humble/sensor_msgs", *OLDER)
"""Definitions that replace others for ROS 2 Humble."""

PARTS = {"srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}
"""The parts of services and actions, in the order of their texts."""

_OF_ACTIONS = {
    "SendGoal_Request": ("unique_identifier_msgs/UUID goal_id", "{0}_Goal goal"),
    "SendGoal_Response": ("bool accepted", "builtin_interfaces/Time stamp"),
    "GetResult_Request": ("unique_identifier_msgs/UUID goal_id",),
    "GetResult_Response": ("int8 status", "{0}_Result result"),
    "FeedbackMessage": ("unique_identifier_msgs/UUID goal_id", "{0}_Feedback feedback"),
}
"""The messages of every action, with its name for {0}."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    Attributes:
        kind: a plain type, `str`, or the layout of another message.
        count: None for one value, 0 for a sequence of any length, else the length of an array.
        default: value of a field of one plain value that is not set.
        most: the values that a sequence has at most; 0: any number.
    """

    name: str
    kind: Kind
    count: int | None
    default: bool | int | float
    most: int = 0


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


def read_layouts(*, humble: bool = False, older: bool = False) -> dict[str, Layout]:
    """Return all layouts by name.

    A service `std_srvs/srv/Trigger` gives two, ending in `_Request` and `_Response`. An action gives those of its goal,
    result and feedback, and those of its two services and of its topic.

    Args:
        humble: as ROS 2 Humble has them.
        older: as earlier releases of packages have them.
    """
    found: dict[str, Layout] = {}
    for text in (*_PACKAGES, *(HUMBLE if humble else OLDER if older else ())):
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
    parts: list[list[str]] = [[]]
    for line in lines:
        if line == "---":
            parts.append([])
        else:
            parts[-1].append(line)
    kind = {1: "msg", 2: "srv", 3: "action"}[len(parts)]
    for end, part in zip(PARTS.get(kind, ("",)), parts, strict=True):
        full = f"{package}/{kind}/{name}{end and '_' + end}"
        found[full] = _layout(full, part, found)
    for end, part in _OF_ACTIONS.items() if kind == "action" else ():
        full = f"{package}/action/{name}_{end}"
        found[full] = _layout(full, [line.format(f"{package}/action/{name}") for line in part], found)


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
        most = 0
        if match["most"]:
            count, most = 0, count or 0
        fields.append(Field(match["name"], kind, count, type(default)(match["value"] or default), most))
    return Layout(name, tuple(fields), constants)


def _kind(package: str, written: str, known: Mapping[str, Layout]) -> Kind:
    if written == "string":
        return str
    if written in PRIMITIVES:
        return PRIMITIVES[written]
    if written.count("/") == 2:
        return known[written]
    owner, _, short = written.rpartition("/")
    return known[f"{owner or package}/msg/{short}"]
