"""The members of a namespace as lines of a stub: functions with their types and texts, constants with their values."""

from __future__ import annotations

import inspect
import keyword
import re
import textwrap
import typing
from collections.abc import Callable, Container, Iterator, Mapping
from typing import Any, cast

from simx_server import sim_api as api
from simx_server.gateways.zmq.listing import namespace
from simx_server.sim_api.listing.coverage import ScriptFunction, Support, script_functions
from simx_server.sim_api.properties.property_types import TYPES

from .annotations import ANY, argument, result

_WIDTH = 110

_PROPERTIES: Mapping[str, str] = {
    "bool": "bool",
    "integer": "int",
    "float": "float",
    "text": "str",
    "integers": "list[int]",
    "texts": "list[str]",
    "table": ANY,
}
"""Types of properties by family; those of the others hold lists of numbers."""

_PROPERTY = re.compile(r"get(\w+)Property")

OLD_NAME = re.compile(r"ext[A-Z]")
"""Start of V-REP 3's names of plug-ins' functions (``simExtRemoteApiStart``); clients use the plug-ins' namespaces."""

BY_THE_GATEWAY: Mapping[str, str] = {
    "sim.setStepping": "(self, enable: bool | int = True, /) -> int",
    "sim.step": "(self, wait: bool = True, /) -> None",
    "sim.switchThread": "(self) -> None",
    "sim.testCB": "(self, first: Any, function: Callable[[Any, Any], Any], second: Any, times: int = 99, /) -> Any",
    "sim.handleExtCalls": "(self) -> None",
    "sim.readCustomDataBlock": "(self, handle: int, tag: str, /) -> bytes",
}
"""Functions that behave otherwise for clients than for scripts, or that only clients have."""


def constants(space: str) -> Iterator[str]:
    """Yield the lines of the class with the constants of a namespace, none for one without constants."""
    for name, content in namespace(space).items():
        if "const" in content:
            yield f"    {name}: Final = {content['const']!r}"
        elif "func" not in content:
            yield f"    class {name}:"
            for inner, value in content.items():
                if not keyword.iskeyword(inner):
                    yield f"        {inner}: Final = {value['const']!r}"


def functions(space: str, *, without: Container[str] = (), is_async: bool = False) -> Iterator[str]:
    """Yield the lines of the class with the functions of a namespace.

    Args:
        space: Its name.
        without: Names to leave out.
        is_async: Calls return awaitables, and the lines have no texts: the other stub has them.
    """
    lines = {line.name: line for line in script_functions()}
    for name, content in namespace(space).items():
        if "func" not in content or name in without or OLD_NAME.match(name):
            continue
        if not name.isidentifier() or keyword.iskeyword(name):
            continue  # `sim.yield`: Python has no form for it
        line = None if is_async else lines.get(f"{space}.{name}")
        yield from _function(space, name, line, is_async=is_async)


def _function(space: str, name: str, line: ScriptFunction | None, *, is_async: bool) -> Iterator[str]:
    shape = BY_THE_GATEWAY.get(f"{space}.{name}") or _shape(space, name)
    definition = f"    {'async ' if is_async else ''}def {name}{shape}:"
    doc = _doc(line) if line else ""
    if not doc:
        yield f"{definition} ..."
        return
    yield definition
    yield from textwrap.wrap(
        f'{"r" if chr(92) in doc else ""}"""{doc}"""',
        _WIDTH,
        initial_indent=" " * 8,
        subsequent_indent=" " * 8,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _doc(line: ScriptFunction) -> str:
    mark = "" if line.support is Support.FULL else f"{_MARKS[line.support]}: {line.differs}"
    text = " ".join(each for each in (line.doc, mark) if each).replace('"""', "'''")
    return f"{text} " if text.endswith('"') else text


_MARKS = {Support.PARTLY: "Partly", Support.STAND_IN: "Stand-in", Support.NONE: "Not here"}


def _shape(space: str, name: str) -> str:
    """Return the parameters and the result. The client's functions take values by position only."""
    function = cast("Callable[..., Any]", getattr(api.NAMESPACES[space], name))
    hints = typing.get_type_hints(function, include_extras=True)
    parameters: list[str] = []
    rest = ""
    for each in list(inspect.signature(function).parameters.values())[1:]:
        hint = hints[each.name]
        if each.kind is inspect.Parameter.VAR_POSITIONAL:
            rest = f"*{each.name.lstrip('_')}: {argument(hint)}"
        elif each.default is inspect.Parameter.empty:
            parameters.append(f"{each.name.lstrip('_')}: {argument(hint)}")
        else:
            shown = _default(each.default)
            parameters.append(f"{each.name.lstrip('_')}: {argument(hint, is_optional=True)} = {shown}")
    listed = ", ".join(["self", *parameters, *(["/"] if parameters else []), *([rest] if rest else [])])
    return f"({listed}) -> {_returned(name, hints.get('return'))}"


def _returned(name: str, hint: Any) -> str:
    found = _PROPERTY.fullmatch(name)
    if found is None or found[1] not in TYPES:
        return result(hint)
    if found[1] == "Buffer":
        return "bytes"
    return _PROPERTIES.get(TYPES[found[1]].family, "list[float]")


def _default(value: Any) -> str:
    return repr(value) if value is None or isinstance(value, (bool, int, float, str)) else "..."
