"""Run ``simx compare``, a command of the server."""

from __future__ import annotations

from ..server_command import ServerCommand

COMMAND = ServerCommand("compare", "Find the first simulation step in which two recordings compareer")
make_parser, main = COMMAND.make_parser, COMMAND.main
