"""``simx classroom``: the flags, and the start of a class.

The client's program finds this module by the entry point ``simx.commands``. Settings of the seats' servers have the
flags, variables and rules of ``simx-server``.
"""

from __future__ import annotations

import argparse
import dataclasses
import logging
import os
import signal
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

from simx_client.protocol.cli.exit_codes import FAILURE, INTERRUPTED, USAGE
from simx_client.protocol.cli.parser import Parser
from simx_server.processes import log_format
from simx_server.sensors.opengl.mujoco_import import import_mujoco
from simx_server.settings.gathering import gather
from simx_server.settings.rules import FOLDER, PORT, Rule, SettingError, between, matching, new_file
from simx_server.settings.settings import SETTINGS, Settings

from .addresses import AddressError, is_loopback, listen, resolve, shown_address
from .editor.flags import NoEditor, add_flags, make_plan
from .plan import ClassPlan, make_seats
from .tokens import TokensError, make_tokens

logger = logging.getLogger(__name__)

OF_SERVERS = (
    "scene", "start", "speed", "time_step", "package", "xacro", "limit", "allow_code", "unconfined_scripts",
    "check_files", "supervised",
    "log_level", "log_format",
)  # fmt: skip
"""Settings of ``simx-server`` that hold for every seat."""

MOST_SEATS = 100
"""A seat has about 110 threads, and the systems of many users allow 10,000."""

LIMITS = ("load_memory=256M", "stored=100M")
"""Limits that differ from those of one server, since the memory of one computer is for all seats: the folder for
temporary files is in memory on many systems. ``--limit`` changes them.
"""

USUAL_SEATS = 8
MOST_NAME = 60
"""Characters of a student's name."""

SEATS = between(1, MOST_SEATS)
HOST = matching(r"[^\s/]+", "an address of this machine", "HOST")
ADDRESS = matching(r"[A-Za-z0-9.:_-]+", "a host name or an IP address", "ADDRESS")
CAMERA = matching(r"\S+", "the name of a camera or vision sensor", "NAME")
NAMES = Rule("a text file with a name on each line", lambda text: _names(Path(text)), "FILE")
MEMORY = between(200, 1_000_000)


def make_parser(program: str = "simx classroom") -> argparse.ArgumentParser:
    """Return the parser.

    Args:
        program: the command as it was called, for help and messages.
    """
    parser = Parser(
        program,
        usage=f"{program} [SCENE] [options]",
        description="Run a class: a server for each student, and a page that shows all of them to the teacher.",
        epilog=f"""\
examples:
  {program} ur5 --seats 8                   on this machine alone, to try it
  {program} ur5 --seats 30 --host 0.0.0.0   for the network of the classroom
  {program} ur5 --names class_7b.txt --tokens class_7b.json
                                                a seat for each name; links stay valid
""",
        argument_default=argparse.SUPPRESS,
    )
    own = parser.add_argument_group("the class")

    def add(flag: str, rule: Rule, help: str, default: object = None) -> None:
        own.add_argument(flag, type=_typed(rule, flag), metavar=rule.metavar, default=default, help=help)

    add("--seats", SEATS, f"number of seats ({USUAL_SEATS}, or one for each name)")
    add("--names", NAMES, "text file with a student's name on each line")
    add(
        "--host", HOST, "address to listen at (127.0.0.1); 0.0.0.0: all networks of this machine", "127.0.0.1"
    )
    add("--address", ADDRESS, "address of this machine in the links (found automatically)")
    add("--page-port", PORT, "port of the page (8088); 0: a free one", 8088)
    add("--seat-port", PORT, "port of the first seat (20100), the others follow; 0: free ones", 20100)
    add("--tokens", new_file(), "keep the tokens in a file, so that links stay valid")
    add("--workspace", FOLDER, "folder with a folder for each seat's files (a temporary one)")
    add("--camera", CAMERA, "camera or vision sensor that tiles show (an overview)")
    add("--seat-memory", MEMORY, "megabytes after which a seat is started again (1000)", 1000)
    add_flags(parser, _typed)
    group = parser.add_argument_group("each seat, as for simx-server")
    for name in OF_SERVERS:
        setting = SETTINGS[name]
        words = [word for word in (setting.letter, setting.flag) if word]
        if setting.is_positional:
            group.add_argument(name, nargs="?", metavar=setting.flag, help=setting.help)
        elif setting.is_switch:
            group.add_argument(*words, dest=name, action=argparse.BooleanOptionalAction, help=setting.help)
        else:
            action = "append" if setting.many else "store"
            group.add_argument(*words, dest=name, action=action, metavar=setting.metavar, help=setting.help)
        for flag, meaning in setting.shortcuts.items():
            group.add_argument(flag, dest=name, action="store_const", const=meaning, help=argparse.SUPPRESS)
    return parser


