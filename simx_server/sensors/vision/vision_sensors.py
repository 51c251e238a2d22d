"""Vision sensors: the settings of each camera's image, and requests to the render thread.

V-REP renders in the sensing phase; here an image is rendered on request, from the last complete state, so equal
requests share one image and an unread camera costs nothing. A sensor that is handled explicitly keeps its image (at
first the background) until a script handles it; an image that was set stays until the next simulation step, or with
external input until another one is set. A sensor whose script has a vision call-back is rendered in each simulation
step. The conversion to wire bytes runs on the render thread.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError, NotHandledYet
from simx_server.scene.objects import ObjectKind
from simx_server.world.part import Part

from .image import NO_CODE, CameraView, Picture, depth_as_grey, fovy_from_perspective_angle, grey
from .vision_settings import Verdict, VisionSettings, settings_from_model

if TYPE_CHECKING:
    from simx_server.sensors.vision.render_thread import RenderThread
    from simx_server.world.simulation import Simulation

_A = TypeVar("_A")
_B = TypeVar("_B")

BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


class VisionSensors(Part):
    """All vision sensors of the scene. Physics thread only; the futures finish on the render thread."""

    def __init__(self, sim: Simulation, rendering: RenderThread) -> None:
        self._sim = sim
        self._rendering = rendering
        self.enabled = True
        """Boolean parameter 10: whether sensors are handled at all; if false, images are the background."""
        self.background = BLACK
        """RGB 0..1 where nothing is seen; V-REP uses the colour of the scene's fog, at first black."""
        self.on_picture: Callable[[int], object] = _nobody
        """Called with a sensor's handle when it was handled or an image was set: scripts that process images."""
        self._settings: dict[int, VisionSettings] = {}

    def scene_changed(self) -> None:
        self._change_scene()

    def run_started(self) -> None:
        self._forget_pictures()

    def run_stopped(self) -> None:
        self._forget_pictures()

    def settings(self, handle: int) -> VisionSettings:
        """Return the settings of a sensor, for reading.

        Raises:
            UnknownHandle, WrongKind: the handle is not a vision sensor's.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.VISION_SENSOR, ObjectKind.CAMERA)
        if handle not in self._settings:
            self._settings[handle] = settings_from_model(item, self._sim.model)
        return self._settings[handle]

    def change(self, handle: int, **values: float | int) -> None:
        """Change settings by field name.

        Raises:
            CommandError: an image with these settings is impossible; the settings stay as they were.
        """
        settings = self.settings(handle)
        before = {name: getattr(settings, name) for name in values}
        for name, value in values.items():
            setattr(settings, name, value)
        try:
            self._view(handle)
        except CommandError:
            for name, value in before.items():
                setattr(settings, name, value)
            raise
        settings.forget()

    def copy_settings(self, copies: Mapping[int, int]) -> None:
        """Copy settings of sensors to their copies; `copies` maps the handle of the original to that of the copy."""
        for handle, copy in copies.items():
            if handle in self._settings:
                self._settings[copy] = replace(
                    self._settings[handle], picture=None, filtered=None, verdict=None
                )

    def image(self, handle: int, *, as_grey: bool, asker: str = "") -> Future[tuple[list[int], bytes]]:
        """Return [width, height] and bytes, rows bottom first: RGB, or one grey byte per pixel.

        `asker`, here and below: the caller; the render thread serves all callers in turn.
        """
        settings = self._sensor(handle)
        size = [settings.width, settings.height]
        shown = settings.drawn if settings.filtered is None else settings.filtered
        if shown is not None:
            return _done((size, (grey(shown) if as_grey else shown).tobytes()))
        if settings.shows_depth:
            picture = self._picture(handle, depth=True, asker=asker)
        else:
            picture = self._picture(handle, rgb=True, asker=asker)
        shows_depth = settings.shows_depth

        def convert(made: Picture) -> tuple[list[int], bytes]:
            pixels = _shown(made, shows_depth)
            return size, (grey(pixels) if as_grey else pixels).tobytes()

        return then(picture, convert)

    def depth(self, handle: int, *, asker: str = "") -> Future[tuple[list[int], bytes]]:
        """Return [width, height] and float32 values 0..1, rows bottom first."""
        settings = self._sensor(handle)
        size = [settings.width, settings.height]

        def convert(made: Picture) -> tuple[list[int], bytes]:
            assert made.depth is not None
            return size, made.depth.astype("<f4", copy=False).tobytes()

        return then(self._picture(handle, depth=True, asker=asker), convert)

    def read(self, handle: int, *, asker: str = "") -> Future[tuple[bool, list[list[float]]]]:
        """Return whether the sensor detects, and [15 numbers].

        The numbers are minimum, maximum and mean of intensity, red, green, blue and depth. For a sensor that shows
        handles they are those handles, each plus a half, as in V-REP; it does not detect anything on its own.

        Colours are bytes / 255 and their means whole bytes before that, as in V-REP. Detection is set by
        `simx:vision` annotations (`detect_above`, `detect_below`), which replace V-REP's image filters, or by the
        script's vision call-back, whose packets follow the first one.

        Raises:
            CommandError: no simulation step was made yet, handling is switched off, or the sensor is handled
                explicitly or takes external images and got none.
        """
        settings = self._sensor(handle)
        drawn = settings.drawn
        by_itself = self.enabled and not settings.explicit and not settings.external
        handled = settings.picture is not None or (by_itself and self._sim.step_count > 0)
        if drawn is None and not handled:
            name = self._sim.scene.get(handle).name
            raise NotHandledYet(
                f"vision sensor '{name}' has not been handled yet; it is in each pass of a running simulation, "
                "(unless that is switched off), or by its script when it is handled explicitly",
                is_coming=by_itself and self._sim.is_before_first_pass,
            )
        verdict = settings.verdict
        shows_depth = settings.shows_depth and drawn is None
        picture = self._picture(handle, rgb=not shows_depth and drawn is None, depth=True, asker=asker)

        def convert(made: Picture) -> tuple[bool, list[list[float]]]:
            seen = made if drawn is None else Picture(drawn, made.depth)
            return _judged(settings, seen, shows_depth, verdict)

        return then(picture, convert)

    def check(self, handle: int) -> Future[tuple[bool, list[list[float]]]]:
        """Return the same as `read`, from an image rendered now, whatever was handled or set.

        Raises:
            UnknownHandle, WrongKind: the handle is not a vision sensor's.
        """
        settings = self._sensor(handle)
        picture = self._request(handle, rgb=True, depth=True)
        return then(picture, lambda made: _judged(settings, made, settings.shows_depth))

    def handle(self, handle: int) -> None:
        """Render a sensor now and keep its image, as `sim.handleVisionSensor` does.

        While handling is switched off, no image is kept.
        """
        settings = self._sensor(handle)
        if settings.external:
            return
        if not self.enabled:
            settings.picture = None
            return
        self._take(settings, handle, self._sim.step_count)
        self.on_picture(handle)

    def sense(self, handle: int) -> bool:
        """Render a sensor for its script in the sensing phase; the image is kept until the next sensing.

        Returns:
            False for a sensor that is not handled automatically: explicit handling, external input, all switched
                off.
        """
        settings = self._sensor(handle)
        if settings.explicit or settings.external or not self.enabled:
            return False
        self._take(settings, handle, self._sim.step_count + 1)
        return True

    def filter_image(self, handle: int, pixels: NDArray[np.uint8]) -> None:
        """Show another image, (height, width, 3), until the present image is replaced."""
        settings = self._sensor(handle)
        settings.filtered = pixels
        settings.picture_pass = max(settings.picture_pass, self._sim.step_count)

    def judge(self, handle: int, verdict: Verdict) -> None:
        """Store a script's findings in the present image."""
        self._sensor(handle).verdict = verdict

    def set_image(self, handle: int, image: bytes, *, as_grey: bool) -> None:
        """Replace the image by bytes, rows bottom first; the depth does not change.

        Raises:
            CommandError: the number of bytes does not match the resolution.
            LimitReached: sensors keep too many images already.
        """
        settings = self._sensor(handle)
        width, height = settings.width, settings.height
        channels = 1 if as_grey else 3
        if len(image) != width * height * channels:
            raise CommandError(
                f"an image for {width} x {height} pixels has {width * height * channels} bytes, not {len(image)}"
            )
        pixels = np.frombuffer(image, np.uint8).reshape(height, width, channels)
        self._check_room(settings)
        rgb = np.repeat(pixels, 3, axis=2) if as_grey else pixels
        settings.drawn, settings.filtered, settings.verdict = rgb, None, None
        settings.picture_pass = max(settings.picture_pass, self._sim.step_count)
        self.on_picture(handle)

    def _check_room(self, taker: VisionSettings) -> None:
        """Check the memory of all kept images together with an image of this sensor.

        Raises:
            LimitReached: it would be too much.
        """
        kept = sum(each.kept_bytes for each in self._settings.values() if each is not taker)
        self._sim.limits.check(
            "images", kept + taker.most_bytes, "let other sensors' images go, or make them smaller"
        )

    def _take(self, settings: VisionSettings, handle: int, until: int) -> None:
        settings.forget()
        self._check_room(settings)
        settings.picture = self._request(handle, rgb=True, depth=True)
        settings.picture_pass = until

    def look(
        self, handle: int, size: tuple[int, int], background: tuple[float, float, float] | None = None
    ) -> Future[NDArray[np.uint8]]:
        """Return the present view of a sensor or a camera in another size: (height, width, 3), rows bottom first.

        As `image`, but always rendered: images set by scripts and clients are not used. The perspective angle
        belongs to the larger side here too.

        Raises:
            CommandError: the handle is not a sensor's or camera's, or the size is impossible.
        """
        settings = self.settings(handle)
        shows_depth = settings.shows_depth
        view = self._view(handle, size)
        if background is not None:
            view = replace(view, background=background)
        return then(
            self._ask(view, rgb=not shows_depth, depth=shows_depth), lambda made: _shown(made, shows_depth)
        )

    def look_from(self, view: CameraView) -> Future[NDArray[np.uint8]]:
        """Return the same as `look` for a view that does not belong to an object."""
        return then(self._ask(view, rgb=True, depth=False), lambda made: _shown(made, shows_depth=False))

    def views(self) -> list[CameraView]:
        """Return the view of each vision sensor with its present settings."""
        handles = self._sim.scene.of_kind(ObjectKind.VISION_SENSOR)
        return [self._view(handle) for handle in handles]

    def _sensor(self, handle: int) -> VisionSettings:
        self._sim.scene.get_kind(handle, ObjectKind.VISION_SENSOR)
        settings = self.settings(handle)
        if not settings.explicit and settings.picture_pass < self._sim.step_count:
            settings.picture = None
            if not settings.external:
                settings.forget()
        return settings

    def _picture(
        self, handle: int, *, rgb: bool = False, depth: bool = False, asker: str = ""
    ) -> Future[Picture]:
        settings = self.settings(handle)
        if settings.picture is not None:
            return settings.picture
        if settings.explicit or settings.external or not self.enabled:
            return _done(self._background(settings))
        return self._request(handle, rgb=rgb, depth=depth, asker=asker)

    def _request(self, handle: int, *, rgb: bool, depth: bool, asker: str = "") -> Future[Picture]:
        return self._ask(self._view(handle), rgb=rgb, depth=depth, asker=asker)

    def _ask(self, view: CameraView, *, rgb: bool, depth: bool, asker: str = "") -> Future[Picture]:
        sim = self._sim
        sim.physics_calls.refuse("a picture cannot be taken", step_only=True)
        sim.refresh()
        return self._rendering.request(
            sim.model, sim.data, view, rgb=rgb, depth=depth, version=sim.version, asker=asker
        )

    def _background(self, settings: VisionSettings) -> Picture:
        colour = np.rint(np.clip(self._background_of(settings), 0.0, 1.0) * np.float64(255)).astype(np.uint8)
        rgb = np.tile(colour, (settings.height, settings.width, 1))
        return Picture(rgb, np.ones((settings.height, settings.width), np.float32))

    def _background_of(self, settings: VisionSettings) -> tuple[float, float, float]:
        return WHITE if settings.shows_handles else self.background

    def _codes(self) -> tuple[int, ...]:
        """Return the handle of each geom's shape."""
        scene, model = self._sim.scene, self._sim.model
        owners = (scene.owner_of_geom(geom, model) for geom in range(model.ngeom))
        return tuple(owner if owner >= 0 else NO_CODE for owner in owners)

    def _view(self, handle: int, size: tuple[int, int] | None = None) -> CameraView:
        settings = self.settings(handle)
        width, height = size or (settings.width, settings.height)
        try:
            return CameraView(
                camera_id=self._sim.scene.get(handle).id,
                width=width,
                height=height,
                fovy_deg=fovy_from_perspective_angle(settings.angle, width, height),
                near=settings.near,
                far=settings.far,
                background=self._background_of(settings),
                orthographic_size=settings.orthographic_size,
                codes=self._codes() if settings.shows_handles else None,
            )
        except ValueError as problem:
            raise CommandError(str(problem)) from None

    def _change_scene(self) -> None:
        """Reset switch, background and sensors for another scene."""
        self.enabled = True
        self.background = BLACK
        self._settings.clear()

    def _forget_pictures(self) -> None:
        for settings in self._settings.values():
            settings.forget()


