"""Drives of mobile bases: `cmd_vel` becomes target velocities of wheels.

The place of each wheel, and the direction in which its joint turns, are measured in the scene. A wheel of radius r at
(x, y) of the base moves with v = (vx - w y, vy + w x). A plain wheel turns with v_x / r, a mecanum wheel with
(v_x ± v_y) / r, since its rollers stand at 45 degrees: minus in front on the left and behind on the right. An Ackermann
steering is described in `steering.py`.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.placing import object_pose
from simx_server.scene.poses.poses import Pose, compose, conjugate, inverse, rotate

from ..content.joint_commands import LARGEST
from ..endpoints import Commanded, Content, Context, Followed, Moment, Offer
from ..table_call import Call
from ..wire.qos import Qos
from . import steering
from .notes import DRIVE_TOPICS, Names, annotated, topic_of, turn_of
from .steering import Steer
from .wheels import NoDrive, free_axle, steering_of

logger = logging.getLogger(__name__)

TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"

TIMEOUT = 0.5
"""Seconds of simulated time without a command after which a base stops, unless its annotation has others."""

_NEWEST = Qos(depth=1)
"""Only the last command counts."""

_UPRIGHT = 0.5
"""Least share of a wheel's axis that points across the base; sine of 30 degrees."""


class Wheel(NamedTuple):
    """A driven wheel."""

    handle: int
    x: float
    """Place in the frame of the base, metres."""

    y: float
    rate: float
    """Target velocity of the joint for 1 m/s at the wheel, rad/m; negative for a joint that turns backward."""

    sideways: float
    """Share of the sideways velocity at the wheel: 0 for a plain wheel, 1 or -1 for a mecanum wheel."""

    is_steered: bool = False
    """An Ackermann steering turns it; `x` is then from the axle that is not steered."""

    def target(self, vx: float, vy: float, w: float) -> float:
        """Return the target velocity of the joint, rad/s, for velocities of the base, m/s and rad/s."""
        if self.is_steered:
            return self.rate * steering.speed(self.x, self.y, vx, w)
        return self.rate * (vx - w * self.y + self.sideways * (vy + w * self.x))


class Drive:
    """The wheels of one base, and when they were commanded last."""

    def __init__(self) -> None:
        self.wheels: Sequence[Wheel] = ()
        self.steers: Sequence[Steer] = ()
        """The joints of an Ackermann steering; empty for other drives."""

        self.topic = ""
        self._timeout = 0
        self._commanded: int | None = None
        """Simulated nanoseconds of the last command that is not 0; None while the base is to stand."""

    def set(self, wheels: Sequence[Wheel], steers: Sequence[Steer], topic: str, timeout: float) -> None:
        """Take the wheels, the topic and the seconds of the present scene; what was commanded last stays."""
        self.wheels, self.steers, self.topic = wheels, steers, topic
        self._timeout = round(timeout * 1e9)

    def calls(self, now: int, message: Mapping[str, Any]) -> Sequence[Call]:
        """Return the calls of a Twist."""
        wanted = message["linear"]["x"], message["linear"]["y"], message["angular"]["z"]
        calls = self._targets(*wanted)
        # The comparison is false for NaN too. The wanted values count as well: at a wheel they may cancel out.
        if not all(abs(number) <= LARGEST for number in (*wanted, *(call.arguments[1] for call in calls))):
            raise CommandError(
                f"{self.topic} has linear.x, linear.y and angular.z of {wanted}; valid: finite numbers, m/s and "
                f"rad/s, for which no wheel turns faster than {LARGEST:g} rad/s"
            )
        self._commanded = now if any(wanted) else None
        return calls

    def is_under_way(self) -> bool:
        """Return whether the base follows a command, which ends after a while."""
        return self._commanded is not None

    def due(self, moment: Moment) -> Sequence[Call]:
        """Return the calls that stop the base, once no command has come for a while."""
        since = self._commanded
        if since is None or since <= moment.nanoseconds < since + self._timeout:
            return ()
        self._commanded = None
        return self._targets(0.0, 0.0, 0.0)

    def forget(self) -> None:
        """Forget the last command: the run ends."""
        self._commanded = None

    def _targets(self, vx: float, vy: float, w: float) -> Sequence[Call]:
        turns: list[Call] = []
        if self.steers:
            vx, w = steering.limited(self.steers, vx, w)
            if vx:  # a car that stands keeps its wheels as they are
                turns = [
                    Call("simxSetJointTargetPosition", [steer.handle, steering.angle(steer, vx, w)])
                    for steer in self.steers
                ]
        return turns + [
            Call("simxSetJointTargetVelocity", [wheel.handle, wheel.target(vx, vy, w)])
            for wheel in self.wheels
        ]


