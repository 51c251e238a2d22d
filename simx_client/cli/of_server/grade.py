"""Run ``simx grade``, a command of the server."""

from __future__ import annotations

from ..server_command import ServerCommand

COMMAND = ServerCommand("grade", "Grade programs by what their simulation did")
make_parser, main = COMMAND.make_parser, COMMAND.main
