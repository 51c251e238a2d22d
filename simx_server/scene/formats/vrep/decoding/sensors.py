"""Vision sensors with their filters, proximity sensors with their volumes, cameras, lights."""

from __future__ import annotations

from simx_server.scene.formats.vrep.chunks import Chunks
from simx_server.scene.formats.vrep.objects import (
    Camera,
    Filter,
    Light,
    ProximitySensor,
    VisionSensor,
    Volume,
)

from .colors import material_of
from .context import Reading
from .numbers import color, vector

VOLUMES = ("pyramid", "cylinder", "disc", "cone", "ray")
FIRST_METHOD = 30
METHODS = dict(enumerate(VOLUMES, FIRST_METHOD))
"""Methods of detection by their numbers."""
FINDS_CLOSEST, LIMITS_ANGLE, IGNORES_FRONT, IGNORES_BACK, EXPLICIT_DETECTION = 2, 4, 16, 32, 128
"""Bits of Pr4 of a proximity sensor."""
PERSPECTIVE, EXPLICIT, OF_ENVIRONMENT = 1, 2, 128
"""Bits of Va3 of a vision sensor; the last one: the background has the scene's colour."""
EXTERNAL, NO_RGB, NO_DEPTH, NO_STATISTICS = 1, 2, 4, 16
"""Bits of Va2 of a vision sensor."""
MOST_PIXELS = 16_384
"""Along a side of an image."""
ORTHOGRAPHIC = 3
"""Flags of all orthographic cameras; each of both bits was never met alone."""


def fill_vision_sensor(sensor: VisionSensor, own: Chunks, reading: Reading) -> None:
    """Fill a vision sensor. Raises SceneError."""
    sensor.orthographic_size, sensor.angle, sensor.near, sensor.far = own.reals("Ccp")
    width, height = own.ints("Res")
    if min(width, height) >= 1 and max(width, height) <= MOST_PIXELS:
        sensor.resolution = width, height
    else:
        own.note("Res", f"has the resolution {width} x {height}; {sensor.resolution} is taken")
    if own.has("Si2"):
        (size,) = own.reals("Si2")
        sensor.body = size, size, 2 * size
    else:
        sensor.body = vector(own.reals("Siz", *sensor.body))
    sensor.default_color = color(own.reals("Db2", 0.0, 0.0, 0.0))
    (sensor.render_mode,) = own.ints("Rmd", 0)
    (sensor.entity,) = own.ints("Dox", -1)
    (flags,) = own.ints("Va3", 1)
    sensor.is_perspective, sensor.is_explicit = bool(flags & PERSPECTIVE), bool(flags & EXPLICIT)
    sensor.uses_environment_background = bool(flags & OF_ENVIRONMENT)
    (flags,) = own.ints("Va2", 0)
    sensor.is_external, sensor.ignores_rgb = bool(flags & EXTERNAL), bool(flags & NO_RGB)
    sensor.ignores_depth, sensor.has_no_statistics = bool(flags & NO_DEPTH), bool(flags & NO_STATISTICS)
    chain = own.child("Cfr")
    sensor.filters = None if chain is None else [_filter_of(each) for each in chain.each("Sfr")]


def _filter_of(chunks: Chunks) -> Filter:
    kind, _, _ = chunks.ints("Sft")
    (flags,) = chunks.ints("Sfe", 1)
    return Filter(
        type=kind,
        enabled=bool(flags & 1),
        integers=list(chunks.ints("Pai")[1:]) if chunks.has("Pai") else [],
        reals=list(chunks.reals("Paf")) if chunks.has("Paf") else [],
        data=chunks.raw("Pab")[4:],
    )


def fill_proximity_sensor(sensor: ProximitySensor, own: Chunks, reading: Reading) -> None:
    """Fill a proximity sensor. Raises SceneError."""
    (method,) = own.ints("Snt")
    if method not in METHODS:
        raise own.error("Snt", f"has the type {method}; valid is {', '.join(map(str, METHODS))}")
    sensor.method = METHODS[method]
    volume = own.child("Vod")
    if volume is None:
        raise own.error("Vod", "is missing")
    sensor.volume = volume_of(volume)
    (flags,) = volume.ints("Par", 0)
    (minimum,) = volume.reals("Wtf", 0.0)
    sensor.minimum_distance = minimum if flags & 1 else None
    (flags,) = own.ints("Pr4", FINDS_CLOSEST)
    sensor.finds_closest, sensor.is_explicit = bool(flags & FINDS_CLOSEST), bool(flags & EXPLICIT_DETECTION)
    sensor.front_faces, sensor.back_faces = not flags & IGNORES_FRONT, not flags & IGNORES_BACK
    (angle,) = own.reals("Al2", 0.0)
    sensor.max_normal_angle = angle if flags & LIMITS_ANGLE else None
    (sensor.entity,) = own.ints("Sox", -1)
    (sensor.detectable_kind,) = own.ints("Sst", 0)
    rays, needed = own.ints("Rad", 1, 1)
    sensor.rays = rays, needed
    (sensor.size,) = own.reals("Sns", sensor.size)


def volume_of(chunks: Chunks) -> Volume:
    """Return the volume in a list."""
    (kind,) = chunks.ints("Snt")
    if not 0 <= kind < len(VOLUMES):
        raise chunks.error("Snt", f"has the type {kind}; valid is 0 to {len(VOLUMES) - 1}")
    values = chunks.reals("Ss3")
    offset, length, x, y, x_far, y_far, radius, radius_far, angle = values
    (gap,) = chunks.reals("Sia", 0.0)
    faces = chunks.ints("Ssi", 0, 0)
    return Volume(
        type=VOLUMES[kind],
        offset=offset,
        range=length,
        x_size=x,
        y_size=y,
        x_size_far=x_far,
        y_size_far=y_far,
        radius=radius,
        radius_far=radius_far,
        angle=angle,
        inside_gap=gap,
        faces=(faces[0], faces[1]),
    )


def fill_camera(camera: Camera, own: Chunks, reading: Reading) -> None:
    """Fill a camera."""
    camera.orthographic_size, camera.angle = own.reals("Cp3", camera.orthographic_size, camera.angle)
    camera.near, camera.far = own.reals("Ccp", camera.near, camera.far)
    (camera.tracked,) = own.ints("Cp4", -1)
    (camera.size,) = own.reals("Cp4", camera.size)
    if own.has("Cpm"):
        (perspective,) = own.ints("Cpm")  # -1: as the view wants
        camera.is_perspective = perspective == 1
    else:
        (flags,) = own.ints("Ca2", 0)
        camera.is_perspective = flags & ORTHOGRAPHIC != ORTHOGRAPHIC


def fill_light(light: Light, own: Chunks, reading: Reading) -> None:
    """Fill a light."""
    light.type, light.exponent = own.ints("Cp2", light.type, light.exponent)
    (light.size,) = own.reals("Cp2", light.size)
    (light.cutoff,) = own.reals("Cp3", light.cutoff)
    light.attenuation = vector(own.reals("Caf", *light.attenuation))
    (flags,) = own.ints("Cas", 1)
    light.is_on = bool(flags & 1)
    light.color = material_of(own.child("Cl2"))
