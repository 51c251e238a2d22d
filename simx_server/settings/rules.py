"""The rules of one setting: how it is spelled, and how its text becomes a value.

The parse function of a rule raises ValueError for a text that it cannot use; :meth:`Setting.read` adds the rest.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from ipaddress import IPv4Address
from pathlib import Path
from typing import Any, TypeVar

from simx_client.protocol.nearest import did_you_mean
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import StartError

_T = TypeVar("_T")

FROM_ENVIRONMENT = "ROS_DOMAIN_ID"
"""Stands for the domain that this variable holds, 0 without it."""

LAST_ROS_DOMAIN = 232
"""The highest domain that ROS 2 allows."""

LARGEST_SIDE = 4096
"""Pixels of the longest side of an image, see scene/cameras/image.py."""


class SettingError(StartError, ValueError):
    """A setting has a value that cannot be used; the text gives its origin and the valid values."""


@dataclass(frozen=True, slots=True)
class Rule:
    """The valid values of a setting."""

    valid: str
    """A description of valid values; completes "valid: ..." in an error."""

    parse: Callable[[str], Any]
    """Text to value; raises ValueError for a bad one."""

    metavar: str = ""
    words: tuple[str, ...] = ()
    """Words that a value may be, or start with before a ``=``: an error suggests the nearest."""


@dataclass(frozen=True, slots=True)
class Setting(Rule):
    """The way in which one field of :class:`Settings` is read."""

    help: str = ""
    flag: str = ""
    """``--speed``, or an upper-case word for a positional argument; empty: made from the field's name."""

    letter: str = ""
    """One-letter form of the flag, with its dash."""

    many: bool = False
    """The flag may be repeated; the variable then holds a list divided by commas or blanks."""

    shortcuts: Mapping[str, str] = field(default_factory=dict[str, str])
    """Further flags without a value that stand for one: ``-v`` for ``debug``."""

    unset: str = ""
    """The meaning of None, for people."""

    lone: str = ""
    """The value when the flag is given without one."""

    heading: str = ""
    """The heading of the group of flags in the help that starts with this setting; empty: it belongs to the group
    before it.
    """

    is_told_elsewhere: bool = False
    """The help of another flag names it: a screen has few lines."""

    serves: bool = False
    """It has no meaning where no client is served."""

    needs_process: bool = False
    """It is for a server in a separate process, not for an embedded one."""

    def named(self, name: str) -> Setting:
        """Return the setting with the flag of the field of this name."""
        return replace(self, flag=self.flag or "--" + name.replace("_", "-"))

    @property
    def is_positional(self) -> bool:
        return not self.flag.startswith("-")

    @property
    def is_switch(self) -> bool:
        return self.parse is YES_OR_NO.parse

    @property
    def variable(self) -> str:
        return "SIMX_" + self.flag.lstrip("-").upper().replace("-", "_")

    def read(self, text: str, origin: str) -> Any:
        """Return the value of a text; SettingError names `origin` and what is valid."""
        try:
            return self.parse(text)
        except ValueError:
            word = text.partition("=")[0]
            meant = (did_you_mean(word, self.words) if word not in self.words else "") or ";"
            raise SettingError(f"{origin}: {text!r} cannot be used{meant} valid: {self.valid}") from None


def _that(convert: Callable[[str], _T], is_good: Callable[[_T], object]) -> Callable[[str], _T]:
    """Make a function that converts a text and refuses bad values."""

    def parse(text: str) -> _T:
        value = convert(text)
        if not is_good(value):
            raise ValueError(text)
        return value

    return parse


def _word(text: str) -> str:
    return text.strip().lower()


def _yes_or_no(text: str) -> bool:
    if (word := _word(text)) not in _WORDS:
        raise ValueError(text)
    return _WORDS[word]


def _path(is_good: Callable[[Path], bool]) -> Callable[[str], Path]:
    parse = _that(lambda text: Path(text).expanduser(), is_good)
    return lambda text: parse(text).resolve()


def between(least: float, most: float) -> Rule:
    """Make the rule for a number; both bounds are whole if it is."""
    kind, what = (int, "whole number") if isinstance(least, int) else (float, "number")
    parse = _that(kind, lambda number: least <= number <= most)
    return Rule(f"a {what} from {least:g} to {most:g}", parse, "N")


def seconds(example: str) -> Rule:
    return Rule(f"seconds greater than 0, such as {example}", _positive, "SECONDS")


def matching(pattern: str, valid: str, metavar: str) -> Rule:
    return Rule(valid, _that(str, lambda text: re.fullmatch(pattern, text)), metavar)


def endpoint(example: str) -> Rule:
    return matching(r"[a-z][a-z0-9-]*/\S+", f"PROTOCOL/ADDRESS, such as {example}", "ENDPOINT")


def file(valid: str) -> Rule:
    return Rule(valid, _path(Path.is_file), "FILE")


