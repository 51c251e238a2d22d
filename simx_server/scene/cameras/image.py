"""The definition of a camera image: its view, its pixels, and the rules of every renderer.

Rules, the same for OpenGL and for ray casting:

* rows come bottom first, each row left to right (the order of V-REP's image and depth buffers);
* a surface is seen between the near and the far plane only, both measured along the view axis; beyond the far
  plane RGB is the background and depth is 1, as in V-REP;
* depth has V-REP's polygon offset, `DEPTH_OFFSET`: a tilted surface is a little farther away than it is;
* only geoms of `visibility.VISIBLE_GROUPS` are seen, and only their front faces; users see those of `USERS_GROUP` too;
* geoms less opaque than `visibility.OPAQUE_ALPHA` tint the colour of what is behind them and have a depth, as in V-REP;
* an image of codes instead of colours has one code per pixel, exactly, and see-through geoms are solid in it.
"""

import math
from collections.abc import Callable, Hashable
from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import RenderError as RenderError

MAX_SIDE = 4096
"""Maximum image side in pixels: 4096 x 4096 is 50 MB of RGB; a mistyped size must not exhaust the memory."""

DEPTH_OFFSET = 0.5
"""Factor of V-REP's polygon offset: how much of the slope of a surface is added to its depth.

The slope is the greater change of OpenGL's depth, 0 near to 1 far, from one pixel to the next across or up.
"""

NO_CODE = 0xFFFFFF
"""White: the code of pixels without an object, and the background in V-REP's images of handles."""


