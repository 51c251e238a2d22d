"""Run ``simx fit``, a command of the server."""

from __future__ import annotations

from ..server_command import ServerCommand

COMMAND = ServerCommand("fit", "Choose physics with which runs meet recorded ones")
make_parser, main = COMMAND.make_parser, COMMAND.main
