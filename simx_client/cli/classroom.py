"""Run ``simx classroom``: the installed server's command of this name, which an entry point leads to."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import entry_points
from typing import Any

from simx_client.protocol.cli.exit_codes import FAILURE
from simx_client.protocol.cli.installing import missing_server

from .command_parser import command_parser, program

NAME = "classroom"
_GROUP = "simx.commands"


def _command() -> Any:
    """Return the server's module with the command; None where only the client is installed."""
    return next((each.load() for each in entry_points(group=_GROUP, name=NAME)), None)


def make_parser() -> argparse.ArgumentParser:
    """Return the server's parser; one without flags where only the client is installed."""
    found = _command()
    if found is None:
        return command_parser(NAME, "Run a class: a server for each student (needs simx-server).")
    return found.make_parser(f"{program()} {NAME}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run a class until it is ended. Returns the exit code."""
    found = _command()
    if found is None:
        make_parser().parse_known_args(argv)  # --help and --version
        missing = missing_server() or "the installed simx-server is older than this client; install it again"
        sys.stderr.write(f"{program()} {NAME}: {missing}\n")
        return FAILURE
    return found.main(argv, f"{program()} {NAME}")
