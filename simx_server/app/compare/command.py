"""``simx compare PROGRAM --scene FILE --original HOST[:PORT]``: a program against the original and here.

The client's program finds this module by the entry point ``simx.commands``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from simx_client.protocol.cli.parser import Parser

from .flags import add_allow_code, add_program, parse


def make_parser(program: str = "simx compare") -> argparse.ArgumentParser:
    """Return the parser.

    Args:
        program: the command as it was called, for help and messages.
    """
    parser = Parser(
        program,
        description="Run a program against CoppeliaSim or V-REP, and here, and print the first quantity that departs.",
        epilog=f"""\
examples:
  {program} robot.py --scene scene.ttt --original localhost:23000 --page result.html
  {program} robot.py --scene scene.ttt --original pc:19997 --save original.npz
  {program} robot.py --scene scene.ttt --recorded original.npz
The original must have the scene open. A program for the legacy port keeps its own library there.
exit codes: 0 equal within the tolerances, 1 a failure, 2 wrong usage, 3 they depart, or the run here ends early
""",
    )
    add_program(parser, "the Python file")
    parser.add_argument("--scene", required=True, help="the scene for the run here")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument(
        "--original",
        metavar="HOST[:PORT]",
        help="a running simulator: its legacy port (19997) or ZeroMQ port (23000)",
    )
    source.add_argument(
        "--recorded",
        metavar="FILE",
        type=Path,
        help="a run that was recorded: NPZ of --save, CSV, or .simxlog",
    )
    parser.add_argument("--save", metavar="FILE", type=Path, help="write the original's run (NPZ)")
    parser.add_argument("--page", metavar="FILE", type=Path, help="write the result with plots as HTML")
    parser.add_argument("--json", action="store_true", help="print one line of JSON")
    parser.add_argument(
        "--tolerance",
        metavar="NAME=NUMBER",
        action="append",
        default=[],
        help="such as position=0.01; repeatable",
    )
    add_allow_code(parser)
    parser.add_argument(
        "--server-arg",
        metavar="FLAG",
        action="append",
        default=[],
        help="for the server here, such as --speed=2",
    )
    return parser


def main(argv: Sequence[str] | None = None, program: str = "simx compare") -> int:
    """Compare, and print the result. Returns the exit code."""
    parser = make_parser(program)
    options = parse(parser, argv)
    if options.save and options.recorded:
        parser.error("--save keeps the original's run: give --original")
    from .comparing import print_comparison  # it imports MuJoCo, which a parser does without

    return print_comparison(options, program)
