"""Compute the poses of all objects at little cost to the physics thread.

Nearly every object is fixed to a body: its pose in that body is found once for a model, and composed with the poses of
the bodies on the writing thread. The poses of the others (a second joint of a body, a joint of a tendon, a camera that
follows something) are read in each simulation step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.placing import body_pose, carrier_body, object_pose
from simx_server.scene.poses.poses import Pose, compose, inverse
from simx_server.sensors.proximity.seen import cross

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class State:
    """Copies of one instant."""

    positions: Array
    """(nbody, 3)."""
    quats_wxyz: Array
    """(nbody, 4)."""
    others: list[Pose]
    """World poses of objects that are not fixed to a body, in the order of `Places.others`."""


class Places:
    """The frames of one model: their names, and how to compute their poses."""

    def __init__(self, sim: Simulation) -> None:
        """Find the frames. Physics thread."""
        sim.refresh()
        fixed: list[tuple[str, int, Pose]] = []
        self.others: list[SceneObject] = []
        for item in sim.scene.objects.values():
            if _is_fixed(sim, item):
                body = carrier_body(sim, item)
                local = compose(inverse(body_pose(sim, body)), object_pose(sim, item))
                fixed.append((item.name, body, local))
            else:
                self.others.append(item)
        self.names = [name for name, _, _ in fixed] + [item.name for item in self.others]
        self._bodies = np.array([body for _, body, _ in fixed], np.intp)
        self._positions = np.array([pose[0] for _, _, pose in fixed]).reshape(-1, 3)
        self._quats = np.array([pose[1] for _, _, pose in fixed]).reshape(-1, 4)

    def state(self, sim: Simulation) -> State:
        """Return the present state. Physics thread; the kinematics must be up to date."""
        others = [object_pose(sim, item) for item in self.others]
        return State(sim.data.xpos.copy(), sim.data.xquat.copy(), others)

    def poses(self, state: State) -> Array:
        """Return world positions and quaternions xyzw, shape (frames, 7), in the order of `names`. Any thread."""
        quats = state.quats_wxyz[self._bodies]
        found = np.empty((len(self.names), 7))
        count = len(self._bodies)
        found[:count, :3] = state.positions[self._bodies] + _turned(quats, self._positions)
        product = _product(quats, self._quats)
        found[:count, 3:6], found[:count, 6] = product[:, 1:], product[:, 0]
        for row, (position, (w, x, y, z)) in enumerate(state.others, count):
            found[row] = *position, x, y, z, w
        return found


def _is_fixed(sim: Simulation, item: SceneObject) -> bool:
    model = sim.model
    match item.element:
        case "joint":
            return item.id == int(model.body_jntadr[item.body])
        case "camera":
            return model.cam_mode[item.id] == mujoco.mjtCamLight.mjCAMLIGHT_FIXED.value
        case "light":
            return model.light_mode[item.id] == mujoco.mjtCamLight.mjCAMLIGHT_FIXED.value
        case element:
            return element != "tendon"


def _product(first: Array, second: Array) -> Array:
    """Return the products of quaternions wxyz, row by row, shape (n, 4)."""
    w, v = first[:, :1], first[:, 1:]
    other_w, other_v = second[:, :1], second[:, 1:]
    vector = w * other_v + other_w * v + cross(v, other_v)
    return np.hstack((w * other_w - np.einsum("ni,ni->n", v, other_v)[:, np.newaxis], vector))


def _turned(quats: Array, points: Array) -> Array:
    """Return points rotated by quaternions wxyz, shape (n, 3); p + 2 w (v x p) + 2 v x (v x p)."""
    w, v = quats[:, :1], quats[:, 1:]
    once = cross(v, points)
    return points + 2 * (w * once + cross(v, once))
