"""Run ``python -m simx_client COMMAND``: the client's commands, each a module with a ``main(argv)``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from importlib import import_module

from simx_client.cli.command_parser import program
from simx_client.protocol.cli.exit_codes import INTERRUPTED, USAGE
from simx_client.protocol.cli.parser import Parser
from simx_client.protocol.cli.terminal import print_what_can_be, while_read

COMMANDS = {
    "list": ("list the live simulators", "simx_client.cli.listing"),
    "call": ("call one function of the remote API", "simx_client.cli.call"),
    "watch": ("print the results of a reading function whenever they change", "simx_client.cli.watch"),
    "past": ("show the last steps of a run and their calls, go on from one", "simx_client.cli.past"),
    "image": ("write a camera's image into a file", "simx_client.cli.image"),
    "completion": (
        "print the completion script of a shell",
        "simx_client.cli.completion",
    ),
    "check": ("report what an old script needs and what is missing", "simx_client.checking.command"),
    "run": ("run an unmodified legacy script", "simx_client.launch.run"),
    "status": ("report health and metrics of simulators", "simx_client.cli.status.command"),
    "fleet": ("run servers on the hosts of a Ray cluster", "simx_client.fleet.command"),
    "classroom": (
        "run a class: a server for each student, and a page",
        "simx_client.cli.of_server.classroom",
    ),
    "diff": ("find the first step in which two recordings differ", "simx_client.cli.of_server.diff"),
    "compare": ("run a program at the original and here: what departs", "simx_client.cli.of_server.compare"),
    "export": ("write a recording for other programs, as a bag of ROS 2", "simx_client.cli.of_server.export"),
    "grade": ("give points to a program for what its simulation did", "simx_client.cli.of_server.grade"),
    "fit": ("choose physics with which runs meet recorded ones", "simx_client.cli.of_server.fit"),
    "mcp": ("offer a simulation to agents (MCP)", "simx_client.agents.command"),
    "shims": ("write stand-ins for vrep.py and sim.py into a folder", "simx_client.cli.shims"),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Pass the remaining arguments to the command and return its exit code, 130 after Ctrl-C.

    ``simx help COMMAND`` is ``simx COMMAND --help``. Without a command, print the help and return 2.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if words and words[0] == "help":
        words = [*words[1:2], "--help"]
    commands = "\n".join(f"  {name:10} {meaning}" for name, (meaning, _) in COMMANDS.items())
    parser = Parser(
        program(),
        usage=f"{program()} COMMAND [ARGS...]",
        description=f"commands:\n{commands}\n\n{program()} COMMAND --help prints more; simx-server starts a simulator.",
    )
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND", help=argparse.SUPPRESS)
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
    if not words:
        parser.print_help()
        return USAGE
    options = parser.parse_args(words)
    try:
        command = partial(import_module(COMMANDS[options.command][1]).main, options.arguments)
        if options.command == "run":  # there stdout is the script's
            return command()
        print_what_can_be()
        return while_read(command)
    except KeyboardInterrupt:
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
