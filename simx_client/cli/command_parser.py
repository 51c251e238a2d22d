"""The parsers of the client's own commands, and the name by which help and messages call the program."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from simx_client.protocol.cli.parser import Parser

SCRIPT = "simx"
"""The console script that is ``python -m simx_client``."""

MODULE = "python -m simx_client"
"""How texts spell the program before `called` has put in how it was started."""


def program() -> str:
    """How this process was started: by the script, or by Python itself (also by a program that imports this)."""
    return SCRIPT if Path(sys.argv[0]).stem == SCRIPT else MODULE


def called(text: str) -> str:
    """The text with the program called as it was started."""
    return text.replace(MODULE, program())


def command_parser(
    name: str, description: str, *, examples: str | None = None, usage: str | None = None
) -> argparse.ArgumentParser:
    """A parser for ``python -m simx_client NAME``; flags must be written out.

    Args:
        examples: come last in the help, line for line.
        usage: the words that follow the name, where argparse's own usage says too little.
    """
    prog = f"{program()} {name}"
    return Parser(
        prog,
        usage=None if usage is None else f"{prog} {usage}",
        description=description,
        epilog=None if examples is None else called(examples),
    )
