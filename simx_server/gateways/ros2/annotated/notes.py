"""The annotations of objects for ROS 2, and the topics, frames and joints that they name in a scene."""

from __future__ import annotations

from collections.abc import Iterator

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.objects import ObjectKind, Scene, SceneObject
from simx_server.scene.poses.poses import Quaternion, from_rows

from ..content.naming import frame_name, joint_name, optical_frame, part_of_topic
from ..robots import Robots

TOPICS = ("states", "command", "topic", "range", "scan", "imu", "cmd", "odom")
"""Keys that name topics."""

DRIVE_TOPICS = {"cmd": "/cmd_vel", "odom": "/odom"}
"""Topics of a drive without these keys."""

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def note_of(item: SceneObject) -> Annotation:
    """Return the annotation of an object, empty for none."""
    return item.annotations.get("ros2", {})


def annotated(scene: Scene, robots: Robots, *keys: str) -> Iterator[tuple[SceneObject, Annotation]]:
    """Yield the objects whose annotation, or what is guessed in its place, has one of these keys, in scene order."""
    for item in scene.objects.values():
        note = note_of(item) or robots.guessed.get(item.handle, {})
        if note and not note.keys().isdisjoint(keys):
            yield item, note


def topic_of(note: Annotation, key: str) -> str | None:
    """Return the topic that a key names, or that a drive has without it; None for none."""
    default = DRIVE_TOPICS.get(key) if "drive" in note else None
    found = note.get(key, default)
    return None if found is None else str(found)


def base_frame(note: Annotation) -> str:
    """Return the frame of a mobile base, before a prefix."""
    return str(note.get("base", "base_link"))


def odom_frame(note: Annotation) -> str:
    """Return the frame in which its odometry is given, before a prefix."""
    return str(note.get("odom_frame", "odom"))


def turn_of(note: Annotation) -> Quaternion:
    """Return the frame x forward, y left, z up in the frame of the object: w, x, y, z."""
    forward, up = (_axis(str(note.get(key, default))) for key, default in (("forward", "x"), ("up", "z")))
    left = (
        up[1] * forward[2] - up[2] * forward[1],
        up[2] * forward[0] - up[0] * forward[2],
        up[0] * forward[1] - up[1] * forward[0],
    )
    return from_rows([*zip(forward, left, up, strict=True)])


def _axis(name: str) -> tuple[float, float, float]:
    x, y, z = _AXES[name[-1]]
    return (-x, -y, -z) if name.startswith("-") else (x, y, z)


def scene_period(scene: Scene) -> float:
    """Return the least seconds between two messages of all joints or of all transforms; 0 for each step."""
    return period_of(scene.annotations.ros2)


def period_of(note: Annotation) -> float:
    """Return the least seconds between two messages of a topic; 0 for one in each simulation step."""
    rate = note.get("rate")
    return 0.0 if rate is None else 1 / float(rate)


def unpublished(scene: Scene) -> set[int]:
    """Return the handles of objects that have, or are below one that has, the key `publish=no`."""
    hidden: set[int] = set()
    for item in scene.objects.values():
        if not note_of(item).get("publish", True):
            hidden |= {item.handle, *scene.descendants(item.handle)}
    return hidden