def then(future: Future[_A], convert: Callable[[_A], _B]) -> Future[_B]:
    """Return a future of the converted result; the conversion runs on the thread that finishes the first one."""
    converted: Future[_B] = Future()

    def finish(done: Future[_A]) -> None:
        error = done.exception()
        if error is not None:
            # The caller receives the reason; a missing renderer is not an error in the server's code.
            converted.set_exception(CommandError(str(error)))
            return
        try:
            result = convert(done.result())
        except Exception as problem:
            converted.set_exception(problem)
        else:
            converted.set_result(result)

    future.add_done_callback(finish)
    return converted


def statistics(picture: Picture, shows_depth: bool) -> list[float]:
    """Return the 15 numbers of V-REP's first auxiliary packet."""
    assert picture.depth is not None
    pixels = _shown(picture, shows_depth)
    channels = [grey(pixels), pixels[..., 0], pixels[..., 1], pixels[..., 2]]
    found: list[float] = []
    for measure in (np.min, np.max, _mean):
        found += [int(measure(channel)) / 255 for channel in channels]
        found.append(float(measure(picture.depth)))
    return found


def _handles_in(picture: Picture) -> list[float]:
    """Return the handles in an image, in order; V-REP adds a half so that rounding down cannot change them."""
    assert picture.rgb is not None
    codes = np.unique(picture.rgb.astype(np.uint32) @ np.array([1, 256, 65536], np.uint32))
    return [code + 0.5 for code in codes.tolist() if code != NO_CODE]


