"""A command of ``simx`` that the installed server implements; an entry point leads to it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import entry_points
from typing import Any

from simx_client.protocol.cli.exit_codes import FAILURE
from simx_client.protocol.cli.installing import missing_server

from .command_parser import command_parser, program

_GROUP = "simx.commands"


class ServerCommand:
    """One command; its module in the server has ``make_parser(program)`` and ``main(argv, program)``."""

    def __init__(self, name: str, description: str) -> None:
        """Name the command.

        Args:
            name: the word after ``simx``, and the name of the entry point.
            description: the help where only the client is installed.
        """
        self._name, self._description = name, description

    def make_parser(self) -> argparse.ArgumentParser:
        """Return the server's parser; one without flags where only the client is installed."""
        found = self._module()
        if found is None:
            return command_parser(self._name, f"{self._description} (needs simx-server).")
        return found.make_parser(self._called)

    def main(self, argv: Sequence[str] | None = None) -> int:
        """Run the command. Returns the exit code."""
        found = self._module()
        if found is None:
            self.make_parser().parse_known_args(argv)  # --help and --version
            missing = (
                missing_server() or "the installed simx-server is older than this client; install it again"
            )
            sys.stderr.write(f"{self._called}: {missing}\n")
            return FAILURE
        return found.main(argv, self._called)

    @property
    def _called(self) -> str:
        return f"{program()} {self._name}"

    def _module(self) -> Any:
        """Return the server's module with the command; None where only the client is installed."""
        return next((each.load() for each in entry_points(group=_GROUP, name=self._name)), None)
