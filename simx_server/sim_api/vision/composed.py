"""``simVision``: images that are made of the images of several sensors."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.callbacks.images import wait_for
from simx_server.sensors.vision.spherical import SphericalMap, spherical_map
from simx_server.sim_api.base import ApiPart

Pixels = TypeVar("Pixels", NDArray[np.uint8], NDArray[np.float32])

_SIX = "front, top, back, bottom, left and right"
_HIGHLIGHTS = 4
"""Bit of `CameraView.unlit`."""

_LEAST_ANGLE = math.radians(5.0)
_RED_CYAN = [1.0, 0.0, 0.0, 0.0, 1.0, 1.0]


class ComposedImageFunctions(ApiPart, effect="changes"):
    """Functions that handle some sensors, and write an image into another, passive sensor."""

    def handleSpherical(
        self, passive: int, sensors: list[int], across: float, up: float, depth_passive: int = -1
    ) -> int:
        """Write an image of these angles (radians) around the front into a sensor: equal angles between columns, and
        between rows. `passive`, `depth_passive`: the sensors that get colours and depth, or -1; `sensors`: front, top,
        back, bottom, left, right, with square images over 90 degrees and explicit handling. As in V-REP, columns run
        from the right to the left of the front, and the one to the back is upside down; angles are at most a whole
        sphere; and the depth is the distance for Python, for files since CoppeliaSim 4.3 and for clients, before that
        the depth along the axis of each sensor.
        """
        if len(sensors) < 6:
            raise CommandError(f"a spherical image is made of six sensors: {_SIX}; got {len(sensors)}")
        active = [self._explicit(sensor) for sensor in sensors[:6]]
        takers = [self._handle_of(each) for each in (passive, depth_passive) if each != -1]
        sizes = {self._size(each) for each in takers}
        sides = {self._size(each) for each in active}
        if len(sizes) != 1:
            raise CommandError("there must be a sensor for colours or depth, and both have one resolution")
        (width, height) = sizes.pop()
        (side, other) = next(iter(sides))
        if len(sides) != 1 or side != other:
            raise CommandError(f"the sensors {_SIX} have one resolution, as high as wide")
        angles = [
            min(max(angle, _LEAST_ANGLE), most) for angle, most in ((across, 2 * math.pi), (up, math.pi))
        ]
        with self._at_no_cost():
            found = spherical_map(width, height, side, *angles)
        used: list[int] = np.unique(found.sensor).tolist()
        for each in used:
            self._handle_without_highlights(active[each])
        if passive != -1:
            images = {each: self._image(active[each]) for each in used}
            pixels = _gathered(found, images, np.zeros((height, width, 3), np.uint8))
            self._world.vision.set_image(takers[0], pixels.tobytes(), as_grey=False)
        if depth_passive != -1:
            depths = {each: self._depth(active[each]) for each in used}
            depth = _gathered(found, depths, np.zeros((height, width), np.float32))
            if self._script.full_results:
                settings = self._world.vision.settings(active[0])
                near, reach = settings.near, settings.far - settings.near
                depth = np.minimum(((near + reach * depth) * found.lengthening - near) / reach, 1.0)
            self._world.vision.set_image(takers[-1], _bytes_of(depth).tobytes(), as_grey=True)
        return 1

    def handleAnaglyphStereo(
        self, passive: int, sensors: list[int], colors: list[float] | None = None
    ) -> int:
        """Write the image of a left and a right sensor into a third one: grey, in one colour each. `colors`: RGB 0..1
        of the left and of the right one; without it red and cyan. All have one resolution and explicit handling.
        """
        if len(sensors) < 2:
            raise CommandError("a stereo image is made of two sensors, left and right")
        weights = _RED_CYAN if colors is None else colors
        if len(weights) < 6:
            raise CommandError("colours are red, green, blue for the left and for the right sensor")
        taker, *active = (self._explicit(each) for each in (passive, *sensors[:2]))
        if len({self._size(each) for each in (taker, *active)}) != 1:
            raise CommandError("the three sensors of a stereo image have one resolution")
        for each in active:
            self._world.vision.handle(each)
        left, right = (self._image(each).mean(axis=2, keepdims=True) for each in active)
        mixed = left * np.array(weights[:3]) + right * np.array(weights[3:6])
        self._world.vision.set_image(taker, np.clip(mixed, 0, 255).astype(np.uint8).tobytes(), as_grey=False)
        return 1

    def _handle_without_highlights(self, handle: int) -> None:
        """Handle a sensor as V-REP's plug-in did, since the highlights of neighbours do not fit together."""
        settings = self._world.vision.settings(handle)
        before = settings.unlit
        settings.unlit |= _HIGHLIGHTS
        try:
            self._world.vision.handle(handle)
        finally:
            settings.unlit = before

    def _handle_of(self, sensor: int) -> int:
        return self._sim.scene.get_kind(self._self(sensor), ObjectKind.VISION_SENSOR).handle

    def _explicit(self, sensor: int) -> int:
        handle = self._handle_of(sensor)
        if not self._world.vision.settings(handle).explicit:
            name = self._sim.scene.get(handle).name
            raise CommandError(f"vision sensor '{name}' must be handled explicitly: simx:vision explicit=yes")
        return handle

    def _size(self, handle: int) -> tuple[int, int]:
        settings = self._world.vision.settings(handle)
        return settings.width, settings.height

    def _image(self, handle: int) -> NDArray[np.uint8]:
        (width, height), data = wait_for(self._sim, self._world.vision.image(handle, as_grey=False))
        return np.frombuffer(data, np.uint8).reshape(height, width, 3)

    def _depth(self, handle: int) -> NDArray[np.float32]:
        (width, height), data = wait_for(self._sim, self._world.vision.depth(handle))
        return np.frombuffer(data, "<f4").astype(np.float32).reshape(height, width)


def _gathered(found: SphericalMap, images: dict[int, Pixels], made: Pixels) -> Pixels:
    """Fill an image with the pixels of the sensors' images."""
    for each, image in images.items():
        shown = found.sensor == each
        made[shown] = image[found.row[shown], found.column[shown]]
    return made


def _bytes_of(depth: NDArray[np.float32]) -> NDArray[np.uint8]:
    return (np.clip(depth, 0.0, 1.0) * 255.1).astype(np.uint8)  # as V-REP makes bytes of numbers
