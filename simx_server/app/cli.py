"""The command line ``simx-server``: flags, listings, logging, exit codes.

Exit codes: 0 done, 1 failure, 2 wrong usage, 130 interrupted (docs/operations.md). Requested output goes to stdout, the
log to stderr. The flags are built from ``settings``; heavy modules are imported only when the server starts.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import sys
from collections.abc import Collection, Sequence
from functools import partial

from simx_client.protocol.cli.exit_codes import DONE, FAILURE, INTERRUPTED, USAGE
from simx_client.protocol.cli.parser import Parser
from simx_client.protocol.cli.terminal import print_what_can_be, while_read
from simx_client.protocol.python.garbage import made_to_stay
from simx_server import __version__
from simx_server.processes import log_format
from simx_server.processes.early_end import ended_by_sigterm
from simx_server.processes.lifeline import GRACE as LIFELINE_GRACE
from simx_server.processes.watchdog import Watchdog, watched
from simx_server.sensors.opengl.mujoco_import import import_mujoco
from simx_server.settings.gathering import gather
from simx_server.settings.listing import list_settings
from simx_server.settings.rules import SettingError
from simx_server.settings.settings import SETTINGS, Settings

logger = logging.getLogger(__name__)

PROGRAM = "simx-server"

LISTS = ("commands", "script_functions", "zmq_functions")
PAGES = ("tree", "import_report", "doctor", *LISTS)
"""Flags that print something instead of serving."""

EXAMPLES = """\
examples:
  simx-server                          the tutorial's scene on 19997 and 19999
  simx-server my_robot.ttt --start     any V-REP scene, MJCF or URDF, running at once
  simx-server --speed max --port 0     as fast as it goes, on a free port
  simx-server --count 8 --port 0       eight of them, listed as JSON when ready
every flag is also a variable: --time-step is SIMX_TIME_STEP; the flag wins
"""


class _Help(argparse.RawDescriptionHelpFormatter):
    """Keep the first column narrow, and show the form of a switch that changes something."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=30, width=100)

    def _format_action_invocation(self, action: argparse.Action) -> str:
        if isinstance(action, argparse.BooleanOptionalAction):
            off, on = action.option_strings[-1], action.option_strings[0]
            return off if _default_of(action.dest) else on
        if action.metavar and len(action.option_strings) > 1:
            return f"{', '.join(action.option_strings)} {action.metavar}"
        return super()._format_action_invocation(action)


def _default_of(name: str) -> object:
    return getattr(Settings(), name)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser; its result holds only the flags that were given, under the fields' names."""
    parser = Parser(
        PROGRAM,
        version=_version,
        usage=f"{PROGRAM} [SCENE] [options]",
        description="A MuJoCo simulation that scripts written for V-REP can drive.",
        epilog=EXAMPLES,
        formatter_class=_Help,
        argument_default=argparse.SUPPRESS,
        add_help=False,
    )
    group = parser.add_argument_group()
    for name, setting in SETTINGS.items():
        spellings = [word for word in (setting.letter, setting.flag) if word]
        shown = argparse.SUPPRESS if setting.is_told_elsewhere else setting.help
        if setting.heading:
            group = parser.add_argument_group(setting.heading)
        if setting.is_positional:
            group.add_argument(name, nargs="?", metavar=setting.flag, help=setting.help)
        elif setting.is_switch:
            action = argparse.BooleanOptionalAction
            group.add_argument(*spellings, dest=name, action=action, help=shown)
        elif not setting.metavar:
            group.add_argument(*spellings, dest=name, action="store_const", const="yes", help=setting.help)
        elif setting.lone:
            group.add_argument(
                *spellings,
                dest=name,
                nargs="?",
                const=setting.lone,
                metavar=setting.metavar,
                help=shown,
            )
        else:
            action = "append" if setting.many else "store"
            group.add_argument(*spellings, dest=name, action=action, metavar=setting.metavar, help=shown)
        for flag, meaning in setting.shortcuts.items():
            # The setting's own help names them: a screen has few lines.
            group.add_argument(flag, dest=name, action="store_const", const=meaning, help=argparse.SUPPRESS)
    group = parser.add_argument_group("information, printed in place of serving")
    group.add_argument("-h", "--help", action="help", help="print this help and exit")
    parser.add_version(group)
    group.add_argument("--show-settings", action="store_true", help="print every setting and its origin")
    group.add_argument("--tree", action="store_true", help="print the scene's objects (--json)")
    group.add_argument(
        "--import-report", action="store_true", help="print what a V-REP file loses here (--json)"
    )
    group.add_argument("--doctor", action="store_true", help="test what it needs of this machine (--json)")
    group.add_argument(
        "--commands",
        action="store_true",
        help="print the simx functions (--json); --script-functions: those of scripts",
    )
    # The help above names them: a screen has few lines. The last is for writing docs/.
    for hidden in ("--script-functions", "--zmq-functions", "--json", "--markdown"):
        group.add_argument(hidden, action="store_true", help=argparse.SUPPRESS)
    return parser


def _version() -> str:
    import platform

    packages = {"mujoco": "mujoco", "zenoh": "eclipse-zenoh"}
    parts = [f"{name} {_installed(package)}" for name, package in packages.items()]
    return f"{__version__} ({', '.join(parts)}, Python {platform.python_version()})"


