"""``simVision``: rotating laser scanners made of four vision sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import compose, inverse, matrix
from simx_server.scripting.callbacks.images import wait_for
from simx_server.sensors.vision.filters import detections
from simx_server.sensors.vision.filters import image_filters as filters
from simx_server.sensors.vision.filters.work import Work
from simx_server.sim_api.base import ApiPart

from .scanned_points import HIDDEN, ScannedPoints
from .sim_vision_images import numbers

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_IN_THE_WORLD = 0x800000
"""sim.handleflag_abscoords."""

_POLAR = 4
"""The option bit of angles and a distance instead of coordinates."""

_MOST_SCANNERS = 100

_COLORING = (1.0, 5.0)
"""Distances in metres of the first and the last colour, unless a script gives them."""

_VPL16 = 16, math.radians(30.0)
_HDL64E = 64, math.radians(26.8)
"""Number of lasers of each, and the angle that they cover."""

_JUST_BELOW_FAR = 0.9999


@dataclass
class _Scanner:
    sensors: tuple[int, ...]
    frequency: float
    options: int
    rows: int
    angle: float
    shown: ScannedPoints | None = None
    azimuth: float = 0.0
    """Direction of the lasers, radians from the view of the first sensor about its y axis."""


class VelodyneFunctions(ApiPart):
    """Functions for scanners: each needs vision sensors with explicit handling that look in all directions."""

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._scanners: dict[int, _Scanner] = {}

    def createVelodyneVPL16(
        self,
        sensors: list[int],
        frequency: float,
        options: int = 0,
        size: float = 2.0,
        colors: list[float] | None = None,
        scaling: float = 1.0,
        cloud: int = -1,
    ) -> int:
        """Return the handle of a scanner with 16 lasers over 30 degrees, `frequency` turns per second.

        Options: 1 `cloud` gets no points, 2 it gets those of the last handling only, 4 data are azimuth, elevation and
        distance, 8 its colours are emissive. `size`: pixels of its points; `colors`: distances of yellow and blue (m);
        `scaling`: factor for the points that are shown.

        Partly: without a point cloud no points are drawn.
        """
        shown = self._shown(cloud, options, size, colors, scaling)
        return self._create(sensors, frequency, options, *_VPL16, shown)

    def createVelodyneHDL64E(
        self,
        sensors: list[int],
        frequency: float,
        options: int = 0,
        size: float = 2.0,
        colors: list[float] | None = None,
        scaling: float = 1.0,
        cloud: int = -1,
    ) -> int:
        """Create a sensor as simVision.createVelodyneVPL16 does, with 64 lasers over 26.8 degrees.

        Partly: without a point cloud no points are drawn.
        """
        shown = self._shown(cloud, options, size, colors, scaling)
        return self._create(sensors, frequency, options, *_HDL64E, shown)

    def handleVelodyneVPL16(self, scanner: int, step: float) -> list[float]:
        """Turn on by `step` seconds; return x, y, z of the points that the lasers met meanwhile, in the frame of the
        first sensor, or in the world with sim.handleflag_abscoords added to the handle.
        """
        known = self._scanner(scanner)
        turn = min(2 * math.pi, 2 * math.pi * known.frequency * max(step, 0.0))
        start, known.azimuth = known.azimuth, (known.azimuth + turn) % (2 * math.pi)
        found = [self._scan(known, sensor, start, turn) for sensor in known.sensors]
        points = np.concatenate(found) if found else np.zeros((0, 3))
        position, quaternion = frames.get_pose(self._sim, known.sensors[0])
        pose = np.array(position), np.array(matrix(quaternion))
        if known.shown is not None:
            known.shown.renew(self._world, (start, turn), points, pose)
        if scanner & _IN_THE_WORLD:
            points = points @ pose[1].T + pose[0]
        if known.options & _POLAR:
            points = _polar(points)
        return points.ravel().tolist()

    handleVelodyneHDL64E = handleVelodyneVPL16

    def destroyVelodyneVPL16(self, scanner: int) -> int:
        """Remove a scanner and the points of its cloud; its sensors stay."""
        if (shown := self._scanner(scanner).shown) is not None:
            shown.end(self._world)
        del self._scanners[scanner & ~_IN_THE_WORLD]
        return 1

    destroyVelodyneHDL64E = destroyVelodyneVPL16

    def _shown(
        self, cloud: int, options: int, size: float, colors: list[float] | None, scaling: float
    ) -> ScannedPoints | None:
        if cloud == -1 or options & HIDDEN:
            return None
        near, far = numbers(colors, 2, "colours by distance") if colors else _COLORING
        shown = ScannedPoints(self._self(cloud), options, near, far, scaling)
        shown.begin(self._world, size)
        return shown

    def _create(
        self,
        sensors: list[int],
        frequency: float,
        options: int,
        rows: int,
        angle: float,
        shown: ScannedPoints | None,
    ) -> int:
        if not sensors or not frequency > 0.0:
            raise CommandError("a scanner needs vision sensors, and turns more than 0 times per second")
        if len(self._scanners) >= _MOST_SCANNERS:
            raise CommandError(f"a script has at most {_MOST_SCANNERS} scanners; destroy some")
        handles = tuple(
            self._sim.scene.get_kind(self._self(sensor), ObjectKind.VISION_SENSOR).handle
            for sensor in sensors
        )
        number = max(self._scanners, default=-1) + 1
        self._scanners[number] = _Scanner(handles, frequency, options, rows, angle, shown)
        return number

    def _scanner(self, scanner: int) -> _Scanner:
        known = self._scanners.get(scanner & ~_IN_THE_WORLD)
        if known is None:
            raise CommandError(
                f"no scanner has the handle {scanner}; create one with simVision.createVelodyneVPL16"
            )
        return known

    def _scan(self, scanner: _Scanner, sensor: int, start: float, turn: float) -> NDArray[np.float64]:
        """Return (points, 3) in the first sensor's frame: those that a sensor sees in a range of azimuths."""
        settings = self._world.vision.settings(sensor)
        first, own = (frames.get_pose(self._sim, one) for one in (scanner.sensors[0], sensor))
        position, quaternion = compose(inverse(first), own)
        rotation = np.array(matrix(quaternion))
        yaw = math.atan2(rotation[0, 2], rotation[2, 2])
        half = math.atan(settings.view.half[0])
        if turn + 2 * half < (start + turn - yaw + half) % (2 * math.pi):
            return np.zeros((0, 3))  # the lasers do not pass its view
        self._world.vision.handle(sensor)
        (width, height), data = wait_for(self._sim, self._world.vision.depth(sensor))
        depth = np.frombuffer(data, "<f4").reshape(height, width).astype(float)
        with self._at_no_cost():
            work = Work.beginning_with(filters.as_grey(depth))
            points = detections.scan(work, settings.view, (width, scanner.rows), scanner.angle)
            azimuth = (np.arctan2(points[:, 0], points[:, 2]) + yaw - start) % (2 * math.pi)
            met = (azimuth < turn) & (points[:, 3] < settings.far * _JUST_BELOW_FAR)
            return points[met, :3] @ rotation.T + np.array(position)


def _polar(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (points, 3): azimuth about y from z, elevation, distance."""
    x, y, z = points.T
    return np.stack([np.arctan2(x, z), np.arctan2(y, np.hypot(x, z)), np.linalg.norm(points, axis=1)], axis=1)
