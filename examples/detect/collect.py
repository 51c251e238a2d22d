"""Pictures of a ball through the hand camera, with labels, to train a detector: ``python examples/detect/collect.py``.

It starts a simulator of the tutorial's scene and ends it. The labels come from the camera itself, which can tell the
object of each pixel. The set lies in detect_output/set then, and a sheet of some of its pictures beside it.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from pathlib import Path

import pictures
from simulator import simulator
from studio import Shot, Studio

from simx_client import Client
from simx_client.errors import SimxError

SET = Path("detect_output") / "set"
ON_THE_SHEET = 12
HELD_OUT = 6
"""Every sixth picture is for the test: it is not learned from."""


def bar(count: int) -> Iterator[int]:
    """Counts, and shows how far it is; tqdm where that is installed."""
    try:
        from tqdm import tqdm

        yield from tqdm(range(count), unit="picture", leave=False)
    except ImportError:
        for number in range(count):
            print(f"\r{number:6} of {count} [{'#' * (40 * number // count):40}]", end="", file=sys.stderr)
            yield number
        print(file=sys.stderr)


def collect(client: Client, folder: Path, count: int, seed: int) -> float:
    """Take pictures and save them with their labels; gives how many a second. Raises SimxError, OSError."""
    pictures.begin(folder)
    shown: list[pictures.CameraImage] = []
    with client.stepping():
        studio = Studio(client, seed)
        began = time.perf_counter()
        for number in bar(count):
            shot: Shot = studio.take()
            boxes = [] if shot.box is None else [shot.box]
            split = "val" if number % HELD_OUT == HELD_OUT - 1 else "train"
            pictures.save(folder, split, number, shot.picture, boxes)
            if len(shown) < ON_THE_SHEET:
                shown.append(pictures.with_boxes(shot.picture, boxes))
        rate = count / (time.perf_counter() - began)
    pictures.write(folder.parent / "preview.png", pictures.sheet(shown))
    return rate


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Take labelled pictures of a ball.")
    parser.add_argument("--count", type=int, default=2400, help="pictures (2400); every sixth is held out")
    parser.add_argument("--folder", type=Path, default=SET, help=f"where they go ({SET})")
    parser.add_argument("--seed", type=int, default=1, help="equal seeds give equal pictures (1)")
    parser.add_argument(
        "--port",
        type=int,
        help="of a running `simx-server ur5_rg2_kinect --command-server --allow-code`, in place of one of its own",
    )
    chosen = parser.parse_args(arguments)
    # As an exception, so that the simulator ends with it.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    try:
        with (
            simulator() if chosen.port is None else nullcontext(chosen.port) as port,
            Client("127.0.0.1", port) as client,
        ):
            rate = collect(client, chosen.folder, chosen.count, chosen.seed)
    except (SimxError, OSError, RuntimeError) as problem:  # the last: its own simulator did not get ready
        sys.exit(f"collect.py: {problem}")
    print(
        f"{chosen.count} pictures in {chosen.folder}, {rate:.1f} a second; see {chosen.folder.parent / 'preview.png'}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
