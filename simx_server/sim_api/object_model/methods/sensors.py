"""Methods of proximity sensors, vision sensors and cameras."""

from __future__ import annotations

import math
from typing import Any, cast

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.sim_api.object_model.classes import to_api_1
from simx_server.sim_api.object_model.values import Matrix, Ref
from simx_server.sim_api.objects.sensors import Detected

from .method import Call, Options, method, number, option, pair, text_option

_FRONT, _BACK = 1, 2
_TYPES = {"rgb": 0, "grey": 1, "rgba": 2}
"""Options of API 1 by types of an image."""


def _detection(result: Any) -> Any:
    """Return whether a sensor detects, distance, point, object and normal."""
    if not isinstance(result, tuple) or result[0] != 1:
        return False, 0.0, Matrix.vector([0.0] * 3), None, Matrix.vector([0.0] * 3)
    _, distance, point, handle, normal = cast(Detected, result)
    return True, distance, Matrix.vector(point[:3]), Ref(handle), Matrix.vector(normal)


@method("proximitySensor", "handleSensor", "changes")
def handle_proximity_sensor(call: Call) -> Any:
    """Compute the sensor now."""
    return _detection(call.sim.handleProximitySensor(call.handle))


@method("proximitySensor", "checkSensor", "reads")
def check_proximity_sensor(call: Call, entity: int = c.sim_handle_all, options: Options = None) -> Any:
    """Return what the sensor detects of an entity; options frontFaces, backFaces, maxNormal (rad)."""
    bits = _FRONT * bool(option(options, "frontFaces", True)) | _BACK * bool(
        option(options, "backFaces", True)
    )
    steepest = number(options, "maxNormal", 0.0)
    target = entity if entity == c.sim_handle_all else to_api_1(entity)
    return _detection(call.sim.checkProximitySensorEx(call.handle, target, bits, math.inf, steepest))


@method("proximitySensor", "resetSensor", "changes")
def reset_proximity_sensor(call: Call) -> None:
    """Delete the detection until the next handling."""
    call.sim.resetProximitySensor(call.handle)


def _type(options: Options) -> int:
    word = text_option(options, "type", "rgb")
    if word not in _TYPES:
        raise CommandError(f"'{word[:40]}' is no type of an image; those are {', '.join(_TYPES)}")
    return _TYPES[word]


@method("visionSensor", "getImage", "reads")
def get_image(call: Call, options: Options = None) -> Any:
    """Return an image and its resolution; options `position` and `size` of a part, `type`, `rgbaCutOff`."""
    cut_off = number(options, "rgbaCutOff", 0.0)
    parts = (pair(options, "position"), pair(options, "size"))
    return call.sim.getVisionSensorImg(call.handle, _type(options), cut_off, *parts)


@method("visionSensor", "getDepth", "reads")
def get_depth(call: Call, options: Options = None) -> Any:
    """Return a depth image and its resolution; options `position` and `size` of a part, `meters`."""
    bits = int(bool(option(options, "meters", False)))
    found = call.sim.getVisionSensorDepth(call.handle, bits, pair(options, "position"), pair(options, "size"))
    return _depth_matrix(*found)


def _depth_matrix(data: bytes, resolution: list[int]) -> tuple[Matrix, list[int]]:
    """Return a depth image as rows, the lowest first."""
    width, height = resolution
    return Matrix(height, width, list(memoryview(data).cast("f"))), resolution


@method("visionSensor", "setImage", "changes")
def set_image(call: Call, image: bytes, options: Options = None) -> None:
    """Set the image, or a part of it; options `position`, `size`, `type`."""
    parts = (pair(options, "position"), pair(options, "size"))
    call.sim.setVisionSensorImg(call.handle, image, _type(options), *parts)


def _packets(result: Any) -> Any:
    """Return whether a sensor detects, and two packets of numbers."""
    values = cast(tuple[Any, ...], result) if isinstance(result, tuple) else (result,)
    packets: list[list[float]] = [each if isinstance(each, list) else [] for each in values[1:3]]
    return values[0] == 1, *packets, *([[]] * (2 - len(packets)))


@method("visionSensor", "handleSensor", "changes")
def handle_vision_sensor(call: Call) -> Any:
    """Render now."""
    return _packets(call.sim.handleVisionSensor(call.handle))


@method("visionSensor", "checkSensor", "reads")
def check_vision_sensor(call: Call, entity: int = c.sim_handle_all) -> Any:
    """Return whether the sensor detects an entity."""
    target = entity if entity == c.sim_handle_all else to_api_1(entity)
    return _packets(call.sim.checkVisionSensor(call.handle, target))


@method("visionSensor", "resetSensor", "changes")
def reset_vision_sensor(call: Call) -> None:
    """Delete the result until the next handling."""
    call.sim.resetVisionSensor(call.handle)


@method("camera", "getImage", "reads")
def get_camera_image(_call: Call, _options: Options = None) -> Any:
    """Refuse: cameras show views of a window."""
    raise CommandError("a camera is a view of a window here; put a vision sensor in its place")
