"""The points of a laser scanner that a point cloud shows: those of its last turn, coloured by their distance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.parts.clouds.clouds import GLOWS

if TYPE_CHECKING:
    from simx_server.world.world import World

Array = NDArray[np.float64]

HIDDEN, LATEST_ONLY, EMISSIVE = 1, 2, 8
"""Bits of a scanner's options."""

_COLORS = np.array([[0, 0, 255], [255, 0, 255], [255, 0, 0], [255, 255, 0]], float)
"""From far to near, at equal steps."""


@dataclass
class ScannedPoints:
    """The points of a scanner that a point cloud shows."""

    cloud: int
    options: int
    near: float
    far: float
    """Distances in metres of the first and the last colour."""
    scaling: float
    """Factor from distances to those that are shown."""
    azimuths: Array = field(default_factory=lambda: np.zeros(0))
    """(n,) 0 to a whole turn."""
    places: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(n, 3) in the world."""
    colors: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((0, 3), np.uint8))

    def begin(self, world: World, point_size: float) -> None:
        """Give the cloud the scanner's options. Raises UnknownHandle, WrongKind, CommandError."""
        world.clouds.points(self.cloud)
        if not 0.0 <= point_size < math.inf:
            raise CommandError(f"a point has a size of 0 or more pixels, not {point_size}")
        settings = world.clouds.settings(self.cloud)
        options = settings.options & ~GLOWS | (GLOWS if self.options & EMISSIVE else 0)
        world.clouds.set_settings(self.cloud, replace(settings, options=options, point_size=point_size))

    def renew(
        self,
        world: World,
        part: tuple[float, float],
        points: Array,
        pose: tuple[Array, Array],
    ) -> None:
        """Show the points that were scanned.

        Args:
            world: the world.
            part: first azimuth and range of the scan, radians.
            points: (n, 3) in the frame of the first sensor.
            pose: position (3,) and rotation matrix (3, 3) of that frame.
        """
        distances = np.linalg.norm(points, axis=1)
        start, turn = part
        old = (self.azimuths - start) % (2 * math.pi) >= turn
        if self.options & LATEST_ONLY:
            old[:] = False
        azimuths = np.arctan2(points[:, 0], points[:, 2]) % (2 * math.pi)
        places = points * self.scaling @ pose[1].T + pose[0]
        self.azimuths = np.concatenate([self.azimuths[old], azimuths])
        self.places = np.concatenate([self.places[old], places])
        self.colors = np.concatenate([self.colors[old], self._colors(distances)])
        shown = world.clouds.points(self.cloud)
        shown.clear()
        world.clouds.check_room(len(self.places))
        shown.add(world.clouds.local(self.cloud, self.places), self.colors)
        world.clouds.note_change(self.cloud)

    def end(self, world: World) -> None:
        """Remove all points."""
        if self.cloud in world.simulation.scene.objects:
            world.clouds.points(self.cloud).clear()
            world.clouds.note_change(self.cloud)

    def _colors(self, distances: Array) -> NDArray[np.uint8]:
        reach = self.far - self.near
        intensity = 1.0 - (distances - self.near) / (reach if abs(reach) > 1e-9 else 1e-9)
        steps = np.linspace(0.0, 1.0, len(_COLORS))
        channels = [np.interp(intensity, steps, _COLORS[:, channel]) for channel in range(3)]
        return np.stack(channels, axis=1).astype(np.uint8)
