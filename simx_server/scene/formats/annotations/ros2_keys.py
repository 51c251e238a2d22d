"""The keys of `simx:ros2`: topics and frames of an object in ROS 2, and the checks that concern several of them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import NamedTuple

from .annotation import Annotation, SceneError, Value
from .checks import number, one_of, positive, switch

_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_FRAME = re.compile(r"[^\s/?-]\S*")

AXES = ("x", "-x", "y", "-y", "z", "-z")
"""Axes of an object, by which `forward` and `up` place x and z of its frame in ROS 2."""


def topic(text: str) -> str:
    """Return a topic with a slash in front."""
    if not _TOPIC.fullmatch(text):
        raise ValueError("a topic such as /odom, of letters, digits, underscores and slashes")
    return text if text.startswith("/") else f"/{text}"


def frame(text: str) -> str:
    """Return the name of a frame."""
    if not _FRAME.fullmatch(text):
        raise ValueError("a frame such as base_link, without spaces and without a slash in front")
    return text


def between(least: float, most: float) -> Callable[[str], float]:
    """Return the check of a number within limits."""

    def check(text: str) -> float:
        try:
            value = number(text)
        except ValueError:
            value = least - 1
        if not least <= value <= most:
            raise ValueError(f"a number from {least:g} to {most:g}")
        return value

    return check


rate = between(0.001, 10_000)
increment = between(0.01, 360)
timeout = between(0.001, 1_000_000)


class JointName(NamedTuple):
    """A joint of a group, as ROS 2 knows it."""

    joint: str
    """Its name in the scene."""

    name: str
    """Its name in ROS 2."""

    offset: float
    """Position in ROS 2 minus that in the scene, rad or m."""


def read_joints(text: str) -> list[JointName]:
    """Return the joints of a group from `joint:name` or `joint:name:offset` with commas between them."""
    found: list[JointName] = []
    for word in text.split(","):
        parts = word.split(":")
        if not 2 <= len(parts) <= 3 or not all(parts):
            raise ValueError("joints such as arm1:shoulder,arm2:elbow:-1.57, each with its name and offset")
        found.append(JointName(parts[0], parts[1], number(parts[2]) if len(parts) == 3 else 0.0))
    return found


def joints(text: str) -> str:
    """Return the text of a group's joints, checked."""
    read_joints(text)
    return text


def renamed_joints(key: str, text: str, names: Mapping[str, str]) -> str:
    """Return the value of a key of `JOINT_LISTS` with joints renamed."""

    def new(word: str) -> str:
        joint, colon, rest = word.partition(":") if key == "joints" else (word, "", "")
        return names.get(joint, joint) + colon + rest

    return ",".join(map(new, text.split(",")))


OF_OBJECTS: dict[str, Callable[[str], Value]] = {
    "name": str,
    "publish": switch,
    "states": topic,
    "command": topic,
    "joints": joints,
    "topic": topic,
    "frame": frame,
    "rate": rate,
    "compressed": switch,
    "range": topic,
    "scan": topic,
    "angle_min_deg": number,
    "angle_max_deg": number,
    "increment_deg": increment,
    "imu": topic,
    "drive": one_of("diff", "mecanum", "ackermann"),
    "left": str,
    "right": str,
    "steer": str,
    "radius": positive,
    "track": positive,
    "cmd": topic,
    "stamped": one_of("auto", "yes", "no"),
    "timeout": timeout,
    "odom": topic,
    "odom_frame": frame,
    "base": frame,
    "parent_frame": frame,
    "namespace": topic,
    "tf": switch,
    "forward": one_of(*AXES),
    "up": one_of(*AXES),
}

OF_SCENE: dict[str, Callable[[str], Value]] = {
    "rate": rate,
    "tf": switch,
    "root": frame,
    "helper": switch,
}
"""Keys of `simx:ros2:world`."""

ROS2_KEYS: dict[str, Callable[[str], Value]] = {**OF_OBJECTS, **OF_SCENE}

_ONLY_OF = {
    "name": "joint",
    "topic": "vision sensor",
    "compressed": "vision sensor",
    "range": "proximity sensor",
}
"""Keys that only one kind of object has."""

