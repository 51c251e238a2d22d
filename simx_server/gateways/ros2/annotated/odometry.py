"""Odometry of mobile bases: where the base is since the start of the run, as a message and as a transform.

It is the exact pose in the simulation, not one counted from wheels. The frame `odom` stands where the base was at the
start of the run, with its heading, level. While the simulation is stopped the base is there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.placing import object_pose
from simx_server.scene.poses.poses import Pose, Quaternion, compose, conjugate, inverse, rotate
from simx_server.simulation.simulation import SimulationState

from ..endpoints import Message, Moment, Published
from ..robots import Robots
from .notes import Names, annotated, base_frame, odom_frame, topic_of, turn_of

if TYPE_CHECKING:
    from simx_server.world.world import World

TYPE = "nav_msgs/msg/Odometry"

VARIANCE = 1e-6
"""Of each coordinate, m² and rad²: the values are exact, but filters refuse 0."""

_COVARIANCE = [VARIANCE if row == column else 0.0 for row in range(6) for column in range(6)]


class Base(NamedTuple):
    """A mobile base."""

    item: SceneObject
    turn: Pose
    """The frame of the base in that of the object."""

    frame: str
    odom: str
    """The frame in which it moves."""

    parent: str
    """The frame below which `odom` stands; empty: none, for localisation to give it one."""

    has_transform: bool
    """Whether the transform from `odom` is published."""

    topic: str
    """Of the odometry; empty for none."""


class Odometers:
    """All mobile bases of a scene, with their poses at the start of the run."""

    def __init__(self, world: World, robots: Robots) -> None:
        self._world, self._robots = world, robots
        self._starts: dict[int, Pose] = {}
        self.bases: list[Base] = []

    def renew(self, names: Names) -> None:
        """List the bases of the present scene."""
        self.bases = []
        for item, note in annotated(self._world.simulation.scene, self._robots, "drive", "odom"):
            topic = topic_of(note, "odom")
            parent = note.get("parent_frame")
            self.bases.append(
                Base(
                    item,
                    ((0.0, 0.0, 0.0), turn_of(note)),
                    names.frame(item, base_frame(note)),
                    names.frame(item, odom_frame(note)),
                    "" if parent is None else str(parent),
                    bool(note.get("tf", True)),
                    "" if topic is None else names.topic(item, topic),
                )
            )
        handles = {base.item.handle for base in self.bases}
        self._starts = {handle: pose for handle, pose in self._starts.items() if handle in handles}
        for base in self.bases:
            self._starts.setdefault(base.item.handle, _level(self.pose(base)))

    def note_start(self) -> None:
        """Take the present poses for those of the start."""
        self._starts = {base.item.handle: _level(self.pose(base)) for base in self.bases}

    def pose(self, base: Base) -> Pose:
        """Return the pose of a base in the world."""
        simulation = self._world.simulation
        simulation.refresh()
        return compose(object_pose(simulation, base.item), base.turn)

    def start(self, base: Base) -> Pose:
        """Return the pose of `odom` in the world."""
        if self._world.simulation.state is SimulationState.STOPPED:
            self._starts[base.item.handle] = _level(self.pose(base))
        return self._starts[base.item.handle]

    def since_start(self, base: Base) -> Pose:
        """Return the pose of a base in `odom`."""
        return compose(inverse(self.start(base)), self.pose(base))

    def transforms(self, moment: Moment) -> Iterator[Mapping[str, Any]]:
        """Yield the transform from `odom` of each base that has one."""
        for base in self.bases:
            if base.has_transform:
                (x, y, z), turn = self.since_start(base)
                yield {
                    "header": moment.header(base.odom),
                    "child_frame_id": base.frame,
                    "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": quaternion(turn)},
                }

    def offers(self) -> Iterable[Published]:
        """Yield the topics of the bases."""
        for base in self.bases:
            if base.topic:
                yield Published(base.topic, TYPE, partial(self._message, base))

    def _message(self, base: Base, moment: Moment) -> Message:
        (x, y, z), turn = self.since_start(base)
        linear, _, angular = self._world.velocities.measure(base.item.handle)
        back = conjugate(self.pose(base)[1])
        return {
            "header": moment.header(base.odom),
            "child_frame_id": base.frame,
            "pose": {
                "pose": {"position": {"x": x, "y": y, "z": z}, "orientation": quaternion(turn)},
                "covariance": _COVARIANCE,
            },
            "twist": {
                "twist": {"linear": vector(rotate(back, linear)), "angular": vector(rotate(back, angular))},
                "covariance": _COVARIANCE,
            },
        }


def vector(values: Iterable[float]) -> Mapping[str, float]:
    """Return a ``geometry_msgs/Vector3``."""
    x, y, z = values
    return {"x": x, "y": y, "z": z}


def quaternion(turn: Quaternion) -> Mapping[str, float]:
    """Return a ``geometry_msgs/Quaternion``."""
    w, x, y, z = turn
    return {"x": x, "y": y, "z": z, "w": w}


def _level(pose: Pose) -> Pose:
    """Return a pose with its heading about the world's z alone."""
    position, turn = pose
    x, y, _ = rotate(turn, (1.0, 0.0, 0.0))
    half = math.atan2(y, x) / 2
    return position, (math.cos(half), 0.0, 0.0, math.sin(half))
