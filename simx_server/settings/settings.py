"""Every setting of the server, declared once: default, flag, variable, rule and help in one place.

A value comes from the flag, else from the environment variable, else from the default; its origin is kept for
``--show-settings``. The variable follows from the flag: ``--time-step`` is ``SIMX_TIME_STEP``.

`gathering.py` makes the record. This module reads no files and imports neither mujoco nor zenoh, so ``--help`` stays
quick.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from simx_client.protocol.files import SAVED_SUFFIXES
from simx_client.protocol.python.light_dataclass import dataclass
from simx_client.protocol.zenoh import keys
from simx_server.limits import NAMES as LIMIT_NAMES
from simx_server.limits import VALID as VALID_LIMIT
from simx_server.limits import Limits, limit_text
from simx_server.processes.log_format import FORMATS as LOG_FORMATS

from . import rules
from .rules import YES_OR_NO, Rule, Setting

LOG_LEVELS = ("debug", "info", "warning", "error")
OWN, OMPL = "own", "ompl"
"""Planners: the server's own for all algorithms, or those of the library OMPL."""

FIRST_ARM = "first"
"""Stands for the first arm of the scene."""

_REALM = Rule("1 to 64 letters, digits, dots, dashes and underscores", keys.check_chunk, "NAME")
_LIMIT = Rule(VALID_LIMIT, limit_text, "NAME=N", LIMIT_NAMES)


def _setting(default: Any, help: str, rule: Rule = YES_OR_NO, **more: Any) -> Any:
    """Return a field; `more` are those of `Setting`."""
    entry = {"setting": Setting(rule.valid, rule.parse, rule.metavar, rule.words, help=help, **more)}
    if callable(default):
        return field(default_factory=default, metadata=entry)
    return field(default=default, metadata=entry)


