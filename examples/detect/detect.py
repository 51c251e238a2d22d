"""Find the ball with the trained detector while the arm moves, and tell where it is in the world:

    simx-run --server ur5_rg2_kinect examples/detect/detect.py

Needs the weights that train.py has written to detect_output/ball.pt. It is written as a script for V-REP would be: it
knows `vrep` and nothing else of the simulator. Stepped mode lets picture, depths and truth be of one instant.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pictures
import vrep
from numpy.typing import NDArray

try:
    import torch
    from detector import Detector
except ModuleNotFoundError as missing:
    from simx_client.protocol.cli.installing import extra_line

    sys.exit(f"the package {missing.name} is not installed, which the detector needs: {extra_line('detect')}")

WAIT, SEND = vrep.simx_opmode_blocking, vrep.simx_opmode_oneshot
VIEW = np.array([90.0, -45.0, 90.0, 0.0, -100.0, 0.0])
SWAY = np.array([25.0, 6.0, 6.0, 0.0, 12.0, 15.0])
"""Degrees: a pose that sees the ball, and how far the joints swing about it."""
PERIODS = np.array([90.0, 70.0, 50.0, 1.0, 60.0, 40.0])
"""Passes of each joint's swing."""

RADIUS = 0.05
"""The ball's, m: what is seen is its surface, what is wanted its middle."""
SURE = 0.5
ON_THE_SHEET = 12


def need(answer: Any) -> Any:
    """What a call gives beside its return code, which must be 0."""
    code, *values = answer if isinstance(answer, tuple) else (answer,)
    if code != vrep.simx_return_ok:
        sys.exit(
            f"detect.py: the simulator refused a call (return code {code}); it needs the scene ur5_rg2_kinect"
        )
    return values[-1] if values else None


