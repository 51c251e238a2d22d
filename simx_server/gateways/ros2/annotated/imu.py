"""IMUs: orientation, angular velocity and acceleration of objects with the key `imu` (REP-145).

Velocities are those of the remote API, means over the last simulation step. The acceleration is the change of the
linear velocity from one step to the next, minus gravity: at rest +9.81 m/s² upwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.poses.placing import object_pose
from simx_server.scene.poses.poses import IDENTITY, Pose, Vector, compose, conjugate, rotate, scale, subtract
from simx_server.simulation.simulation import SimulationState

from ..endpoints import Content, Context, Message, Moment, Offer, Published
from ..wire.qos import SENSOR_DATA
from .notes import Names, annotated, period_of, turn_of
from .odometry import VARIANCE, quaternion, vector

if TYPE_CHECKING:
    from simx_server.world.world import World

TYPE = "sensor_msgs/msg/Imu"

_COVARIANCE = [VARIANCE, 0.0, 0.0, 0.0, VARIANCE, 0.0, 0.0, 0.0, VARIANCE]


class Imus(Content):
    """Publishes the IMUs of the scene."""

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._world = context.world
        self._imus: dict[int, Imu] = {}
        """By the handle of the object; each goes on when the offers are listed again."""

    def offers(self) -> Iterable[Offer]:
        before, self._imus = self._imus, {}
        scene = self._world.simulation.scene
        names = Names(scene, self._robots)
        for item, note in annotated(scene, self._robots, "imu"):
            imu = before.get(item.handle) or Imu(self._world, item.handle)
            imu.set(note, names.header_frame(item, note))
            self._imus[item.handle] = imu
            period = period_of(note)
            make = imu.message if period <= self._world.simulation.time_step else partial(imu.seldom, period)
            yield Published(names.topic(item, str(note["imu"])), TYPE, make, SENSOR_DATA)


class Imu:
    """One IMU, which remembers the velocity of the step before while someone listens."""

    def __init__(self, world: World, handle: int) -> None:
        self._world, self._handle, self._frame = world, handle, ""
        self._turn: Pose = IDENTITY
        self._seen = -1
        """Step count when the velocity was remembered."""

        self._velocity: Vector = (0.0, 0.0, 0.0)
        """Linear velocity then, m/s along world axes."""

        self._acceleration: Vector | None = None
        """Of the same step, m/s² along world axes; None if the step before was not measured."""

        self._published = 0

    def set(self, note: Annotation, frame: str) -> None:
        """Take the axes of the annotation, and the frame of messages."""
        self._turn, self._frame = ((0.0, 0.0, 0.0), turn_of(note)), frame

    def seldom(self, period: float, moment: Moment) -> Message | None:
        """Return the message once per period in seconds; the velocity is remembered in each step."""
        made, last = self.message(moment), self._published
        if made is None or moment.nanoseconds // (period * 1e9) == last // (period * 1e9):
            return None
        self._published = moment.nanoseconds
        return made

    def message(self, moment: Moment) -> Message | None:
        """Return the message of the present state; None for the first of several steps that are measured."""
        simulation = self._world.simulation
        linear, _, angular = self._world.velocities.measure(self._handle)
        if simulation.state is SimulationState.STOPPED:
            self._seen = -1
            return self._made(moment, (0.0, 0.0, 0.0), angular)
        count = simulation.step_count
        if self._seen != count:  # while paused the last step is measured again
            change = scale(subtract(linear, self._velocity), 1.0 / simulation.time_step)
            self._acceleration = change if self._seen == count - 1 else None
            self._seen, self._velocity = count, (linear[0], linear[1], linear[2])
        return None if self._acceleration is None else self._made(moment, self._acceleration, angular)

    def _made(self, moment: Moment, acceleration: Sequence[float], angular: Sequence[float]) -> Message:
        simulation = self._world.simulation
        simulation.refresh()
        _, turn = compose(object_pose(simulation, simulation.scene.get(self._handle)), self._turn)
        back = conjugate(turn)
        felt = subtract(acceleration, simulation.model.opt.gravity.tolist())
        return {
            "header": moment.header(self._frame),
            "orientation": quaternion(turn),
            "orientation_covariance": _COVARIANCE,
            "angular_velocity": vector(rotate(back, angular)),
            "angular_velocity_covariance": _COVARIANCE,
            "linear_acceleration": vector(rotate(back, felt)),
            "linear_acceleration_covariance": _COVARIANCE,
        }
