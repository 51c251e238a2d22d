"""Vision sensors: a camera, and in an annotation what MJCF cannot say."""

from __future__ import annotations

import math

import mujoco

from simx_server.scene.cameras.image import MAX_SIDE
from simx_server.scene.formats.texts.render_modes import RENDER_MODES
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.numbers import colour, is_same, within
from simx_server.scene.formats.vrep.objects import VisionSensor
from simx_server.scene.poses.poses import Pose

from .cameras import (
    clip_planes,
    perspective_angle,
    place_camera,
    view_size,
)
from .entities import entity_name
from .filters import chain_text, is_plain, shows_depth

_COLOURS, _AUXILIARY = 0, 1
"""Render modes."""


def add_vision(conversion: Conversion, sensor: VisionSensor, body: mujoco.MjsBody, at: Pose) -> None:
    """Add a vision sensor.

    Args:
        conversion: the conversion.
        sensor: the sensor.
        body: the body on which it rides.
        at: its frame in that body.
    """
    name = conversion.name(sensor)
    width, height = (int(within(side, 1, MAX_SIDE, 1)) for side in sensor.resolution)
    if (width, height) != sensor.resolution:
        conversion.report.approximate(
            f"vision sensors have an impossible resolution; it is cut to 1 to {MAX_SIDE} pixels a side", name
        )
    camera = place_camera(body, name, sensor, at, (width, height))
    if shows_depth(sensor):
        camera.output = int(mujoco.mjtCamOutBit.mjCAMOUT_DEPTH)
    near, far = clip_planes(sensor.near, sensor.far)
    if sensor.render_mode == _AUXILIARY:
        conversion.report.approximate("vision sensors show auxiliary channels; they show colours", name)
    conversion.annotate(
        "vision",
        name,
        near=near,
        far=far,
        angle_deg=round(math.degrees(perspective_angle(sensor)), 5),
        size=view_size(sensor) if sensor.is_perspective else None,
        body=_body(sensor),
        explicit=True if sensor.is_explicit else None,
        external=True if sensor.is_external else None,
        render=RENDER_MODES.get(sensor.render_mode) if sensor.render_mode != _COLOURS else None,
        background=_background(conversion, sensor),
        rgb=False if sensor.ignores_rgb else None,
        depth=False if sensor.ignores_depth else None,
        statistics=False if sensor.has_no_statistics else None,
        entity=entity_name(conversion, sensor, sensor.entity),
        filters=None if is_plain(sensor) or shows_depth(sensor) else chain_text(conversion, sensor),
        single_pixel=True if (width, height) == (1, 1) else None,
    )


def _body(sensor: VisionSensor) -> str | None:
    """Return the sizes of the body that is drawn; None for those of a new sensor."""
    sides = [within(side, 0.0, 1e3, 0.01) for side in sensor.body]
    is_usual = all(map(is_same, sides, VisionSensor.body))
    return None if is_usual else ",".join(f"{side:.7g}" for side in sides)


def _background(conversion: Conversion, sensor: VisionSensor) -> str | None:
    """Return the sensor's own background, or that of the environment; None for black."""
    is_shared = sensor.uses_environment_background
    parts = colour(conversion.file.settings.fog if is_shared else sensor.default_color)
    return ",".join(f"{part:.6g}" for part in parts) if any(parts) or not is_shared else None