@dataclass(frozen=True)
class Settings:
    """All settings of a server at its start. Times are in seconds.

    ``Settings(ports=(0,), speed=math.inf)`` in code takes values as they are; texts from users go through `gather`.
    """

    scene: str | None = _setting(
        None,
        "V-REP (.ttt, .ttm), MJCF or URDF file, or the name of a shipped scene",
        Rule("a path or a name", str),
        flag="SCENE",
        unset="ur5_rg2_kinect, the tutorial's",
        heading="scene",
    )
    start: bool = _setting(False, "start the simulation at once", heading="simulation", serves=True)
    auto_start: bool = _setting(True, "connecting on the temporary port starts nothing", serves=True)
    speed: float = _setting(1.0, "times real time (1), or max", rules.SPEED, serves=True)
    time_step: float | None = _setting(
        None,
        "length of one simulation step (the scene's, else 0.05)",
        rules.seconds("0.05"),
        unset="the scene's, else 0.05",
    )
    duration: float | None = _setting(
        None,
        "exit after this wall time",
        rules.seconds("60"),
        unset="no limit",
        needs_process=True,
    )
    quit_after_stop: bool = _setting(False, "exit when the simulation stops", serves=True, needs_process=True)
    until_eof: bool = _setting(
        False, "exit when standard input ends, as with its starter", needs_process=True
    )
    count: int | None = _setting(
        None,
        "number of servers, started again if they crash (--supervised: one)",
        rules.between(1, 1000),
        unset="one, in this process",
        needs_process=True,
    )
    supervised: bool | None = _setting(
        None,
        "start it again if it crashes, where it was",
        unset="with --count alone",
        is_told_elsewhere=True,
        serves=True,
    )
    arguments: tuple[str, ...] = _setting(
        (),
        "text that scripts read as string parameter 2, 3, ...; repeatable",
        Rule("up to 9 texts", str, "TEXT"),
        flag="--argument",
        letter="-g",
        many=True,
    )
    seed: int = _setting(
        0,
        "of searches for poses and paths (--planner ompl: by the algorithms of OMPL)",
        rules.between(0, 999_999),
    )
    planner: str = _setting(
        OWN,
        "who plans paths by the name of an algorithm: own, or ompl (the extra ompl)",
        rules.one_of("NAME", OWN, OMPL),
        is_told_elsewhere=True,
    )
    command_server: bool = _setting(False, "add the object remoteApiCommandServer to every scene")
    headless: bool = _setting(
        True, "no window; always so, accepted for old habits", rules.YES, needs_process=True
    )
    ports: tuple[int, ...] = _setting(
        (19997, 19999),
        "port to answer on, repeatable (19997, 19999); 0: a free one",
        rules.PORT,
        flag="--port",
        letter="-p",
        many=True,
        heading="connections",
        serves=True,
    )
    temporary_port: int = _setting(
        19999, "the port that is there only while running (19999)", rules.PORT, serves=True
    )
    script_ports: bool = _setting(True, "scripts of the scene open no ports", serves=True)
    local: bool = _setting(
        True, "clients on this host use Zenoh too, not a socket of the file system", serves=True
    )
    legacy_ports: tuple[str, ...] = _setting(
        (),
        "port for unmodified programs with V-REP's own library, repeatable",
        rules.LEGACY_ADDRESS,
        flag="--legacy-port",
        many=True,
        serves=True,
    )
    legacy_pace: str = _setting(
        "repeat",
        "when their blocking calls are answered: free, repeat (as in V-REP), every",
        rules.one_of("PACE", "free", "repeat", "every"),
        serves=True,
    )
    listen: tuple[str, ...] = _setting(
        (),
        "further Zenoh endpoint, repeatable; opens it to others",
        rules.endpoint("tcp/0.0.0.0:7447"),
        letter="-l",
        many=True,
        serves=True,
    )
    connect: tuple[str, ...] = _setting(
        (),
        "Zenoh router to be reached through, repeatable",
        rules.endpoint("tcp/router:7447"),
        many=True,
        serves=True,
    )
    config: Path | None = _setting(
        None,
        "Zenoh configuration (TLS, passwords, access rules)",
        rules.file("an existing JSON5 file of Zenoh settings"),
        letter="-c",
        unset="none",
        serves=True,
    )
    zmq: str | None = _setting(
        None,
        "serve clients of the ZeroMQ remote API (23000; --zmq-viewers: read only)",
        rules.WEB_ADDRESS,
        unset="they are not served",
        lone="23000",
        serves=True,
    )
    zmq_viewers: str | None = _setting(
        None,
        "a second such port, whose clients only read (23001)",
        rules.WEB_ADDRESS,
        unset="there is none",
        lone="23001",
        is_told_elsewhere=True,
        serves=True,
    )
    zmq2: str | None = _setting(
        None,
        "serve clients of API 2 (24020; --zmq2-viewers: read only)",
        rules.WEB_ADDRESS,
        unset="they are not served",
        lone="24020",
        serves=True,
    )
    zmq2_viewers: str | None = _setting(
        None,
        "a second such port, whose clients only read (24021)",
        rules.WEB_ADDRESS,
        unset="there is none",
        lone="24021",
        is_told_elsewhere=True,
        serves=True,
    )
    ros2: int | None = _setting(
        None,
        "node of ROS 2 (--ros2-router, --ros2-namespace, --ros2-distro, --ros2-drive, --ros2-messages)",
        rules.ROS_DOMAIN,
        unset="no node of ROS 2",
        lone=rules.FROM_ENVIRONMENT,
        serves=True,
    )
    ros2_namespace: str | None = _setting(
        None,
        "in front of the names of its node, topics and services",
        rules.ROS_NAMESPACE,
        unset="none",
        is_told_elsewhere=True,
        serves=True,
    )
    ros2_router: str = _setting(
        "tcp/127.0.0.1:7447",
        "ROS 2's router; self: this server is it",
        rules.ROS_ROUTER,
        is_told_elsewhere=True,
        serves=True,
    )
    ros2_distro: str = _setting(
        "jazzy",
        "distribution of ROS 2: humble, or a later one (jazzy)",
        rules.one_of("NAME", "humble", "iron", "jazzy", "kilted", "lyrical", "rolling"),
        is_told_elsewhere=True,
        serves=True,
    )
    ros2_drive: str | None = _setting(
        None,
        "the robot whose drive is guessed for ROS 2; off: none",
        rules.matching(r"[^\s].{0,99}", "the name of an object, or off", "NAME"),
        unset="each without annotation",
        is_told_elsewhere=True,
        serves=True,
    )
    ros2_messages: tuple[Path, ...] = _setting(
        (),
        "folder of a package with own messages and services; repeatable",
        rules.FOLDER,
        many=True,
        is_told_elsewhere=True,
    )
    multicast_scouting: bool = _setting(False, "let others on the network discover it", serves=True)
    realm: str | None = _setting(
        None,
        "name of this simulator among several",
        _REALM,
        unset="simx-PORT, of the first port; with --connect HOST-PORT",
        serves=True,
    )
    workspace: Path = _setting(
        Path.cwd, "the only folder where clients may touch files", rules.FOLDER, heading="clients"
    )
    package: tuple[str, ...] = _setting(
        (), "folder of a ROS package, repeatable (--xacro NAME:=VALUE: for xacro)", rules.PACKAGE, many=True
    )
    xacro: tuple[str, ...] = _setting(
        (),
        "value of an argument of a xacro file, repeatable",
        rules.XACRO,
        many=True,
        is_told_elsewhere=True,
    )
    limit: tuple[str, ...] = _setting(
        (), "how much clients may make it hold, as objects=500; repeatable", _LIMIT, many=True
    )
    allow_code: bool = _setting(
        False, "clients' code may run in scripts (--unconfined-scripts: without seccomp)"
    )
    unconfined_scripts: bool = _setting(
        False, "Python scripts run where the kernel lacks seccomp too", is_told_elsewhere=True
    )
    allow_machine: bool = _setting(False, "scripts may start programs and open serial ports")
    check_files: bool = _setting(
        False, "try all files in a child process before they are loaded, not clients' alone"
    )
    view: str | None = _setting(
        None,
        "show it in a browser (8080; HOST:PORT for others; --teleop [ARM]: drive it)",
        rules.WEB_ADDRESS,
        unset="no page",
        lone="8080",
        heading="images and recordings",
        serves=True,
    )
    teleop: str | None = _setting(
        None,
        "drive an arm in the browser by keys, a gamepad and the mouse",
        rules.matching(r"\S+", "the name of an arm's tip, or of an object that carries it", "ARM"),
        unset="nobody drives an arm there",
        lone=FIRST_ARM,
        is_told_elsewhere=True,
        serves=True,
    )
    history: float | None = _setting(
        None,
        "keep the last N s of a run for the time slider; 0: none",
        rules.between(0.0, 86_400.0),
        unset="120 s while a web viewer is open",
    )
    snapshot: Path | None = _setting(
        None,
        "write one image and leave (--camera NAME, --size WxH)",
        rules.new_file(".png"),
        unset="nothing",
        needs_process=True,
    )
    save_mjcf: Path | None = _setting(
        None,
        "write SCENE as MJCF and leave, for example a URDF",
        rules.new_file(".xml"),
        unset="nothing",
        needs_process=True,
    )
    save: Path | None = _setting(
        None,
        "save the scene as MJCF, .mjz or .ttt and leave (--duration: after a run)",
        rules.new_file(*SAVED_SUFFIXES),
        unset="nothing",
        needs_process=True,
    )
    convert: Path | None = _setting(
        None,
        "write a V-REP file as MJCF, with all its parts, and leave",
        rules.NEW_FOLDER,
        unset="nothing",
        needs_process=True,
    )
    video: Path | None = _setting(
        None, "film what runs (--camera NAME, --size WxH, --fps N)", rules.new_file(".mp4"), unset="nothing"
    )
    state_log: Path | None = _setting(
        None,
        "log what runs for viewers of robot data (--camera, --fps)",
        rules.new_file(".mcap"),
        unset="nothing",
    )
    rosbag: Path | None = _setting(
        None,
        "write ROS 2's topics of what runs, without images",
        rules.new_file(".mcap"),
        unset="nothing",
    )
    camera: str | None = _setting(
        None,
        "camera or vision sensor of the image or film",
        rules.matching(r"\S+", "the name of a camera or vision sensor", "NAME"),
        unset="an overview",
        is_told_elsewhere=True,
    )
    size: tuple[int, int] | None = _setting(
        None,
        "pixels of the image or film",
        rules.IMAGE_SIZE,
        unset="the vision sensor's, else 1280x720",
        is_told_elsewhere=True,
    )
    fps: float | None = _setting(
        None,
        "images per simulated second",
        rules.between(1.0, 240.0),
        unset="one for each simulation step, 25 at most",
        is_told_elsewhere=True,
    )
    record: Path | None = _setting(
        None, "record all calls, to be replayed (docs/recording.md)", rules.new_file(), unset="nothing"
    )
    replay: Path | None = _setting(
        None,
        "serve no client: repeat the recorded calls, and compare; --video films it",
        rules.file("an existing file that --record made"),
        unset="nothing",
        needs_process=True,
    )
    log_level: str = _setting(
        "info",
        "how much to tell: debug (-v), info, warning (-q), error",
        rules.one_of("LEVEL", *LOG_LEVELS),
        shortcuts=MappingProxyType({"-v": "debug", "-q": "warning"}),
        heading="log",
    )
    log_format: str = _setting(
        "text", "text for people, or json, one object a line", rules.one_of("FORMAT", *LOG_FORMATS)
    )
    origins: Mapping[str, str] = field(default_factory=dict[str, str], compare=False, repr=False)
    """Field name to the origin of its value; a field that is not in it has its default."""

    @property
    def limits(self) -> Limits:
        """Return all limits, with the chosen values."""
        return Limits.of(self.limit)

    @property
    def operated_arm(self) -> str | None:
        """Return the arm that an operator drives in the web viewer; empty: the first one; None: none."""
        return "" if self.teleop == FIRST_ARM else self.teleop

    @property
    def is_supervised(self) -> bool:
        """Return whether a process watches the server, and starts it again after a crash."""
        if self.replay or self.snapshot or self.save or self.save_mjcf or self.convert:
            return False
        return self.count is not None if self.supervised is None else self.supervised


SETTINGS: Mapping[str, Setting] = MappingProxyType(
    {
        entry.name: entry.metadata["setting"].named(entry.name)
        for entry in dataclasses.fields(Settings)
        if "setting" in entry.metadata
    }
)
"""Field name to its declaration, in order; the command line is built from this."""