class Names:
    """The names that annotations give, different for each robot.

    A robot is a model with all that is below it. If it would have a topic, frame or joint of one before it, such as a
    copy, all its names start with that of the model: `/Pioneer_p3dx_0/odom`, `Pioneer_p3dx_0/base_link`. A robot that
    was spawned with a namespace, or has one in its annotation, has this instead of the model's name.
    """

    def __init__(self, scene: Scene, robots: Robots) -> None:
        self._scene, self._robots = scene, robots
        self._prefixes: dict[int, str] = {}
        """By the robot's handle."""

        taken: set[tuple[str, str]] = set()
        for robot, names in self._claims().items():
            if given := self._namespace(robot):
                self._prefixes[robot] = given
                continue
            is_second = not names.isdisjoint(taken)
            self._prefixes[robot] = part_of_topic(scene, scene.objects[robot]) if is_second else ""
            taken |= names

    def topic(self, item: SceneObject, topic: str) -> str:
        """Return the topic of an object, with a slash in front."""
        prefix = self._prefix(item)
        return f"/{prefix}{topic}" if prefix else topic

    def own_topic(self, item: SceneObject) -> str:
        """Return the topic of an object that is named after it."""
        given = self._namespace(self._robot(item))
        return f"{given and '/' + given}/{part_of_topic(self._scene, item)}"

    def frame(self, item: SceneObject, frame: str) -> str:
        """Return a frame of an object."""
        prefix = self._prefix(item)
        return f"{prefix}/{frame}" if prefix else frame

    def joint(self, item: SceneObject) -> str:
        """Return the name of a joint in JointState."""
        given = note_of(item).get("name")
        if given is None:
            return joint_name(item)
        return self.prefixed(item, str(given))

    def prefixed(self, item: SceneObject, name: str) -> str:
        """Return the name of a joint of an object's robot."""
        prefix = self._prefix(item).replace("/", "_")
        return f"{prefix}_{name}" if prefix else name

    def header_frame(self, item: SceneObject, note: Annotation) -> str:
        """Return the frame of what an object measures: that of its annotation, else its own."""
        given = note.get("frame")
        return frame_name(item) if given is None else self.frame(item, str(given))

    def camera_frame(self, item: SceneObject, note: Annotation) -> str:
        """Return the optical frame of a vision sensor."""
        given = note.get("frame")
        return optical_frame(item) if given is None else self.frame(item, str(given))

    def laser_frame(self, item: SceneObject) -> str:
        """Return the frame of a vision sensor of one row as a laser scanner: x forward, y to the left."""
        return f"{frame_name(item)}_laser"

    def range_frame(self, item: SceneObject, note: Annotation) -> str:
        """Return the frame of a proximity sensor, x along its axis."""
        given = note.get("frame")
        return f"{frame_name(item)}_range" if given is None else self.frame(item, str(given))

    def robot(self, item: SceneObject) -> SceneObject:
        """Return the model to which an object belongs, or itself."""
        return self._scene.objects[self._robot(item)]

    def _namespace(self, robot: int) -> str:
        """Return the namespace of a robot without a slash in front; empty for none."""
        given = self._robots.namespace(robot) or str(note_of(self._scene.objects[robot]).get("namespace", ""))
        return given.strip("/")

    def _prefix(self, item: SceneObject) -> str:
        return self._prefixes.get(self._robot(item), "")

    def _robot(self, item: SceneObject) -> int:
        """Return the handle of the model to which an object belongs, or its own."""
        above = item.handle
        while above in self._scene.objects:
            if self._scene.is_model_base(above):
                return above
            above = self._scene.objects[above].parent
        return item.handle

    def _claims(self) -> dict[int, set[tuple[str, str]]]:
        """Return the names that robots want, by the robot's handle."""
        found: dict[int, set[tuple[str, str]]] = {}
        for item in self._scene.objects.values():
            note = note_of(item) or self._robots.guessed.get(item.handle, {})
            if not note:
                continue
            names = found.setdefault(self._robot(item), set())
            names |= {("topic", topic) for key in TOPICS if (topic := topic_of(note, key)) is not None}
            names |= {(key, str(note[key])) for key in ("name", "frame") if key in note}
            if "drive" in note or "odom" in note:
                names |= {("frame", base_frame(note)), ("frame", odom_frame(note))}
        return found


def sensors_below(scene: Scene, item: SceneObject) -> list[SceneObject]:
    """Return the proximity sensors of a ring: the object itself, and all below it."""
    return _below(scene, item, ObjectKind.PROXIMITY_SENSOR)


def joints_below(scene: Scene, item: SceneObject) -> list[SceneObject]:
    """Return the object itself if it is a joint, and all joints below it."""
    return _below(scene, item, ObjectKind.JOINT)


def _below(scene: Scene, item: SceneObject, kind: ObjectKind) -> list[SceneObject]:
    found = (scene.objects[handle] for handle in (item.handle, *scene.descendants(item.handle)))
    return [each for each in found if each.kind is kind]
