"""One setting: how it is spelled, and how a person's text becomes its value.

The rules raise ValueError for a text they cannot use; :meth:`Setting.read` says the rest.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from simx_client.protocol.nearest import did_you_mean

LARGEST_SIDE = 4096
"""Pixels: what a picture may have, see sensors/picture.py."""


class SettingError(ValueError):
    """A setting has a value that cannot be used; the text says where it came from and what is valid."""


@dataclass(frozen=True, slots=True)
class Setting:
    """How one field of :class:`Settings` is read."""

    flag: str
    """``--speed``, or an upper-case word for a positional argument."""

    help: str
    valid: str
    """What a good value looks like; completes "valid: ..." in an error."""

    parse: Callable[[str], Any]
    """Text to value; raises ValueError for a bad one."""

    metavar: str = ""
    letter: str = ""
    """One-letter form of the flag, with its dash."""

    many: bool = False
    """The flag may be repeated; the variable then holds a list divided by commas or blanks."""

    shortcuts: Mapping[str, str] = field(default_factory=dict[str, str])
    """Further flags without a value that stand for one: ``-v`` for ``debug``."""

    unset: str = ""
    """What None means, for people."""

    lone: str = ""
    """What the flag means when no value follows it."""

    heading: str = ""
    """Of the group of flags in the help that this setting begins; empty: it belongs to the group before it."""

    words: tuple[str, ...] = ()
    """Words that a value may be, or begin with before a ``=``: the nearest is suggested in an error."""

    is_told_elsewhere: bool = False
    """The help of another flag names it: a screen has few lines."""

    @property
    def is_positional(self) -> bool:
        return not self.flag.startswith("-")

    @property
    def is_switch(self) -> bool:
        return self.parse is yes_or_no

    @property
    def variable(self) -> str:
        return "SIMX_" + self.flag.lstrip("-").upper().replace("-", "_")

    def read(self, text: str, origin: str) -> Any:
        """The value that `text` stands for; SettingError names `origin` and what is valid."""
        try:
            return self.parse(text)
        except ValueError:
            word = text.partition("=")[0]
            meant = (did_you_mean(word, self.words) if word not in self.words else "") or ";"
            raise SettingError(f"{origin}: {text!r} cannot be used{meant} valid: {self.valid}") from None


def yes_or_no(text: str) -> bool:
    word = text.strip().lower()
    if word in ("1", "yes", "true", "on"):
        return True
    if word in ("0", "no", "false", "off"):
        return False
    raise ValueError(text)


def only_yes(text: str) -> bool:
    if not yes_or_no(text):
        raise ValueError(text)
    return True


def port(text: str) -> int:
    number = int(text)
    if not 0 <= number <= 65535:
        raise ValueError(text)
    return number


def between(least: int, most: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        number = int(text)
        if not least <= number <= most:
            raise ValueError(text)
        return number

    return parse


def between_numbers(least: float, most: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        number = float(text)
        if not least <= number <= most:
            raise ValueError(text)
        return number

    return parse


def positive(text: str) -> float:
    number = float(text)
    if not (0.0 < number < math.inf):
        raise ValueError(text)
    return number


def web_address(text: str) -> str:
    """``HOST:PORT`` of a page; of a port alone this host's own."""
    host, colon, number = text.strip().rpartition(":")
    if colon and not host:
        raise ValueError(text)
    return f"{host or '127.0.0.1'}:{port(number)}"


def speed(text: str) -> float:
    return math.inf if text.strip().lower() == "max" else positive(text)


def matching(pattern: str) -> Callable[[str], str]:
    def parse(text: str) -> str:
        if not re.fullmatch(pattern, text):
            raise ValueError(text)
        return text

    return parse


def file(text: str) -> Path:
    path = Path(text).expanduser()
    if not path.is_file():
        raise ValueError(text)
    return path.resolve()


def new_file(text: str) -> Path:
    path = Path(text).expanduser()
    if path.is_dir() or not path.parent.is_dir():
        raise ValueError(text)
    return path.resolve()


def new_file_ending(ending: str) -> Callable[[str], Path]:
    def parse(text: str) -> Path:
        path = new_file(text)
        if path.suffix.lower() != ending:
            raise ValueError(text)
        return path

    return parse


def picture_size(text: str) -> tuple[int, int]:
    width, height = (int(side) for side in text.lower().split("x"))
    if not (16 <= width <= LARGEST_SIDE and 16 <= height <= LARGEST_SIDE):
        raise ValueError(text)
    return width, height


def folder(text: str) -> Path:
    path = Path(text).expanduser()
    if not path.is_dir():
        raise ValueError(text)
    return path.resolve()


def package(text: str) -> str:
    """``NAME=DIR`` of an existing folder, which comes back in full."""
    name, sign, path = text.partition("=")
    if not sign or not re.fullmatch(r"[^/\\\s]+", name.strip()) or not path.strip():
        raise ValueError(text)
    return f"{name.strip()}={folder(path.strip())}"


def one_of(words: tuple[str, ...]) -> Callable[[str], str]:
    def parse(text: str) -> str:
        word = text.strip().lower()
        if word not in words:
            raise ValueError(text)
        return word

    return parse
