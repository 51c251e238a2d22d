"""Run ``simx fit``, a command of the server."""

from __future__ import annotations

from ..server_command import ServerCommand

COMMAND = ServerCommand("fit", "Find the first simulation step in which two recordings fiter")
make_parser, main = COMMAND.make_parser, COMMAND.main
