"""Implement ``python -m simx_client completion SHELL``: completion of the programs' flags and names in a
shell.

Everything is read from the programs' parsers and from the table. The server's flags are included if the
server is installed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from importlib.metadata import entry_points
from types import MappingProxyType
from typing import Any

from simx_client.protocol.cli.exit_codes import DONE
from simx_client.protocol.commands import TABLE, Command, Place

from . import completion_scripts
from .command_parser import SCRIPT, command_parser
from .completion_words import FILE, FOLDER, Flag, Program, Value
from .values.arguments import is_callable

PROGRAMS = {
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

_PATHS = {"FILE": FILE, "FILE.png": FILE, "SCRIPT": FILE, "SCENE": FILE, "ARGS": FILE, "FOLDER": FOLDER}


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser(
        "completion",
        "Print a script by which a shell completes simx-server, simx-run, simx-check and simx.",
        examples=EXAMPLES,
    )
    parser.add_argument("shell", choices=("bash", "zsh", "fish"), metavar="SHELL", help="bash, zsh or fish")
    return parser


def main(argv: Sequence[str]) -> int:
    """Print the script; return the exit code."""
    options = make_parser().parse_args(argv)
    lines = getattr(completion_scripts, options.shell)(programs())
    sys.stdout.writelines(f"{line}\n" for line in lines)
    return DONE


def programs() -> list[Program]:
    """Return all installed programs."""
    found: list[Program] = []
    for entry in _servers():
        found.append(_described(entry.PROGRAM, entry.make_parser(), entry.words_of_settings()))
    for name, module in PROGRAMS.items():
        found.append(_described(name, import_module(module).make_parser()))
    commands = import_module("simx_client.__main__").COMMANDS
    parts = {
        name: (meaning, _described(f"{SCRIPT}-{name}", import_module(module).make_parser()))
        for name, (meaning, module) in commands.items()
    }
    return [*found, Program(SCRIPT, commands=parts)]


def _described(
    name: str, parser: argparse.ArgumentParser, known: Mapping[str, tuple[str, ...]] = MappingProxyType({})
) -> Program:
    """Describe a program; `known` has the values of flags that take words, by field."""
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


def _servers() -> Iterator[Any]:
    """Load what installed servers tell shells; the client alone finds none."""
    for entry in entry_points(group="simx.completion"):
        yield entry.load()


def _scenes() -> tuple[str, ...]:
    return tuple(scene for server in _servers() for scene in server.scenes())
