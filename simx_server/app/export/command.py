"""``simx export RUN``: replay a recording and write it in the format of another program.

The client's program finds this module by the entry point ``simx.commands``. Each format is a flag that names its
output; several are written by one replay.
"""

from __future__ import annotations

import argparse
import logging
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE, INCOMPLETE
from simx_client.protocol.cli.parser import Parser
from simx_server.app.server import open_world
from simx_server.errors import CommandError, StartError
from simx_server.recording.log_file import LogReader
from simx_server.recording.opened import Opened
from simx_server.recording.replayed import Divergence
from simx_server.recording.replaying import replay
from simx_server.settings.settings import Settings
from simx_server.world.world import World

from .datasets import add_choice, export_datasets
from .rosbag import export_rosbag


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
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    try:
        return _export(options, program)
    except Divergence as problem:
        sys.stderr.write(f"{program}: the replay differs {problem}; the output has what is before it\n")
        return DIVERGED
    except (CommandError, StartError, OSError) as error:
        sys.stderr.write(f"{program}: {error}\n")
        return FAILURE


def _export(options: argparse.Namespace, program: str) -> int:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-export-")))
        opened = Opened(LogReader(options.recording), folder)
        settings = opened.settings(Settings(allow_code=options.allow_code))

        def attach(world: World, _scene: Path) -> None:
            opened.attach(world)

        world = open_world(settings, stack, attach)
        with ExitStack() as outputs:
            datasets = outputs.enter_context(export_datasets(world, options))
            bag = None
            if options.rosbag is not None:
                bag = outputs.enter_context(
                    export_rosbag(
                        world,
                        options.rosbag.expanduser().resolve(),
                        drive=options.ros2_drive,
                        began=opened.began,
                        images=not options.no_images,
                    )
                )
            before_step = (lambda: None) if datasets is None else datasets.before_step
            outcome = replay(opened, world, settings.history, before_step=before_step)
        if bag is not None:
            print(f"'{options.rosbag}' has {bag.writer.written} messages on {len(bag.writer.topics)} topics")
        if datasets is not None:
            print(f"episodes: {datasets.episodes} written, {datasets.left_out} left out")
        if problem := outcome.problem:
            sys.stderr.write(f"{program}: the recording is not complete: {problem}\n")
            return INCOMPLETE
        return FAILURE if bag is not None and bag.writer.has_failed else DONE
