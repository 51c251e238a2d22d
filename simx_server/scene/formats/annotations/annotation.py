"""The annotations of a scene as checked values, and the error of a wrong one."""

from __future__ import annotations

from dataclasses import field

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

PREFIX = "simx:"

Value = float | bool | str
Annotation = dict[str, Value]


class SceneError(CommandError):
    """A scene file that cannot be loaded; the text names the element and the valid values."""


@dataclass
class Annotations:
    """All annotations of a scene: per object name, per kind, checked values; and those of the scene itself."""

    objects: dict[str, dict[str, Annotation]] = field(default_factory=dict[str, dict[str, Annotation]])
    registered: dict[str, dict[str, Annotation]] = field(default_factory=dict[str, dict[str, Annotation]])
    """Registered entries by kind of REGISTERED and name; these names are not names of objects."""
    main_script: Annotation | None = None
    data: Annotation = field(default_factory=dict[str, Value])
    """Custom data of the scene itself: bytes in base64 by name."""
    scene: Annotation = field(default_factory=dict[str, Value])
    """Settings of the whole scene."""
    ros2: Annotation = field(default_factory=dict[str, Value])
    """Those that concern ROS 2."""
    time_step: float | None = None


def numbers_of(value: Value) -> tuple[float, ...]:
    """Return the numbers of a checked value that has several."""
    return tuple(float(word) for word in str(value).split(","))
