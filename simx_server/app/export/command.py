"""``simx export RUN``: replay a recording and write it in the format of another program.

The client's program finds this module by the entry point ``simx.commands``. Each format is a flag that names its
output; several are written by one replay.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from simx_client.protocol.cli.parser import Parser

from .flags import add_choice


def make_parser(program: str = "simx export") -> argparse.ArgumentParser:
    """Return the parser.

    Args:
        program: the command as it was called, for help and messages.
    """
    parser = Parser(
        program,
        description="Replay a recording, and write it in the format of another program.",
        epilog=f"""\
examples:
  {program} run.simxlog --rosbag run              a bag, as ros2 bag record makes it
  {program} run.simxlog --rosbag run.mcap         only its file, for Foxglove
  {program} run.simxlog --rosbag run --no-images
  {program} run.simxlog --npz demos               episodes of demonstrations, for NumPy
  {program} run.simxlog --lerobot demos --cameras kinect_rgb:128x96 overview:320x240 --task "pick the cube"
Recordings are made by simx-server --record FILE.
exit codes: 0 written, 1 the recording or the output cannot be used, 2 wrong usage, 3 the replay differs from the
recording, 4 the recording is not complete; up to there it is written
""",
    )
    parser.add_argument("recording", metavar="RUN", type=Path, help="a recording")
    parser.add_argument(
        "--rosbag", metavar="DIR", type=Path, help="ROS 2's topics as a bag: a new folder, or a file DIR.mcap"
    )
    parser.add_argument(
        "--npz",
        metavar="DIR",
        type=Path,
        help="episodes as NumPy files (docs/demonstrations.md): a new folder",
    )
    parser.add_argument("--lerobot", metavar="DIR", type=Path, help="a dataset of LeRobot: a new folder")
    parser.add_argument("--minari", metavar="DIR", type=Path, help="a dataset of Minari: a new folder")
    parser.add_argument(
        "--no-images", action="store_true", help="leave out what cameras see, which takes long and much space"
    )
    parser.add_argument(
        "--ros2-drive",
        metavar="NAME",
        help="the robot whose drive is guessed for ROS 2; off: none",
    )
    add_choice(parser)
    parser.add_argument(
        "--allow-code",
        action="store_true",
        help="also replay recordings in which clients had their own code run",
    )
    return parser


def main(argv: Sequence[str] | None = None, program: str = "simx export") -> int:
    """Write a recording in other formats. Returns the exit code."""
    parser = make_parser(program)
    options = parser.parse_args(argv)
    if not any((options.rosbag, options.npz, options.lerobot, options.minari)):
        parser.error("no output; valid: --rosbag DIR, --npz DIR, --lerobot DIR, --minari DIR")
    from .exporting import export  # it imports MuJoCo, which a parser does without

    return export(options, program)