def _installed(package: str) -> str:
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:  # --doctor reports it; the version must not fail because of it
        return "missing"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code; argparse may leave with SystemExit."""
    print_what_can_be()
    try:
        with ended_by_sigterm():
            return while_read(partial(_run, argv))
    except KeyboardInterrupt:
        return INTERRUPTED
    except (
        ModuleNotFoundError
    ) as error:  # a client alone needs fewer packages, and often only these are installed
        if error.name is None or error.name.startswith("simx_"):
            raise
        from simx_client.protocol.cli import installing

        sys.stderr.write(
            f"{PROGRAM}: the package {error.name} is not installed; {installing.missing_line()} brings all that a "
            f"server needs, and {PROGRAM} --doctor tells what is missing\n"
        )
        return FAILURE


def _run(argv: Sequence[str] | None) -> int:
    parser = make_parser()
    given = vars(parser.parse_args(argv))
    show_settings = given.pop("show_settings", False)
    pages = [name for name in PAGES if given.pop(name, False)]
    form = {name for name in ("json", "markdown") if given.pop(name, False)}
    if len(pages) > 1 or len(form) > 1 or (form and not pages):
        parser.error(
            "--json and --markdown say how to print a page; valid: --tree, --import-report, --doctor, --commands or "
            "--script-functions, with one of them or none"
        )
    page = pages[0] if pages else None
    if page in LISTS:
        return _print_list(page, form)
    if page is not None and "markdown" in form:
        parser.error(f"--markdown is for lists; valid: --{page.replace('_', '-')} with --json or nothing")
    try:
        settings = gather(given, os.environ)
    except SettingError as error:
        parser.error(str(error))
    if show_settings:
        return _print_settings(settings)
    if page is not None:
        return _print_page(page, settings, as_json="json" in form)
    log_format.configure(
        settings.log_level, settings.log_format, several=settings.count is not None or settings.is_supervised
    )
    # Nothing here multiplies large matrices; a thread pool costs memory, and prevents a process from forking safely.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    return _serve(settings)


def _serve(settings: Settings) -> int:
    if settings.until_eof and sys.stdin is None:
        logger.error("--until-eof needs a standard input; leave it out, or start the server with one")
        return USAGE
    # A parent of servers watches the lifeline itself, because it ends the servers one by one.
    children = settings.count or int(settings.is_supervised)
    lifeline = sys.stdin.fileno() if settings.until_eof and not children else None
    with watched(children, lifeline, LIFELINE_GRACE) as watchdog:
        return _serve_watched(settings, watchdog)


def _serve_watched(settings: Settings, watchdog: Watchdog | None) -> int:
    # Imports make little garbage, and collections are a tenth of their time.
    with made_to_stay():
        import_mujoco()
    from simx_server.sensors.opengl.backend import requested_backend

    try:
        requested_backend()  # refuses an unknown MUJOCO_GL now, before the first image
    except ValueError as error:
        logger.error("%s", error)
        return USAGE
    if settings.count is not None or settings.is_supervised:
        from .fleet import serve as serve_many

        return serve_many(settings, watchdog)
    from simx_server.files.library import DEFAULT_SCENE
    from simx_server.scene.trial import helper as trial_helper
    from simx_server.sensors.opengl.early_probe import begin_early

    # Before the rest is imported, which takes as long.
    probe = None if settings.replay is not None else begin_early(settings.scene or DEFAULT_SCENE)
    with made_to_stay():
        from .server import serve
    helper = trial_helper.fork()
    try:
        return serve(settings, probe, helper)
    finally:
        if helper is not None:
            helper.close()
        if probe is not None:
            probe.close()


def _print_settings(settings: Settings) -> int:
    rows = list_settings(settings)
    name_width, value_width = (max(len(row[column]) for row in rows) for column in (0, 1))
    for name, value, origin in rows:
        sys.stdout.write(f"{name:{name_width}}  {value:{value_width}}  {origin}\n")
    return DONE


def _print_page(page: str, settings: Settings, *, as_json: bool) -> int:
    """Print a listing that needs the settings. Only warnings are logged, unless the settings ask for more."""
    level = settings.log_level if "log_level" in settings.origins else "warning"
    log_format.configure(level, settings.log_format, several=False)
    if page == "doctor":  # it imports nothing that may be missing: its child processes do
        from .doctor.page import print_findings

        return print_findings(settings, as_json=as_json)
    with watched():
        import_mujoco()
        if page == "import_report":
            from .import_report import print_report

            return print_report(settings, as_json=as_json)
        from .scene_listing import print_tree

        return print_tree(settings, as_json=as_json)


def _print_list(name: str, form: Collection[str]) -> int:
    import_mujoco()
    from simx_server.gateways.zmq.listing import offered
    from simx_server.handlers import HANDLERS
    from simx_server.sim_api.listing import forms
    from simx_server.sim_api.listing.coverage import script_functions

    from . import coverage

    if name == "zmq_functions":
        if "json" not in form:
            sys.stderr.write(f"{PROGRAM}: --zmq-functions is for programs; valid: --zmq-functions --json\n")
            return USAGE
        text = json.dumps(offered(), indent=1)
        sys.stdout.write(text + "\n")
        return DONE
    if name == "commands":
        page, lines = coverage, coverage.coverage(HANDLERS.keys())
    else:
        page, lines = forms, script_functions()
    if "json" in form:
        text = json.dumps(page.as_records(lines), indent=1)
    elif "markdown" in form:
        text = page.as_markdown(lines).rstrip("\n")
    else:
        text = page.as_text(lines)
    sys.stdout.write(text + "\n")
    return DONE