@dataclass(frozen=True)
class Viewpoint:
    """The position of an eye that is not a camera of the model, in the terms of MuJoCo's free camera. Hashable."""

    lookat: tuple[float, float, float]
    """World position of the middle of the image, metres."""
    distance: float
    """Distance from there to the eye, metres."""
    azimuth_deg: float
    """Viewing direction about the world's z: 90 is along y."""
    elevation_deg: float
    """-90 looks straight down."""

    def pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return position (3,) and matrix (3, 3) as a MuJoCo camera has them: columns right, up, backward."""
        azimuth, elevation = math.radians(self.azimuth_deg), math.radians(self.elevation_deg)
        flat = np.array((math.cos(azimuth), math.sin(azimuth), 0.0))
        upwards = np.array((0.0, 0.0, 1.0))
        forward = math.cos(elevation) * flat + math.sin(elevation) * upwards
        up = math.cos(elevation) * upwards - math.sin(elevation) * flat
        position = np.array(self.lookat) - self.distance * forward
        return position, np.stack((np.cross(forward, up), up, -forward), axis=1)


@dataclass(frozen=True)
class CameraView:
    """Everything that defines an image, apart from the state of the world. Hashable.

    `camera_id` is a MuJoCo camera (looks along -z, +y up, +x right); its own field of view, resolution and clip
    planes are not used. It counts only without a `viewpoint`.

    Raises:
        ValueError: a size, angle or clip plane that a camera cannot have.
    """

    camera_id: int
    width: int
    """Width in pixels."""
    height: int
    """Height in pixels."""
    fovy_deg: float
    """Full vertical opening angle, degrees. Not used by an orthographic view."""
    near: float
    """Near plane, metres along the view axis."""
    far: float
    """Far plane, metres along the view axis."""
    background: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Background RGB, each 0..1."""
    orthographic_size: float | None = None
    """Metres across the larger image side; None for a perspective view."""
    codes: tuple[int, ...] | None = None
    """For each geom of the model the number, 1 to NO_CODE, that its pixels show instead of a colour.

    red + 256 green + 65536 blue. Skins and flexes show NO_CODE. None: colours.
    """
    only: frozenset[int] | None = None
    """Ids of the only geoms that are seen; None: all."""
    viewpoint: Viewpoint | None = None
    """For a view of the scene that differs from all its cameras."""
    unlit: int = 0
    """Bits of the components of all lights that are left out: 1 ambient, 2 diffuse, 4 highlights."""
    is_users: bool = False
    """Whether it is a user's view, which shows shapes that vision sensors do not see."""

    def __post_init__(self) -> None:
        if not (1 <= self.width <= MAX_SIDE and 1 <= self.height <= MAX_SIDE):
            raise ValueError(
                f"a picture of {self.width} x {self.height} pixels cannot be made; "
                f"give each side between 1 and {MAX_SIDE}"
            )
        if not 0.0 < self.near < self.far < math.inf:
            raise ValueError(
                f"clip planes near={self.near} far={self.far} are not usable; give 0 < near < far, in metres"
            )
        if self.orthographic_size is None and not 0.0 < self.fovy_deg < 180.0:
            raise ValueError(
                f"a vertical angle of {self.fovy_deg} degrees is not between 0 and 180 (exclusive)"
            )
        if self.orthographic_size is not None and not 0.0 < self.orthographic_size < math.inf:
            raise ValueError(
                f"an orthographic size of {self.orthographic_size} is not usable; give metres above 0"
            )

    def check_camera(self, model: mujoco.MjModel) -> None:
        """Check that the model has the camera.

        Raises:
            RenderError: it does not.
        """
        if self.viewpoint is None and not 0 <= self.camera_id < model.ncam:
            raise RenderError(f"camera id {self.camera_id} is not in the model, which has {model.ncam}")

    def pose(self, data: mujoco.MjData) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return world position (3,) and matrix (3, 3) of the eye: columns right, up, backward."""
        if self.viewpoint is not None:
            return self.viewpoint.pose()
        return data.cam_xpos[self.camera_id], data.cam_xmat[self.camera_id].reshape(3, 3)

    @property
    def place(self) -> Hashable:
        """Return what all views have in common that show the same geoms in the same pixels, whatever their colours."""
        shape = self.width, self.height, self.fovy_deg, self.near, self.far, self.orthographic_size
        return self.camera_id, self.viewpoint, shape, self.only, self.is_users

    def half_extent(self) -> tuple[float, float]:
        """Return half width and half height of the visible area, metres: at 1 m depth, or anywhere if orthographic."""
        if self.orthographic_size is not None:
            per_pixel = self.orthographic_size / max(self.width, self.height)
            return 0.5 * per_pixel * self.width, 0.5 * per_pixel * self.height
        half_height = math.tan(math.radians(self.fovy_deg) / 2)
        return half_height * self.width / self.height, half_height

    def background_bytes(self) -> tuple[int, int, int]:
        """Return the background as three bytes."""
        red, green, blue = (round(255 * min(max(channel, 0.0), 1.0)) for channel in self.background)
        return red, green, blue


@dataclass(frozen=True, eq=False)
class CameraImage:
    """Pixels of one view at one instant, read-only because several callers may share them.

    `rgb`: (height, width, 3) uint8, C-contiguous. `depth`: (height, width) float32, linear along the view axis, 0
    at the near plane, 1 at the far plane or where nothing is seen. A channel that was not requested may be None.
    """

    rgb: NDArray[np.uint8] | None
    depth: NDArray[np.float32] | None

    def __post_init__(self) -> None:
        for channel in (self.rgb, self.depth):
            if channel is not None:
                channel.setflags(write=False)

    @property
    def nbytes(self) -> int:
        return sum(channel.nbytes for channel in (self.rgb, self.depth) if channel is not None)


PART = 1 << 20
"""Number of pixels drawn at once: larger images are drawn in parts, so that others do not wait long."""


def nothing() -> None:
    """Do nothing between two parts."""


class Renderer(Protocol):
    """Renders images of one model at a time. Used by one thread from creation to close."""

    def turn_to(self, model: mujoco.MjModel) -> None: ...

    def render(
        self,
        data: mujoco.MjData,
        view: CameraView,
        rgb: bool,
        depth: bool,
        let_in: Callable[[], None] = nothing,
    ) -> CameraImage:
        """Return an image; `let_in` is called between its parts, and may render other images of the same model."""
        ...

    def render_both(
        self,
        data: mujoco.MjData,
        view: CameraView,
        coded: CameraView,
        let_in: Callable[[], None] = nothing,
    ) -> tuple[CameraImage, CameraImage]:
        """Return the images of a view of colours and of one of codes with the same `place`, with all channels."""
        ...

    def rest(self) -> None:
        """Free the memory that only large images need."""
        ...

    def close(self) -> None: ...


def grey(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return (h, w) uint8: the integer mean (r + g + b) // 3 of each pixel, as V-REP's grey option computes it."""
    total = rgb[..., 0].astype(np.uint16)
    total += rgb[..., 1]
    total += rgb[..., 2]
    total //= 3
    return total.astype(np.uint8)


def depth_as_grey(depth: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return (h, w, 3) uint8, equal channels: depth as V-REP's depth-to-grey filter shows it, 0 near, 255 far."""
    levels = np.rint(depth * np.float32(255)).astype(np.uint8)
    return np.repeat(levels[..., np.newaxis], 3, axis=2)


def fovy_from_perspective_angle(angle_rad: float, width: int, height: int) -> float:
    """Return the vertical angle in degrees for V-REP's perspective angle, which belongs to the larger image side."""
    if width <= height:
        return math.degrees(angle_rad)
    return math.degrees(2 * math.atan(math.tan(angle_rad / 2) * height / width))


def perspective_angle_from_fovy(fovy_deg: float, width: int, height: int) -> float:
    """Return V-REP's perspective angle (radians, across the larger image side) for the vertical angle."""
    if width <= height:
        return math.radians(fovy_deg)
    return 2 * math.atan(math.tan(math.radians(fovy_deg) / 2) * width / height)
