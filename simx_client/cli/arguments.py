"""Words of a command line as arguments of a function, by their kinds in the table.

Numbers as they are, lists as ``1,2,3``, switches as ``yes`` or ``no``. Where a handle is wanted, a name is looked up
in the scene; where any other whole number is wanted, a legacy constant may be named.
"""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable, Sequence
from typing import Any

from simx_client.errors import SimxError
from simx_client.protocol import constants
from simx_client.protocol.commands import BY_NAME, Command, Place, Value
from simx_client.protocol.nearest import did_you_mean

LookUp = Callable[[str, str], int]
"""From the name of a function that finds handles, and an object's name, to the handle. May raise SimxError."""

OMITTED: dict[str, Any] = {
    "relativeToObjectHandle": -1,
    "options": 0,
    "timeOutInMs": 5000,
    "inputInts": [],
    "inputFloats": [],
    "inputStrings": [],
    "inputBuffer": b"",
}
"""What the last arguments are when they are left out; ``optional_`` kinds are None."""

_FINDERS = {
    "collisionObjectHandle": "simxGetCollisionHandle",
    "distanceObjectHandle": "simxGetDistanceHandle",
    "uiHandle": "simxGetUIHandle",
}
_WITHOUT_NAMES = ("consoleHandle", "dialogHandle")
_HANDLES_TOO = ("parentObject", "entity1", "entity2")
_SWITCHES = {
    **dict.fromkeys(("1", "yes", "true", "on"), True),
    **dict.fromkeys(("0", "no", "false", "off"), False),
}
_NEGATIVE = re.compile(r"-[\d.]")
_PLAIN = ("simxStart", "simxFinish", "simxPauseCommunication")
"""Of no use in a connection that ends with the command."""


class WrongUse(SimxError):
    """The command line asks for something that cannot be; says what is valid."""


def add_arguments(parser: argparse.ArgumentParser, function: str) -> None:
    """Add FUNCTION, whose help is given, and ARGS."""
    parser.add_argument("function", metavar="FUNCTION", help=function)
    parser.add_argument("arguments", nargs="*", metavar="ARGS", help="all but client id and operation mode")


def shielded(words: Sequence[str]) -> list[str]:
    """The words with those like ``-1,2`` made such that argparse takes them for no flags; `bare` takes it back."""
    return [f" {word}" if _NEGATIVE.match(word) else word for word in words]


def bare(words: Sequence[str]) -> list[str]:
    """The words as they were typed."""
    return [word[1:] if word.startswith(" ") and _NEGATIVE.match(word[1:]) else word for word in words]


def is_callable(command: Command) -> bool:
    """Whether the function asks a server something, in a connection of its own."""
    if command.place is Place.LOCAL:
        return bool(command.results) and command.results[0].name == "rc" and command.name not in _PLAIN
    return True


def command_named(name: str) -> Command:
    """Return the function of a name. Raises WrongUse, with the nearest names."""
    command = BY_NAME.get(name)
    if command is None:
        meant = did_you_mean("simx" + name.removeprefix("simx"), BY_NAME) or ";"
        raise WrongUse(f"there is no function {name}{meant} simx-server --commands lists them all")
    if not is_callable(command):
        raise WrongUse(
            f"{name} does its work within a script, and asks the server for nothing; call another one"
        )
    return command


def wanted(command: Command) -> list[Value]:
    """The arguments that are given by hand."""
    return [each for each in command.arguments if each.name not in ("clientID", "operationMode", "timeOut")]


def parse(command: Command, words: Sequence[str], look_up: LookUp) -> list[Any]:
    """The arguments out of words, in order.

    Raises:
        WrongUse: there are too few or too many, or one cannot be read.
        SimxError: a name could not be looked up.
    """
    arguments = wanted(command)
    if len(words) > len(arguments):
        raise WrongUse(f"{usage(command)}; {len(words)} arguments were given")
    values = [
        _read(command, argument, word, look_up) for argument, word in zip(arguments, words, strict=False)
    ]
    for argument in arguments[len(words) :]:
        if argument.name in OMITTED:
            values.append(OMITTED[argument.name])
        elif argument.kind.name.startswith("optional_"):
            values.append(None)
        else:
            raise WrongUse(f"{usage(command)}; {argument.name} is missing")
    return values


