"""Read the image of a vision sensor over the remote API: upright, depth as colours, advice when it is empty."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simx_client import Client
from simx_client.protocol import constants as c
from simx_server.scene.cameras.image import fovy_from_perspective_angle

_DEPTH_STOPS = np.array([(253, 231, 37), (53, 183, 121), (49, 104, 142), (68, 1, 84)], float)
"""Red, green and blue from the nearest to the farthest; lightness falls, so that the order shows in grey as well."""

_NOTHING = (24, 24, 24)
_ENLARGED = 192
"""Pixels of the larger side to which small images are enlarged."""

_FEW_PIXELS = 64
"""Sensors with no more pixels often see only one colour."""


@dataclass(frozen=True)
class Optics:
    """The optics of a vision sensor: pixels and metres."""

    width: int
    height: int
    near: float
    far: float
    across: float
    """The larger side of the image: in radians, for an orthographic one in metres."""

    is_orthographic: bool

    @property
    def fovy(self) -> float:
        """Return the angle in radians from the lower to the upper edge, for a perspective image."""
        return math.radians(fovy_from_perspective_angle(self.across, self.width, self.height))

    def __str__(self) -> str:
        view = (
            f"{self.across:g} m across" if self.is_orthographic else f"angle {math.degrees(self.across):.1f}°"
        )
        return f"{self.width} × {self.height}, {view}, near {self.near:.4g} m, far {self.far:.4g} m"


@dataclass(frozen=True, eq=False)
class Sight:
    """An image, the top row first: (height, width, 3), and metres along the axis, (height, width)."""

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32] | None


def ask_optics(client: Client, handle: int, *, is_orthographic: bool) -> Optics:
    """Return the optics of a vision sensor. Raises RemoteError: the object is not a vision sensor; TimedOut."""
    extent = (
        c.sim_visionfloatparam_ortho_size if is_orthographic else c.sim_visionfloatparam_perspective_angle
    )
    with client.batch() as calls:
        width = calls.simxGetObjectIntParameter(handle, c.sim_visionintparam_resolution_x)
        height = calls.simxGetObjectIntParameter(handle, c.sim_visionintparam_resolution_y)
        near = calls.simxGetObjectFloatParameter(handle, c.sim_visionfloatparam_near_clipping)
        far = calls.simxGetObjectFloatParameter(handle, c.sim_visionfloatparam_far_clipping)
        across = calls.simxGetObjectFloatParameter(handle, extent)
    return Optics(width.value, height.value, near.value, far.value, across.value, is_orthographic)


def ask_sight(client: Client, path: str, *, with_depth: bool) -> Sight:
    """Return the image of a vision sensor. Raises SimxError: it is missing, cannot render, or the server is away."""
    camera = client.camera(path)
    return Sight(camera.rgb(), camera.depth() if with_depth else None)


def enlarged(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a small image with each pixel repeated: browsers show images at their original size."""
    times = _ENLARGED // max(picture.shape[:2])
    return picture if times < 2 else picture.repeat(times, axis=0).repeat(times, axis=1)


def depth_colours(depth: NDArray[np.float32], far: float) -> tuple[NDArray[np.uint8], str]:
    """Return an image of depths in metres, and the meaning of its colours."""
    is_seen = depth < far * (1 - 1e-5)
    picture = np.full((*depth.shape, 3), _NOTHING, np.uint8)
    if not is_seen.any():
        return picture, f"depth: nothing nearer than {far:.4g} m"
    seen = depth[is_seen]
    nearest, farthest = float(seen.min()), float(seen.max())
    place = (seen - nearest) / max(farthest - nearest, 1e-6) * (len(_DEPTH_STOPS) - 1)
    stops = np.arange(len(_DEPTH_STOPS))
    for channel in range(3):
        picture[is_seen, channel] = np.interp(place, stops, _DEPTH_STOPS[:, channel])
    text = f"depth: {nearest:.3f} m (yellow)"
    if farthest - nearest > 5e-4:
        text += f" to {farthest:.3f} m (violet)"
    return picture, text if is_seen.all() else f"{text}; black: nothing nearer than {far:.4g} m"


def advice(name: str, sight: Sight, optics: Optics) -> str:
    """Return advice about an image that shows nothing; empty when it shows something."""
    depth = sight.depth
    if depth is not None and (depth >= optics.far * (1 - 1e-5)).all():
        return (
            f"{name} sees nothing but background: it looks along its +z axis, {optics.near:.3g} to {optics.far:.3g} m. "
            "Move the arm or turn the camera, see docs/cameras.md"
        )
    if depth is not None and (depth <= optics.near * (1 + 1e-5)).all():
        return (
            f"{name} is inside of something, or right before it: nothing is farther than its near clipping plane at "
            f"{optics.near:.3g} m. Move the camera or what is in front of it, see docs/cameras.md"
        )
    pixels = sight.rgb.reshape(-1, 3)
    # Where the depth shows something, one colour is that of a surface, unless it is black.
    is_doubtful = depth is None or not pixels.any()
    if is_doubtful and len(pixels) > _FEW_PIXELS and (pixels == pixels[0]).all():
        colour = ", ".join(map(str, pixels[0]))
        return (
            f"{name} sees one single colour ({colour}): it looks along its +z axis at nothing, at one surface, or "
            "without light. Its depth tells which, see docs/cameras.md"
        )
    return ""
