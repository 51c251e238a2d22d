"""``python -m simx_client completion SHELL``: what a shell needs to complete the programs' flags and names.

Everything is read from the programs' own parsers and from the table, so nothing here has to be kept up to date.
The server's flags are known where the server is installed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from types import MappingProxyType
from typing import Any, NamedTuple

from simx_client.protocol.cli.exit_codes import DONE
from simx_client.protocol.commands import TABLE, Command, Place

from .arguments import is_callable
from .command_parser import SCRIPT, command_parser

PROGRAMS = {
    "simx-server": "simx_server.app.cli",
    "simx-run": "simx_client.launch.run",
    "simx-check": "simx_client.checking.command",
}
"""Console scripts, and the modules with their ``make_parser``."""

EXAMPLES = """\
examples:
  python -m simx_client completion bash > ~/.local/share/bash-completion/completions/simx-server
  python -m simx_client completion fish > ~/.config/fish/conf.d/simx.fish
  source <(python -m simx_client completion bash)     bash, this shell only; ~/.bashrc for all to come
  source <(python -m simx_client completion zsh)      zsh, after compinit; ~/.zshrc for all to come
"""

FILE, FOLDER = "file", "folder"
_PATHS = {"FILE": FILE, "FILE.png": FILE, "SCRIPT": FILE, "SCENE": FILE, "ARGS": FILE, "FOLDER": FOLDER}


class Value(NamedTuple):
    """What may stand in one place of a command line."""

    words: tuple[str, ...] = ()
    path: str = ""
    """FILE or FOLDER where one may be named."""


class Flag(NamedTuple):
    """One flag in all its spellings."""

    spellings: tuple[str, ...]
    help: str
    value: Value | None
    """None: it takes none."""


class Program(NamedTuple):
    """One program, or one command of it."""

    name: str
    flags: Sequence[Flag] = ()
    value: Value = Value()
    """What its words without a dash may be."""

    commands: Mapping[str, tuple[str, Program]] = MappingProxyType({})
    """Name to help and what it takes."""


def make_parser() -> argparse.ArgumentParser:
    """The flags of the command."""
    parser = command_parser(
        "completion",
        "Print a script by which a shell completes simx-server, simx-run, simx-check and simx.",
        examples=EXAMPLES,
    )
    parser.add_argument("shell", choices=("bash", "zsh", "fish"), metavar="SHELL", help="bash, zsh or fish")
    return parser


def main(argv: Sequence[str]) -> int:
    """Print the script. Returns the exit code."""
    from . import completion_scripts

    options = make_parser().parse_args(argv)
    lines = getattr(completion_scripts, options.shell)(programs())
    sys.stdout.writelines(f"{line}\n" for line in lines)
    return DONE


def programs() -> list[Program]:
    """All of them that are installed."""
    found: list[Program] = []
    for name, module in PROGRAMS.items():
        try:
            found.append(_described(name, import_module(module).make_parser()))
        except ImportError:
            continue  # the client alone
    commands = import_module("simx_client.__main__").COMMANDS
    parts = {
        name: (meaning, _described(f"{SCRIPT}-{name}", import_module(module).make_parser()))
        for name, (meaning, module) in commands.items()
    }
    return [*found, Program(SCRIPT, commands=parts)]


def _described(name: str, parser: argparse.ArgumentParser) -> Program:
    known = _words_of_settings() if name == "simx-server" else {}
    flags: list[Flag] = []
    rest = Value()
    for action in parser._actions:  # pyright: ignore[reportPrivateUsage]  # argparse has no other way to ask
        value = Value(known.get(action.dest) or _words(name, action), _PATHS.get(str(action.metavar), ""))
        if action.option_strings:
            text = "" if action.help in (None, argparse.SUPPRESS) else str(action.help)
            flags.append(Flag(tuple(action.option_strings), text, None if action.nargs == 0 else value))
        else:
            rest = Value(rest.words + value.words, rest.path or value.path)
    return Program(name, flags, rest)


def _words(program: str, action: argparse.Action) -> tuple[str, ...]:
    if action.choices is not None:
        return tuple(map(str, action.choices))
    if action.metavar == "FUNCTION":
        only_reads = program.endswith("-watch")
        return tuple(
            name
            for command in TABLE
            if (_is_watchable(command) if only_reads else is_callable(command))
            for name in command.names
        )
    if action.metavar == "SCENE":
        return _scenes()
    return ()


def _is_watchable(command: Command) -> bool:
    return command.place is Place.REMOTE and command.only_reads and not command.gives_image


def _scenes() -> tuple[str, ...]:
    try:
        library: Any = import_module("simx_server.files.library")
    except ImportError:
        return ()
    return tuple(library.list_scenes())


def _words_of_settings() -> dict[str, tuple[str, ...]]:
    """By field: the values that a setting can have, where these are words."""
    settings: Any = import_module("simx_server.app.settings")
    return {name: setting.words for name, setting in settings.SETTINGS.items()}