_MEAN_INTENSITY = 10
"""Index of the mean intensity in the 15 numbers."""


def _judged(
    settings: VisionSettings, picture: Picture, shows_depth: bool, verdict: Verdict | None = None
) -> tuple[bool, list[list[float]]]:
    """Return whether the sensor detects, for which all limits that are set must be met, and the packets.

    A script's verdict replaces the limits.
    """
    if settings.shows_handles:
        seen = [_handles_in(picture)]
        return (False, seen) if verdict is None else (bool(verdict.detects), [*seen, *verdict.packets])
    numbers = statistics(picture, shows_depth)
    intensity = numbers[_MEAN_INTENSITY]
    above, below = settings.detect_above, settings.detect_below
    detects = (
        (above is not None or below is not None)
        and (above is None or intensity > above)
        and (below is None or intensity < below)
    )
    if verdict is None:
        return detects, [numbers]
    return detects if verdict.detects is None else verdict.detects, [numbers, *verdict.packets]


def _mean(values: np.ndarray) -> float:
    """Return the mean in double precision: a large image's sum would lose digits in single."""
    return float(values.mean(dtype=np.float64))


def _shown(picture: Picture, shows_depth: bool) -> np.ndarray:
    """Return (h, w, 3) uint8: the sensor's image."""
    if shows_depth:
        assert picture.depth is not None
        return depth_as_grey(picture.depth)
    assert picture.rgb is not None
    return picture.rgb


def _nobody(_handle: int) -> None:
    """Do nothing, while scripts that process images are absent."""


def _done(result: _A) -> Future[_A]:
    future: Future[_A] = Future()
    future.set_result(result)
    return future
