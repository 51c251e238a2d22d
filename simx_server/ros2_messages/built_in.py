"""The layouts that the server has, read from the texts in `definitions/`.

A text holds the messages of one package. A line without indentation names a message, service or action; the indented
lines below it are its definition, as in ROS 2's own files.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from .grammar import read_interface, unknown_type
from .layouts import Layout

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

_KINDS = {1: "msg", 2: "srv", 3: "action"}


def read_layouts(*, humble: bool = False, older: bool = False) -> dict[str, Layout]:
    """Return all layouts by name.

    A service `std_srvs/srv/Trigger` gives two, ending in `_Request` and `_Response`. An action gives those of its goal,
    result and feedback, and those of its two services and of its topic.

    Args:
        humble: as ROS 2 Humble has them.
        older: as earlier releases of packages have them.
    """
    found: dict[str, Layout] = {}

    def find(name: str) -> Layout:
        if name not in found:
            raise unknown_type(name, found)
        return found[name]

    for text in (*_PACKAGES, *(HUMBLE if humble else OLDER if older else ())):
        package = text.rpartition("/")[2]
        for name, lines in _sections((_FOLDER / f"{text}.txt").read_text(encoding="utf-8")):
            kind = _KINDS[1 + lines.count("---")]
            for layout in read_interface(package, kind, name, lines, find):
                found[layout.name] = layout
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
