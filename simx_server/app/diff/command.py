"""``simx diff ONE OTHER``: the first step in which two recordings differ, what differs, and which call came before.

The client's program finds this module by the entry point ``simx.commands``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from simx_client.protocol.cli.parser import Parser
from simx_server.app.compare.flags import add_allow_code


def make_parser(program: str = "simx diff") -> argparse.ArgumentParser:
    """Return the parser.

    Args:
        program: the command as it was called, for help and messages.
    """
    parser = Parser(
        program,
        description="Find the first simulation step in which two recordings differ.",
        epilog=f"""\
examples:
  {program} monday.simxlog tuesday.simxlog           the step, what differs, and the call before it
  {program} monday.simxlog tuesday.simxlog --json    the same for a program
Recordings are made by simx-server --record FILE. Both are replayed up to that step, to name what differs.
exit codes: 0 all steps are equal, 1 a file cannot be used, 2 wrong usage, 3 they differ
""",
    )
    parser.add_argument("one", metavar="ONE", type=Path, help="a recording")
    parser.add_argument("other", metavar="OTHER", type=Path, help="the recording to compare it with")
    parser.add_argument("--json", action="store_true", help="print one line of JSON")
    parser.add_argument(
        "--no-replay", action="store_true", help="compare the files only, without names of objects"
    )
    add_allow_code(parser)
    return parser


def main(argv: Sequence[str] | None = None, program: str = "simx diff") -> int:
    """Compare two recordings and print the first difference. Returns the exit code."""
    options = make_parser(program).parse_args(argv)
    from .differing import print_difference  # it imports MuJoCo, which a parser does without

    return print_difference(options, program)
