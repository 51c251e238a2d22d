"""``simVision``: filters and detection on a sensor's work image (V-REP's vision plugin)."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import matrix
from simx_server.sensors.vision.filters import detections
from simx_server.sensors.vision.filters import image_filters as filters
from simx_server.sensors.vision.filters.image_filters import Mask
from simx_server.sensors.vision.filters.work import Work

from .composed import ComposedImageFunctions
from .sim_vision_images import WorkImages, numbers
from .velodyne import VelodyneFunctions

_MOST_POINTS = 320_000
"""Points of one packet: those of an image of 640 x 480 pixels, and some more."""

_IN_THE_WORLD = 0x800000
"""sim.handleflag_abscoords."""


class ImageFilters(WorkImages, effect="changes"):
    """Functions that change the work image. Sizes and shifts are shares of the image, colours RGB or, if not `rgb`,
    HSL.
    """

    def horizontalFlipWorkImg(self, sensor: int) -> bool:
        """Swap left and right."""
        work = self._work(sensor)
        work.image = filters.flipped_horizontally(work.image)
        return False

    def verticalFlipWorkImg(self, sensor: int) -> bool:
        """Swap top and bottom."""
        work = self._work(sensor)
        work.image = filters.flipped_vertically(work.image)
        return False

    def uniformImgToWorkImg(self, sensor: int, color: list[float]) -> bool:
        work = self._work(sensor)
        work.image = np.tile(numbers(color, 3, "a colour"), (*work.image.shape[:2], 1)).astype(float)
        return False

    def normalizeWorkImg(self, sensor: int) -> bool:
        """Scale the components so that the least becomes 0 and the greatest 1."""
        work = self._work(sensor)
        work.image = filters.normalised(work.image)
        return False

    def colorSegmentationOnWorkImg(self, sensor: int, max_distance: float) -> bool:
        """Merge colours whose distance (in RGB) is below `max_distance`."""
        work = self._work(sensor)
        with self._at_no_cost():
            work.image = filters.with_fewer_colours(work.image, max_distance)
        return False

    def intensityScaleOnWorkImg(self, sensor: int, start: float, end: float, grey: bool) -> bool:
        """Map intensity 0..1 to `start`..`end`: in grey, or from black over blue and red to yellow."""
        work = self._work(sensor)
        work.image = filters.intensity_scaled(work.image, start, end, grey)
        return False

    def selectiveColorOnWorkImg(
        self, sensor: int, color: list[float], tolerance: list[float], rgb: bool, keep: bool, to_buffer1: bool
    ) -> bool:
        """Keep or remove the pixels of a colour; removed pixels become black, and are copied into buffer 1 on
        request.
        """
        work = self._work(sensor)
        wanted = numbers(color, 3, "a colour"), numbers(tolerance, 3, "a tolerance")
        return _kept(work, filters.is_coloured(work.image, *wanted, rgb) == keep, to_buffer1)

    def scaleAndOffsetWorkImg(
        self, sensor: int, before: list[float], scale: list[float], after: list[float], rgb: bool
    ) -> bool:
        """Set each component to (value + before) * scale + after, within 0..1."""
        work = self._work(sensor)
        steps = [numbers(values, 3, "an offset or a scale") for values in (before, scale, after)]
        work.image = filters.scaled_and_offset(work.image, steps[0], steps[1], steps[2], rgb)
        return False

    def sharpenWorkImg(self, sensor: int) -> bool:
        work = self._work(sensor)
        work.image = filters.sharpened(work.image)
        return False

    def edgeDetectionOnWorkImg(self, sensor: int, threshold: float) -> bool:
        """Set a pixel to white if it is brighter than its neighbours by `threshold` (24 of it against 3 of each),
        else to black.
        """
        work = self._work(sensor)
        work.image = filters.edges(work.image, threshold)
        return False

    def matrix3x3OnWorkImg(
        self, sensor: int, passes: int, multiplier: float, matrix: list[float] | None = None
    ) -> bool:
        """Replace each pixel by the weighted sum of its neighbours, `passes` times; without a matrix the image is
        blurred.
        """
        return self._convolve(sensor, passes, multiplier, matrix, 3)

    def matrix5x5OnWorkImg(
        self, sensor: int, passes: int, multiplier: float, matrix: list[float] | None = None
    ) -> bool:
        """Filter as simVision.matrix3x3OnWorkImg does, with 25 numbers."""
        return self._convolve(sensor, passes, multiplier, matrix, 5)

    def shiftWorkImg(self, sensor: int, shift: list[float], wrap: bool) -> bool:
        work = self._work(sensor)
        across, up = numbers(shift, 2, "a shift")
        work.image = filters.shifted(work.image, across, up, wrap)
        return False

    def resizeWorkImg(self, sensor: int, scale: list[float]) -> bool:
        """Stretch the image about its centre; the resolution stays."""
        work = self._work(sensor)
        across, up = numbers(scale, 2, "a scale")
        if across <= 0 or up <= 0:
            raise CommandError(f"factors of an image's size are above 0, not {across} and {up}")
        work.image = filters.resized(work.image, across, up)
        return False

    def rotateWorkImg(self, sensor: int, angle: float) -> bool:
        """Rotate the image anticlockwise about its centre by radians."""
        work = self._work(sensor)
        work.image = filters.rotated(work.image, angle)
        return False

    def circularCutWorkImg(self, sensor: int, radius: float, to_buffer1: bool) -> bool:
        """Set the pixels outside a circle to black; radius 1 touches the nearer sides."""
        work = self._work(sensor)
        return _kept(work, filters.within_circle(work.image.shape, radius), to_buffer1)

    def rectangularCutWorkImg(self, sensor: int, sizes: list[float], to_buffer1: bool) -> bool:
        """Set the pixels outside a centred rectangle to black."""
        work = self._work(sensor)
        width, height = numbers(sizes, 2, "a size")
        return _kept(work, filters.within_rectangle(work.image.shape, width, height), to_buffer1)

    def _convolve(
        self, sensor: int, passes: int, multiplier: float, matrix: list[float] | None, side: int
    ) -> bool:
        work = self._work(sensor)
        if matrix is None:
            weights = filters.blur_kernel(side).ravel()
        else:
            weights = np.array(numbers(matrix, side * side, "the matrix"))
        with self._at_no_cost():
            work.image = filters.convolved_often(work.image, weights * multiplier, min(passes, 100))
        return False


class SimVision(VelodyneFunctions, ComposedImageFunctions, ImageFilters, effect="changes"):
    """Functions that detect; results are packed (sim.unpackFloatTable), ready for the packedPackets of
    sysCall_vision.
    """

    PLUGIN = "simVision"

    def binaryWorkImg(
        self,
        sensor: int,
        threshold: float,
        proportion: float,
        proportion_tolerance: float,
        x: float,
        x_tolerance: float,
        y: float,
        y_tolerance: float,
        angle: float,
        angle_tolerance: float,
        roundness: float,
        triggers: bool,
        overlay: list[float] | None = None,
    ) -> tuple[bool, bytes]:
        """Set pixels of at least this intensity to white, others to black. The packet holds the share of white, x and
        y of its centre, angle of its axis, and roundness. The sensor triggers when all are within tolerance and the
        roundness is not exceeded.
        """
        work = self._work(sensor)
        wanted = detections.Wanted(
            proportion,
            proportion_tolerance,
            x,
            x_tolerance,
            y,
            y_tolerance,
            angle,
            angle_tolerance,
            roundness,
        )
        colour = numbers(overlay, 3, "a colour") if overlay else None
        is_as_wanted, packet = detections.find_patch(work, threshold, wanted, colour)
        return triggers and is_as_wanted, _packed(packet)

    def blobDetectionOnWorkImg(
        self,
        sensor: int,
        threshold: float,
        least_size: float,
        paint_apart: bool,
        overlay: list[float] | None = None,
    ) -> tuple[bool, bytes]:
        """Find connected pixels of at least this intensity. The packet: the number of blobs, 6, and of each its share
        of the image, angle, x and y of the centre, width and height of the smallest rectangle about it.
        """
        work = self._work(sensor)
        colour = numbers(overlay, 3, "a colour") if overlay else None
        with self._at_no_cost():
            packet = detections.find_blobs(work, threshold, least_size, paint_apart, colour)
        return False, _packed(packet)

    def changedPixelsOnWorkImg(self, sensor: int, threshold: float) -> tuple[bool, bytes] | bool:
        """Find pixels that changed by this share against buffer 2, which then gets the new image. The packet, for
        each such pixel: 1 or -1 (brighter, darker), x and y in pixels; none without a change. The image: white,
        black, else grey.
        """
        work = self._work(sensor)
        packet = detections.find_changes(work, threshold)
        return (False, _packed(packet)) if packet else False

    def coordinatesFromWorkImg(
        self, sensor: int, points: list[int], even_angles: bool, colors: bool = False
    ) -> tuple[bool, bytes] | tuple[bool, bytes, bytes]:
        """Return points of a work image that holds the depth. The packet: how many across and up, then of each x, y,
        z and the distance in metres, in the sensor's frame, or in the world with sim.handleflag_abscoords added to
        the handle. With `colors` also a string of RGB bytes from buffer 1, and three bytes more, as in CoppeliaSim.
        """
        handle, work = self._sensor(sensor), self._work(sensor)
        settings = self._world.vision.settings(handle)
        across, up = _counts(points)
        with self._at_no_cost():
            found, pixels = detections.find_coordinates(work, settings.view, (across, up), even_angles)
        if sensor > 0 and bool(sensor & _IN_THE_WORLD):
            position, quaternion = frames.get_pose(self._sim, handle)
            found[:, :3] = found[:, :3] @ np.array(matrix(quaternion)).T + np.array(position)
        packet = _packed(detections.packet_of((across, up), found))
        if not colors:
            return False, packet
        shown = np.clip(work.buffer1[pixels[:, 0], pixels[:, 1]], 0.0, 1.0) * 255.1
        return False, packet, shown.astype(np.uint8).tobytes() + bytes(3)

    def velodyneDataFromWorkImg(self, sensor: int, points: list[int], angle: float) -> tuple[bool, bytes]:
        """Return points of a work image that holds the depth, as a rotating scanner with rows over `angle` meets them.
        The packet is as that of simVision.coordinatesFromWorkImg.
        """
        handle, work = self._sensor(sensor), self._work(sensor)
        if not 0.0 < angle < math.pi:
            raise CommandError("the angle is above 0 and below pi rad")
        across, up = _counts(points)
        with self._at_no_cost():
            found = detections.scan(work, self._world.vision.settings(handle).view, (across, up), angle)
        return False, _packed(detections.packet_of((across, up), found))


def _kept(work: Work, stays: Mask, to_buffer1: bool) -> bool:
    work.keep(stays, to_buffer1)
    return False


def _counts(points: list[int]) -> tuple[int, int]:
    """Return how many points there are across and up. Raises CommandError."""
    if len(points) < 2 or min(points) < 1 or points[0] * points[1] > _MOST_POINTS:
        raise CommandError(
            f"the numbers of points are two integers above 0, across and up, for at most {_MOST_POINTS} points"
        )
    return points[0], points[1]


def _packed(values: Sequence[float]) -> bytes:
    return struct.pack(f"<{len(values)}f", *values)
