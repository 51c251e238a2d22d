"""Velocities of objects as V-REP measures them: from the poses at the ends of the last two simulation steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.geometry import poses
from simx_server.scene.geometry.frames import euler_from_quat
from simx_server.scene.geometry.placing import body_pose, carrier_body, object_pose
from simx_server.scene.geometry.poses import Pose, compose, conjugate, inverse, multiply, scale, subtract
from simx_server.scene.objects import SceneObject

from .part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.world.simulation import Simulation

_ARRAYS = {
    "body": ("xpos", "xquat"),
    "site": ("site_xpos", "site_xmat"),
    "camera": ("cam_xpos", "cam_xmat"),
    "light": ("light_xpos", "light_xdir"),
    "geom": ("geom_xpos", "geom_xmat"),
}
"""For each element the names of its world position and rotation in `MjData`."""

Memory = dict[str, tuple[np.ndarray, np.ndarray]]


class Velocities(Part):
    """Keeps poses from one simulation step to the next. Poses set between two steps count as motion."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._before: Memory
        self._after: Memory
        self._sources: list[tuple[str, np.ndarray, np.ndarray]]
        """World positions and rotations in MuJoCo's data, of the elements that the model has."""
        self.restart()

    def scene_changed(self) -> None:
        self.restart()

    def run_started(self) -> None:
        self.restart()

    def run_stopped(self) -> None:
        self.restart()

    def model_changed(self, twins: Twins | None) -> None:
        if twins is None:
            self.restart()
        else:
            self._carry(twins)

    def restart(self) -> None:
        """Reset all velocities to 0: a run starts or ends, or there is another model. The kinematics must be fresh."""
        self._before, self._after = self._copy(), self._copy()
        data = self._sim.data
        self._sources = [
            (element, getattr(data, place), getattr(data, turn))
            for element, (place, turn) in _ARRAYS.items()
            if len(self._after[element][0])
        ]

    def store(self) -> None:
        """Store the poses at the end of a simulation step. The kinematics must be fresh."""
        self._before, self._after = self._after, self._before
        for element, places, turns in self._sources:
            kept_places, kept_turns = self._after[element]
            kept_places[:] = places
            kept_turns[:] = turns

    def go_on(self, before: mujoco.MjData | None) -> None:
        """Take the velocities between an earlier step's poses and the present ones; None: all are 0."""
        self.restart()
        if before is not None:
            self._before = _copy(before)

    def _carry(self, twins: Twins) -> None:
        """Carry velocities over to an edited model, for elements that stayed (by name)."""
        before, after = self._before, self._after
        self.restart()
        for element in _ARRAYS:
            old, new = twins.pairs("cam" if element == "camera" else element)
            for target, source in ((self._before, before), (self._after, after)):
                for kept, known in zip(target[element], source[element], strict=True):
                    kept[new] = known[old]

    def measure(self, handle: int) -> tuple[list[float], list[float], list[float]]:
        """Return linear velocity (m/s), Euler-angle rates (rad/s) and angular velocity (rad/s) in world axes.

        All are zero at the start. The Euler rates are the angles of the rotation between the two poses, per length
        of the simulation step.
        """
        old, new = self._poses(self._sim.scene.get(handle))
        rate = 1.0 / self._sim.time_step
        turn = multiply(new[1], conjugate(old[1]))
        linear = scale(subtract(new[0], old[0]), rate)
        euler = [angle * rate for angle in euler_from_quat(turn)]
        return list(linear), euler, list(scale(poses.rotation_vector(turn), rate))

    def _poses(self, item: SceneObject) -> tuple[Pose, Pose]:
        if item.element in _ARRAYS:
            return _pose(self._before, item.element, item.id), _pose(self._after, item.element, item.id)
        # A joint or a tendon's frame is measured by the body it is fixed to.
        self._sim.refresh()
        body = carrier_body(self._sim, item)
        local = compose(inverse(body_pose(self._sim, body)), object_pose(self._sim, item))
        return compose(_pose(self._before, "body", body), local), compose(
            _pose(self._after, "body", body), local
        )

    def _copy(self) -> Memory:
        return _copy(self._sim.data)


def _copy(data: mujoco.MjData) -> Memory:
    return {
        element: (getattr(data, place).copy(), getattr(data, turn).copy())
        for element, (place, turn) in _ARRAYS.items()
    }


def _pose(memory: Memory, element: str, index: int) -> Pose:
    places, turns = memory[element]
    position: poses.Vector = tuple(places[index].tolist())  # type: ignore[assignment]
    if element == "body":
        return position, tuple(turns[index].tolist())  # type: ignore[return-value]
    if element == "light":
        return position, poses.turn_z_to(turns[index].tolist())
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, turns[index])
    return position, tuple(quat.tolist())  # type: ignore[return-value]
