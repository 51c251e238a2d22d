"""Vision sensors: handling, statistics, images and depth.

Images are rendered on the render thread, which never waits for the physics. A script that requests one waits until
the image of this simulation step is ready, so that the same script always gets the same numbers. The wait has a
time-out and does not count as processor time of the script.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers import vision
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.callbacks.images import wait_for
from simx_server.scripting.interpreter import Constant
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_T = TypeVar("_T", bound=np.generic)

_FLAG_GREY = _FLAG_STRING = 0x400000
"""sim.handleflag_greyscale of images, sim.handleflag_codedstring of depth."""
_FLAG_METRES = 0x800000
_FLAGS = 0xFF00000 | _FLAG_GREY | _FLAG_METRES

_MOST_NUMBERS = 2_000_000
"""Numbers in a table with an image: 64 MB."""

_AS_STRING = 1
_GREY = _METRES = 1
_ALPHA = 2
"""Bits of the options of CoppeliaSim 4's functions."""

_NEAREST = 1e-9
"""Share of the depth between the planes that stands for the near one."""


class VisionFunctions(ApiPart, effect="changes"):
    """Functions for vision sensors. Rows come bottom first. Regions: x and y of the lower left pixel, width and
    height; 0, 0 is the whole image.
    """

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "handleflag_greyscale": _FLAG_GREY,
        "handleflag_codedstring": _FLAG_STRING,
        "handleflag_depthbuffer": _FLAG_METRES,
        "handleflag_depthbuffermeters": _FLAG_METRES,
    }

    def handleVisionSensor(self, sensor: int) -> tuple[int | list[float] | None, ...]:
        """Render now; return 1 if the sensor detects, else 0, and 15 statistics; for sim.handle_all the number of
        sensors that detect.
        """
        if sensor not in (c.sim_handle_all, c.sim_handle_all_except_explicit):
            self._world.vision.handle(self._vision_sensor(sensor))
            return self.readVisionSensor(sensor)
        detecting = 0
        for handle in self._sim.scene.of_kind(ObjectKind.VISION_SENSOR):
            settings = self._world.vision.settings(handle)
            is_automatic = not settings.explicit and not settings.external
            if is_automatic:
                if settings.image is None:
                    self._world.vision.handle_automatic(handle)
                elif (
                    settings.image_step <= self._sim.step_count
                ):  # else a script has already processed the image of this simulation step
                    self._world.vision.handle(handle)
            elif sensor == c.sim_handle_all:
                self._world.vision.handle(handle)
            # Images of the others are rendered only if somebody reads them.
            if settings.may_detect and (is_automatic or sensor == c.sim_handle_all):
                detecting += self.readVisionSensor(handle)[0] == 1
        return (detecting,)

    @reads
    def readVisionSensor(self, sensor: int) -> tuple[int | list[float] | None, ...]:
        """Return 1 if the sensor detects, else 0; least, greatest, mean of intensity, red, green, blue, depth. -1 if
        not handled.
        """
        handle = self._vision_sensor(sensor)
        self._sim.physics_calls.refuse("a vision sensor cannot be read", step_only=True)
        try:
            future = self._world.vision.read(handle)
        except CommandError:
            return _with_packets(-1, [])  # the handle is valid, so this is the only reason
        triggered, packets = wait_for(self._sim, future)
        return _with_packets(int(triggered), packets)

    def resetVisionSensor(self, sensor: int) -> int:
        """Delete a handled or set image; also for sim.handle_all and similar handles."""
        if sensor not in (c.sim_handle_all, c.sim_handle_all_except_explicit):
            self._world.vision.reset(self._vision_sensor(sensor))
            return 1
        for handle in self._sim.scene.of_kind(ObjectKind.VISION_SENSOR):
            if sensor == c.sim_handle_all or not self._world.vision.settings(handle).explicit:
                self._world.vision.reset(handle)
        return 1

    @reads
    def checkVisionSensor(self, sensor: int, entity: int) -> tuple[int | list[float] | None, ...]:
        """Return 1 if the sensor detects, else 0, and the statistics of a new image of an object or collection, or of
        everything with sim.handle_all.
        """
        handle = self._vision_sensor(sensor)
        triggered, packets = wait_for(self._sim, self._world.vision.check(handle, entity))
        return _with_packets(int(triggered), packets)

    @reads
    def checkVisionSensorEx(self, sensor: int, entity: int, wants_image: bool) -> list[float]:
        """Return a new image (numbers 0..1) or depth (0..1) of an object or collection, or of everything with
        sim.handle_all.
        """
        handle = self._vision_sensor(sensor)
        made = wait_for(self._sim, self._world.vision.image_of(handle, entity))
        found = _shares(made.rgb) if wants_image and made.rgb is not None else made.depth
        assert found is not None
        return _as_table(found)

    @reads
    def getVisionSensorResolution(self, sensor: int) -> list[int]:
        """Return {width, height} in pixels."""
        settings = self._world.vision.settings(self._vision_sensor(sensor))
        return [settings.width, settings.height]

    getVisionSensorRes = getVisionSensorResolution

    @reads
    def getVisionSensorImage(
        self, sensor: int, x: int = 0, y: int = 0, width: int = 0, height: int = 0, kind: int = 0
    ) -> list[float] | bytes:
        """Return numbers 0..1, or with `kind` 1 a string of bytes; RGB, or grey with sim.handleflag_greyscale added. As
        in all functions that read an image, it is the background, and the depth 1, until a simulation step or a script
        has handled the sensor in this run.
        """
        pixels = self._pixels(sensor, [x, y], [width, height], grey=_has(sensor, _FLAG_GREY))
        return pixels.tobytes() if kind == _AS_STRING else _as_table(_shares(pixels))

    @reads
    def getVisionSensorCharImage(
        self, sensor: int, x: int = 0, y: int = 0, width: int = 0, height: int = 0, cut_off: float = 0.0
    ) -> tuple[bytes, int, int]:
        """Return a string of bytes, and the sensor's width and height. `cut_off` above 0 adds an alpha channel to the
        pixels: 0 where the depth (0..1) is above it, else 255.
        """
        pixels = self._pixels(sensor, [x, y], [width, height], _has(sensor, _FLAG_GREY), cut_off)
        across, up = self.getVisionSensorResolution(sensor)
        return pixels.tobytes(), across, up

    @reads
    def getVisionSensorImg(
        self,
        sensor: int,
        options: int = 0,
        cut_off: float = 0.0,
        position: list[int] | None = None,
        size: list[int] | None = None,
    ) -> tuple[bytes, list[int]]:
        """Return bytes and {width, height}: CoppeliaSim 4's form. `options`: 1 grey, 2 one byte more for each pixel:
        255 where the depth, 0 at the near plane to 1 at the far one, is at most `cut_off`, else 0.
        """
        cut_off = max(cut_off, _NEAREST) if options & _ALPHA else cut_off
        pixels = self._pixels(sensor, position, size, bool(options & _GREY), cut_off)
        return pixels.tobytes(), [pixels.shape[1], pixels.shape[0]]

    def setVisionSensorImage(self, sensor: int, image: list[float] | bytes) -> int:
        """Set the image until the next handling: numbers 0..1 or a string of bytes; grey with
        sim.handleflag_greyscale.
        """
        if isinstance(image, bytes):
            return self.setVisionSensorCharImage(sensor, image)
        numbers = np.clip(np.array(image, float), 0.0, 1.0) * 255.0
        return self.setVisionSensorCharImage(sensor, numbers.round().astype(np.uint8).tobytes())

    def setVisionSensorCharImage(self, sensor: int, image: bytes) -> int:
        """Set the image as sim.setVisionSensorImage does, with bytes. Too few bytes are an error."""
        width, height = self.getVisionSensorResolution(sensor)
        grey = _has(sensor, _FLAG_GREY)
        wanted = width * height * (1 if grey else 3)
        vision.set_vision_sensor_image(self._world, self._vision_sensor(sensor), image[:wanted], int(grey))
        return 1

    def setVisionSensorImg(
        self,
        sensor: int,
        image: bytes | list[float],
        options: int = 0,
        position: list[int] | None = None,
        size: list[int] | None = None,
    ) -> int:
        """Set the image, or a part of it: CoppeliaSim 4's form. `options`: 1 grey, 2 one byte more for each pixel,
        which is ignored. `position` and `size` of the part in pixels; sizes 0 mean all.
        """
        handle = self._vision_sensor(sensor)
        flag = _FLAG_GREY if options & _GREY else 0
        if not isinstance(image, bytes) or not (options & _ALPHA or any([*(position or []), *(size or [])])):
            return self.setVisionSensorImage(handle | flag, image)
        whole = np.array(self._pixels(handle, None, None, bool(flag), 0.0))
        part = _region(whole, position, size)
        channels = (1 if flag else 3) + bool(options & _ALPHA)
        wanted = part.shape[0] * part.shape[1] * channels
        if len(image) < wanted:
            raise CommandError(
                f"{part.shape[1]} x {part.shape[0]} pixels have {wanted} bytes, not {len(image)}"
            )
        given = np.frombuffer(image, np.uint8, wanted).reshape(*part.shape[:2], channels)
        part[...] = given[..., 0] if flag else given[..., :3]
        return self.setVisionSensorCharImage(handle | flag, whole.tobytes())

    @reads
    def getVisionSensorDepthBuffer(
        self, sensor: int, x: int = 0, y: int = 0, width: int = 0, height: int = 0
    ) -> list[float] | bytes:
        """Return the depth: 0 at the near plane, 1 at the far one; with sim.handleflag_depthbuffermeters added
        metres.

        The result is a table, or with sim.handleflag_codedstring a string of little-endian float32.
        """
        depth = self._depth(sensor, [x, y], [width, height], _has(sensor, _FLAG_METRES))
        return depth.astype("<f4").tobytes() if _has(sensor, _FLAG_STRING) else _as_table(depth)

    @reads
    def getVisionSensorDepth(
        self,
        sensor: int,
        options: int = 0,
        position: list[int] | None = None,
        size: list[int] | None = None,
    ) -> tuple[bytes, list[int]]:
        """Return a string of little-endian float32 and {width, height}: CoppeliaSim 4's form; bit 0 of `options`:
        metres.
        """
        depth = self._depth(sensor, position, size, bool(options & _METRES))
        return depth.astype("<f4").tobytes(), [depth.shape[1], depth.shape[0]]

    def _vision_sensor(self, sensor: int) -> int:
        plain = sensor & ~_FLAGS if sensor > 0 else sensor
        return self._sim.scene.get_kind(self._self(plain), ObjectKind.VISION_SENSOR).handle

    def _pixels(
        self,
        sensor: int,
        position: list[int] | None,
        size: list[int] | None,
        grey: bool,
        cut_off: float = 0.0,
    ) -> NDArray[np.uint8]:
        """Return the pixels (height, width, channels) of a region."""
        handle = self._vision_sensor(sensor)
        future = self._world.vision.image(handle, as_grey=grey, as_handled=True)
        (width, height), data = wait_for(self._sim, future)
        pixels = _region(np.frombuffer(data, np.uint8).reshape(height, width, -1), position, size)
        if cut_off <= 0.0:
            return pixels
        near = self._depth(handle, position, size, metres=False) <= cut_off
        return np.concatenate([pixels, np.where(near, 255, 0).astype(np.uint8)[..., np.newaxis]], axis=2)

    def _depth(
        self, sensor: int, position: list[int] | None, size: list[int] | None, metres: bool
    ) -> NDArray[np.float32]:
        """Return the depth (height, width) of a region."""
        handle = self._vision_sensor(sensor)
        (width, height), data = wait_for(self._sim, self._world.vision.depth(handle, as_handled=True))
        depth = _region(np.frombuffer(data, "<f4").reshape(height, width), position, size)
        if not metres:
            return depth
        settings = self._world.vision.settings(handle)
        return depth * np.float32(settings.far - settings.near) + np.float32(settings.near)

    # Names of V-REP 2.

    handleRenderingSensor = handleVisionSensor
    readRenderingSensor = readVisionSensor
    resetRenderingSensor = resetVisionSensor
    checkRenderingSensor = checkVisionSensor
    checkRenderingSensorEx = checkVisionSensorEx
    getRenderingSensorResolution = getVisionSensorResolution
    getRenderingSensorImage = getVisionSensorImage
    setRenderingSensorImage = setVisionSensorImage
    getRenderingSensorDepthBuffer = getVisionSensorDepthBuffer


