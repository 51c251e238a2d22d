"""Forces that scripts apply to shapes: they add up, act during the next simulation step, and are cleared after it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import poses
from simx_server.scene.poses.placing import body_pose
from simx_server.scene.poses.poses import Vector

if TYPE_CHECKING:
    from .simulation import Simulation


class AppliedForces:
    """The forces of one simulation, kept in MuJoCo's `xfrc_applied` (world axes, at the centre of mass)."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._any = False
        self.has_work = False
        """Whether forces were ever applied."""

    def add(self, shape: int, force: Vector, torque: Vector) -> None:
        """Add newtons at the centre of mass and newton metres, both along world axes.

        A shape that physics does not move ignores them, as in V-REP.

        Raises:
            UnknownHandle, WrongKind: the handle is not a shape's.
        """
        body = self._body(shape)
        self._sim.data.xfrc_applied[body] += (*force, *torque)
        self._any = True
        if not self.has_work:
            self.has_work = True
            self._sim.parts.replan()

    def add_at(self, shape: int, point: Vector, force: Vector) -> None:
        """Add a force in newtons at a point, both in the shape's own frame.

        Raises:
            UnknownHandle, WrongKind: the handle is not a shape's.
        """
        body = self._body(shape)
        self._sim.refresh()
        position, turn = body_pose(self._sim, body)
        pull = poses.rotate(turn, force)
        centre: list[float] = self._sim.data.xipos[body].tolist()
        x, y, z = poses.subtract(poses.add(position, poses.rotate(turn, point)), centre)
        torque = (y * pull[2] - z * pull[1], z * pull[0] - x * pull[2], x * pull[1] - y * pull[0])
        self.add(shape, pull, torque)

    def reset(self, shape: int, *, force: bool, torque: bool) -> None:
        """Clear what was added since the last simulation step.

        Raises:
            UnknownHandle, WrongKind: the handle is not a shape's.
        """
        wrench = self._sim.data.xfrc_applied[self._body(shape)]
        if force:
            wrench[:3] = 0.0
        if torque:
            wrench[3:] = 0.0

    def _body(self, shape: int) -> int:
        return self._sim.scene.get_kind(shape, ObjectKind.SHAPE).body

    def clear(self) -> None:
        """Clear all forces after the physics of a simulation step."""
        if self._any:
            self._sim.data.xfrc_applied[:] = 0.0
            self._any = False
