"""Range of single proximity sensors, and LaserScan of rings of them.

Values are those of ``simxReadProximitySensor`` at the same simulation step. While the sensors have no result, such as
before the first step, nothing is published.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.ros2_messages import BY_NAME
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.placing import object_pose
from simx_server.scene.poses.poses import Pose, compose, inverse, matrix

from ..endpoints import Content, Context, Message, Moment, Offer, Published
from ..wire.qos import SENSOR_DATA
from .notes import Names, annotated, period_of, sensors_below, turn_of

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

RANGE, SCAN = "sensor_msgs/msg/Range", "sensor_msgs/msg/LaserScan"

_CONSTANTS = BY_NAME[RANGE].constants
_LIGHT = ("infrared", "laser")
"""Kinds of sensors, by the key `detects`, whose Range is one of light."""

_SAME_DIRECTION = 1e-3
"""Angle in rad below which two sensors look in one direction, when a ring's increment is measured."""


class Ranges(Content):
    """Publishes proximity sensors with the key `range`."""

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._world = context.world

    def offers(self) -> Iterable[Offer]:
        scene = self._world.simulation.scene
        names = Names(scene, self._robots)
        for item, note in annotated(scene, self._robots, "range"):
            topic, frame = names.topic(item, str(note["range"])), names.range_frame(item, note)
            yield Published(
                topic, RANGE, partial(self._message, item.handle, frame), SENSOR_DATA, period_of(note)
            )

    def _message(self, handle: int, frame: str, moment: Moment) -> Message | None:
        item = self._world.simulation.scene.get(handle)
        volume = item.annotations.get("proximity", {})
        try:
            found = self._world.proximity.read(handle)
        except CommandError:
            return None  # it has no result now, or a script handles it and has not yet
        near = float(volume.get("offset", 0.0))
        return {
            "header": moment.header(frame),
            "radiation_type": _CONSTANTS["INFRARED" if volume.get("detects") in _LIGHT else "ULTRASOUND"],
            "field_of_view": math.radians(float(volume.get("angle_deg", 0.0))),
            "min_range": max(0.0, near, float(volume.get("min_distance", 0.0))),
            "max_range": near + self._world.proximity.reach(handle),
            "range": math.inf if found is None else math.hypot(*found.point),
            "variance": 0.0,
        }


