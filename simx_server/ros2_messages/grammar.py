"""Read definitions of messages, services and actions as ROS 2's own files have them.

A line is `type name`, `type name default`, or `type NAME=value` for a constant. A type that ends in `[]` is a sequence,
in `[<=9]` one of at most nine values, in `[9]` an array of nine; `string<=9` has at most nine characters. In a service
a line `---` parts request and response; an action has two of them, which part goal, result and feedback.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from types import MappingProxyType
from typing import TypeAlias

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import StartError

from .layouts import Field, Kind, Layout, Value, WideString
from .primitives import PRIMITIVES, Primitive

Find: TypeAlias = Callable[[str], Layout]
"""Returns the layout of a full name, such as `std_msgs/msg/Header`. Raises DefinitionError."""

PARTS = {"msg": ("",), "srv": ("_Request", "_Response"), "action": ("_Goal", "_Result", "_Feedback")}
"""The ends of the names of what a definition has, in the order of its text."""

_OF_ACTIONS = {
    "SendGoal_Request": ("unique_identifier_msgs/UUID goal_id", "{0}_Goal goal"),
    "SendGoal_Response": ("bool accepted", "builtin_interfaces/Time stamp"),
    "GetResult_Request": ("unique_identifier_msgs/UUID goal_id",),
    "GetResult_Response": ("int8 status", "{0}_Result result"),
    "FeedbackMessage": ("unique_identifier_msgs/UUID goal_id", "{0}_Feedback feedback"),
}
"""The messages of every action, with its name for {0}."""

_LINE = re.compile(
    r"(?P<kind>[A-Za-z][\w/]*)(?:<=(?P<longest>\d{1,9}))?"
    r"(?P<array>\[(?:(?P<most><=)?(?P<count>\d{1,9}))?\])?"
    r"\s+(?P<name>[A-Za-z]\w*)(?:\s*=\s*(?P<constant>.*)|\s+(?P<default>[^=\s].*))?"
)
_FIELD_NAME = re.compile(r"[a-z](?:_?[a-z0-9])*")
_CONSTANT_NAME = re.compile(r"[A-Z](?:_?[A-Z0-9])*")
_ITEM = re.compile(r"\s*(\"(?:[^\"\\]|\\.)*\"|'(?:[^'\\]|\\.)*'|[^,]*)\s*(?:,|$)")
_STRINGS = {"string": str, "wstring": WideString}
_TRUTH = {"true": True, "1": True, "false": False, "0": False}


class DefinitionError(StartError):
    """A definition cannot be used; the text names it, and says what is wrong."""


def read_interface(package: str, kind: str, name: str, lines: Iterable[str], find: Find) -> Iterator[Layout]:
    """Yield the layouts of a definition; those of an action include its services and its topic.

    Args:
        kind: `msg`, `srv` or `action`.
        name: without package and kind.
        lines: of the text, with or without comments.
        find: returns other layouts, and those that were yielded before.

    Raises:
        DefinitionError: it is not a definition.
    """
    full = f"{package}/{kind}/{name}"
    parts: list[list[str]] = [[]]
    for line in lines:
        content = line.partition("#")[0].strip()
        if content == "---":
            parts.append([])
        elif content:
            parts[-1].append(content)
    ends = PARTS[kind]
    if len(parts) != len(ends):
        raise DefinitionError(
            f"{full}: it has {len(parts) - 1} lines with ---, and a definition of this kind has {len(ends) - 1}"
        )
    for end, part in zip(ends, parts, strict=True):
        yield _layout(full + end, part, find)
    for end, part in _OF_ACTIONS.items() if kind == "action" else ():
        yield _layout(f"{full}_{end}", [line.format(full) for line in part], find)


def _layout(name: str, lines: Iterable[str], find: Find) -> Layout:
    fields: dict[str, Field] = {}
    constants: dict[str, Value] = {}
    for line in lines:
        match = _LINE.fullmatch(line)
        if match is None:
            raise DefinitionError(f"{name}: {line[:100]!r} is not the definition of a field or constant")
        field = match["name"]
        if field in fields or field in constants:
            raise DefinitionError(f"{name}: {field[:100]} is defined twice")
        pattern = _FIELD_NAME if match["constant"] is None else _CONSTANT_NAME
        if not pattern.fullmatch(field):
            raise DefinitionError(
                f"{name}: {field[:100]!r} is not a name; valid are lower case for fields, upper case for constants, "
                "and single underscores between letters and digits"
            )
        if match["constant"] is None:
            fields[field] = _field(name, match, find)
        else:
            constants[field] = _constant(name, match)
    return Layout(name, tuple(fields.values()), MappingProxyType(constants))


def _field(owner: str, match: re.Match[str], find: Find) -> Field:
    kind = _kind(owner, match["kind"], find)
    longest = int(match["longest"] or 0)
    if match["longest"] and kind not in _STRINGS.values():
        raise DefinitionError(f"{owner}: only strings have a limit such as <={longest} behind their type")
    is_array = match["array"] is not None
    number = int(match["count"] or 0)
    if match["count"] and not number:
        raise DefinitionError(f"{owner}: field {match['name']}: an array has at least one value")
    count, most = (None, 0) if not is_array else (0, number) if match["most"] else (number, 0)
    default = _default(owner, match, kind, is_array)
    if (
        isinstance(default, tuple)
        and default
        and ((most and len(default) > most) or count not in (0, len(default)))
    ):
        raise DefinitionError(f"{owner}: field {match['name']}: its default has {len(default)} values")
    texts = default if isinstance(default, tuple) else (default,)
    if longest and any(len(str(each)) > longest for each in texts):
        raise DefinitionError(
            f"{owner}: field {match['name']}: its default has more than {longest} characters"
        )
    return Field(match["name"], kind, count, default, most, longest)


def _kind(owner: str, written: str, find: Find) -> Kind:
    if written in _STRINGS:
        return _STRINGS[written]
    if written in PRIMITIVES:
        return PRIMITIVES[written]
    if written.count("/") == 2:
        return find(written)
    package, _, short = written.rpartition("/")
    return find(f"{package or owner.partition('/')[0]}/msg/{short}")


def _default(owner: str, match: re.Match[str], kind: Kind, is_array: bool) -> Value | tuple[Value, ...]:
    text = (match["default"] or "").strip()
    if not text:
        return () if is_array else kind.default if isinstance(kind, Primitive) else ""
    if isinstance(kind, Layout):
        raise DefinitionError(f"{owner}: field {match['name']}: a message within a message has no default")
    if not is_array:
        return _value(owner, match["name"], kind, text)
    if not (text.startswith("[") and text.endswith("]")):
        raise DefinitionError(
            f"{owner}: field {match['name']}: the default of an array is a list in brackets"
        )
    return tuple(_value(owner, match["name"], kind, item) for item in _items(text[1:-1]))


def _items(text: str) -> Iterator[str]:
    at = 0
    while at < len(text) and (match := _ITEM.match(text, at)):
        if not match[1].strip() and match.end() == len(text):
            return
        yield match[1].strip()
        at = match.end()


def _constant(owner: str, match: re.Match[str]) -> Value:
    written = match["kind"]
    if match["array"] is not None or (written not in PRIMITIVES and written not in _STRINGS):
        raise DefinitionError(f"{owner}: constant {match['name']} is not a single plain value")
    kind = _STRINGS.get(written) or PRIMITIVES[written]
    return _value(owner, match["name"], kind, match["constant"].strip())


def _value(owner: str, name: str, kind: Primitive | type[str], text: str) -> Value:
    """Return the value of a default or constant."""
    if not isinstance(kind, Primitive):
        return _text(text)
    try:
        value = _number(kind, text)
    except (ValueError, KeyError):
        raise DefinitionError(f"{owner}: {name}: {text[:60]!r} is not a value of {kind.name}") from None
    if kind.least is not None and kind.most is not None and not kind.least <= value <= kind.most:
        raise DefinitionError(f"{owner}: {name}: {value} is not from {kind.least} to {kind.most}")
    return value


def _number(kind: Primitive, text: str) -> bool | int | float:
    if kind.letter == "?":
        return _TRUTH[text.lower()]
    if kind.least is None:
        return float(text)
    try:
        return int(text)
    except ValueError:
        return int(text, 0)


def _text(text: str) -> str:
    for quote in "\"'":
        if len(text) > 1 and text.startswith(quote) and text.endswith(quote):
            return text[1:-1].replace(f"\\{quote}", quote)
    return text


def unknown_type(name: str, known: Iterable[str], owner: str = "") -> DefinitionError:
    """Return the error for a type that is not known."""
    where = f"{owner}: " if owner else ""
    return DefinitionError(
        f"{where}the type '{name[:100]}' is not known; --ros2-messages takes folders with the packages of all types"
        f"{did_you_mean(name, [*known])}"
    )
