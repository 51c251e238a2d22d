"""Cameras of the user interface, and what they share with vision sensors: the frame and the opening angle."""

from __future__ import annotations

import math

import mujoco

from simx_server.scene.cameras.image import fovy_from_perspective_angle
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.numbers import within
from simx_server.scene.formats.vrep.objects import Camera, VisionSensor
from simx_server.scene.poses.poses import Pose, Quaternion, multiply

VIEW = (640, 480)
"""Pixels of a view, which V-REP takes from its window."""

_HALF_TURN_ABOUT_Y: Quaternion = (0.0, 0.0, 1.0, 0.0)
"""V-REP's sensors look along z with x to the left, MuJoCo's cameras along -z with x to the right."""

_NEAREST, _FARTHEST = 1e-5, 1e6

_HIGHEST = 179.0
"""Metres: greatest height of an orthographic image, which MuJoCo limits as if it were an angle."""


def add_camera(conversion: Conversion, camera: Camera, body: mujoco.MjsBody, at: Pose) -> None:
    """Add a camera of the user interface.

    Args:
        conversion: the conversion.
        camera: the camera.
        body: the body on which it rides.
        at: its frame in that body.
    """
    name = conversion.name(camera)
    place_camera(body, name, camera, at, VIEW)
    near, far = clip_planes(camera.near, camera.far)
    conversion.annotate("camera", name, view=True)
    conversion.annotate(
        "vision",
        name,
        near=near,
        far=far,
        angle_deg=None if camera.is_perspective else round(math.degrees(perspective_angle(camera)), 5),
        size=view_size(camera) if camera.is_perspective else None,
    )
    if camera.tracked in conversion.names:
        conversion.report.leave_out("cameras of the user interface do not track an object", name)


def place_camera(
    body: mujoco.MjsBody, name: str, camera: Camera | VisionSensor, at: Pose, resolution: tuple[int, int]
) -> mujoco.MjsCamera:
    """Add and return MuJoCo's camera for a camera or sensor of V-REP, whose frame in the body is `at`."""
    width, height = resolution
    element = body.add_camera(
        name=name, pos=at[0], quat=multiply(at[1], _HALF_TURN_ABOUT_Y), resolution=[width, height]
    )
    if camera.is_perspective:
        element.fovy = fovy_from_perspective_angle(perspective_angle(camera), width, height)
    else:
        element.proj = mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC
        element.fovy = min(view_size(camera) * min(1.0, height / width), _HIGHEST)
    return element


def perspective_angle(camera: Camera | VisionSensor) -> float:
    """Return the opening angle across the larger side, radians, within what an image can have."""
    return within(camera.angle, math.radians(0.01), math.radians(179.0), math.radians(60.0))


def view_size(camera: Camera | VisionSensor) -> float:
    """Return the metres across the larger side of an orthographic view."""
    return within(camera.orthographic_size, _NEAREST, _FARTHEST, 1.0)


def clip_planes(near: float, far: float) -> tuple[float, float]:
    """Return near and far plane in metres, near before far."""
    nearest = within(near, _NEAREST, _FARTHEST, 0.01)
    return nearest, within(far, nearest * 1.0001, 2 * _FARTHEST, max(10.0, 2 * nearest))
