"""Points of meshes in the world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.poses.poses import Pose, matrix


def placed(points: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
    """Return points (n, 3) in the world that are given in a frame, metres."""
    return points @ np.array(matrix(pose[1])).T + np.array(pose[0])
