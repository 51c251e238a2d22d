"""Images and camera infos of every vision sensor: upright, as ROS wants them, in the camera's optical frame."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from concurrent.futures import Future
from functools import partial
from typing import Any

import cv2
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind, Scene, SceneObject
from simx_server.sensors.vision.futures import then
from simx_server.sensors.vision.vision_settings import VisionSettings

from ..annotated.notes import Names, note_of, period_of, topic_of, unpublished
from ..endpoints import Content, Context, Message, Moment, Offer, Published
from ..wire.qos import SENSOR_DATA
from .clouds import CLOUD, cloud, metres, scan_of_row

JPEG_QUALITY = 95
"""Of compressed images, as image_transport has it unless told otherwise."""

_NO_DISTORTION = [0.0] * 5
_NO_TURN = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]


class Cameras(Content):
    """Publishes what each vision sensor sees.

    An image is rendered only if someone listens to its topic. It is that of ``simxGetVisionSensorImage`` with the rows
    from the top, RGB; the depth image has metres, with infinity where nothing is in range.
    """

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._world = context.world

    def offers(self) -> Iterable[Offer]:
        scene = self._world.simulation.scene
        names, hidden = Names(scene, self._robots), unpublished(scene)
        for handle in scene.of_kind(ObjectKind.VISION_SENSOR):
            if handle not in hidden:
                yield from self._of_sensor(scene, scene.objects[handle], names)

    def _of_sensor(self, scene: Scene, item: SceneObject, names: Names) -> Iterator[Offer]:
        image, info = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
        handle, note = item.handle, note_of(item)
        given, period = topic_of(note, "topic"), period_of(note)
        topic = names.own_topic(item) if given is None else names.topic(item, given)
        frame = names.camera_frame(item, note)
        give_image, give_depth = partial(self._image, handle, frame), partial(self._depth, handle, frame)
        give_info = partial(self._info, handle, frame)
        yield Published(f"{topic}/image_raw", image, give_image, SENSOR_DATA, period)
        yield Published(f"{topic}/camera_info", info, give_info, SENSOR_DATA, period)
        yield Published(f"{topic}/depth/image_raw", image, give_depth, SENSOR_DATA, period)
        yield Published(f"{topic}/depth/camera_info", info, give_info, SENSOR_DATA, period)
        give_points = partial(self._points, handle, frame)
        yield Published(f"{topic}/points", CLOUD, give_points, SENSOR_DATA, period)
        settings = self._world.vision.settings(handle)
        if settings.height == 1 and settings.orthographic_size is None:
            scan, laser = partial(self._scan, handle, names.laser_frame(item)), "sensor_msgs/msg/LaserScan"
            yield Published(f"{topic}/scan", laser, scan, SENSOR_DATA, period)
        if note.get("compressed", False):
            kind, give = "sensor_msgs/msg/CompressedImage", partial(self._compressed, handle, frame)
            yield Published(f"{topic}/image_raw/compressed", kind, give, SENSOR_DATA, period)

    def _image(self, handle: int, frame: str, moment: Moment) -> Future[Message]:
        header = moment.header(frame)

        def upright(seen: tuple[list[int], bytes]) -> Message:
            (width, height), rows = seen
            pixels = np.frombuffer(rows, np.uint8).reshape(height, width * 3)[::-1]
            return _image_message(header, width, height, "rgb8", 3, pixels)

        return then(self._world.vision.image(handle, as_grey=False, asker="ros2"), upright)

    def _compressed(self, handle: int, frame: str, moment: Moment) -> Future[Message]:
        header = moment.header(frame)

        def packed(seen: tuple[list[int], bytes]) -> Message:
            (width, height), rows = seen
            pixels = np.frombuffer(rows, np.uint8).reshape(height, width, 3)[::-1, :, ::-1]
            done, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
            if not done:
                raise CommandError(f"OpenCV cannot make a JPEG of {width} x {height} pixels")
            return {"header": header, "format": "rgb8; jpeg compressed bgr8", "data": data}

        return then(self._world.vision.image(handle, as_grey=False, asker="ros2"), packed)

    def _depth(self, handle: int, frame: str, moment: Moment) -> Future[Message]:
        header, settings = moment.header(frame), self._world.vision.settings(handle)

        def upright(seen: tuple[list[int], bytes]) -> Message:
            (width, height), rows = seen
            data = np.ascontiguousarray(metres(settings, rows), "<f4").view(np.uint8)
            return _image_message(header, width, height, "32FC1", 4, data)

        return then(self._world.vision.depth(handle, asker="ros2"), upright)

    def _points(self, handle: int, frame: str, moment: Moment) -> Future[Message]:
        header, settings = moment.header(frame), self._world.vision.settings(handle)

        def placed(seen: tuple[list[int], bytes]) -> Message:
            return cloud(header, settings, *seen)

        return then(self._world.vision.depth(handle, asker="ros2"), placed)

    def _scan(self, handle: int, frame: str, moment: Moment) -> Future[Message]:
        header, settings = moment.header(frame), self._world.vision.settings(handle)

        def measured(seen: tuple[list[int], bytes]) -> Message:
            return scan_of_row(header, settings, seen[1])

        return then(self._world.vision.depth(handle, asker="ros2"), measured)

    def _info(self, handle: int, frame: str, moment: Moment) -> Message:
        return camera_info(moment.header(frame), self._world.vision.settings(handle))


def camera_info(header: Any, settings: VisionSettings) -> Message:
    """Return the ``sensor_msgs/CameraInfo`` of a sensor.

    An orthographic sensor has no camera matrix: all its numbers are 0, which stands for a camera without calibration.
    """
    width, height = settings.width, settings.height
    k, p = [0.0] * 9, [0.0] * 12
    if settings.orthographic_size is None:
        # The perspective angle belongs to the larger side; pixels are square. The axis of the camera passes between the
        # two pixels in the middle, as ROS counts pixels by their centres.
        focal = max(width, height) / 2 / math.tan(settings.angle / 2)
        cx, cy = (width - 1) / 2, (height - 1) / 2
        k = [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]
        p = [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return {
        "header": header,
        "height": height,
        "width": width,
        "distortion_model": "plumb_bob",
        "d": _NO_DISTORTION,
        "k": k,
        "r": _NO_TURN,
        "p": p,
        "binning_x": 0,
        "binning_y": 0,
        "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    }


def _image_message(
    header: Any, width: int, height: int, encoding: str, pixel_bytes: int, data: Any
) -> Message:
    """Return a ``sensor_msgs/Image``.

    Args:
        data: the rows from the top, as bytes.
    """
    return {
        "header": header,
        "height": height,
        "width": width,
        "encoding": encoding,
        "is_bigendian": 0,
        "step": width * pixel_bytes,
        "data": data,
    }
