"""Every setting of the server, declared once: default, flag, variable, rule and help in one place.

A value is taken from the flag, else from the environment variable, else from the default; where it came
from is remembered for ``--show-settings``. The variable follows from the flag: ``--time-step`` is
``SIMX_TIME_STEP``.
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

from simx_client.protocol import keys
from simx_server.app.log_format import FORMATS as LOG_FORMATS
from simx_server.app.setting_conflicts import refuse_conflicts
from simx_server.app.setting_rules import (
    Setting,
    SettingError,
    between,
    between_numbers,
    file,
    folder,
    matching,
    new_file,
    new_file_ending,
    one_of,
    only_yes,
    package,
    picture_size,
    port,
    positive,
    speed,
    web_address,
    yes_or_no,
)
from simx_server.limits import NAMES as LIMIT_NAMES
from simx_server.limits import VALID as VALID_LIMIT
from simx_server.limits import Limits, limit_text

__all__ = ["SETTINGS", "SettingError", "Settings"]

LOG_LEVELS = ("debug", "info", "warning", "error")
_YES_OR_NO = "yes or no"


def _setting(default: Any, flag: str, help: str, valid: str, parse: Callable[[str], Any], **more: Any) -> Any:
    entry = {"setting": Setting(flag, help, valid, parse, **more)}
    if callable(default):
        return field(default_factory=default, metadata=entry)
    return field(default=default, metadata=entry)


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
        heading="scene",
    )
    start: bool = _setting(
        False, "--start", "start the simulation at once", _YES_OR_NO, yes_or_no, heading="simulation"
    )
    auto_start: bool = _setting(
        True, "--auto-start", "connecting on the temporary port starts nothing", _YES_OR_NO, yes_or_no
    )
    speed: float = _setting(
        1.0,
        "--speed",
        "times real time (1), or max",
        "a number greater than 0, or max",
        speed,
        metavar="FACTOR",
        words=("max",),
    )
    time_step: float | None = _setting(
        None,
        "--time-step",
        "length of one pass (the scene's, else 0.05)",
        "seconds greater than 0, such as 0.05",
        positive,
        metavar="SECONDS",
        unset="the scene's, else 0.05",
    )
    duration: float | None = _setting(
        None,
        "--duration",
        "leave after so much wall time",
        "seconds greater than 0, such as 60",
        positive,
        metavar="SECONDS",
        unset="no limit",
    )
    quit_after_stop: bool = _setting(
        False, "--quit-after-stop", "leave when the simulation stops", _YES_OR_NO, yes_or_no
    )
    until_eof: bool = _setting(
        False, "--until-eof", "leave when standard input ends, as with its starter", _YES_OR_NO, yes_or_no
    )
    count: int | None = _setting(
        None,
        "--count",
        "so many servers in processes of their own",
        "a whole number from 1 to 1000",
        between(1, 1000),
        metavar="N",
        unset="one, in this process",
    )
    arguments: tuple[str, ...] = _setting(
        (),
        "--argument",
        "text that scripts read as string parameter 2, 3, ...; repeatable",
        "up to 9 texts",
        str,
        metavar="TEXT",
        letter="-g",
        many=True,
    )
    command_server: bool = _setting(
        False,
        "--command-server",
        "add the object remoteApiCommandServer to every scene",
        _YES_OR_NO,
        yes_or_no,
    )
    headless: bool = _setting(
        True,
        "--headless",
        "no window; always so, accepted for old habits",
        "yes; there is no window to ask for",
        only_yes,
    )
    ports: tuple[int, ...] = _setting(
        (19997, 19999),
        "--port",
        "port to answer on, repeatable (19997, 19999); 0: a free one",
        "a whole number from 0 to 65535",
        port,
        metavar="PORT",
        letter="-p",
        many=True,
        heading="connections",
    )
    temporary_port: int = _setting(
        19999,
        "--temporary-port",
        "the port that is there only while running (19999)",
        "a whole number from 0 to 65535",
        port,
        metavar="PORT",
    )
    listen: tuple[str, ...] = _setting(
        (),
        "--listen",
        "further Zenoh endpoint, repeatable; opens it to others",
        "PROTOCOL/ADDRESS, such as tcp/0.0.0.0:7447",
        matching(r"[a-z][a-z0-9-]*/\S+"),
        metavar="ENDPOINT",
        letter="-l",
        many=True,
    )
    connect: tuple[str, ...] = _setting(
        (),
        "--connect",
        "Zenoh router to be reached through, repeatable",
        "PROTOCOL/ADDRESS, such as tcp/router:7447",
        matching(r"[a-z][a-z0-9-]*/\S+"),
        metavar="ENDPOINT",
        many=True,
    )
    config: Path | None = _setting(
        None,
        "--config",
        "Zenoh configuration (TLS, passwords, access rules)",
        "an existing JSON5 file of Zenoh settings",
        file,
        metavar="FILE",
        letter="-c",
        unset="none",
    )
    multicast_scouting: bool = _setting(
        False, "--multicast-scouting", "let others on the network discover it", _YES_OR_NO, yes_or_no
    )
    realm: str | None = _setting(
        None,
        "--realm",
        "name of this simulator among several",
        "1 to 64 letters, digits, dots, dashes and underscores",
        keys.check_chunk,
        metavar="NAME",
        unset="simx-PORT, of the first port; with --connect HOST-PORT",
    )
    workspace: Path = _setting(
        Path.cwd,
        "--workspace",
        "the only folder where clients may touch files",
        "an existing folder",
        folder,
        metavar="FOLDER",
        heading="clients",
    )
    package: tuple[str, ...] = _setting(
        (),
        "--package",
        "folder of a ROS package that a URDF names, repeatable",
        "NAME=DIR with an existing folder",
        package,
        metavar="NAME=DIR",
        many=True,
    )
    limit: tuple[str, ...] = _setting(
        (),
        "--limit",
        "how much clients may make it hold, as objects=500; repeatable",
        VALID_LIMIT,
        limit_text,
        metavar="NAME=N",
        words=LIMIT_NAMES,
        many=True,
    )
    allow_code: bool = _setting(
        False, "--allow-code", "clients may have their own code run in scripts", _YES_OR_NO, yes_or_no
    )
    check_files: bool = _setting(
        False,
        "--check-files",
        "try all files in a child process before they are loaded, not clients' alone",
        _YES_OR_NO,
        yes_or_no,
    )
    view: str | None = _setting(
        None,
        "--view",
        "show it in a browser (8080); HOST:PORT for others too",
        "a port, 0 for a free one, or HOST:PORT; SCENE stands before it",
        web_address,
        metavar="PORT",
        unset="no page",
        lone="8080",
        heading="images and recordings",
    )
    snapshot: Path | None = _setting(
        None,
        "--snapshot",
        "write one picture and leave (--camera NAME, --size WxH)",
        "a file in an existing folder whose name ends in .png",
        new_file_ending(".png"),
        metavar="FILE.png",
        unset="nothing",
    )
    save_mjcf: Path | None = _setting(
        None,
        "--save-mjcf",
        "write SCENE as MJCF and leave, for example a URDF",
        "a file in an existing folder whose name ends in .xml",
        new_file_ending(".xml"),
        metavar="FILE.xml",
        unset="nothing",
    )
    video: Path | None = _setting(
        None,
        "--video",
        "film what runs (--camera NAME, --size WxH, --fps N)",
        "a file in an existing folder whose name ends in .mp4",
        new_file_ending(".mp4"),
        metavar="FILE.mp4",
        unset="nothing",
    )
    state_log: Path | None = _setting(
        None,
        "--state-log",
        "log what runs for viewers of robot data (--camera, --fps)",
        "a file in an existing folder whose name ends in .mcap",
        new_file_ending(".mcap"),
        metavar="FILE.mcap",
        unset="nothing",
    )
    camera: str | None = _setting(
        None,
        "--camera",
        "camera or vision sensor that is pictured",
        "the name of a camera or vision sensor",
        matching(r"\S+"),
        metavar="NAME",
        unset="an overview",
        is_told_elsewhere=True,
    )
    size: tuple[int, int] | None = _setting(
        None,
        "--size",
        "pixels of what is pictured",
        "WIDTHxHEIGHT, each from 16 to 4096, such as 1280x720",
        picture_size,
        metavar="WxH",
        unset="the vision sensor's, else 1280x720",
        is_told_elsewhere=True,
    )
    fps: float | None = _setting(
        None,
        "--fps",
        "pictures per simulated second",
        "a number from 1 to 240",
        between_numbers(1.0, 240.0),
        metavar="N",
        unset="one for each pass, 25 at most",
        is_told_elsewhere=True,
    )
    record: Path | None = _setting(
        None,
        "--record",
        "record all calls, to be replayed (docs/recording.md)",
        "a file in an existing folder",
        new_file,
        metavar="FILE",
        unset="nothing",
    )
    replay: Path | None = _setting(
        None,
        "--replay",
        "serve nobody: do what was recorded, and compare; --video films it",
        "an existing file that --record made",
        file,
        metavar="FILE",
        unset="nothing",
    )
    log_level: str = _setting(
        "info",
        "--log-level",
        "how much to tell: debug (-v), info, warning (-q), error",
        ", ".join(LOG_LEVELS),
        one_of(LOG_LEVELS),
        metavar="LEVEL",
        words=LOG_LEVELS,
        shortcuts=MappingProxyType({"-v": "debug", "-q": "warning"}),
        heading="log",
    )
    log_format: str = _setting(
        "text",
        "--log-format",
        "text for people, or json, one object a line",
        ", ".join(LOG_FORMATS),
        one_of(LOG_FORMATS),
        metavar="FORMAT",
        words=LOG_FORMATS,
    )
    origins: Mapping[str, str] = field(default_factory=dict[str, str], compare=False, repr=False)
    """Field name to where its value came from; a field that is not in it has its default."""

    @property
    def limits(self) -> Limits:
        """All of them, with what was chosen."""
        return Limits.of(self.limit)

    @classmethod
    def gather(cls, flags: Mapping[str, Any], environment: Mapping[str, str]) -> Settings:
        """Settings out of parsed flags (field name to text, list of texts or bool) and the environment.

        An empty variable counts as absent. Raises SettingError for the first bad value.
        """
        values: dict[str, Any] = {}
        origins: dict[str, str] = {}
        for name, setting in SETTINGS.items():
            given: Any
            if name in flags:
                origin = "argument " + setting.flag if setting.is_positional else "flag " + setting.flag
                given = flags[name]
            elif text := environment.get(setting.variable, "").strip():
                origin = "environment " + setting.variable
                given = re.split(r"[,\s]+", text.strip(" ,")) if setting.many else text
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
        refuse_conflicts(settings)
        return settings

    def member(self, number: int) -> Settings:
        """The settings of one of ``--count`` servers, counted from 0: its ports follow those of the one before.

        With 19997 and 19999 the next has 20000 and 20002; 0 stays 0. A given realm becomes ``NAME-0``, ``NAME-1``.
        """
        fixed = [port for port in self.ports if port]
        offset = number * (max(fixed) - min(fixed) + 1) if fixed else 0
        return dataclasses.replace(
            self,
            ports=tuple(port and port + offset for port in self.ports),
            temporary_port=self.temporary_port + (offset if self.temporary_port in fixed else 0),
            realm=self.realm and f"{self.realm}-{number}",
            count=None,
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