_NEEDS: Mapping[str, tuple[str, ...]] = {
    "joints": ("states", "command"),
    "left": ("drive",),
    "right": ("drive",),
    "steer": ("drive",),
    "radius": ("drive",),
    "track": ("drive",),
    "cmd": ("drive",),
    "stamped": ("drive",),
    "timeout": ("drive",),
    "odom_frame": ("drive", "odom"),
    "base": ("drive", "odom"),
    "parent_frame": ("drive", "odom"),
    "tf": ("drive", "odom"),
    "angle_min_deg": ("scan",),
    "angle_max_deg": ("scan",),
    "increment_deg": ("scan",),
    "forward": ("drive", "odom", "scan", "imu"),
    "up": ("drive", "odom", "scan", "imu"),
}
"""Keys that have a meaning only beside one of others."""

JOINT_LISTS = ("left", "right", "steer", "joints")
"""Keys that name joints with commas between them."""

_ANGLES = (("angle_min_deg", -180.0), ("angle_max_deg", 180.0))

_OF_WHEELS = ("left", "right", "radius")
"""Keys without which a drive is not complete."""


def check_keys(note: Annotation, element: str, *, is_scene: bool) -> None:
    """Check that the keys of one annotation belong together.

    Args:
        note: its checked values.
        element: is named in errors.
        is_scene: it is `simx:ros2:world`.

    Raises:
        SceneError: a key has no meaning there, or another one is missing.
    """
    for key in note:
        if is_scene and key not in OF_SCENE:
            raise SceneError(f"text '{element}' has {key}=; valid for the scene are {', '.join(OF_SCENE)}")
        if not is_scene and key not in OF_OBJECTS:
            raise SceneError(f"text '{element}' has {key}=, which is for the scene: simx:ros2:world")
        needed = () if is_scene else _NEEDS.get(key, ())
        if needed and not note.keys() & set(needed):
            raise SceneError(f"text '{element}' has {key}=, which needs {' or '.join(needed)}= beside it")
    if "drive" in note:
        _check_wheels(note, element)
    axes = [str(note.get(key, default)) for key, default in (("forward", "x"), ("up", "z"))]
    if axes[0][-1] == axes[1][-1]:
        raise SceneError(
            f"text '{element}' has forward={axes[0]} and up={axes[1]}, which are not at right angles"
        )
    low, high = (float(note.get(key, default)) for key, default in _ANGLES)
    if not low < high <= low + 360:
        raise SceneError(
            f"text '{element}' has a scan from {low:g} to {high:g} degrees; valid is angle_min_deg below "
            "angle_max_deg, and a circle at most"
        )


def _check_wheels(note: Annotation, element: str) -> None:
    if missing := [key for key in _OF_WHEELS if not note.get(key)]:
        raise SceneError(f"text '{element}' has a drive, which needs {', '.join(missing)}")
    if (note["drive"] == "ackermann") != bool(note.get("steer")):
        raise SceneError(
            f"text '{element}' has drive={note['drive']}; drive=ackermann needs steer= with the joints that turn its "
            "wheels, and no other drive has it"
        )
    counts = [len(str(note[key]).split(",")) for key in ("left", "right")]
    if note["drive"] == "mecanum" and counts != [2, 2]:
        raise SceneError(
            f"text '{element}' has a mecanum drive with {counts[0]} and {counts[1]} wheels; valid are two joints in "
            "left and two in right, with a comma between them"
        )


def check_kind(note: Annotation, element: str, kind: str, kinds_of: Mapping[str, str]) -> None:
    """Check that an object may have these keys, and that joints that they name exist.

    Args:
        note: the checked values.
        element: is named in errors.
        kind: of the object, in words.
        kinds_of: the kinds of all objects by name.

    Raises:
        SceneError: it may not, or a joint is missing.
    """
    for key, wanted in _ONLY_OF.items():
        if key in note and kind != wanted:
            raise SceneError(f"text '{element}' has {key}=, which is for a {wanted}; the object is a {kind}")
    for key in JOINT_LISTS:
        for word in filter(None, str(note.get(key, "")).split(",")):
            name = word.partition(":")[0] if key == "joints" else word
            if kinds_of.get(name) != "joint":
                raise SceneError(f"text '{element}' has {key}={name}, which is no joint of the scene")
