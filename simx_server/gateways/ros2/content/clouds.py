"""Point clouds of depth images, and laser scans of vision sensors with one row, as V-REP's fast Hokuyo has them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_server.sensors.vision.vision_settings import VisionSettings

from ..endpoints import Message

CLOUD = "sensor_msgs/msg/PointCloud2"

_FLOAT32 = 7
"""Datatype of ``sensor_msgs/PointField``."""

_FIELDS = [
    {"name": name, "offset": 4 * at, "datatype": _FLOAT32, "count": 1} for at, name in enumerate("xyz")
]


def metres(settings: VisionSettings, rows: bytes) -> NDArray[np.float32]:
    """Return (height, width) depths in metres from the top row on; infinity without a return."""
    part = np.frombuffer(rows, "<f4").reshape(settings.height, settings.width)[::-1]
    depth = settings.near + part * np.float32(settings.far - settings.near)
    return np.where(part < 1.0, depth, np.float32(np.inf))


def cloud(header: Any, settings: VisionSettings, size: list[int], rows: bytes) -> Message:
    """Return the ``PointCloud2`` of a depth image in the optical frame: x right, y down, z forward, metres.

    It has a point for each pixel, in the order of the image; a pixel without a return is NaN.

    Args:
        size: width and height of the image.
        rows: of the vision sensor, the lowest first, each value from 0 at the near plane to 1 at the far plane.
    """
    width, height = size
    depth = metres(settings, rows)
    depth = np.where(np.isfinite(depth), depth, np.float32(np.nan))
    across, down = (np.arange(count, dtype=np.float32) - (count - 1) / 2 for count in (width, height))
    points = np.empty((height, width, 3), "<f4")
    if settings.orthographic_size is None:
        focal = max(width, height) / 2 / math.tan(settings.angle / 2)
        points[..., 0], points[..., 1] = depth * across / focal, depth * down[:, None] / focal
    else:
        pixel = settings.orthographic_size / max(width, height)
        points[..., 0] = np.where(np.isnan(depth), depth, across * pixel)
        points[..., 1] = np.where(np.isnan(depth), depth, down[:, None] * pixel)
    points[..., 2] = depth
    return {
        "header": header,
        "height": height,
        "width": width,
        "fields": _FIELDS,
        "is_bigendian": False,
        "point_step": 12,
        "row_step": 12 * width,
        "data": points.view(np.uint8).ravel(),
        "is_dense": bool(np.isfinite(depth).all()),
    }


def scan_of_row(header: Any, settings: VisionSettings, rows: bytes) -> Message:
    """Return the ``LaserScan`` of a vision sensor with one row, anticlockwise, with equal angles between its values.

    Each value is that of the pixel in whose middle its ray nearly ends. The frame has x forward and y to the left.
    """
    width = settings.width
    depth = metres(settings, rows)[0]
    focal = width / 2 / math.tan(settings.angle / 2)
    edge = math.atan((width - 1) / 2 / focal)
    angles = np.linspace(-edge, edge, width) if width > 1 else np.zeros(1)
    pixels = np.clip(np.rint((width - 1) / 2 - focal * np.tan(angles)), 0, width - 1).astype(np.intp)
    return {
        "header": header,
        "angle_min": -edge,
        "angle_max": edge,
        "angle_increment": 2 * edge / max(width - 1, 1),
        "time_increment": 0.0,
        "scan_time": 0.0,
        "range_min": settings.near,
        "range_max": settings.far / math.cos(edge),
        "ranges": (depth[pixels] / np.cos(angles)).astype("<f4"),
        "intensities": np.empty(0, "<f4"),
    }
