"""Run ``simx diff``, a command of the server."""

from __future__ import annotations

from ..server_command import ServerCommand

COMMAND = ServerCommand("diff", "Find the first simulation step in which two recordings differ")
make_parser, main = COMMAND.make_parser, COMMAND.main
