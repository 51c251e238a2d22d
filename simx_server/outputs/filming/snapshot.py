"""Write one image to a file: of a scene, or of a moment in a replay, without serving clients."""

from __future__ import annotations

import logging
from concurrent.futures import Future
from pathlib import Path

import cv2

from simx_server.errors import CommandError
from simx_server.outputs.packages import OutputError
from simx_server.outputs.running import run_for
from simx_server.simulation.part import Part
from simx_server.world.world import World

from .shot import Pixels, Shot, awaited, first_image

logger = logging.getLogger(__name__)


def write_snapshot(world: World, path: Path, shot: Shot, duration: float | None) -> None:
    """Write a PNG of the scene as it was loaded, or as it is after this many simulated seconds of running.

    The run is as fast as possible. An existing file is replaced.

    Raises:
        OutputError: the run ended before, or the file cannot be written.
        CommandError: the image could not be made.
    """
    try:
        if duration is not None:
            run_for(world, duration, "picture")
        pixels = first_image(shot)
    finally:
        world.simulation.stop()
    _write(pixels, path, shot)


class Moment(Part):
    """An image of one moment in a replay. Physics thread only."""

    def __init__(self, world: World, shot: Shot, second: float | None = None) -> None:
        """Wait for the moment.

        Args:
            second: the first complete simulation step at or after this simulated time, of all runs one after the other;
                None: the end of the last run, before the stop resets it.

        Raises:
            CommandError: images cannot be made here.
        """
        first_image(shot)  # report problems now, and not after a long run
        self._sim = sim = world.simulation
        self._shot = shot
        self._second = second
        self._elapsed = 0.0
        self._image: Future[Pixels] | None = None
        sim.parts.attach(self)

    def write(self, path: Path) -> None:
        """Write the image as a PNG, after the replay. An existing file is replaced.

        Raises:
            OutputError: the moment did not come, or the file cannot be written.
            CommandError: the image could not be made.
        """
        if self._second is None and (self._image is None or self._sim.is_running):
            self._take()
        if self._image is None:
            raise OutputError(
                f"there are only {self._elapsed:g} s of simulated time, so there is no picture of {self._second:g} s; "
                "give a shorter --duration, or none for the end of the last run"
            )
        _write(awaited(self._shot, self._image), path, self._shot)

    def run_ending(self) -> None:
        if self._second is None:
            self._take()

    def step_finished(self) -> None:
        self._elapsed += self._sim.time_step
        if self._second is not None and self._image is None and self._elapsed >= self._second - 1e-9:
            self._take()

    def _take(self) -> None:
        try:
            self._image = self._shot.ask()
        except CommandError as problem:  # the run goes on
            self._image = Future()
            self._image.set_exception(problem)


def _write(pixels: Pixels, path: Path, shot: Shot) -> None:
    made, png = cv2.imencode(".png", pixels[..., ::-1])
    if not made:
        raise OutputError(f"OpenCV cannot make a PNG of {pixels.shape[1]} x {pixels.shape[0]} pixels")
    try:
        path.write_bytes(png.tobytes())
    except OSError as error:
        raise OutputError(
            f"'{path}' cannot be written: {error.strerror}; give --snapshot a file in a folder that may be written"
        ) from None
    logger.info("'%s' is an image of %s, %d x %d", path, shot.name, pixels.shape[1], pixels.shape[0])
