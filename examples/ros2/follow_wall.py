"""Follow the wall on the right of a robot: read its laser scan, and publish velocities.

    simx-server pioneer_p3dx --ros2 --ros2-router self --start
    python follow_wall.py --scan /scan --distance 0.6

It ends after `--seconds` of simulated time, and prints how far the robot drove and how near it came to a wall.
"""

from __future__ import annotations

import argparse
import math
import threading
from typing import Any

import numpy as np
from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber, get_message_class  # pyright: ignore[reportMissingImports]

RIGHT, FRONT = (-110, -50), (-30, 30)
"""Sectors in degrees, anticlockwise from the robot's x axis."""


class WallFollower:
    """Publishes one velocity for each scan."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.driven, self.nearest = 0.0, math.inf
        self.done = threading.Event()
        self._place: tuple[float, float] | None = None
        self._end: float | None = None
        self._has_wall = False
        self._vector: Any = get_message_class("geometry_msgs/msg/Vector3")
        port = {"router_port": options.port}
        self._speed = ROS2Publisher("/cmd_vel", "geometry_msgs/msg/Twist", **port)
        self._kept = [
            ROS2Subscriber(options.scan, "sensor_msgs/msg/LaserScan", self.scanned, **port),
            ROS2Subscriber("/odom", "nav_msgs/msg/Odometry", self.moved, **port),
        ]

    def scanned(self, scan: Any) -> None:
        """Steer by a scan."""
        now = scan.header.stamp.sec + scan.header.stamp.nanosec * 1e-9
        self._end = now + self.options.seconds if self._end is None else self._end
        if now >= self._end:
            self.send(0.0, 0.0)
            self.done.set()
            return
        ranges = np.asarray(scan.ranges)
        angles = np.degrees(scan.angle_min + scan.angle_increment * np.arange(ranges.size)) + self.options.yaw

        def least(sector: tuple[int, int]) -> float:
            inside = ranges[(angles >= sector[0]) & (angles <= sector[1])]
            return float(inside.min(initial=math.inf))

        front, right = least(FRONT), least(RIGHT)
        wanted, speed, most = self.options.distance, self.options.speed, self.options.turn
        self.nearest = min(self.nearest, front, right)
        self._has_wall |= right < 2 * wanted
        if front < 1.5 * wanted:
            self.send(0.0, most)
        elif self._has_wall:  # around a corner: a circle with the radius of the distance
            self.send(speed, max(-speed / wanted, min(most, 2.0 * most * (1 - right / wanted))))
        else:
            self.send(speed, 0.0)

    def moved(self, odometry: Any) -> None:
        """Add up the way."""
        place = odometry.pose.pose.position.x, odometry.pose.pose.position.y
        self.driven += math.dist(place, self._place or place)
        self._place = place

    def send(self, forward: float, turn: float) -> None:
        """Publish a velocity, in m/s and rad/s."""
        zero = {"x": 0.0, "y": 0.0, "z": 0.0}
        self._speed.publish(
            linear=self._vector(**{**zero, "x": forward}), angular=self._vector(**{**zero, "z": turn})
        )


def main() -> None:
    """Follow the wall."""
    parser = argparse.ArgumentParser(description="Follow the wall on the right of a robot.")
    parser.add_argument("--port", type=int, default=7447, help="of the router")
    parser.add_argument("--scan", default="/scan", help="topic of the laser scanner")
    parser.add_argument(
        "--yaw", type=float, default=0.0, help="degrees that the scanner is turned on the robot"
    )
    parser.add_argument("--distance", type=float, default=0.6, help="metres to the wall")
    parser.add_argument("--speed", type=float, default=0.2, help="m/s")
    parser.add_argument("--turn", type=float, default=0.6, help="most rad/s")
    parser.add_argument("--seconds", type=float, default=30.0, help="of simulated time")
    follower = WallFollower(parser.parse_args())
    follower.done.wait()
    print(f"drove {follower.driven:.2f} m, nearest wall {follower.nearest:.2f} m", flush=True)


if __name__ == "__main__":
    main()
