"""Run ``simx compare``, a command of the server."""

from __future__ import annotations

from ..server_command import ServerCommand

COMMAND = ServerCommand("compare", "Run a program at the original and here, and find what departs")
make_parser, main = COMMAND.make_parser, COMMAND.main
