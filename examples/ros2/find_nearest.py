"""Find what is nearest to a camera: read its depth image, its colour image and its camera matrix.

    simx-server ur5_rg2_kinect --ros2 --ros2-router self --start
    python find_nearest.py /kinect_depth /kinect_rgb

It prints the place of the nearest point in the optical frame (x right, y down, z forward, in metres) and its colour.
"""

from __future__ import annotations

import argparse
import threading
from typing import Any

import numpy as np
from zenoh_ros2_sdk import ROS2Subscriber  # pyright: ignore[reportMissingImports]


class Camera:
    """Collects one message of each topic."""

    def __init__(self, depth: str, colour: str, port: int) -> None:
        self._changed = threading.Condition()
        self._messages: dict[str, Any] = {}
        image, info = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
        topics = {
            "depth": (f"{depth}/depth/image_raw", image),
            "info": (f"{depth}/depth/camera_info", info),
            "colour": (f"{colour}/image_raw", image),
        }
        self._kept = [
            ROS2Subscriber(topic, kind, self._keep(name), router_port=port, qos="2::,5:,:,:,,")
            for name, (topic, kind) in topics.items()
        ]

    def _keep(self, name: str) -> Any:
        def arrived(message: Any) -> None:
            with self._changed:
                self._messages[name] = message
                self._changed.notify_all()

        return arrived

    def next(self) -> tuple[Any, Any, Any]:
        """Return depth image, camera info and colour image."""
        with self._changed:
            self._changed.wait_for(lambda: len(self._messages) == 3)
            return self._messages["depth"], self._messages["info"], self._messages["colour"]


def nearest(depth: Any, info: Any) -> tuple[np.ndarray, tuple[int, int]]:
    """Return the nearest point in the optical frame in metres, and its row and column."""
    metres = np.frombuffer(bytes(depth.data), "<f4").reshape(depth.height, depth.width)
    row, column = np.unravel_index(int(np.argmin(metres)), metres.shape)
    z = float(metres[row, column])
    focal_x, _, centre_x, _, focal_y, centre_y, *_ = info.k
    return np.array([(column - centre_x) / focal_x * z, (row - centre_y) / focal_y * z, z]), (
        int(row),
        int(column),
    )


def main() -> None:
    """Print the nearest point."""
    parser = argparse.ArgumentParser(description="Find what is nearest to a camera.")
    parser.add_argument("depth", help="the camera whose depth image is read, such as /kinect_depth")
    parser.add_argument(
        "colour", nargs="?", help="the camera of the colour, at the same place; else the same one"
    )
    parser.add_argument("--port", type=int, default=7447, help="of the router")
    options = parser.parse_args()
    depth, info, colour = Camera(options.depth, options.colour or options.depth, options.port).next()
    place, (row, column) = nearest(depth, info)
    pixels = np.asarray(colour.data, np.uint8).reshape(colour.height, colour.width, 3)
    row, column = row * colour.height // depth.height, column * colour.width // depth.width
    where = " ".join(f"{each:.3f}" for each in place)
    print(f"nearest point {where} m, colour {' '.join(map(str, pixels[row, column]))}", flush=True)


if __name__ == "__main__":
    main()
