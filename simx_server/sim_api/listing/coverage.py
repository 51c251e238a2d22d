"""List of the functions that embedded scripts find under ``sim`` and the other namespaces, read from the code.

In a method's docstring, the text after ``Partly:``, ``Stand-in:`` or ``Not here:`` is the difference from the original;
a method without these marks behaves as the original does. A stand-in accepts the call and changes nothing that a
client sees.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from types import MappingProxyType

from simx_server import sim_api as api
from simx_server.scripting.conversion.signature import Parameter, Signature
from simx_server.sim_api.namespaces import constants, signatures


class Support(StrEnum):
    """Degree to which a function is implemented."""

    FULL = "full"
    PARTLY = "partly"
    STAND_IN = "stand-in"
    NONE = "no"


_MARKS = {Support.NONE: "Not here:", Support.STAND_IN: "Stand-in:", Support.PARTLY: "Partly:"}


@dataclass(frozen=True, slots=True)
class ScriptFunction:
    """One line of the listing."""

    name: str
    """Name with its namespace."""
    arguments: str
    topic: str
    support: Support
    doc: str
    differs: str
    """Difference from the original, if the function is not fully implemented."""


def script_functions() -> list[ScriptFunction]:
    """Return all functions, by topic in the order of the files of `sim_api/`."""
    found: list[ScriptFunction] = []
    for space, kind in api.NAMESPACES.items():
        known = signatures(space)
        for part in kind.__mro__:
            for name in vars(part):
                if name in known and getattr(kind, name) is vars(part)[name]:
                    found.append(_describe(space, name, known[name], part, vars(part)[name]))
    return found


@cache
def descriptions() -> Mapping[str, str]:
    """Return for each function, by its full name, its arguments and what it does, and for each constant its value."""
    found = {
        f"{space}.{name}": f"{space}.{name} = {value}"
        for space in api.NAMESPACES
        for name, value in constants(space).items()
    }
    for line in script_functions():
        tip = f"{line.name}({line.arguments})"
        found[line.name] = "\n".join(text for text in (tip, line.doc, line.differs) if text)
    return MappingProxyType(found)


def _describe(space: str, name: str, signature: Signature, part: type, method: object) -> ScriptFunction:
    text = " ".join((inspect.getdoc(method) or "").split())
    support, doc, differs = Support.FULL, text, ""
    for level, mark in _MARKS.items():
        if mark in text:
            doc, _, differs = text.partition(mark)
            support = level
            break
    arguments = ", ".join(_argument(parameter) for parameter in signature.parameters)
    topic = _topic(space, part.__name__.removesuffix("Functions").removesuffix("Namespace"))
    return ScriptFunction(f"{space}.{name}", arguments, topic, support, doc.strip(), differs.strip())


_WORD = re.compile(r"[A-Z]+\d*(?![a-z])|[A-Z][a-z]+\d*")
_ACRONYMS: Mapping[str, str] = {
    each.lower(): each
    for each in ("API", "IK", "OMPL", "ROS", "ROS2", "UI", "UIs", "B0", "CHAI3D", "MTB", "ZMQ")
}


def _topic(space: str, name: str) -> str:
    """Return the words of a class's name, such as custom UI; "basic" for the one of the namespace itself."""
    if name.lower() == space.lower() or f"sim{name}".lower() == space.lower():
        return "basic functions"
    found: list[str] = _WORD.findall(name)
    words = [_ACRONYMS.get(word.lower(), word.lower()) for word in found]
    return " ".join(words)


def _argument(parameter: Parameter) -> str:
    name = parameter.name.lstrip("_")
    if parameter.default is inspect.Parameter.empty:
        return name
    return f"{name}={'nil' if parameter.default is None else parameter.default}"


def count(lines: list[ScriptFunction]) -> str:
    full, partly, stand_in, none = (sum(line.support is level for line in lines) for level in Support)
    return (
        f"{full} functions are there in full, {partly} partly, {stand_in} as stand-ins, {none} only as an error that "
        "says so"
    )
