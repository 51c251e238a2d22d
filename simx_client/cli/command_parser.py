"""The parsers of the client's commands, and the program's name in help and messages."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from simx_client.protocol.cli.parser import Parser

SCRIPT = "simx"
"""The console script for ``python -m simx_client``."""

MODULE = "python -m simx_client"
"""The program's name in texts, which `called` replaces with the way it was started."""


def program() -> str:
    """Return how this process was started: by the script, or by Python (also by a program that imports this)."""
    return SCRIPT if Path(sys.argv[0]).stem == SCRIPT else MODULE


def called(text: str) -> str:
    """Return the text with the program's name as it was started."""
    return text.replace(MODULE, program())


def command_parser(
    name: str, description: str, *, examples: str | None = None, usage: str | None = None
) -> argparse.ArgumentParser:
    """Return a parser for ``python -m simx_client NAME``; flags must be written in full.

    Args:
        examples: the last part of the help, line by line.
        usage: the words after the name, where argparse's usage is not enough.
    """
    prog = f"{program()} {name}"
    return Parser(
        prog,
        usage=None if usage is None else f"{prog} {usage}",
        description=description,
        epilog=None if examples is None else called(examples),
    )
