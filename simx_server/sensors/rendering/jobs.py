"""Work of the render thread: requested images, a preparation, and the task of this moment."""

import time
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Future
from dataclasses import field
from typing import NamedTuple

import mujoco

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.cameras.image import CameraImage, CameraView, Renderer, RenderError
from simx_server.sensors.opengl.backend import Backend

from .shared_cameras import Requested
from .state_copies import Snapshot

DRAWN_WITHIN = 30.0
"""Seconds until a renderer or one image must be made: a large scene by ray casting on a busy machine takes long."""


class Doing(NamedTuple):
    """The present task of the render thread, for the case that it never ends."""

    what: str
    since: float
    limit: float

    def is_overdue(self) -> bool:
        """Return whether the task takes longer than its limit."""
        return time.monotonic() > self.since + self.limit

    def reason(self) -> str:
        """Return why no image can be made now."""
        seconds = time.monotonic() - self.since
        return (
            f"the render thread has been {self.what} for {seconds:.0f} s, so no picture can be made now; the graphics "
            "driver may hang: test it with simx-server --doctor, or set MUJOCO_GL=disable to cast rays"
        )


@dataclass(eq=False)
class ImageJob:
    """One image: waiting, in progress, or done and kept as the newest of its camera."""

    model: mujoco.MjModel
    view: CameraView
    version: Hashable
    rgb: bool
    depth: bool
    asked: set[str]
    """Requested channels, which may be fewer than the rendered ones."""
    cameras: set[int]
    """All cameras that requested it."""
    snapshot: Snapshot | None
    """None once the image is done."""
    asker: str = ""
    future: "Future[CameraImage]" = field(default_factory=Future[CameraImage])
    is_given_up: bool = False
    """It has failed although it is in progress."""
    twin: "ImageJob | None" = None
    """The image of codes that belongs to colours, or the other way round; both come from one drawing."""

    def expect(self, other: Requested) -> "ImageJob":
        """Make the other image of a pair, which waits for this one and fails with it."""
        self.rgb = self.depth = True
        twin = self.twin = ImageJob(
            self.model, other.view, self.version, True, True, set(), {other.camera}, None, self.asker
        )

        def fail(done: "Future[CameraImage]") -> None:
            error = done.exception()
            if error is not None:
                twin.future.set_exception(error)

        self.future.add_done_callback(fail)
        return twin

    @property
    def key(self) -> tuple[int, CameraView, Hashable]:
        """Return what equal requests have in common."""
        return id(self.model), self.view, self.version

    @property
    def camera_name(self) -> str:
        """Return the camera's name, for the statistics."""
        if self.view.viewpoint is not None:
            return "(overview)"
        camera = self.view.camera_id
        return mujoco.mj_id2name(self.model, mujoco.mjtObj.mjOBJ_CAMERA, camera) or f"camera {camera}"

    def draw(
        self, renderer: Renderer, snapshot: Snapshot, let_in: Callable[[], None]
    ) -> "dict[ImageJob, CameraImage]":
        """Return the images of this job and of its twin. `let_in` is called between parts of a large image."""
        twin = self.twin
        if twin is None:
            return {self: renderer.render(snapshot.data, self.view, self.rgb, self.depth, let_in)}
        colours, coded = (self, twin) if self.view.codes is None else (twin, self)
        made = renderer.render_both(snapshot.data, colours.view, coded.view, let_in)
        # The twin is done first: the conversions of the other image may take long.
        return dict(zip((twin, self), made if twin is colours else made[::-1], strict=True))

    def explained(self, backend: Backend | None, error: Exception) -> RenderError:
        """Return an error that says which image could not be rendered."""
        means = f" with {backend.name}" if backend is not None else ""
        explained = RenderError(
            f"the {self.view.width} x {self.view.height} picture of {title(self.view)} "
            f"could not be rendered{means}: {error}"
        )
        explained.__cause__ = error
        return explained


@dataclass(eq=False)
class Preparation:
    """A model to make the renderer for, and views to draw once."""

    model: mujoco.MjModel
    views: Sequence[CameraView]
    snapshot: Snapshot | None
    done: "Future[None]" = field(default_factory=Future[None])


def channels(rgb: bool, depth: bool) -> set[str]:
    """Return the names of the channels that are requested."""
    return {name for name, is_asked in (("rgb", rgb), ("depth", depth)) if is_asked}


def title(view: CameraView) -> str:
    """Return what messages call a view."""
    return "the overview" if view.viewpoint is not None else f"camera id {view.camera_id}"
