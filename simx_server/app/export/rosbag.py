"""Write the replay of a recording as a bag of ROS 2."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from simx_server.gateways.ros2.bag.bag import Bag
from simx_server.gateways.ros2.bag.bag_folder import SUFFIX, file_of, write_metadata
from simx_server.world.world import World


@contextmanager
def export_rosbag(world: World, path: Path, *, drive: str | None, began: int, images: bool) -> Generator[Bag]:
    """Write what is simulated meanwhile into a bag, which is complete afterwards.

    Args:
        path: a new folder, or a file that ends in `.mcap`.
        ``began``, drive, images: as `Bag` has them.

    Raises:
        OutputError: it cannot be written, or a package is missing.
    """
    bag = Bag(world, file_of(path), drive=drive, began=began, images=images)
    try:
        yield bag
    finally:
        bag.close()
        if path.suffix != SUFFIX:
            write_metadata(bag.writer)