def _with_packets(result: int, packets: list[list[float]]) -> tuple[int | list[float] | None, ...]:
    """Return the results of a reading, at least three, since programs in Python name two packets."""
    return result, *packets, *[None] * (2 - len(packets))


def _shares(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return colours 0..1 in single precision, as V-REP's: programs find the bytes again by * 255."""
    return pixels.astype(np.float32) / np.float32(255)


def _as_table(image: NDArray[Any]) -> list[float]:
    """Return the numbers of an image. Raises CommandError: they are too many for a table."""
    if image.size > _MOST_NUMBERS:
        raise CommandError(
            f"a picture of {image.size} numbers is too large for a table, which takes {_MOST_NUMBERS}: read a "
            "region, or a string of bytes"
        )
    return image.ravel().tolist()


def _has(sensor: int, flag: int) -> bool:
    return sensor > 0 and bool(sensor & flag)


def _region(
    image: NDArray[_T],
    position: list[int] | None,
    size: list[int] | None,
) -> NDArray[_T]:
    """Return a region of an image.

    Raises:
        CommandError: the region is not within the image.
    """
    height, width = image.shape[:2]
    x, y, *_ = [*(position or ()), 0, 0]
    across, up, *_ = [*(size or ()), 0, 0]
    if across == up == 0:
        across, up = width, height
    if not (0 <= x < x + across <= width and 0 <= y < y + up <= height):
        raise CommandError(
            f"the region at {x}, {y} of {across} x {up} pixels is not within a picture of {width} x {height}"
        )
    return image[y : y + up, x : x + across]
