"""Flags that ``simx compare``, ``simx fit`` and ``simx diff`` share: the program with its arguments, and replays."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from simx_client.protocol.cli.parser import seconds


def add_program(parser: argparse.ArgumentParser, meaning: str) -> None:
    """Add the program and its arguments, see `parse`, and its time.

    Args:
        meaning: the help of the program.
    """
    parser.add_argument("program", metavar="PROGRAM", help=meaning)
    parser.add_argument("arguments", metavar="ARGS", nargs="*", help="arguments of the program, behind --")
    parser.add_argument(
        "--timeout", metavar="S", type=seconds, default=300.0, help="end the program after (300)"
    )


def add_allow_code(parser: argparse.ArgumentParser) -> None:
    """Add ``--allow-code``, which replays need."""
    parser.add_argument(
        "--allow-code",
        action="store_true",
        help="also replay recordings in which clients had their own code run",
    )


def parse(parser: argparse.ArgumentParser, words: Sequence[str] | None) -> argparse.Namespace:
    """Parse a command line of a program; `arguments` has all words behind ``--``.

    argparse would take them only where the program's name is the last word before.
    """
    given = list(sys.argv[1:] if words is None else words)
    end = given.index("--") if "--" in given else len(given)
    options = parser.parse_args(given[:end])
    options.arguments += given[end + 1 :]
    return options
