"""Velocities of objects as V-REP measures them: from the poses at the ends of the last two simulation steps.

The physics engine's own velocity of a moving body is another one: at the end of the step, of the centre of mass.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.objects import SceneObject
from simx_server.scene.poses import poses
from simx_server.scene.poses.frames import euler_from_quat
from simx_server.scene.poses.placing import body_pose, carrier_body, object_pose
from simx_server.scene.poses.pose_copies import POSES, PoseCopies, Poses
from simx_server.scene.poses.poses import Pose, compose, conjugate, inverse, multiply, scale, subtract

from .part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins

    from .simulation import Simulation


class Velocities(Part):
    """Keeps poses from one simulation step to the next. Poses set between two steps count as motion."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._present = sim.poses
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
        self._before = self._after = self._present.numbers()
        self._copies = self._present.copies

    def store(self) -> None:
        """Store the poses at the end of a simulation step. The kinematics must be fresh."""
        self._before, self._after = self._after, self._present.numbers()

    @property
    def newest(self) -> np.ndarray:
        """Return the poses at the end of the last simulation step, or at the start of the run; not to be written."""
        return self._after

    @property
    def copies(self) -> PoseCopies:
        """Return what copies the poses."""
        return self._copies

    def adopt(self, before: np.ndarray, after: np.ndarray) -> None:
        """Take over the poses at the ends of two simulation steps that were made outside."""
        self._before, self._after = before, after

    def go_on(self, before: mujoco.MjData | None) -> None:
        """Take the velocities between an earlier step's poses and the present ones; None: all are 0."""
        self.restart()
        if before is not None:
            self._before = self._copies.numbers()
            old, new = PoseCopies(before).take(), self._copies.poses(self._before)
            for element in POSES:
                for kept, known in zip(new.of(element), old.of(element), strict=True):
                    kept[:] = known

    def _carry(self, twins: Twins) -> None:
        """Carry velocities over to an edited model, for elements that stayed (by name)."""
        copies, before, after = self._copies, self._before, self._after
        self.restart()
        stayed = {element: twins.pairs("cam" if element == "camera" else element) for element in POSES}

        def carried(numbers: np.ndarray) -> np.ndarray:
            found = self._copies.numbers()
            source, target = copies.poses(numbers), self._copies.poses(found)
            for element, (old, new) in stayed.items():
                if len(new):
                    for kept, known in zip(target.of(element), source.of(element), strict=True):
                        kept[new] = known[old]
            return found

        self._before = carried(before)
        self._after = self._before if after is before else carried(after)

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

    def of_mass_centre(self, body: int) -> tuple[list[float], list[float]]:
        """Return the velocity of a body's centre of mass (m/s) and its angular velocity (rad/s) in world axes."""
        sim = self._sim
        sim.refresh()
        mujoco.mj_comVel(sim.model, sim.data)
        motion = np.empty(6)
        mujoco.mj_objectVelocity(sim.model, sim.data, mujoco.mjtObj.mjOBJ_BODY, body, motion, 0)
        return motion[3:].tolist(), motion[:3].tolist()

    def _poses(self, item: SceneObject) -> tuple[Pose, Pose]:
        self._sim.compile_edits()  # the object has the number of the new model, and so have the poses then
        before, after = map(self._copies.poses, (self._before, self._after))
        if item.element in POSES:
            return _pose(before, item.element, item.id), _pose(after, item.element, item.id)
        # A joint or a tendon's frame is measured by the body it is fixed to.
        self._sim.refresh()
        body = carrier_body(self._sim, item)
        local = compose(inverse(body_pose(self._sim, body)), object_pose(self._sim, item))
        return compose(_pose(before, "body", body), local), compose(_pose(after, "body", body), local)


def _pose(memory: Poses, element: str, index: int) -> Pose:
    places, turns = memory.of(element)
    position: poses.Vector = tuple(places[index].tolist())  # type: ignore[assignment]
    if element == "body":
        return position, tuple(turns[index].tolist())  # type: ignore[return-value]
    if element == "light":
        return position, poses.turn_z_to(turns[index].tolist())
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, turns[index])
    return position, tuple(quat.tolist())  # type: ignore[return-value]