def check(command: Command, words: Sequence[str]) -> None:
    """What is wrong with the words by themselves, before a simulator is asked for names. Raises WrongUse."""
    parse(command, words, lambda finder, name: 0)


def usage(command: Command) -> str:
    """How the function is called, in words."""
    arguments = wanted(command)
    if not arguments:
        return f"{command.name} takes no arguments"
    return f"{command.name} takes " + ", ".join(f"{each.name} ({_form(each)})" for each in arguments)


def finder_of(argument: Value) -> str | None:
    """The function that looks up a name for this argument; None where no name stands for a handle."""
    if argument.kind.name not in ("int", "ints") or argument.name in _WITHOUT_NAMES:
        return None
    if argument.name in _FINDERS:
        return _FINDERS[argument.name]
    is_handle = argument.name.endswith(("Handle", "Handles")) or argument.name in _HANDLES_TOO
    return "simxGetObjectHandle" if is_handle else None


def _form(argument: Value) -> str:
    kind = argument.kind.name.removeprefix("optional_")
    if finder_of(argument) is not None:
        return "names or handles: a,b" if kind == "ints" else "a name or a handle"
    length = _length(argument)
    if length:
        return f"{length} numbers: {','.join(map(str, range(1, length + 1)))}"
    forms = {
        "ints": "whole numbers: 1,2",
        "floats": "numbers: 0.5,2",
        "texts": "texts: a,b",
        "bool": "yes or no",
    }
    return forms.get(kind, argument.kind.meaning)


def _length(argument: Value) -> int:
    """Of kinds with a fixed number of elements, else 0."""
    found = re.fullmatch(r"(?:optional_)?(?:vector|matrix|ints|floats)(\d+)", argument.kind.name)
    return int(found[1]) if found else 0


def _read(command: Command, argument: Value, word: str, look_up: LookUp) -> Any:
    kind = argument.kind.name
    if kind.startswith("optional_"):
        if word.lower() == "none":
            return None
        kind = kind.removeprefix("optional_")
    finder = finder_of(argument)
    try:
        if kind == "int":
            return _whole(word, finder, look_up)
        if kind == "ints":
            return [_whole(each, finder, look_up) for each in _items(word)]
        if kind == "float":
            return _number(word)
        if kind == "bool":
            return _SWITCHES[word.lower()]
        if kind == "text":
            return word
        if kind == "bytes":
            return word.encode("utf-8", "surrogateescape")
        if kind == "texts":
            return _items(word)
        if kind == "pixels":
            raise WrongUse(f"{command.name}: {argument.name} is a picture, which no command line can hold")
        values = [int(each, 0) if kind.startswith("ints") else _number(each) for each in _items(word)]
    except (ValueError, KeyError):
        raise WrongUse(
            f"{command.name}: {argument.name} cannot be {word!r}; valid: {_form(argument)}"
        ) from None
    length = _length(argument)
    if length and len(values) != length:
        raise WrongUse(
            f"{command.name}: {argument.name} has {length} numbers, {len(values)} were given: {word!r}"
        )
    return values


def _whole(word: str, finder: str | None, look_up: LookUp) -> int:
    try:
        return int(word, 0)
    except ValueError:
        pass
    if word.startswith(("sim_", "simx_")) and isinstance(value := getattr(constants, word, None), int):
        return value
    if finder is None:
        raise ValueError(word)
    return look_up(finder, word)


def _number(word: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(word)
    return value


def _items(word: str) -> list[str]:
    return [each.strip() for each in word.split(",")] if word.strip() else []
