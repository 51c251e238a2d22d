"""The settings of a vision sensor's image, and the results of its last handling."""

from __future__ import annotations

import math
from concurrent.futures import Future
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.objects import SceneObject

from .image import MAX_SIDE, Picture, perspective_angle_from_fovy

DEFAULT_SIDE = 256
"""Default pixels per side of a camera without a resolution; V-REP's own new sensors have 32."""


@dataclass(frozen=True)
class Verdict:
    """The result of a script's vision call-back."""

    detects: bool | None
    """None: the script did not decide."""
    packets: tuple[list[float], ...] = ()
    """Auxiliary values; they follow the statistics."""


@dataclass
class VisionSettings:
    """The properties of a vision sensor, as in V-REP."""

    width: int
    height: int
    near: float
    far: float
    angle: float
    """Perspective angle across the larger image side, radians."""
    orthographic_size: float | None
    """Metres across the larger image side; None for perspective."""
    is_depth_camera: bool
    """The image is the depth in grey (MJCF output="depth"), unless it shows handles."""
    explicit: bool
    shows_handles: bool = False
    """V-REP's render mode 2: each pixel is the handle of the visible object, red + 256 green + 65536 blue."""
    external: bool = False
    """Nothing is rendered: the image is the one that was set last."""
    detect_above: float | None = None
    detect_below: float | None = None
    """The image's mean intensity, 0..1, above and below which the sensor detects; None, None: it detects nothing."""
    picture: Future[Picture] | None = None
    """An image that was handled explicitly, or rendered for a script; None: the scene is rendered."""
    drawn: NDArray[np.uint8] | None = None
    """(height, width, 3): an image that was set and replaces the rendered one; the depth stays the rendered one."""
    filtered: NDArray[np.uint8] | None = None
    """(height, width, 3): a script's version of the image; clients receive it, the statistics ignore it."""
    verdict: Verdict | None = None
    """A script's findings in the image."""
    picture_pass: int = -1
    """The last simulation step in which these values count, unless the sensor is handled explicitly."""

    @property
    def shows_depth(self) -> bool:
        """Return whether the image is the depth in grey."""
        return self.is_depth_camera and not self.shows_handles

    @property
    def most_bytes(self) -> int:
        """Return the bytes of an image with both channels: three bytes and a float per pixel."""
        return self.width * self.height * 7

    @property
    def kept_bytes(self) -> int:
        """Return the bytes of the images that it keeps."""
        images = sum(image.nbytes for image in (self.drawn, self.filtered) if image is not None)
        return images + (self.most_bytes if self.picture is not None else 0)

    def forget(self) -> None:
        """Drop the image, and what was set or found."""
        self.picture = self.drawn = self.filtered = self.verdict = None


def settings_from_model(item: SceneObject, model: mujoco.MjModel) -> VisionSettings:
    """Return settings from the annotation first, then the camera's attributes, then the model's clip planes."""
    note: Annotation = item.annotations.get("vision", {})
    width, height = (int(side) for side in model.cam_resolution[item.id])
    if width * height <= 1:
        width = height = DEFAULT_SIDE
    width, height = min(width, MAX_SIDE), min(height, MAX_SIDE)
    fovy = float(model.cam_fovy[item.id])
    orthographic = model.cam_projection[item.id] == mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC
    if "angle_deg" in note:
        angle = math.radians(float(note["angle_deg"]))
    else:
        angle = perspective_angle_from_fovy(60.0 if orthographic else fovy, width, height)
    output = int(model.cam_output[item.id])
    wants_depth = bool(output & int(mujoco.mjtCamOutBit.mjCAMOUT_DEPTH))
    wants_rgb = bool(output & int(mujoco.mjtCamOutBit.mjCAMOUT_RGB))
    extent = float(model.stat.extent)
    return VisionSettings(
        width=width,
        height=height,
        near=float(note["near"]) if "near" in note else float(model.vis.map.znear) * extent,
        far=float(note["far"]) if "far" in note else float(model.vis.map.zfar) * extent,
        angle=angle,
        orthographic_size=fovy * max(1.0, width / height) if orthographic else None,
        is_depth_camera=wants_depth and not wants_rgb,
        explicit=bool(note.get("explicit", False)),
        shows_handles=note.get("render") == "handles",
        external=bool(note.get("external", False)),
        detect_above=_limit(note, "detect_above"),
        detect_below=_limit(note, "detect_below"),
    )


def _limit(note: Annotation, key: str) -> float | None:
    return float(note[key]) if key in note else None
