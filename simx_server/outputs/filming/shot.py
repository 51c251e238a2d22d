"""Define what is filmed: a camera or vision sensor of the scene, or an overview, upright as people look at it."""

from __future__ import annotations

from collections.abc import Hashable
from concurrent.futures import Future
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.cameras.image import CameraView, Viewpoint
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.sensors.vision.content import framed
from simx_server.sensors.vision.futures import then

from .close_up import CloseUp, viewpoint_of

if TYPE_CHECKING:
    from simx_server.world.world import World

DEFAULT_SIZE = 1280, 720
"""Pixels, for cameras without a resolution."""

USERS_CAMERA = "DefaultCamera"
"""V-REP's window showed a scene through this camera; in scenes that have it, it is the overview."""

PAPER = (0.86, 0.89, 0.92)
"""RGB 0..1 of the background, except for vision sensors."""

LONGEST_WAIT = 120.0
"""Seconds for a first image: some machines need long to choose their renderer."""

Pixels = NDArray[np.uint8]
"""(height, width, 3) RGB, the top row first."""


class Shot:
    """One camera, for any number of images. Physics thread only.

    A vision sensor in its own size gives the image of the remote API, including images that clients or scripts have
    set; in another size its view is rendered again. One that shows depth gives that in grey.
    """

    def __init__(
        self,
        world: World,
        camera: str | None = None,
        size: tuple[int, int] | None = None,
        *,
        is_close: bool = False,
        light: Hashable = None,
    ) -> None:
        """Make a shot.

        Args:
            camera: a name or path, None for the overview.
            size: width and height in pixels, None for the camera's own.
            is_close: an overview is as near as the things that move allow.
            light: other than None, if the caller changes the light of its images; each is rendered for it.

        Raises:
            CommandError: the scene has no such camera.
        """
        self._sim = world.simulation
        self._vision = world.vision
        self._camera = camera
        self._chosen_size = size
        self._viewpoint: tuple[int, Viewpoint] | None = None
        self._framed: tuple[int, Viewpoint | None] | None = None
        self._is_close = is_close
        self._light = light
        self._close_up: CloseUp | None = None
        item = self._find()
        self.name = item.name if item is not None else "overview"
        self.size = size or self._own_size(item) or DEFAULT_SIZE
        """Width and height of the images; those of a sensor change when its resolution is changed."""

    def ask(self) -> Future[Pixels]:
        """Request the image of the present state; it is made on the render thread.

        Raises:
            CommandError: the scene has no such camera any more, or it cannot show anything.
        """
        item = self._find()
        vision = self._vision
        if self._camera is None and (item is None or self._is_close or self._frame(item) is not None):
            return then(vision.look_from(self._overview(item), self._light), _upright)
        assert item is not None  # a camera that was named is found
        if item.kind == ObjectKind.VISION_SENSOR and self._chosen_size is None and self._light is None:
            return then(vision.image(item.handle, as_grey=False), _unpacked)
        background = None if item.kind == ObjectKind.VISION_SENSOR else PAPER
        return then(vision.look(item.handle, self.size, background, self._light), _upright)

    def _find(self) -> SceneObject | None:
        """Return the camera or sensor; None for the overview without a camera."""
        scene = self._sim.scene
        if self._camera is None:
            handle = scene.by_name(USERS_CAMERA)
            found = None if handle is None else scene.get(handle)
            return found if found is not None and found.kind == ObjectKind.CAMERA else None
        try:
            return scene.get_kind(scene.resolve(self._camera), ObjectKind.CAMERA, ObjectKind.VISION_SENSOR)
        except CommandError as problem:
            kinds = (ObjectKind.VISION_SENSOR, ObjectKind.CAMERA)
            names = [scene.get(handle).name for kind in kinds for handle in scene.of_kind(kind)]
            told = (
                f"the cameras of this scene are {', '.join(names)}" if names else "this scene has no camera"
            )
            raise CommandError(f"{problem}; {told}") from None

    def _own_size(self, item: SceneObject | None) -> tuple[int, int] | None:
        if item is None or item.kind != ObjectKind.VISION_SENSOR:
            return None
        settings = self._vision.settings(item.handle)
        return settings.width, settings.height

    def _overview(self, users_camera: SceneObject | None) -> CameraView:
        """Return MuJoCo's free camera in its initial pose, which a scene may set by `<statistic>` and `<global>`.

        It is nearer where the content would be small, and stays in place while a scene is edited. A close overview has
        the direction of the users' camera, if the scene has one.
        """
        viewpoint = self._free_viewpoint()
        if self._is_close:
            if users_camera is not None:
                viewpoint = viewpoint_of(self._sim.data, users_camera.id)
            model = self._sim.model
            if self._close_up is None or self._close_up.model is not model:
                self._close_up = CloseUp(model)
            viewpoint = self._close_up.viewpoint(self._sim.data, viewpoint)
        else:
            viewpoint = self._frame(users_camera) or viewpoint
        return self._free_view(viewpoint)

    def _frame(self, users_camera: SceneObject | None) -> Viewpoint | None:
        """Return from where the content is seen, None where the overview shows it already; once for each scene.

        The overview is that of the users' camera, if the scene has one.
        """
        if self._framed is None or self._framed[0] != self._sim.scene_id:
            self._sim.refresh()
            free = self._free_view(self._free_viewpoint())
            view = free if users_camera is None else self._vision.view(users_camera.handle, self.size)
            whole = users_camera is not None and self._shows_whole(users_camera)
            viewpoint = framed(self._sim.model, self._sim.data, view, free, whole=whole)
            self._framed = self._sim.scene_id, viewpoint
        return self._framed[1]

    def _shows_whole(self, camera: SceneObject) -> bool:
        """Return whether a camera came with the surroundings of a model, and not with an author's scene."""
        notes = self._sim.scene.annotations.objects.get(camera.name, {})
        return bool(notes.get("camera", {}).get("whole", False))

    def _free_viewpoint(self) -> Viewpoint:
        if self._viewpoint is None or self._viewpoint[0] != self._sim.scene_id:
            free = mujoco.MjvCamera()
            mujoco.mjv_defaultFreeCamera(self._sim.model, free)
            stand = Viewpoint(tuple(free.lookat.tolist()), free.distance, free.azimuth, free.elevation)  # pyright: ignore[reportArgumentType]
            self._viewpoint = self._sim.scene_id, stand
        return self._viewpoint[1]

    def _free_view(self, viewpoint: Viewpoint) -> CameraView:
        """Return the view of MuJoCo's free camera from a viewpoint. Raises CommandError."""
        model = self._sim.model
        eye, clip = model.vis.global_, model.vis.map
        width, height = self.size
        fovy = float(eye.fovy)  # for an orthographic view in metres
        extent = float(model.stat.extent)
        nearness = min(1.0, viewpoint.distance / self._free_viewpoint().distance)
        try:
            return CameraView(
                camera_id=-1,
                width=width,
                height=height,
                fovy_deg=fovy,
                near=float(clip.znear) * extent * nearness,
                far=float(clip.zfar) * extent,
                background=PAPER,
                orthographic_size=fovy * max(1.0, width / height) if eye.orthographic else None,
                viewpoint=viewpoint,
                is_users=True,
            )
        except ValueError as problem:
            raise CommandError(f"the scene's overview cannot be pictured: {problem}") from None


def first_image(shot: Shot) -> Pixels:
    """Wait for an image, and for the choice of the renderer.

    Raises:
        CommandError: images cannot be made here.
    """
    return awaited(shot, shot.ask())


def awaited(shot: Shot, image: Future[Pixels]) -> Pixels:
    """Return the image that was requested from a shot. Raises CommandError if it could not be made."""
    try:
        return image.result(LONGEST_WAIT)
    except TimeoutError:
        raise CommandError(
            f"no picture of {shot.name} came within {LONGEST_WAIT:.0f} s; simx-server --doctor tells how this machine "
            "draws; a smaller --size is drawn sooner"
        ) from None


def _upright(pixels: Pixels) -> Pixels:
    return np.ascontiguousarray(pixels[::-1])


def _unpacked(image: tuple[list[int], bytes]) -> Pixels:
    (width, height), data = image
    return _upright(np.frombuffer(data, np.uint8).reshape(height, width, 3))
