"""List of the functions that embedded scripts find under ``sim`` and the other namespaces, read from the code.

In a method's docstring, the text after ``Partly:``, ``Stand-in:`` or ``Not here:`` is the difference from the original;
a method without these marks behaves as the original does. A stand-in accepts the call and changes nothing that a
client sees.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cache
from types import MappingProxyType

from simx_server import sim_api as api
from simx_server.scripting.signature import Parameter, Signature
from simx_server.sim_api.namespaces import constants, signatures
from simx_server.sim_api.properties import listing


class Support(StrEnum):
    """Degree to which a function is implemented."""

    FULL = "full"
    PARTLY = "partly"
    STAND_IN = "stand-in"
    NONE = "no"


LONG = 6
"""Words of a description that the page does not repeat in another section."""

_MARKS = {Support.NONE: "Not here:", Support.STAND_IN: "Stand-in:", Support.PARTLY: "Partly:"}

PAGE = """\
# What embedded scripts can call

Made by `simx-server --script-functions --markdown > docs/script-functions.md`; a test holds it fresh.
{count}.

Lua and Python scripts see the same functions. Every function of `sim` also has its old flat name in Lua, made from the
new one: `sim.getObjectPosition` is `simGetObjectPosition`. A value behind `=` replaces an argument that is missing or
nil. A function that is not listed raises an error that names it. A stand-in lets a script run that only dresses
V-REP's window or serves a missing program: it keeps values, and logs once what is missing. Functions without a mark
are there in full, unless the heading says stand-ins; functions without a text do what their names say. A function
without parentheses has the arguments of the next one.

{sections}
"""


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


def as_text(lines: list[ScriptFunction]) -> str:
    """Return a table for people, with a count at its end."""
    width = max(len(line.name) for line in lines)
    rows = [f"{line.name:{width}}  {line.support:8}  {line.differs or line.doc}".rstrip() for line in lines]
    return "\n".join([*rows, _count(lines)])


def as_records(lines: list[ScriptFunction]) -> list[dict[str, object]]:
    """Return the lines for programs, ready for json.dumps."""
    return [asdict(line) for line in lines]


def as_markdown(lines: list[ScriptFunction]) -> str:
    """Return the page docs/script-functions.md."""
    sections: list[str] = []
    main = {_description(line): line.name for line in lines}
    for space in api.NAMESPACES:
        of_space = [line for line in lines if line.name.startswith(f"{space}.")]
        for topic in dict.fromkeys(line.topic for line in of_space):
            section = [line for line in of_space if line.topic == topic]
            are_stand_ins = all(line.support is Support.STAND_IN for line in section)
            heading = f"## `{space}`: {topic}{', stand-ins' if are_stand_ins else ''}"
            entries = _entries(section, main, has_marks=not are_stand_ins)
            sections.append("\n".join([heading, "", *entries]))
    sections.append(listing.as_markdown())
    return PAGE.format(count=_count(lines), sections="\n\n".join(sections))


def _entries(lines: Sequence[ScriptFunction], main: Mapping[str, str], *, has_marks: bool) -> list[str]:
    """Return one entry for each description, with all functions that it holds for; those without one come last.

    Args:
        lines: The functions of a section.
        main: Description to the function that has it on the page; those of other sections refer to this one.
        has_marks: Whether each entry says how much of the function is there.
    """
    groups: dict[str, list[ScriptFunction]] = {}
    here = {line.name for line in lines}
    for line in lines:
        text = _description(line, has_mark=has_marks)
        if line.support is not Support.STAND_IN and len(text.split()) > LONG and main[text] not in here:
            text = f"As `{main[text]}`."
        groups.setdefault(text, []).append(line)
    plain = groups.pop("", [])
    found = [f"* {_calls(functions)}: {description}" for description, functions in groups.items()]
    return [*found, *([f"* {_calls(plain)}"] if plain else [])]


def _calls(functions: Sequence[ScriptFunction]) -> str:
    """Return the functions with their arguments; those of the same arguments stand together, the last one has them."""
    names: dict[str, list[str]] = {}
    for each in functions:
        names.setdefault(each.arguments, []).append(each.name)
    calls = {f"{same[-1]}({arguments})": same[:-1] for arguments, same in names.items()}
    return "; ".join(", ".join(f"`{name}`" for name in [*others, call]) for call, others in calls.items())


def _description(line: ScriptFunction, *, has_mark: bool = True) -> str:
    level = f"*{line.support}*" if has_mark and line.support is not Support.FULL else ""
    differs = f"*{line.differs}*" if line.differs else ""
    return " ".join(text for text in (level, line.doc, differs) if text)


def _count(lines: list[ScriptFunction]) -> str:
    full, partly, stand_in, none = (sum(line.support is level for line in lines) for level in Support)
    return (
        f"{full} functions are there in full, {partly} partly, {stand_in} as stand-ins, {none} only as an error that "
        "says so"
    )
