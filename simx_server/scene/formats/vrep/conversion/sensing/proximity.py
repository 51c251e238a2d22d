"""Proximity sensors: a site, and its volume in an annotation."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.numbers import within
from simx_server.scene.formats.vrep.objects import ProximitySensor, Volume
from simx_server.scene.poses.poses import Pose

from .entities import entity_name

SENSOR_GROUP = 4
"""Group of the sites of sensors; cameras see none."""

_LEAST = 1e-6
"""Metres: least length of a volume; V-REP allows 0, where nothing can be detected."""
_FARTHEST = 1e4

_KINDS = {0x10: "ultrasonic", 0x20: "infrared", 0x40: "laser", 0x80: "inductive", 0x100: "capacitive"}

_FACES = {(True, True): "both", (True, False): "front", (False, True): "back", (False, False): "none"}


def add_proximity(conversion: Conversion, sensor: ProximitySensor, body: mujoco.MjsBody, at: Pose) -> None:
    """Add a proximity sensor.

    Args:
        conversion: the conversion.
        sensor: the sensor.
        body: the body on which it rides.
        at: its frame in that body.
    """
    name = conversion.name(sensor)
    body.add_site(name=name, pos=at[0], quat=at[1], group=SENSOR_GROUP, size=[_size(sensor)] * 3)
    volume = sensor.volume
    kind = volume.type
    if kind not in _SIZES:
        conversion.report.approximate("proximity sensors have an unknown volume; they are rays", name)
        kind = "ray"
    sizes = _SIZES[kind](volume)
    if sensor.method == "ray" and kind == "cone":
        kind = "random_rays"
        rays, needed = sensor.rays
        sizes |= {"rays": int(within(rays, 1, 10_000, 1)), "rays_needed": int(within(needed, 1, 10_000, 1))}
    elif sensor.method not in (kind, volume.type):
        conversion.report.approximate(
            "proximity sensors detect by another method than their volume's; the volume counts", name
        )
    minimum, steepest = sensor.minimum_distance, sensor.max_normal_angle
    conversion.annotate(
        "proximity",
        name,
        type=kind,
        offset=within(volume.offset, -_FARTHEST, _FARTHEST, 0.0),
        range=_length(volume.range),
        **sizes,
        explicit=True if sensor.is_explicit else None,
        faces=_faces(sensor),
        max_normal_deg=None if steepest is None else _degrees(steepest, 90.0),
        min_distance=None if minimum is None else within(minimum, 0.0, _FARTHEST, 0.0),
        entity=entity_name(conversion, sensor, sensor.entity),
        detects=_KINDS.get(sensor.detectable_kind),
        carrier=True,
    )


def _size(sensor: ProximitySensor) -> float:
    return within(sensor.size, 1e-4, 1.0, 0.01) / 2


def _faces(sensor: ProximitySensor) -> str | None:
    faces = _FACES[sensor.front_faces, sensor.back_faces]
    return None if faces == "both" else faces


def _length(value: float) -> float:
    return within(value, _LEAST, _FARTHEST, _LEAST)


def _degrees(angle: float, default: float) -> float:
    return within(round(math.degrees(angle), 5), 1e-3, 360.0, default)


def _cone(volume: Volume) -> dict[str, float]:
    gap = within(volume.inside_gap, 0.0, 0.999, 0.0)
    return {
        "angle_deg": _degrees(volume.angle, 1e-3),
        **({"radius": _length(volume.radius)} if volume.radius > 0.0 else {}),
        **({"inside_gap": gap} if gap else {}),
    }


def _cylinder(volume: Volume) -> dict[str, float]:
    return {
        "radius": _length(volume.radius),
        "radius_far": _length(volume.radius_far),
    }


def _pyramid(volume: Volume) -> dict[str, float]:
    return {
        "size_x": _length(volume.x_size),
        "size_y": _length(volume.y_size),
        "size_x_far": _length(volume.x_size_far),
        "size_y_far": _length(volume.y_size_far),
    }


def _ray(_volume: Volume) -> dict[str, float]:
    return {}


def _disc(volume: Volume) -> dict[str, float]:
    return {**_cone(volume), "height": _length(volume.y_size)}


_SIZES: dict[str, Callable[[Volume], dict[str, float]]] = {
    "ray": _ray,
    "cone": _cone,
    "disc": _disc,
    "cylinder": _cylinder,
    "pyramid": _pyramid,
}
"""Sizes by type of volume; the fields that a type does not use hold anything."""
