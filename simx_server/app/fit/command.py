"""``simx fit PROGRAM --scene FILE --recorded FILE --free OBJECT.NAME``: values of a scene that make runs meet.

The client's program finds this module by the entry point ``simx.commands``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from simx_client.protocol.cli.parser import Parser
from simx_server.app.compare.flags import add_allow_code, add_program, parse
from simx_server.app.compare.quantities import WIDTHS

from .parameters import PLACES

MOST_ITERATIONS = 10_000


def make_parser(program: str = "simx fit") -> argparse.ArgumentParser:
    """Return the parser.

    Args:
        program: the command as it was called, for help and messages.
    """
    values = "\n".join(
        f"  {name:10} {'; '.join(place.meaning for place in places)}" for name, places in PLACES.items()
    )
    parser = Parser(
        program,
        description="Choose values of a scene so that a program's run meets a recorded one (mujoco.sysid).",
        epilog=f"""\
values:
{values}

example:
  {program} robot.py --scene scene.xml --recorded original.npz --save fitted.xml
    --free elbow.damping --free cube.friction=0.1:2
The program runs once; each candidate repeats its calls. Keep what you know fixed, and free few values.
exit codes: 0 done, 1 a failure, 2 wrong usage
""",
    )
    add_program(parser, "the Python file, or a .simxlog of a run in the scene")
    parser.add_argument("--scene", required=True, help="the scene")
    parser.add_argument(
        "--recorded", metavar="FILE", type=Path, required=True, help="the run to meet: NPZ, CSV or .simxlog"
    )
    parser.add_argument(
        "--free", metavar="VALUE", action="append", required=True, help="OBJECT.NAME[=LOW:HIGH]; repeatable"
    )
    parser.add_argument(
        "--quantity",
        metavar="NAME",
        action="append",
        choices=tuple(WIDTHS),
        help="meet these only; repeatable (all but force)",
    )
    parser.add_argument(
        "--save",
        metavar="PATH",
        type=Path,
        help="write the scene with the values: an .xml, or a folder for a .ttt",
    )
    parser.add_argument("--iterations", metavar="N", type=_iterations, default=30, help="at most (30)")
    parser.add_argument("--json", action="store_true", help="print one line of JSON")
    add_allow_code(parser)
    parser.add_argument("-v", "--verbose", action="store_true", help="print each candidate to stderr")
    return parser


def _iterations(text: str) -> int:
    if not 1 <= int(text) <= MOST_ITERATIONS:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no number of iterations; valid: 1 to {MOST_ITERATIONS}"
        )
    return int(text)


def main(argv: Sequence[str] | None = None, program: str = "simx fit") -> int:
    """Fit, and print the values. Returns the exit code."""
    options = parse(make_parser(program), argv)
    from .fitted import print_fit  # it imports MuJoCo, which a parser does without

    return print_fit(options, program)
