"""Write the replay of a recording as datasets of demonstrations."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any

from simx_server.datasets.cameras import Light, Wanted
from simx_server.datasets.episodes import Choice, Collector, Episode, Layout, Writer
from simx_server.errors import CommandError
from simx_server.world.world import World


def add_choice(parser: argparse.ArgumentParser) -> None:
    """Add the flags that choose what datasets contain."""
    group = parser.add_argument_group("contents of --npz, --lerobot and --minari")
    group.add_argument(
        "--observe",
        metavar="NAME",
        nargs="+",
        default=[],
        help="UR5_joint1.position, Cube.quaternion, ... (joints that move, and free bodies)",
    )
    group.add_argument(
        "--act",
        metavar="NAME",
        nargs="+",
        default=[],
        help="UR5_joint1.target_position, RG2_open.int_signal, ... (what the motors obey)",
    )
    group.add_argument(
        "--cameras",
        metavar="NAME[:WxH]",
        nargs="+",
        default=[],
        type=_checked(Wanted.parse, "NAME or NAME:WxH, such as kinect_rgb:128x96; overview shows all"),
        help="images of cameras and vision sensors, in any size; overview shows all",
    )
    group.add_argument(
        "--light",
        metavar="X[,AZ,EL]",
        default=Light(),
        type=_checked(Light.parse, "0.5 for half the brightness, or with a direction in degrees 1,90,30"),
        help="light of the images: brightness, and in degrees from where it shines (1)",
    )
    group.add_argument("--successes", action="store_true", help="only episodes that are marked as a success")
    group.add_argument("--task", metavar="TEXT", help="what is shown, in words (the scene's name)")


def _checked(parse: Callable[[str], Any], valid: str) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            return parse(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} cannot be used; valid: {valid}") from None

    return read


@contextmanager
def export_datasets(world: World, options: argparse.Namespace) -> Generator[Collector | None]:
    """Write the episodes that are replayed meanwhile; yield their collector, or None if no dataset is wanted.

    Raises:
        CommandError, OutputError, OSError: a dataset cannot be written, or the recording has no episode for it.
    """
    writers = _writers(world, options)
    if not writers:
        yield None
        return

    def write(layout: Layout, episode: Episode) -> None:
        for writer in writers:
            writer.add(layout, episode)

    choice = Choice(
        options.observe, options.act, options.cameras, options.light, only_successes=options.successes
    )
    collector = Collector(world, choice, write)
    try:
        yield collector
        collector.check()
    finally:
        for writer in writers:
            writer.close()
    if not collector.episodes:
        which = " that is marked as a success" if options.successes else ""
        raise CommandError(f"no episode is written: the recording has none{which}")


def _writers(world: World, options: argparse.Namespace) -> list[Writer]:
    """Return what writes the wanted datasets. Raises OutputError."""
    task = options.task or world.simulation.scene.name
    writers: list[Writer] = []
    if options.npz is not None:
        from simx_server.datasets.npz import NpzWriter

        writers.append(NpzWriter(options.npz.expanduser().resolve(), task))
    if options.lerobot is not None:
        from simx_server.datasets.lerobot.writer import LeRobotWriter

        writers.append(LeRobotWriter(options.lerobot.expanduser().resolve(), task))
    if options.minari is not None:
        from simx_server.datasets.minari import MinariWriter

        writers.append(MinariWriter(options.minari.expanduser().resolve(), task))
    return writers
