"""Run ``simx export``, a command of the server."""

from __future__ import annotations

from ..server_command import ServerCommand

COMMAND = ServerCommand(
    "export", "Write a recording in the format of another program, such as a bag of ROS 2"
)
make_parser, main = COMMAND.make_parser, COMMAND.main
