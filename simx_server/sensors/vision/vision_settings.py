"""The settings of a vision sensor's image, and the results of its last handling."""

from __future__ import annotations

import math
from concurrent.futures import Future
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.cameras.image import (
    MAX_SIDE,
    CameraImage,
    fovy_from_perspective_angle,
    perspective_angle_from_fovy,
)
from simx_server.scene.collection import ALL
from simx_server.scene.formats.annotations import Annotation, numbers_of
from simx_server.scene.formats.texts.filter_chains import read_chain
from simx_server.scene.formats.texts.render_modes import HANDLES, MODE_OF
from simx_server.scene.objects import ObjectKind, SceneObject

from .filters.work import View, Work

if TYPE_CHECKING:
    from .filters.chain import Chain, Processed

DEFAULT_SIDE = 256
"""Default pixels per side of a camera without a resolution; V-REP's own new sensors have 32."""

DEFAULT_SIZES = {ObjectKind.VISION_SENSOR: 0.01, ObjectKind.CAMERA: 2.0}
"""Metres across an orthographic view of a perspective camera without a size, as in V-REP."""


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
    size: float
    """Metres across the larger image side of an orthographic view."""
    is_perspective: bool
    """Whether `angle` counts; if not, `size` does."""
    is_depth_camera: bool
    """The image is the depth in grey (MJCF output="depth"), unless it shows handles."""
    explicit: bool
    render_mode: int = 0
    """One of `RENDER_MODES`. In mode 2 each pixel is the handle of the visible object, red + 256 green + 65536 blue;
    all others draw colours.
    """
    unlit: int = 0
    """Components of lights that are left out, see `CameraView.unlit`."""
    external: bool = False
    """Nothing is rendered: the image is the one that was set last."""
    background: tuple[float, float, float] | None = None
    """RGB 0..1 where nothing is seen; None: the scene's."""
    has_rgb: bool = True
    """Without colours, the image is black: V-REP's sensors that ignore them."""
    has_depth: bool = True
    """Without depth, nothing is nearer than the far plane."""
    has_statistics: bool = True
    """Without statistics, the first packet of numbers is empty."""
    entity: int = ALL
    """The object or collection that alone is rendered."""
    chain: Chain | None = None
    """Filters that each image passes; None: the image stays as it is."""
    detect_above: float | None = None
    detect_below: float | None = None
    """The image's mean intensity, 0..1, above and below which the sensor detects; None, None: it detects nothing."""
    image: Future[CameraImage] | None = None
    """An image that was handled explicitly, or rendered for a script; None: the scene is rendered."""
    drawn: NDArray[np.uint8] | None = None
    """(height, width, 3): an image that was set and replaces the rendered one; the depth stays the rendered one."""
    filtered: NDArray[np.uint8] | None = None
    """(height, width, 3): a script's version of the image; clients receive it, the statistics ignore it."""
    filtered_depth: NDArray[np.float32] | None = None
    """(height, width), 0..1: a script's version of the depth; clients receive it, the statistics ignore it."""
    verdict: Verdict | None = None
    """A script's findings in the image."""
    processed: Future[Processed] | None = None
    """The kept or the set image after the chain."""
    work: Work | None = None
    """Images of a chain that remembers; None: black."""
    image_step: int = -1
    """The last simulation step in which these values count, unless the sensor is handled explicitly."""

    @property
    def orthographic_size(self) -> float | None:
        """Return the size in metres; None for a perspective view."""
        return None if self.is_perspective else self.size

    @property
    def shows_handles(self) -> bool:
        """Return whether pixels are handles."""
        return self.render_mode == HANDLES

    @property
    def shows_depth(self) -> bool:
        """Return whether the image is the depth in grey."""
        return self.is_depth_camera and not self.shows_handles

    @property
    def may_detect(self) -> bool:
        """Return whether limits, a filter or a script may make the sensor detect something."""
        has_limits = self.detect_above is not None or self.detect_below is not None
        return has_limits or self.verdict is not None or (self.chain is not None and self.chain.may_detect)

    @property
    def needs_statistics(self) -> bool:
        """Return whether the numbers of an image are needed."""
        return self.has_statistics or self.detect_above is not None or self.detect_below is not None

    @property
    def view(self) -> View:
        """Return the part of the world that the image shows."""
        width, height = self.width, self.height
        clip, size = (self.near, self.far), self.orthographic_size
        if size is not None:
            per_pixel = size / max(width, height)
            return View(clip, (width * per_pixel / 2, height * per_pixel / 2), is_perspective=False)
        up = math.tan(math.radians(fovy_from_perspective_angle(self.angle, width, height)) / 2)
        return View(clip, (up * width / height, up), is_perspective=True)

    @property
    def most_bytes(self) -> int:
        """Return the bytes of an image with both channels: three bytes and a float per pixel.

        The three images of a chain have three doubles per pixel.
        """
        return self.width * self.height * (7 if self.chain is None else 7 + 3 * 24)

    @property
    def kept_bytes(self) -> int:
        """Return the bytes of the images that it keeps."""
        given = (self.drawn, self.filtered, self.filtered_depth)
        images = sum(image.nbytes for image in given if image is not None)
        return images + (self.most_bytes if self.image is not None else 0)

    def forget(self) -> None:
        """Drop the image, and what was set or found."""
        self.image = self.drawn = self.filtered = self.filtered_depth = self.verdict = self.processed = None


def settings_from_model(item: SceneObject, model: mujoco.MjModel) -> VisionSettings:
    """Return settings from the annotation first, then the camera's attributes, then the model's clip planes."""
    note: Annotation = item.annotations.get("vision", {})
    width, height = (int(side) for side in model.cam_resolution[item.id])
    if width * height <= 1 and not note.get("single_pixel", False):
        width = height = DEFAULT_SIDE
    width, height = min(width, MAX_SIDE), min(height, MAX_SIDE)
    fovy = float(model.cam_fovy[item.id])
    orthographic = model.cam_projection[item.id] == mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC.value
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
        size=_size(item, note, fovy * max(1.0, width / height) if orthographic else None),
        is_perspective=not orthographic,
        is_depth_camera=wants_depth and not wants_rgb,
        explicit=bool(note.get("explicit", False)),
        render_mode=MODE_OF[str(note.get("render", "colours"))],
        external=bool(note.get("external", False)),
        background=_colour(note),
        has_rgb=bool(note.get("rgb", True)),
        has_depth=bool(note.get("depth", True)),
        has_statistics=bool(note.get("statistics", True)),
        chain=_chain(note),
        detect_above=_limit(note, "detect_above"),
        detect_below=_limit(note, "detect_below"),
    )


def _size(item: SceneObject, note: Annotation, of_camera: float | None) -> float:
    """Return the size of an orthographic view: that of the camera, of the note, or V-REP's default."""
    if of_camera is not None:
        return of_camera
    return float(note["size"]) if "size" in note else DEFAULT_SIZES[item.kind]


def _chain(note: Annotation) -> Chain | None:
    if "filters" not in note:
        return None
    from .filters.chain import Chain  # with it OpenCV, and few sensors have filters

    return Chain(read_chain(str(note["filters"])))


def _colour(note: Annotation) -> tuple[float, float, float] | None:
    if "background" not in note:
        return None
    red, green, blue = numbers_of(note["background"])
    return red, green, blue


def _limit(note: Annotation, key: str) -> float | None:
    return float(note[key]) if key in note else None