class Drives(Content):
    """Takes Twist and TwistStamped for each base with a drive."""

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._world = context.world
        self._simulation = context.world.simulation
        self._drives: dict[int, Drive] = {}

    def run_stopped(self) -> None:
        for drive in self._drives.values():
            drive.forget()

    def offers(self) -> Iterable[Offer]:
        before, self._drives = self._drives, {}
        names = Names(self._simulation.scene, self._robots)
        for item, note in annotated(self._simulation.scene, self._robots, "drive"):
            topic = names.topic(item, topic_of(note, "cmd") or DRIVE_TOPICS["cmd"])
            wheels = self._wheels(item, note)
            if not wheels:
                continue
            try:
                wheels, steers = self._with_steering(item, note, wheels)
            except NoDrive as problem:
                logger.warning("ROS 2: %s has no drive, since %s", item.name, problem)
                continue
            drive = self._drives[item.handle] = before.get(item.handle) or Drive()
            drive.set(wheels, steers, topic, float(note.get("timeout", TIMEOUT)))
            yield from self._commands(drive, str(note.get("stamped", "auto")))
            yield Followed(f"drive {item.handle}", drive.due, drive.is_under_way)

    def _commands(self, drive: Drive, stamped: str) -> Iterable[Offer]:
        if stamped != "yes":
            yield Commanded(drive.topic, TWIST, partial(self._plain, drive), _NEWEST)
        if stamped != "no":
            is_listed = stamped == "yes"
            yield Commanded(drive.topic, STAMPED, partial(self._stamped, drive), _NEWEST, is_listed)

    def _plain(self, drive: Drive, message: Mapping[str, Any]) -> Sequence[Call]:
        return drive.calls(self._now(), message)

    def _stamped(self, drive: Drive, message: Mapping[str, Any]) -> Sequence[Call]:
        # The stamp is not compared: many senders have the wall clock's.
        return drive.calls(self._now(), message["twist"])

    def _now(self) -> int:
        return Moment.of(self._simulation.step_count, self._simulation.time_step).nanoseconds

    def _wheels(self, item: SceneObject, note: Annotation) -> Sequence[Wheel]:
        """Return the wheels of a drive; none if one is missing or cannot be one, which the log says."""
        simulation = self._simulation
        simulation.refresh()
        base = compose(object_pose(simulation, item), ((0.0, 0.0, 0.0), turn_of(note)))
        found: list[Wheel] = []
        for side in ("left", "right"):
            for name in str(note[side]).split(","):
                handle = simulation.scene.by_name(name)
                joint = None if handle is None else simulation.scene.objects[handle]
                if joint is None or joint.kind is not ObjectKind.JOINT or joint.element != "joint":
                    logger.warning("ROS 2: %s has no drive, since its wheel %s is missing", item.name, name)
                    return ()
                wheel = self._wheel(joint, base, note, 1.0 if side == "left" else -1.0)
                if wheel is None:
                    logger.warning(
                        "ROS 2: %s has no drive, since the axis of %s is not across the base; set forward= and up=",
                        item.name,
                        name,
                    )
                    return ()
                found.append(wheel)
        return _with_rollers(found) if note["drive"] == "mecanum" else found

    def _with_steering(
        self, item: SceneObject, note: Annotation, wheels: Sequence[Wheel]
    ) -> tuple[Sequence[Wheel], Sequence[Steer]]:
        """Return the wheels with those that are steered, and the steering. Raises NoDrive."""
        if note["drive"] != "ackermann":
            return wheels, ()
        scene, data = self._simulation.scene, self._simulation.data
        base = compose(object_pose(self._simulation, item), ((0.0, 0.0, 0.0), turn_of(note)))
        joints = [scene.objects[wheel.handle] for wheel in wheels]
        axle = in_frame(base, free_axle(self._world, item, joints).tolist())[0]
        steers: dict[int, Steer] = {}
        for name in str(note["steer"]).split(","):
            handle = scene.by_name(name)
            joint = None if handle is None else scene.objects[handle]
            if joint is None or joint.element != "joint":
                raise NoDrive(f"its joint {name} is missing")
            x, y, _ = in_frame(base, data.xanchor[joint.id].tolist())
            up = rotate(conjugate(base[1]), data.xaxis[joint.id].tolist())[2]
            if abs(x - axle) < 1e-3:
                raise NoDrive(f"its joint {name} is on the axle that is not steered")
            steers[joint.handle] = Steer(joint.handle, x - axle, y, math.copysign(1.0, up))
        above = [steering_of(self._world, joint) for joint in joints]
        return [
            wheel._replace(x=steers[joint.handle].x, is_steered=True)
            if joint is not None and joint.handle in steers
            else wheel
            for wheel, joint in zip(wheels, above, strict=True)
        ], [*steers.values()]

    def _wheel(self, joint: SceneObject, base: Pose, note: Annotation, side: float) -> Wheel | None:
        data = self._simulation.data
        axis = rotate(conjugate(base[1]), data.xaxis[joint.id].tolist())
        (x, y, _), _ = compose(inverse(base), (tuple(data.xanchor[joint.id].tolist()), (1.0, 0.0, 0.0, 0.0)))
        if abs(axis[1]) < _UPRIGHT:
            return None
        track = note.get("track")
        if track is not None:
            y = side * float(track) / 2
        return Wheel(joint.handle, x, y, math.copysign(1 / float(note["radius"]), axis[1]), 0.0)


def in_frame(base: Pose, point: Sequence[float]) -> tuple[float, float, float]:
    """Return a point of the world in a frame."""
    x, y, z = (float(each) for each in point)
    return compose(inverse(base), ((x, y, z), (1.0, 0.0, 0.0, 0.0)))[0]


def _with_rollers(wheels: Sequence[Wheel]) -> Sequence[Wheel]:
    """Return the same wheels as mecanum wheels."""
    middle = sum(wheel.x for wheel in wheels) / len(wheels)
    return [wheel._replace(sideways=-1.0 if (wheel.x > middle) == (wheel.y > 0) else 1.0) for wheel in wheels]
