"""Replay a recording, and write it in the formats that the options name."""

from __future__ import annotations

import argparse
import logging
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE, INCOMPLETE
from simx_server.app.server import open_world
from simx_server.errors import CommandError, StartError
from simx_server.recording.log_file import LogReader
from simx_server.recording.opened import Opened
from simx_server.recording.replayed import Divergence
from simx_server.recording.replaying import replay
from simx_server.settings.settings import Settings
from simx_server.world.world import World

from .datasets import export_datasets
from .rosbag import export_rosbag


def export(options: argparse.Namespace, program: str) -> int:
    """Write a recording in other formats. Returns the exit code.

    Args:
        options: the values of the flags.
        program: the command as it was called, for messages.
    """
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    try:
        return _replayed(options, program)
    except Divergence as problem:
        sys.stderr.write(f"{program}: the replay differs {problem}; the output has what is before it\n")
        return DIVERGED
    except (CommandError, StartError, OSError) as error:
        sys.stderr.write(f"{program}: {error}\n")
        return FAILURE


def _replayed(options: argparse.Namespace, program: str) -> int:
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
