"""Words of a command line as arguments of a function, by their kinds and meanings in the table.

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
from simx_client.protocol import constants, kinds
from simx_client.protocol.commands import BY_NAME, Command, Effect, Value
from simx_client.protocol.kinds import Kind
from simx_client.protocol.nearest import did_you_mean
from simx_client.protocol.table.meanings import REQUIRED

LookUp = Callable[[str, str], int]
"""From the name of a function that finds handles, and an object's name, to the handle. May raise SimxError."""

_SWITCHES = {
    **dict.fromkeys(("1", "yes", "true", "on"), True),
    **dict.fromkeys(("0", "no", "false", "off"), False),
}
_NEGATIVE = re.compile(r"-[\d.]")


class WrongUse(SimxError):
    """The command line asks for something that cannot be; says what is valid."""


def add_arguments(parser: argparse.ArgumentParser, function: str) -> None:
    """Add FUNCTION, whose help is given, and ARGS."""
    parser.add_argument("function", metavar="FUNCTION", help=function)
    parser.add_argument("arguments", nargs="*", metavar="ARGS", help="all but client id and operation mode")


def shielded(words: Sequence[str]) -> list[str]:
    """Return the words, with words like ``-1,2`` marked so that argparse reads no flags in them; `bare` removes the
    marks."""
    return [f" {word}" if _NEGATIVE.match(word) else word for word in words]


def bare(words: Sequence[str]) -> list[str]:
    """Return the words as they were typed."""
    return [word[1:] if word.startswith(" ") and _NEGATIVE.match(word[1:]) else word for word in words]


def is_callable(command: Command) -> bool:
    """Return whether the function sends a request to a server, so that a separate connection can call it."""
    return command.effect is not Effect.NOTHING


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
    """Return the arguments that the user types."""
    return [each for each in command.arguments if not each.meaning.automatic]


def parse(command: Command, words: Sequence[str], look_up: LookUp) -> list[Any]:
    """Return the arguments parsed from words, in order.

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
        if argument.meaning.omitted is REQUIRED:
            raise WrongUse(f"{usage(command)}; {argument.name} is missing")
        values.append(argument.meaning.omitted)
    return values


def check(command: Command, words: Sequence[str]) -> None:
    """Check the words alone, before the names are looked up in a simulator. Raises WrongUse."""
    parse(command, words, lambda finder, name: 0)


def usage(command: Command) -> str:
    """Return the usage of the function, in words."""
    arguments = wanted(command)
    if not arguments:
        return f"{command.name} takes no arguments"
    return f"{command.name} takes " + ", ".join(f"{each.name} ({_form(each)})" for each in arguments)


def _form(argument: Value) -> str:
    kind = argument.kind.optional or argument.kind
    if argument.meaning.finder:
        return "names or handles: a,b" if kind is kinds.INTS else "a name or a handle"
    if kind.length:
        return f"{kind.length} numbers: {','.join(map(str, range(1, kind.length + 1)))}"
    return _FORMS.get(kind.name, kind.meaning)


_FORMS = {
    kinds.INTS.name: "whole numbers: 1,2",
    kinds.FLOATS.name: "numbers: 0.5,2",
    kinds.TEXTS.name: "texts: a,b",
    kinds.BOOL.name: "yes or no",
}


def _read(command: Command, argument: Value, word: str, look_up: LookUp) -> Any:
    kind = argument.kind
    if kind.optional is not None:
        if word.lower() == "none":
            return None
        kind = kind.optional
    if kind.is_image:
        raise WrongUse(f"{command.name}: {argument.name} is an image and cannot be given on a command line")
    try:
        value = _value(kind, word, argument.meaning.finder, look_up)
    except (ValueError, KeyError):
        raise WrongUse(
            f"{command.name}: {argument.name} cannot be {word!r}; valid: {_form(argument)}"
        ) from None
    if kind.length and len(value) != kind.length:
        raise WrongUse(
            f"{command.name}: {argument.name} has {kind.length} numbers, {len(value)} were given: {word!r}"
        )
    return value


def _value(kind: Kind, word: str, finder: str, look_up: LookUp) -> Any:
    if kind is kinds.INT:
        return _whole(word, finder, look_up)
    if kind is kinds.FLOAT:
        return _number(word)
    if kind is kinds.BOOL:
        return _SWITCHES[word.lower()]
    if kind is kinds.BYTES:
        return word.encode("utf-8", "surrogateescape")
    if kind is kinds.TEXTS:
        return _items(word)
    if kind.annotation == kinds.INTS.annotation:
        return [_whole(each, finder, look_up) for each in _items(word)]
    if kind.annotation == kinds.FLOATS.annotation:
        return [_number(each) for each in _items(word)]
    return word


def _whole(word: str, finder: str, look_up: LookUp) -> int:
    try:
        return int(word, 0)
    except ValueError:
        pass
    if word.startswith(("sim_", "simx_")) and isinstance(value := getattr(constants, word, None), int):
        return value
    if not finder:
        raise ValueError(word)
    return look_up(finder, word)


def _number(word: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(word)
    return value


def _items(word: str) -> list[str]:
    return [each.strip() for each in word.split(",")] if word.strip() else []