def new_file(*endings: str) -> Rule:
    """Make the rule for a file in an existing folder; the file may be missing; links are refused."""
    return Rule(
        "a file, no link, in an existing folder"
        + (f" whose name ends in {' or '.join(endings)}" if endings else ""),
        _path(
            lambda path: (
                not path.is_dir()
                and not path.is_symlink()
                and path.parent.is_dir()
                and path.name.lower().endswith(endings or "")
            )
        ),
        f"FILE{endings[0]}" if len(endings) == 1 else "FILE",
    )


def one_of(metavar: str, *words: str) -> Rule:
    return Rule(", ".join(words), _that(_word, words.__contains__), metavar, words)


def _package(text: str) -> str:
    """Check ``NAME=DIR`` and return it with the full path of the folder, which must exist."""
    name, sign, path = text.partition("=")
    if not sign or not re.fullmatch(r"[^/\\\s]+", name.strip()) or not path.strip():
        raise ValueError(text)
    return f"{name.strip()}={_folder(path.strip())}"


def _xacro(text: str) -> str:
    """Check ``NAME:=VALUE`` and return it; the value may be empty, and may contain spaces."""
    name, sign, value = text.partition(":=")
    if not sign or not re.fullmatch(r"[^\s:=]+", name.strip()):
        raise ValueError(text)
    return f"{name.strip()}:={value.strip()}"


def web_address(text: str) -> str:
    """Return ``HOST:PORT`` of the web viewer; a port alone means this host."""
    host, colon, number = text.strip().rpartition(":")
    if colon and not host:
        raise ValueError(text)
    return f"{host or '127.0.0.1'}:{PORT.parse(number)}"


def legacy_address(text: str) -> str:
    """Return ``HOST:PORT`` for clients of the original, which know IPv4 only; a port alone means this host."""
    address = web_address(text)
    IPv4Address(address.rpartition(":")[0])
    return address


def port_of(address: str) -> int:
    """Return the port of ``HOST:PORT``."""
    return int(address.rpartition(":")[2])


def next_address(address: str, number: int) -> str:
    """Return ``HOST:PORT`` with a port that is higher by a number; 0, a free one, stays."""
    host, _, port = address.rpartition(":")
    return f"{host}:{int(port) and int(port) + number}"


def _ros_domain(text: str) -> int | str:
    """Return a domain of ROS 2, or the word for that of the environment."""
    return FROM_ENVIRONMENT if text == FROM_ENVIRONMENT else int(between(0, LAST_ROS_DOMAIN).parse(text))


def _image_size(text: str) -> tuple[int, int]:
    width, height = map(_side, text.lower().split("x"))
    return width, height


_WORDS = {
    **dict.fromkeys(("1", "yes", "true", "on"), True),
    **dict.fromkeys(("0", "no", "false", "off"), False),
}
_positive = _that(float, lambda number: 0.0 < number < math.inf)
_folder = _path(Path.is_dir)
_side = _that(int, lambda side: 16 <= side <= LARGEST_SIDE)

YES_OR_NO = Rule("yes or no", _yes_or_no)
YES = Rule("yes; there is no window to ask for", _that(_yes_or_no, bool))
PORT = replace(between(0, 65535), metavar="PORT")
SPEED = Rule(
    "a number greater than 0, or max",
    lambda text: math.inf if _word(text) == "max" else _positive(text),
    "FACTOR",
    ("max",),
)
FOLDER = Rule("an existing folder", _folder, "FOLDER")
NEW_FOLDER = Rule(
    "a folder, or a new one in an existing folder",
    _path(lambda path: path.is_dir() or (path.parent.is_dir() and not path.exists())),
    "FOLDER",
)
PACKAGE = Rule("NAME=DIR with an existing folder", _package, "NAME=DIR")
XACRO = Rule("NAME:=VALUE, such as ur_type:=ur5e", _xacro, "NAME:=VALUE")
WEB_ADDRESS = Rule("a port, 0 for a free one, or HOST:PORT; SCENE stands before it", web_address, "PORT")
LEGACY_ADDRESS = Rule(
    "a port, 0 for a free one, or HOST:PORT with an IPv4 address of this machine, such as 0.0.0.0:19997",
    legacy_address,
    "PORT",
)
ROS_DOMAIN = replace(
    between(0, LAST_ROS_DOMAIN),
    valid="a domain from 0 to 232, or ROS_DOMAIN_ID for that of the environment",
    parse=_ros_domain,
    metavar="DOMAIN",
    words=(FROM_ENVIRONMENT,),
)
ROS_NAMESPACE = matching(
    r"(/[A-Za-z_][A-Za-z0-9_]*)+",
    "a slash and a name of letters, digits and underscores, such as /arm",
    "/NAME",
)
ROS_ROUTER = matching(
    r"self|(self=)?[a-z][a-z0-9-]*/\S+(?<!:0)",
    "PROTOCOL/ADDRESS of a router, self for 127.0.0.1:7447 of this server, or self=PROTOCOL/ADDRESS",
    "ENDPOINT",
)
IMAGE_SIZE = Rule(f"WIDTHxHEIGHT, each from 16 to {LARGEST_SIDE}, such as 1280x720", _image_size, "WxH")
