"""The optics of a proximity sensor, independent of its pose: its volume, and which surfaces it sees."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.geometry.poses import Vector

from . import volume as volumes
from .volume import Volume


@dataclass(frozen=True)
class Optics:
    """The optics of a sensor, independent of its pose."""

    kind: str
    offset: float
    """Metres along z before the volume starts."""
    reach: float
    """Length of the volume, metres."""
    volume: Volume
    faces: str = "both"
    """Which sides of surfaces are seen: both, front or back."""
    least_cosine: float = 0.0
    """Minimum cosine of the angle between line of sight and normal; surfaces at a flatter angle are not detected."""
    least_distance: float = 0.0
    """Metres: something nearer blinds the sensor, which then detects nothing."""

    def accepts(self, point: Vector, normal: Vector) -> bool:
        """Return whether the sensor sees this side and angle of a surface, both vectors in its frame."""
        along = sum(a * b for a, b in zip(point, normal, strict=True))
        if self.faces != "both" and (along < 0) != (self.faces == "front"):
            return False
        return abs(along) >= self.least_cosine * math.dist(point, (0.0, 0.0, 0.0))


def optics(note: Annotation, default_reach: float) -> Optics:
    """Return the optics of a checked `simx:proximity` annotation."""
    kind = str(note.get("type", "ray"))
    offset, reach = _number(note, "offset"), _number(note, "range", default_reach)
    angle, radius, gap = (
        math.radians(_number(note, "angle_deg")),
        _number(note, "radius"),
        _number(note, "inside_gap"),
    )
    match kind:
        case "cone":
            volume = volumes.cone(angle, reach, offset, radius, gap)
        case "disc":
            volume = volumes.disc(angle, reach, _number(note, "height"), offset, radius, gap)
        case "cylinder":
            volume = volumes.cylinder(radius, reach, offset, _number(note, "radius_far", radius))
        case "pyramid":
            size = _number(note, "size_x"), _number(note, "size_y")
            far = _number(note, "size_x_far", size[0]), _number(note, "size_y_far", size[1])
            volume = volumes.pyramid(size, reach, offset, far)
        case _:
            volume = volumes.ray(reach, offset)
    steepest = _number(note, "max_normal_deg", 90.0)
    return Optics(
        kind, offset, reach, volume,
        faces=str(note.get("faces", "both")),
        least_cosine=math.cos(math.radians(steepest)) if steepest < 90.0 else 0.0,
        least_distance=_number(note, "min_distance"),
    )  # fmt: skip


def _number(note: Annotation, key: str, default: float = 0.0) -> float:
    return float(note.get(key, default))
