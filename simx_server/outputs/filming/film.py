"""Film a run: on the physics thread, request an image whenever a frame is due.

Frame n of a run shows the first complete simulation step at or after n / fps seconds of simulated time, so the film
plays in simulated time whatever the pace was. Several runs follow one another; while the simulation is stopped, no
frames are made. Physics never waits for an image. When the wall clock sets the pace, a frame for which rendering or
encoding is too slow repeats the one before. Without a pace, at ``--speed max`` and in stepped mode, the next simulation
step waits until there is space again (`Part.holds_step`), so every frame is made, except perhaps the first of a run
that follows at once; calls are answered meanwhile.
"""

from __future__ import annotations

import logging
import math
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.simulation.part import Part

from .film_file import FilmWriter
from .shot import Shot, first_image

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

MOST_FPS = 25
"""Frames per simulated second when no rate is given."""

MOST_WAITING = 8
"""Frames that were requested and are not encoded yet; 22 MB of 1280 x 720."""


class Film(Part):
    """Listens to a simulation. Physics thread only. Close it at the end, before rendering is closed."""

    def __init__(self, sim: Simulation, path: Path, shot: Shot, fps: float | None = None) -> None:
        """Start a film.

        Args:
            fps: frames per simulated second; None: one for each simulation step, MOST_FPS at most.

        Raises:
            OutputError: the file cannot be written, or the package for films is missing.
            CommandError: images cannot be made here.
        """
        self._sim = sim
        self._shot = shot
        per_step = Fraction(1 / sim.time_step).limit_denominator(1000)
        self.fps = min(Fraction(MOST_FPS), per_step) if fps is None else Fraction(fps).limit_denominator(1000)
        # Choosing the renderer takes a second or two, which the first frames would lack.
        first_image(shot)
        self._writer = FilmWriter(path, shot.size, self.fps)
        self._begin = self._next = 0
        """Frame numbers: of the present run's first, and of the next one."""

        self.behind = 0
        """Frames that repeat the one before because rendering or encoding could not keep up."""

        self.unseen = 0
        """Frames that do so because the scene had no such camera."""

        sim.parts.attach(self)

    def close(self) -> None:
        """Encode the waiting frames and end the file."""
        self._writer.end(self._next)
        if self._writer.has_failed:
            return
        repeated = self.behind + self._writer.not_made
        logger.info(
            "'%s' has %d frames of %s, %.2f s of simulated time; %d of them repeat the one before, as rendering could "
            "not keep up, and %d, as the camera was missing",
            self._writer.path, self._next, self._shot.name, self._next / self.fps, repeated, self.unseen,
        )  # fmt: skip

    def run_started(self) -> None:
        self._begin = self._next
        self._take(self._begin)

    def step_finished(self) -> None:
        number = self._begin + math.floor(self._sim.time * self.fps + 1e-6)
        if number >= self._next:
            self._take(number)

    def _take(self, number: int) -> None:
        """Request an image for a frame. The writer fills frames without an image with the one before."""
        count, self._next = number + 1 - self._next, number + 1
        if self._writer.has_failed:
            return
        if self.holds_step():
            self.behind += count
            return
        try:
            image = self._shot.ask()
        except CommandError as problem:
            if not self.unseen:
                logger.warning("the film goes on with its last image: %s", problem)
            self.unseen += count
            return
        self._writer.put(number, image)

    def holds_step(self) -> bool:
        return self._writer.waiting >= MOST_WAITING