def _typed(rule: Rule, flag: str) -> Any:
    def parse(text: str) -> Any:
        try:
            return rule.parse(text)
        except ValueError as error:
            reason = f"{error}; " if isinstance(error, _Unusable) else ""
            raise argparse.ArgumentTypeError(
                f"{text!r} cannot be used; {reason}valid: {rule.valid}"
            ) from None

    return parse


class _Unusable(ValueError):
    """A value that cannot be used, with the reason."""


def _names(path: Path) -> list[str]:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, ValueError) as error:
        raise _Unusable(str(error)) from None
    names = [" ".join(line.split()) for line in lines if line.strip()]
    if not names:
        raise _Unusable("it has no names")
    for name in names:
        if len(name) > MOST_NAME or not name.isprintable():
            raise _Unusable(f"{name[:MOST_NAME]!r} is not a printable name of at most {MOST_NAME} characters")
    if len(names) > MOST_SEATS:
        raise _Unusable(f"it has {len(names)} names; a class has at most {MOST_SEATS} seats")
    return names


def main(argv: Sequence[str] | None = None, program: str = "simx classroom") -> int:
    """Run a class until it is ended. Returns the exit code."""
    parser = make_parser(program)
    options = parser.parse_args(argv)
    given = {name: value for name, value in vars(options).items() if name in OF_SERVERS}
    variables = {SETTINGS[name].variable for name in OF_SERVERS}
    try:
        base = gather(given, {name: text for name, text in os.environ.items() if name in variables})
    except SettingError as error:
        parser.error(str(error))
    level = base.log_level if "log_level" in base.origins else "warning"
    log_format.configure(level, base.log_format, several=True)
    if sys.platform != "linux":
        logger.error("simx classroom runs on Linux; students may use any system, see docs/classroom.md")
        return USAGE
    students = _students(parser, options)
    # Nothing here multiplies large matrices; a thread pool costs memory, and prevents a process from forking safely.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Temporary files are removed. From its start the supervisor handles SIGTERM.
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
            signal.signal(number, _leave)
    try:
        return _start(options, base, students)
    except KeyboardInterrupt:
        return INTERRUPTED


def _leave(number: int, frame: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)


def _students(parser: argparse.ArgumentParser, options: argparse.Namespace) -> list[str]:
    names: list[str] = options.names or []
    seats: int = options.seats or len(names) or USUAL_SEATS
    if seats < len(names):
        parser.error(
            f"argument --seats: {seats} seats are too few for the {len(names)} names of --names; "
            "valid: as many or more, or --names alone"
        )
    return [*names, *[""] * (seats - len(names))]


def _start(options: argparse.Namespace, base: Settings, students: list[str]) -> int:
    import_mujoco()
    from simx_server.sensors.opengl.backend import requested_backend

    from .supervisor import run_class

    try:
        requested_backend()  # refuses an unknown MUJOCO_GL now, before the first image
    except ValueError as error:
        logger.error("%s", error)
        return USAGE

    with ExitStack() as stack:
        private = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-class-")))
        try:
            host = resolve(options.host, "--host")
            tokens = make_tokens(len(students), options.tokens)
            base = _for_seats(base, options.workspace, private)
            seats = make_seats(base, students, tokens, host, options.seat_port, private)
            listener = stack.enter_context(listen(host, options.page_port, "--page-port"))
            editor = make_plan(options, len(seats), host, base.workspace / "programs", private)
        except (AddressError, NoEditor, TokensError) as error:
            logger.error("%s", error)
            return FAILURE
        except OSError as error:
            logger.error("the folders of the seats cannot be made: %s; choose another --workspace", error)
            return FAILURE
        address = options.address or shown_address(host)
        if not is_loopback(host):
            _warn(host)
        plan = ClassPlan(seats, tokens.teacher, address, options.camera, editor=editor)
        return run_class(plan, base, listener, most_memory=options.seat_memory << 20)


def _for_seats(base: Settings, chosen: Path | None, private: Path) -> Settings:
    if chosen is None:
        chosen = private / "workspaces"
        chosen.mkdir(mode=0o700)
    return dataclasses.replace(base, workspace=chosen, limit=(*LIMITS, *base.limit))


def _warn(host: str) -> None:
    logger.warning(
        "other machines can reach this class at %s: page and seats require their tokens, but nothing is encrypted, so "
        "others on the same network can read what is sent; use it in a network that you trust (docs/classroom.md)",
        "all addresses of this machine" if host in ("0.0.0.0", "::") else host,
    )
