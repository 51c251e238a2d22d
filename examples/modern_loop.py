"""The tutorial's arm follows the ball with its hand camera, in stepped mode: ``python examples/modern_loop.py``.

Needs a server with the tutorial's scene: ``simx-server ur5_rg2_kinect``. A pass is one message, there and back: six
targets go out, six angles, the ball's place in the camera's frame and the time come with the answer.
"""

from __future__ import annotations

import logging
import sys

import numpy as np

from simx_client import Client

logger = logging.getLogger("modern_loop")

VIEW = np.radians([90, -45, 90, 0, -100, 0])
"""Angles at which the camera sees the ball."""

PAN, TILT = 0, 4
"""The joints that turn the camera sideways and up and down, of six."""

GAIN = 0.1
"""Part of the angle to the ball that a pass corrects."""


def follow(client: Client, passes: int) -> float:
    """Turn the camera to the ball; returns the angle that is left between view and ball, radians."""
    arm = client.joints(*[f"UR5_joint{number}" for number in range(1, 7)])
    camera, ball = client.camera("kinect_rgb"), client.object("Target")
    with client.stepping(
        lambda: (arm.positions, ball.relative_to(camera).position, client.simulation.time)
    ) as step:
        arm.positions = targets = VIEW.copy()
        for _ in range(passes):
            arm.target_positions = targets
            angles, (left, up, ahead), seconds = step()
            targets[PAN] += GAIN * np.arctan2(left, ahead)
            targets[TILT] += GAIN * np.arctan2(up, ahead)
        off = float(np.arctan2(np.hypot(left, up), ahead))
        logger.info(
            "after %.1f s the ball is %.3f rad off the middle, joints at %s", seconds, off, angles.round(2)
        )
        picture, depth = camera.rgb(), camera.depth()
        row, column = depth.shape[0] // 2, depth.shape[1] // 2
        logger.info(
            "the middle of the picture has colour %s, %.3f m away",
            picture[row, column].tolist(),
            depth[row, column],
        )
    return off


def main() -> int:
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    with Client("127.0.0.1", 19997) as client:
        return 0 if follow(client, passes=100) < 0.02 else 1


if __name__ == "__main__":
    sys.exit(main())
