"""``simVision``: a script's work image of each sensor, its two buffers, and transfers between them and the sensor."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.callbacks.images import wait_for
from simx_server.sensors.vision.filters import image_filters as filters
from simx_server.sensors.vision.filters.image_filters import Image
from simx_server.sensors.vision.filters.work import Work
from simx_server.sim_api.base import ApiPart

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_PLAIN = 0xFFFFF
"""A handle without flags."""


class WorkImages(ApiPart, effect="changes"):
    """Functions for work images. Rows come bottom first, colours are 0..1. The first result of each function is
    whether the sensor should detect.

    simVision.sensorImgToWorkImg or simVision.sensorDepthMapToWorkImg creates a work image; buffers are black first.
    Each script has separate images, which end with it.
    """

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._works: dict[int, Work] = {}
        self._maps: dict[int, tuple[NDArray[np.intp], Image | None]] = {}
        """Indices of pixels and factors of depths (n,), by sensor."""

    def sensorImgToWorkImg(self, sensor: int) -> bool:
        """Copy the sensor's present image, which other clients also get, to the work image."""
        handle = self._sensor(sensor)
        future = self._world.vision.image(handle, as_grey=False, as_handled=True)
        (width, height), data = wait_for(self._sim, future)
        return self._begin(handle, np.frombuffer(data, np.uint8).reshape(height, width, 3) / 255.0)

    def sensorDepthMapToWorkImg(self, sensor: int) -> bool:
        """Copy the depth in grey to the work image: 0 at the near plane, 1 at the far one."""
        handle = self._sensor(sensor)
        (width, height), data = wait_for(self._sim, self._world.vision.depth(handle, as_handled=True))
        depth = np.frombuffer(data, "<f4").reshape(height, width).astype(float)
        return self._begin(handle, filters.as_grey(depth))

    def workImgToSensorImg(self, sensor: int, remove: bool = True) -> bool:
        """Set the image that clients get until the next handling of the sensor. The work image stays, whatever
        `remove` is.
        """
        pixels = np.rint(self._fitting(sensor) * 255.0).astype(np.uint8)
        self._world.vision.filter_image(self._sensor(sensor), pixels)
        return False

    def workImgToSensorDepthMap(self, sensor: int, remove: bool = True) -> bool:
        """Set the depth that clients get until the next handling of the sensor: the mean of a pixel's colours, 0 at
        the near plane to 1 at the far one. The work image stays, whatever `remove` is.
        """
        depth = self._fitting(sensor).mean(axis=2).astype(np.float32)
        self._world.vision.filter_depth(self._sensor(sensor), depth)
        return False

    def distort(
        self, sensor: int, pixel_map: list[int] | None = None, depth_scalings: list[float] | None = None
    ) -> int:
        """Give clients an image with other pixels in each place until the next handling of the sensor; return 1.

        `pixel_map`: for each pixel the index of the one to take, row by row from the bottom, from 0; nil: as in the
        last call. `depth_scalings`: factors of the distances in metres; nil: the depth stays, or without a
        `pixel_map` as in the last call.
        """
        handle = self._sensor(sensor)
        settings = self._world.vision.settings(handle)
        count = settings.width * settings.height
        for values in (pixel_map, depth_scalings):
            if values is not None and len(values) != count:
                raise CommandError(f"the image has {count} pixels; the map has {len(values)} numbers")
        if pixel_map is not None:
            if count and not 0 <= min(pixel_map) <= max(pixel_map) < count:
                raise CommandError(f"a map of pixels has indices from 0 to {count - 1}")
            self._maps[handle] = np.array(pixel_map, dtype=np.intp), None
        if handle not in self._maps:
            raise CommandError("the first call needs a map of pixels")
        if depth_scalings is not None:
            self._maps[handle] = self._maps[handle][0], np.array(depth_scalings)
        indices, factors = self._maps[handle]
        if len(indices) != count:
            raise CommandError("the sensor's resolution has changed since the map was given; give another")
        vision, shape = self._world.vision, (settings.height, settings.width)
        _, data = wait_for(self._sim, vision.image(handle, as_grey=False, as_handled=True))
        depths: bytes | None = None
        if factors is not None:
            _, depths = wait_for(self._sim, vision.depth(handle, as_handled=True))
        vision.filter_image(handle, np.frombuffer(data, np.uint8).reshape(-1, 3)[indices].reshape(*shape, 3))
        if depths is not None and factors is not None:
            near, extent = settings.near, settings.far - settings.near
            metres = (near + extent * np.frombuffer(depths, "<f4")[indices]) * factors
            scaled = np.clip((metres - near) / extent, 0.0, 1.0).astype(np.float32)
            vision.filter_depth(handle, scaled.reshape(shape))
        return 1

    def workImgToBuffer1(self, sensor: int) -> bool:
        work = self._work(sensor)
        work.buffer1 = work.image.copy()
        return False

    def workImgToBuffer2(self, sensor: int) -> bool:
        work = self._work(sensor)
        work.buffer2 = work.image.copy()
        return False

    def swapBuffers(self, sensor: int) -> bool:
        work = self._work(sensor)
        work.buffer1, work.buffer2 = work.buffer2, work.buffer1
        return False

    def buffer1ToWorkImg(self, sensor: int) -> bool:
        work = self._work(sensor)
        work.image = work.buffer1.copy()
        return False

    def buffer2ToWorkImg(self, sensor: int) -> bool:
        work = self._work(sensor)
        work.image = work.buffer2.copy()
        return False

    def swapWorkImgWithBuffer1(self, sensor: int) -> bool:
        work = self._work(sensor)
        work.image, work.buffer1 = work.buffer1, work.image
        return False

    def addWorkImgToBuffer1(self, sensor: int) -> bool:
        """Add the work image to buffer 1, with components of at most 1."""
        self._work(sensor).add_to_buffer1()
        return False

    def subtractWorkImgFromBuffer1(self, sensor: int) -> bool:
        """Subtract the work image from buffer 1, with components of at least 0."""
        self._work(sensor).subtract_from_buffer1()
        return False

    def addBuffer1ToWorkImg(self, sensor: int) -> bool:
        """Add buffer 1 to the work image, with components of at most 1."""
        self._work(sensor).add_buffer1()
        return False

    def subtractBuffer1FromWorkImg(self, sensor: int) -> bool:
        """Subtract buffer 1 from the work image, with components of at least 0."""
        self._work(sensor).subtract_buffer1()
        return False

    def multiplyWorkImgWithBuffer1(self, sensor: int) -> bool:
        """Multiply the work image by buffer 1, with components of at most 1."""
        self._work(sensor).multiply_with_buffer1()
        return False

    def _begin(self, handle: int, image: Image) -> bool:
        work = self._works.get(handle)
        if work is None or work.image.shape != image.shape:
            self._works[handle] = Work.beginning_with(image)
        else:
            work.image = image
        return False

    def _fitting(self, sensor: int) -> Image:
        """Return the work image (height, width, 3) from 0 to 1. Raises CommandError: the sensor has another size."""
        handle, work = self._sensor(sensor), self._work(sensor)
        settings = self._world.vision.settings(handle)
        if work.image.shape != (settings.height, settings.width, 3):
            raise CommandError(
                "the sensor's resolution has changed since simVision.sensorImgToWorkImg; call that again"
            )
        return np.clip(work.image, 0.0, 1.0)

    def _sensor(self, sensor: int) -> int:
        plain = sensor & _PLAIN if sensor >= 0 else sensor
        return self._sim.scene.get_kind(self._self(plain), ObjectKind.VISION_SENSOR).handle

    def _work(self, sensor: int) -> Work:
        handle = self._sensor(sensor)
        if handle not in self._works:
            raise CommandError(
                "the sensor has no work image yet; call simVision.sensorImgToWorkImg or "
                "simVision.sensorDepthMapToWorkImg first"
            )
        return self._works[handle]


def numbers(values: list[float], count: int, what: str) -> list[float]:
    """Return the first `count` numbers.

    Raises:
        CommandError: there are fewer numbers.
    """
    if len(values) < count:
        raise CommandError(f"{what} has {count} numbers, not {len(values)}")
    return values[:count]