class Robot:
    """The tutorial's arm with its camera, in stepped mode."""

    def __init__(self, address: str, port: int) -> None:
        self.client = vrep.simxStart(address, port, True, True, 5000, 5)
        if self.client == -1:
            sys.exit(f"detect.py: no simulator answers at {address}:{port}")
        names = [f"UR5_joint{number}" for number in range(1, 7)]
        self.joints = [need(vrep.simxGetObjectHandle(self.client, name, WAIT)) for name in names]
        self.rgb, self.depth, self.ball = (
            need(vrep.simxGetObjectHandle(self.client, name, WAIT))
            for name in ("kinect_rgb", "kinect_depth", "Target")
        )
        self.near, self.far, self.angle = (
            need(vrep.simxGetObjectFloatParameter(self.client, self.rgb, number, WAIT))
            for number in (
                vrep.sim_visionfloatparam_near_clipping,
                vrep.sim_visionfloatparam_far_clipping,
                vrep.sim_visionfloatparam_perspective_angle,
            )
        )
        need(vrep.simxSynchronous(self.client, True))
        need(vrep.simxStartSimulation(self.client, WAIT))

    def step(self, degrees: NDArray[np.float64]) -> None:
        """One pass with these targets."""
        for joint, angle in zip(self.joints, degrees, strict=True):
            vrep.simxSetJointTargetPosition(self.client, joint, math.radians(angle), SEND)
        need(vrep.simxSynchronousTrigger(self.client))

    def picture(self) -> pictures.CameraImage:
        code, (width, height), image = vrep.simxGetVisionSensorImage(self.client, self.rgb, 0, WAIT)
        need(code)
        return np.flipud(np.array(image, dtype=np.uint8).reshape(height, width, 3))

    def depths(self) -> NDArray[np.float64]:
        """(height, width), metres along the viewing axis."""
        code, (width, height), buffer = vrep.simxGetVisionSensorDepthBuffer(self.client, self.depth, WAIT)
        need(code)
        return self.near + (self.far - self.near) * np.flipud(np.array(buffer).reshape(height, width))

    def in_world(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """A point of the camera's frame in the world's."""
        place = np.array(need(vrep.simxGetObjectPosition(self.client, self.rgb, -1, WAIT)))
        *axis, w = need(vrep.simxGetObjectQuaternion(self.client, self.rgb, -1, WAIT))
        across = np.cross(axis, point)
        return place + point + 2 * (w * across + np.cross(axis, across))

    def truth(self, relative_to: int) -> NDArray[np.float64]:
        """Where the ball is, m."""
        return np.array(need(vrep.simxGetObjectPosition(self.client, self.ball, relative_to, WAIT)))

    def close(self) -> None:
        vrep.simxStopSimulation(self.client, WAIT)
        vrep.simxSynchronous(self.client, False)
        vrep.simxFinish(self.client)


def middle_of(box: NDArray[np.float64], depths: NDArray[np.float64], focal: float) -> NDArray[np.float64]:
    """The ball's middle in the camera's frame, m, from its box and the depths in the middle third of that."""
    (left, top), (right, bottom) = box[:2], box[2:4]
    u, v = (left + right) / 2, (top + bottom) / 2
    rows = slice(int(v - (bottom - top) / 6), int(v + (bottom - top) / 6) + 1)
    columns = slice(int(u - (right - left) / 6), int(u + (right - left) / 6) + 1)
    height, width = depths.shape
    ray = np.array([(width / 2 - u) / focal, (height / 2 - v) / focal, 1.0])
    return ray * (np.median(depths[rows, columns]) + RADIUS / np.linalg.norm(ray))


@dataclass
class Tally:
    """What was there and what was found."""

    in_sight: int = 0
    found: int = 0
    false_alarms: int = 0
    pixels: list[float] = field(default_factory=list)
    """How far the middle of each right box is from where the ball's middle is in the picture."""
    metres: list[float] = field(default_factory=list)
    """How far the place that was computed is from the ball's."""

    def __str__(self) -> str:
        text = (
            f"the ball was in sight in {self.in_sight} of them and found in {self.found} of these, "
            f"{self.false_alarms} false alarms"
        )
        if self.metres:
            ninth = np.quantile(self.metres, 0.9) * 1e3
            text += (
                f"; median error {np.median(self.pixels):.1f} px and {np.median(self.metres) * 1e3:.1f} mm, "
                f"nine of ten within {ninth:.1f} mm"
            )
        return text


def compare(robot: Robot, boxes: NDArray[np.float64], depths: NDArray[np.float64], tally: Tally) -> str:
    """Count what was found in a picture against where the ball is; gives what there is to say about it."""
    height, width = depths.shape
    focal = max(width, height) / 2 / math.tan(robot.angle / 2)
    left, up, ahead = robot.truth(robot.rgb)
    there = np.array([width / 2 - left / ahead * focal, height / 2 - up / ahead * focal])
    is_in_sight = bool(ahead > 0 and np.all((there > 0) & (there < (width, height))))
    middles = (boxes[:, :2] + boxes[:, 2:4]) / 2
    off = np.linalg.norm(middles - there, axis=1)
    is_right = (off < RADIUS / abs(ahead) * focal) & (ahead > 0)
    tally.in_sight += is_in_sight
    tally.false_alarms += int(np.sum(~is_right))
    if not is_right.any():
        return "missed" if is_in_sight else "not in sight"
    best = int(np.argmax(is_right))  # the surest is first
    tally.found += is_in_sight
    place = robot.in_world(middle_of(boxes[best], depths, focal))
    tally.pixels.append(float(off[best]))
    tally.metres.append(float(np.linalg.norm(place - robot.truth(-1))))
    (u, v), (x, y, z) = middles[best], place
    return f"({u:3.0f}, {v:3.0f}) px, ({x:6.3f}, {y:6.3f}, {z:6.3f}) m, {tally.metres[-1] * 1e3:.1f} mm off"


def watch(robot: Robot, detector: Detector, count: int, output: Path) -> Tally:
    """Look for the ball in so many pictures, with the arm on the move."""
    for _ in range(60):  # from the start pose, in which the arm points up, to one that sees the ball
        robot.step(VIEW)
    tally, shown = Tally(), []
    began = time.perf_counter()
    for number in range(count):
        robot.step(VIEW + SWAY * np.sin(2 * np.pi * number / PERIODS))
        picture, depths = robot.picture(), robot.depths()
        boxes = detector.detect(picture, SURE)
        said = compare(robot, boxes, depths, tally)
        print(f"\rpicture {number + 1:4} of {count}: {said:70}", end="", flush=True)
        if number % max(count // ON_THE_SHEET, 1) == 0:
            shown.append(pictures.with_boxes(picture, boxes[:, :4], pictures.FOUND))
    rate = count / (time.perf_counter() - began)
    print(f"\n{count} pictures, {rate:.1f} a second; {tally}; some are in {output}")
    pictures.write(output, pictures.sheet(shown[:ON_THE_SHEET]))
    return tally


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Find the ball in the hand camera's pictures.")
    parser.add_argument("--weights", type=Path, default=Path("detect_output") / "ball.pt", help="of train.py")
    parser.add_argument("--count", type=int, default=200, help="pictures (200)")
    parser.add_argument(
        "--output", type=Path, default=Path("detect_output") / "live.png", help="a sheet of some"
    )
    parser.add_argument("--address", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=19997)
    chosen = parser.parse_args(arguments)
    if not chosen.weights.is_file():
        sys.exit(
            f"detect.py: there is no {chosen.weights}; train.py writes it, once collect.py has taken pictures"
        )
    torch.set_num_threads(1)  # the other core is the simulator's
    detector = Detector.load(chosen.weights)
    robot = Robot(chosen.address, chosen.port)
    try:
        watch(robot, detector, chosen.count, chosen.output)
    finally:
        robot.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
