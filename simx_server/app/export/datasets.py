"""Write the replay of a recording as datasets of demonstrations."""

from __future__ import annotations

import argparse
from collections.abc import Generator
from contextlib import contextmanager

from simx_server.datasets.episodes import Choice, Collector, Episode, Layout, Writer
from simx_server.errors import CommandError
from simx_server.world.world import World


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