class Ring:
    """The sensors of a scan, and the directions of its values."""

    def __init__(self, poses: Sequence[Pose], note: Annotation) -> None:
        """Measure the ring.

        Args:
            poses: of at least one sensor, in the frame of the scan, whose z is the axis of the ring.
            note: the annotation; missing angles are those of the sensors.
        """
        axes = np.array([matrix(pose[1]) for pose in poses])[:, :, 2]
        looks = np.arctan2(axes[:, 1], axes[:, 0])
        angles = np.sort(looks)
        gaps = np.diff(angles)
        gaps = gaps[gaps > _SAME_DIRECTION]
        step = note.get("increment_deg")
        self.increment = (
            math.radians(float(step)) if step is not None else float(gaps.min()) if len(gaps) else 2 * math.pi
        )
        low, high = note.get("angle_min_deg"), note.get("angle_max_deg")
        self.angle_min = float(angles[0]) if low is None else math.radians(float(low))
        last = float(angles[-1]) if high is None else math.radians(float(high))
        # A value that lies on the upper limit but for rounding belongs to the scan.
        self.count = max(int((last - self.angle_min) / self.increment + 1e-6), 0) + 1
        self._silent = self._places(looks)
        """For each sensor the value of the direction in which it looks, -1 for one outside."""

    @property
    def angle_max(self) -> float:
        """Return the direction of the last value, rad."""
        return self.angle_min + (self.count - 1) * self.increment

    def ranges(self, echoes: NDArray[np.bool_], points: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the values of the scan, metres: +Inf where a sensor has no echo, NaN where no sensor looks.

        Args:
            echoes: (n) whether each sensor detects something.
            points: (m, 3) the points that those detect, in the frame of the scan.
        """
        found = np.full(self.count, np.nan)
        found[self._silent[~echoes & (self._silent >= 0)]] = math.inf
        places = self._places(np.arctan2(points[:, 1], points[:, 0]))
        inside = places >= 0
        nearest = np.full(self.count, math.inf)
        np.minimum.at(nearest, places[inside], np.hypot(points[inside, 0], points[inside, 1]))
        return np.where(nearest < math.inf, nearest, found).astype("<f4")

    def _places(self, angles: NDArray[np.float64]) -> NDArray[np.intp]:
        """Return the values to which directions belong, -1 for those outside."""
        turned = np.mod(angles - self.angle_min + self.increment / 2, 2 * math.pi)
        places = np.floor(turned / self.increment + 1e-9).astype(np.intp)
        return np.where(places < self.count, places, -1)


class Scans(Content):
    """Publishes rings of proximity sensors with the key `scan`."""

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._world = context.world

    def offers(self) -> Iterable[Offer]:
        scene = self._world.simulation.scene
        names = Names(scene, self._robots)
        for item, note in annotated(scene, self._robots, "scan"):
            sensors = [each for each in sensors_below(scene, item) if each.element == "site"]
            if not sensors:
                logger.warning("ROS 2: %s has no scan, since no proximity sensor is below it", item.name)
                continue
            scan = Scan(self._world, item, note, sensors, names.header_frame(item, note))
            topic = names.topic(item, str(note["scan"]))
            yield Published(topic, SCAN, scan.message, SENSOR_DATA, period_of(note))


class Scan:
    """The scan of one object, as long as the model is the same."""

    def __init__(
        self, world: World, item: SceneObject, note: Annotation, sensors: Sequence[SceneObject], frame: str
    ) -> None:
        """Measure the ring.

        Args:
            sensors: at least one, each at a site.
            frame: of the messages.
        """
        self._world, self._item, self._frame = world, item, frame
        self._period = period_of(note)
        self._turn: Pose = (0.0, 0.0, 0.0), turn_of(note)
        self._handles = [sensor.handle for sensor in sensors]
        self._sites = np.array([sensor.id for sensor in sensors], np.intp)
        simulation = world.simulation
        simulation.refresh()
        back = inverse(self._origin())
        poses = [compose(back, object_pose(simulation, each)) for each in sensors]
        self._ring = Ring(poses, note)
        self._range_max = max(
            math.hypot(*pose[0]) + world.proximity.reach(handle)
            for pose, handle in zip(poses, self._handles, strict=True)
        )

    def _origin(self) -> Pose:
        """Return the frame of the scan in the world."""
        return compose(object_pose(self._world.simulation, self._item), self._turn)

    def message(self, moment: Moment) -> Message | None:
        """Return the LaserScan of the last simulation step; None while a sensor has no result."""
        simulation, read = self._world.simulation, self._world.proximity.read
        try:
            found = [read(handle) for handle in self._handles]
        except CommandError:
            return None  # the simulation is stopped, or a script handles a sensor and has not yet
        simulation.refresh()
        ring, data = self._ring, simulation.data
        origin, turn = self._origin()
        echoes = np.array([each is not None for each in found])
        points = np.empty((0, 3))
        if echoes.any():
            sites = self._sites[echoes]
            local = np.array([each.point for each in found if each is not None])
            turns = data.site_xmat[sites].reshape(-1, 3, 3)
            points = data.site_xpos[sites] + np.einsum("nij,nj->ni", turns, local)
            points = (points - origin) @ np.array(matrix(turn))
        return {
            "header": moment.header(self._frame),
            "angle_min": ring.angle_min,
            "angle_max": ring.angle_max,
            "angle_increment": ring.increment,
            "time_increment": 0.0,
            "scan_time": max(self._period, simulation.time_step),
            "range_min": 0.0,
            "range_max": self._range_max,
            "ranges": ring.ranges(echoes, points),
            "intensities": [],
        }
