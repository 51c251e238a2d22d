"""Every setting of the server, declared once: default, flag, environment variable, rule and help in one place.

A value is taken from the flag, else from the environment variable, else from the default; where it came from
is remembered for ``--show-settings``. The variable follows from the flag: ``--time-step`` is ``SIMX_TIME_STEP``.
This module reads no files and imports neither mujoco nor zenoh, so ``--help`` stays quick.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

LOG_LEVELS = ("debug", "info", "warning", "error")


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

    @property
    def is_positional(self) -> bool:
        return not self.flag.startswith("-")

    @property
    def is_switch(self) -> bool:
        return self.parse is _yes_or_no

    @property
    def variable(self) -> str:
        return "SIMX_" + self.flag.lstrip("-").upper().replace("-", "_")

    def read(self, text: str, origin: str) -> Any:
        """The value that `text` stands for; SettingError names `origin` and what is valid."""
        try:
            return self.parse(text)
        except ValueError:
            raise SettingError(f"{origin}: {text!r} cannot be used; valid: {self.valid}") from None


def _yes_or_no(text: str) -> bool:
    answers = {
        "1": True,
        "yes": True,
        "true": True,
        "on": True,
        "0": False,
        "no": False,
        "false": False,
        "off": False,
    }
    try:
        return answers[text.strip().lower()]
    except KeyError:
        raise ValueError(text) from None


def _only_yes(text: str) -> bool:
    if not _yes_or_no(text):
        raise ValueError(text)
    return True


def _port(text: str) -> int:
    port = int(text)
    if not 0 <= port <= 65535:
        raise ValueError(text)
    return port


def _positive(text: str) -> float:
    number = float(text)
    if not (0.0 < number < math.inf):
        raise ValueError(text)
    return number


def _speed(text: str) -> float:
    return math.inf if text.strip().lower() == "max" else _positive(text)


def _matching(pattern: str) -> Callable[[str], str]:
    def parse(text: str) -> str:
        if not re.fullmatch(pattern, text):
            raise ValueError(text)
        return text

    return parse


def _file(text: str) -> Path:
    path = Path(text).expanduser()
    if not path.is_file():
        raise ValueError(text)
    return path.resolve()


def _folder(text: str) -> Path:
    path = Path(text).expanduser()
    if not path.is_dir():
        raise ValueError(text)
    return path.resolve()


def _log_level(text: str) -> str:
    level = text.strip().lower()
    if level not in LOG_LEVELS:
        raise ValueError(text)
    return level


def _setting(default: Any, flag: str, help: str, valid: str, parse: Callable[[str], Any], **more: Any) -> Any:
    entry = {"setting": Setting(flag, help, valid, parse, **more)}
    if callable(default):
        return field(default_factory=default, metadata=entry)
    return field(default=default, metadata=entry)


_YES_OR_NO = "yes or no"


@dataclass(frozen=True)
class Settings:
    """All that can be chosen when a server starts. Times are in seconds.

    ``Settings(ports=(0,), speed=math.inf)`` in code takes values as they are; texts of people go through
    :meth:`gather`.
    """

    scene: str | None = _setting(
        None,
        "SCENE",
        "MJCF or URDF file, or the name of a shipped scene",
        "a path or a name",
        str,
        unset="ur5_rg2_kinect, the tutorial's",
    )
    ports: tuple[int, ...] = _setting(
        (19997, 19999),
        "--port",
        "port to answer on, repeatable (19997, 19999); 0: a free one",
        "a whole number from 0 to 65535",
        _port,
        metavar="PORT",
        letter="-p",
        many=True,
    )
    start: bool = _setting(False, "--start", "start the simulation at once", _YES_OR_NO, _yes_or_no)
    auto_start: bool = _setting(
        True, "--auto-start", "connecting on the temporary port starts nothing", _YES_OR_NO, _yes_or_no
    )
    temporary_port: int = _setting(
        19999,
        "--temporary-port",
        "the port that is there only while running (19999)",
        "a whole number from 0 to 65535",
        _port,
        metavar="PORT",
    )
    speed: float = _setting(
        1.0,
        "--speed",
        "times real time (1), or max",
        "a number greater than 0, or max",
        _speed,
        metavar="FACTOR",
    )
    time_step: float | None = _setting(
        None,
        "--time-step",
        "length of one pass (the scene's, else 0.05)",
        "seconds greater than 0, such as 0.05",
        _positive,
        metavar="SECONDS",
        unset="the scene's, else 0.05",
    )
    duration: float | None = _setting(
        None,
        "--duration",
        "leave after so much wall time",
        "seconds greater than 0, such as 60",
        _positive,
        metavar="SECONDS",
        unset="no limit",
    )
    quit_after_stop: bool = _setting(
        False, "--quit-after-stop", "leave when the simulation stops", _YES_OR_NO, _yes_or_no
    )
    headless: bool = _setting(
        True,
        "--headless",
        "no window; always so, accepted for old habits",
        "yes; there is no window to ask for",
        _only_yes,
    )
    listen: tuple[str, ...] = _setting(
        (),
        "--listen",
        "further Zenoh endpoint, repeatable; opens it to others",
        "PROTOCOL/ADDRESS, such as tcp/0.0.0.0:7447",
        _matching(r"[a-z][a-z0-9-]*/\S+"),
        metavar="ENDPOINT",
        letter="-l",
        many=True,
    )
    config: Path | None = _setting(
        None,
        "--config",
        "Zenoh configuration (TLS, passwords, access rules)",
        "an existing JSON5 file of Zenoh settings",
        _file,
        metavar="FILE",
        letter="-c",
        unset="none",
    )
    multicast_scouting: bool = _setting(
        False, "--multicast-scouting", "let others on the network discover it", _YES_OR_NO, _yes_or_no
    )
    realm: str | None = _setting(
        None,
        "--realm",
        "name of this simulator among several",
        "letters, digits, dots, dashes and underscores",
        _matching(r"[A-Za-z0-9._-]+"),
        metavar="NAME",
        unset="derived from the port",
    )
    workspace: Path = _setting(
        Path.cwd,
        "--workspace",
        "the only folder where clients may touch files",
        "an existing folder",
        _folder,
        metavar="FOLDER",
    )
    log_level: str = _setting(
        "info",
        "--log-level",
        "how much to tell: " + ", ".join(LOG_LEVELS),
        ", ".join(LOG_LEVELS),
        _log_level,
        metavar="LEVEL",
        shortcuts=MappingProxyType({"-v": "debug", "-q": "warning"}),
    )
    origins: Mapping[str, str] = field(default_factory=dict[str, str], compare=False, repr=False)
    """Field name to where its value came from; a field that is not in it has its default."""

    @classmethod
    def gather(cls, flags: Mapping[str, Any], environment: Mapping[str, str]) -> Settings:
        """Settings out of parsed flags (field name to text, list of texts or bool) and the environment.

        An empty variable counts as absent. Raises SettingError for the first bad value.
        """
        values: dict[str, Any] = {}
        origins: dict[str, str] = {}
        for name, setting in SETTINGS.items():
            if name in flags:
                origin = "argument " + setting.flag if setting.is_positional else "flag " + setting.flag
                given = flags[name]
            elif environment.get(setting.variable, "").strip():
                origin = "environment " + setting.variable
                given = environment[setting.variable].strip()
                if setting.many:
                    given = [word for word in re.split(r"[,\s]+", given) if word]
            else:
                continue
            origins[name] = origin
            if isinstance(given, bool):
                values[name] = given
            elif setting.many:
                values[name] = tuple(setting.read(text, origin) for text in given)
            else:
                values[name] = setting.read(given, origin)
        settings = cls(**values, origins=MappingProxyType(origins))
        settings._refuse_repeated_ports()
        return settings

    def _refuse_repeated_ports(self) -> None:
        chosen = [port for port in self.ports if port]
        repeated = sorted({port for port in chosen if chosen.count(port) > 1})
        if repeated:
            raise SettingError(
                f"{self.origins['ports']}: {repeated[0]} is given twice; valid: each port once, 0 as often as you like"
            )

    def table(self) -> list[tuple[str, str, str]]:
        """(name as in the flag, value as text, origin) of every setting, in order of declaration."""
        return [
            (
                setting.flag.lstrip("-").lower(),
                setting.unset if (value := getattr(self, name)) is None else _shown(value),
                self.origins.get(name, "default"),
            )
            for name, setting in SETTINGS.items()
        ]


def _shown(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(str, value)) or "none"  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value == math.inf:
        return "max"
    return str(value)


SETTINGS: Mapping[str, Setting] = MappingProxyType(
    {
        entry.name: entry.metadata["setting"]
        for entry in dataclasses.fields(Settings)
        if "setting" in entry.metadata
    }
)
"""Field name to its declaration, in order; the command line is built from this."""
