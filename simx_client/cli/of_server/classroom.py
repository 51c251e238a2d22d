"""Run ``simx classroom``, a command of the server."""

from __future__ import annotations

from ..server_command import ServerCommand

COMMAND = ServerCommand("classroom", "Run a class: a server for each student")
make_parser, main = COMMAND.make_parser, COMMAND.main
