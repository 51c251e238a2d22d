"""One picture of a scene, as a file. Nobody is served."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import cv2

from ..outputs import OutputError
from ..simulation import Simulation, SimulationState
from .shot import Shot, first_picture

logger = logging.getLogger(__name__)


def write_snapshot(sim: Simulation, path: Path, shot: Shot, duration: float | None) -> None:
    """Write a PNG of the scene as it was loaded, or as it is after so many simulated seconds of running.

    They go by as fast as they can. A file that is there already is replaced.

    Raises:
        OutputError: the run ended before, or the file cannot be written.
        CommandError: the picture could not be made.
    """
    try:
        if duration is not None:
            _run(sim, duration)
        pixels = first_picture(shot)
    finally:
        sim.stop()
    made, png = cv2.imencode(".png", pixels[..., ::-1])
    if not made:
        raise OutputError(f"OpenCV cannot make a PNG of {pixels.shape[1]} x {pixels.shape[0]} pixels")
    try:
        path.write_bytes(png.tobytes())
    except OSError as error:
        raise OutputError(
            f"'{path}' cannot be written: {error.strerror}; give --snapshot a file in a folder that may be written"
        ) from None
    logger.info("'%s' is a picture of %s, %d x %d", path, shot.name, pixels.shape[1], pixels.shape[0])


def _run(sim: Simulation, duration: float) -> None:
    sim.start()
    passes = max(1, math.ceil(duration / sim.time_step - 1e-9))
    for _ in range(passes):
        sim.advance()
        if sim.state is not SimulationState.RUNNING:
            raise OutputError(
                f"the run ended or was paused before its {duration:g} s were over, so there is no picture of its end"
            )
