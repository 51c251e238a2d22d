"""The optics of a proximity sensor, independent of its pose: its volume, and which surfaces it sees."""

from __future__ import annotations

import math

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.poses.poses import Vector

from . import volume as volumes
from .volume import Volume

_GREATEST = 1e9
"""Greatest length of a volume in metres: its square and those of directions stay finite and exact enough."""


@dataclass(frozen=True)
class Throw:
    """Rays in random directions within a cone."""

    rays: int
    """Number of rays of a reading."""
    needed: int
    """Number of rays that must meet something, for the sensor to detect."""
    least_angle: float
    greatest_angle: float
    """Angles to z between which the rays lie, radians."""
    blind: float
    """Distance from the apex at which the rays start, metres."""


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
    """Which sides of surfaces are seen: both, front, back or none."""
    least_cosine: float = 0.0
    """Minimum cosine of the angle between line of sight and normal; surfaces at a flatter angle are not detected."""
    least_distance: float = 0.0
    """Metres: something nearer blinds the sensor, which then detects nothing."""
    detects: str | None = None
    """Kind of sensor, `DETECTABLE_KINDS`: shapes that are detectable to other kinds only are not seen."""
    throw: Throw | None = None
    """Of random rays in the volume, a cone; None: the whole volume is searched."""

    @property
    def detects_points(self) -> bool:
        """Return whether the sensor searches its volume, and so detects points too."""
        return self.kind != "ray" and self.throw is None

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
    throw: Throw | None = None
    match kind:
        case "cone":
            volume = volumes.cone(angle, reach, offset, radius, gap)
        case "random_rays":
            volume = volumes.cone(angle, reach, offset, radius, gap)
            half = volumes.half_angle(angle)
            rays, needed = int(_number(note, "rays", 1.0)), int(_number(note, "rays_needed", 1.0))
            throw = Throw(rays, needed, half * gap, half, radius)
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
        detects=str(note["detects"]) if "detects" in note else None,
        throw=throw,
    )  # fmt: skip


def _number(note: Annotation, key: str, default: float = 0.0) -> float:
    value = float(note.get(key, default))
    if abs(value) > _GREATEST:
        raise CommandError(f"{key} of a proximity sensor is {value:g}; at most {_GREATEST:g} is possible")
    return value
