"""Vision sensors: the settings of each camera's image, and requests to the render thread.

V-REP renders in the sensing phase; here an image is rendered on request, from the last complete state, so equal
requests share one image and an unread camera costs nothing. A sensor that is handled explicitly keeps its image (at
first the background) until a script handles it; an image that was set stays until the next simulation step, or with
external input until another one is set. A sensor whose script has a vision call-back, or whose filters remember
earlier images, is rendered in each simulation step. Filters and the conversion to wire bytes run on the render thread.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from concurrent.futures import Future
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError, NotHandledYet
from simx_server.scene.cameras.image import CameraImage, CameraView, grey
from simx_server.scene.collection import ALL
from simx_server.scene.formats.annotations import numbers_of
from simx_server.scene.objects import ObjectKind
from simx_server.simulation.part import Part

from .futures import done, then
from .handled_sensors import HandledSensors
from .handling_order import HandlingOrder
from .judging import judged, shown
from .sensor_settings import BLACK, Sensor
from .vision_settings import Verdict, VisionSettings

if TYPE_CHECKING:
    from simx_server.scene.collection import Collections
    from simx_server.scene.saved import Saved
    from simx_server.sensors.rendering.render_thread import RenderThread
    from simx_server.simulation.simulation import Simulation

    from .filters.chain import Processed


class VisionSensors(HandledSensors, Part):
    """All vision sensors of the scene. Physics thread only; the futures finish on the render thread."""

    def __init__(
        self,
        sim: Simulation,
        rendering: RenderThread,
        collections: Collections,
        show_changes: Callable[[], object],
    ) -> None:
        """Store what images are made of; `show_changes` brings meshes of points and textures up to date."""
        super().__init__(sim, collections)
        self._rendering = rendering
        self._show_changes = show_changes
        self.enabled = True
        """Boolean parameter 10: whether sensors are handled at all; if false, images are the background."""
        self._order = HandlingOrder()
        self._are_sensed = False
        """Whether a simulation step of this run has come to its sensing phase."""
        self._on_image: Callable[[int], object] = _nobody

    def tell_images(self, on_image: Callable[[int], object]) -> None:
        """Call scripts with a sensor's handle whenever it was handled or an image was set."""
        self._on_image = on_image

    def scene_changed(self) -> None:
        self._change_scene()

    def saving(self, saved: Saved) -> None:
        self._save(saved)
        saved.settings["vision"] = self.enabled

    def run_started(self) -> None:
        self._forget_images()

    def run_stopped(self) -> None:
        self._forget_images()

    def image(
        self, handle: int, *, as_grey: bool, asker: str = "", as_handled: bool = False
    ) -> Future[tuple[list[int], bytes]]:
        """Return [width, height] and bytes, rows bottom first: RGB, or one grey byte per pixel.

        `asker`, here and below: the caller; the render thread serves all callers in turn. `as_handled`: as V-REP's
        buffers, which hold the background until the first handling of a run, or of a new sensor.
        """
        sensor = self._sensor(handle)
        settings = sensor.settings
        size = [settings.width, settings.height]
        if as_handled and self._is_blank(sensor):
            return done((size, _bytes_of(self._background(settings).rgb, as_grey)))
        if settings.filtered is None and (processed := self._processed(sensor, asker)) is not None:
            return then(processed, lambda made: (size, _bytes_of(made.rgb, as_grey)))
        given = settings.drawn if settings.filtered is None else settings.filtered
        if given is not None:
            return done((size, _bytes_of(given, as_grey)))
        if settings.shows_depth:
            image = self._image(sensor, depth=True, asker=asker)
        else:
            image = self._image(sensor, rgb=True, asker=asker)
        shows_depth = settings.shows_depth
        return then(image, lambda made: (size, _bytes_of(shown(made, shows_depth), as_grey)))

    def depth(
        self, handle: int, *, asker: str = "", as_handled: bool = False
    ) -> Future[tuple[list[int], bytes]]:
        """Return [width, height] and float32 values 0..1, rows bottom first. `as_handled`: as in `image`."""
        sensor = self._sensor(handle)
        settings = sensor.settings
        size = [settings.width, settings.height]
        if settings.filtered_depth is not None:
            return done((size, settings.filtered_depth.astype("<f4", copy=False).tobytes()))
        if as_handled and self._is_blank(sensor):
            return done((size, np.ones((settings.height, settings.width), "<f4").tobytes()))

        def convert(made: CameraImage | Processed) -> tuple[list[int], bytes]:
            assert made.depth is not None
            return size, made.depth.astype("<f4", copy=False).tobytes()

        if settings.chain is not None and settings.chain.sets_depth:
            processed = self._processed(sensor, asker)
            if processed is not None:
                return then(processed, convert)
        return then(self._image(sensor, depth=True, asker=asker), convert)

    def read(self, handle: int, *, asker: str = "") -> Future[tuple[bool, list[list[float]]]]:
        """Return whether the sensor detects, and [15 numbers].

        The numbers are minimum, maximum and mean of intensity, red, green, blue and depth. For a sensor that shows
        handles they are those handles, each plus a half, as in V-REP; it does not detect anything on its own.

        Colours are bytes / 255 and their means whole bytes before that, as in V-REP. They are of the image before its
        filters. Filters and the script's vision call-back may detect something; their packets follow the first one.

        Raises:
            CommandError: no simulation step was made yet, handling is switched off, or the sensor is handled
                explicitly or takes external images and got none.
        """
        sensor = self._sensor(handle)
        settings = sensor.settings
        drawn = settings.drawn
        by_itself = self._is_automatic(settings)
        handled = settings.image is not None or (by_itself and self._are_sensed)
        if drawn is None and not handled:
            raise NotHandledYet(
                f"vision sensor '{sensor.item.name}' has not been handled yet; "
                "it is in each pass of a running simulation, "
                "(unless that is switched off), or by its script when it is handled explicitly",
                is_coming=by_itself and self._sim.is_before_first_step,
            )
        verdict = settings.verdict
        if (processed := self._processed(sensor, asker)) is not None:
            return then(processed, lambda made: judged(settings, made.image, False, verdict, made))
        shows_depth = settings.shows_depth and drawn is None
        image = self._image(sensor, rgb=not shows_depth and drawn is None, depth=True, asker=asker)

        def convert(made: CameraImage) -> tuple[bool, list[list[float]]]:
            seen = made if drawn is None else CameraImage(drawn, made.depth)
            return judged(settings, seen, shows_depth, verdict)

        return then(image, convert)

    def check(self, handle: int, entity: int = ALL) -> Future[tuple[bool, list[list[float]]]]:
        """Return the same as `read`, from an image of an entity rendered now, whatever was handled or set.

        Raises:
            UnknownHandle, WrongKind: the handle is not a vision sensor's.
            CommandError: the entity does not exist.
        """
        sensor = self._sensor(handle)
        settings = sensor.settings
        image = self._request(sensor, rgb=True, depth=True, entity=entity)
        if settings.chain is None:
            return then(image, lambda made: judged(settings, made, settings.shows_depth))
        process = self._process(settings, keeps_work=False)
        return then(image, lambda made: judged(settings, made, False, None, process(made)))

    def image_of(self, handle: int, entity: int) -> Future[CameraImage]:
        """Return both channels of an entity as a sensor sees it now.

        Raises:
            UnknownHandle, WrongKind: the handle is not a vision sensor's.
            CommandError: the entity does not exist.
        """
        return self._request(self._sensor(handle), rgb=True, depth=True, entity=entity)

    def handle(self, handle: int) -> None:
        """Render a sensor now and keep its image, as `sim.handleVisionSensor` does.

        While handling is switched off, no image is kept.
        """
        sensor = self._sensor(handle)
        settings = sensor.settings
        if settings.external:
            return
        if not self.enabled:
            settings.image = None
            return
        self._take(sensor, self._sim.step_count)
        self._render_ahead(handle)
        self._on_image(handle)

    def _render_ahead(self, handle: int) -> None:
        """Have the image rendered of the sensor that is probably handled next."""
        expected = self._order.handled(handle, self._sim.version)
        if expected is not None and expected in self._sim.scene.of_kind(ObjectKind.VISION_SENSOR):
            sensor = self._sensor(expected)
            if not sensor.settings.external:
                self._request(sensor, rgb=True, depth=True)

    def set_explicit(self, handle: int, explicit: bool) -> None:
        """Set whether scripts handle a sensor. Its image stays, that of the last simulation step if no other one."""
        sensor = self._sensor(handle)
        settings = sensor.settings
        is_rendered_on_request = settings.image is None and settings.drawn is None
        if explicit and is_rendered_on_request and self._is_automatic(settings) and handle in self._handled:
            self._take(sensor, self._sim.step_count)
        settings.explicit, settings.image_step = explicit, self._sim.step_count
        self._sim.parts.replan()

    def sense(self, handle: int) -> bool:
        """Render a sensor for its script in the sensing phase; the image is kept until the next sensing.

        Returns:
            False for a sensor that is not handled automatically: explicit handling, external input, all switched
                off.
        """
        sensor = self._sensor(handle)
        settings = sensor.settings
        if not self._is_automatic(settings):
            return False
        if settings.image is None or settings.image_step <= self._sim.step_count:
            self._take(sensor, self._sim.step_count + 1)
        return True

    @property
    def has_work(self) -> bool:
        """Return whether there are sensors that this run has not handled yet, or that remember images."""
        if not self._are_sensed:
            return bool(self._sim.scene.of_kind(ObjectKind.VISION_SENSOR))
        return self._are_some_new() or bool(self._remembering())

    @property
    def remembers(self) -> bool:
        """Return whether filters of sensors remember earlier images, which each step has to render."""
        return bool(self._remembering())

    def adopt_run(self, *, is_new: bool, has_steps: bool) -> None:
        """Take over simulation steps that were made outside; only if no filter `remembers` images.

        Args:
            is_new: another run has started.
            has_steps: steps of the run were made.
        """
        if is_new:
            self._forget_images()
        if has_steps:
            self.sense_all()

    def sense_all(self) -> None:
        """Start the sensing phase of a simulation step: render the sensors whose filters remember earlier images.

        The images of other sensors are rendered on request.
        """
        if not self._are_sensed:
            self._are_sensed = True
            self._sim.parts.replan()
        if self.enabled:
            self._handle_new()
        for handle in self._remembering():
            self.sense(handle)

    def _remembering(self) -> list[int]:
        """Return the sensors whose filters remember earlier images."""
        chains = {
            handle: (self._settings.get(handle) or self.settings(handle)).chain
            for handle in self._sim.scene.of_kind(ObjectKind.VISION_SENSOR)
        }
        return [handle for handle, chain in chains.items() if chain is not None and chain.remembers]

    def filter_image(self, handle: int, pixels: NDArray[np.uint8]) -> None:
        """Show another image, (height, width, 3), until the present image is replaced."""
        settings = self._sensor(handle).settings
        settings.filtered = pixels
        settings.image_step = max(settings.image_step, self._sim.step_count)

    def filter_depth(self, handle: int, depth: NDArray[np.float32]) -> None:
        """Give another depth, (height, width) from 0 to 1, until the present image is replaced."""
        settings = self._sensor(handle).settings
        settings.filtered_depth = depth
        settings.image_step = max(settings.image_step, self._sim.step_count)

    def judge(self, handle: int, verdict: Verdict) -> None:
        """Store a script's findings in the present image."""
        self._sensor(handle).settings.verdict = verdict

    def set_image(self, handle: int, image: bytes, *, as_grey: bool) -> None:
        """Replace the image by bytes, rows bottom first; the depth does not change.

        Raises:
            CommandError: the number of bytes does not match the resolution.
            LimitReached: sensors keep too many images already.
        """
        settings = self._sensor(handle).settings
        width, height = settings.width, settings.height
        channels = 1 if as_grey else 3
        if len(image) != width * height * channels:
            raise CommandError(
                f"an image for {width} x {height} pixels has {width * height * channels} bytes, not {len(image)}"
            )
        pixels = np.frombuffer(image, np.uint8).reshape(height, width, channels)
        self._check_room(settings)
        rgb = np.repeat(pixels, 3, axis=2) if as_grey else pixels
        settings.drawn, settings.filtered, settings.filtered_depth, settings.verdict = rgb, None, None, None
        if settings.chain is not None:
            as_set = CameraImage(rgb, np.ones((height, width), np.float32))
            settings.processed = done(self._process(settings)(as_set))
        settings.image_step = max(settings.image_step, self._sim.step_count)
        self._on_image(handle)

    def _check_room(self, taker: VisionSettings) -> None:
        """Check the memory of all kept images together with an image of this sensor.

        Raises:
            LimitReached: it would be too much.
        """
        kept = sum(each.kept_bytes for each in self._settings.values() if each is not taker)
        self._sim.limits.check(
            "images", kept + taker.most_bytes, "let other sensors' images go, or make them smaller"
        )

    def _take(self, sensor: Sensor, until: int) -> None:
        settings = sensor.settings
        settings.forget()
        self._check_room(settings)
        settings.image = self._request(sensor, rgb=True, depth=True)
        settings.image_step = until
        self._handled.add(sensor.item.handle)
        if settings.chain is not None:
            settings.processed = then(settings.image, self._process(settings))

    def _process(
        self, settings: VisionSettings, *, keeps_work: bool = True
    ) -> Callable[[CameraImage], Processed]:
        """Return the chain of a sensor as a function of its images. Not `keeps_work`: it remembers nothing."""
        chain, view, size = settings.chain, settings.view, (settings.width, settings.height)
        assert chain is not None
        if chain.remembers and keeps_work:
            if settings.work is None or settings.work.image.shape != (size[1], size[0], 3):
                settings.work = chain.new_work(*size)
            work = settings.work
            return lambda made: chain.process(made, view, work)
        return lambda made: chain.process(made, view, chain.new_work(*size))

    def _processed(self, sensor: Sensor, asker: str) -> Future[Processed] | None:
        """Return the present image after its chain; None for a sensor without one, or one that shows handles."""
        settings = sensor.settings
        if settings.chain is None or settings.shows_handles:
            return None
        if settings.processed is not None:
            return settings.processed
        self._check_room(settings)
        if settings.image is None and not self._is_automatic(settings):
            from .filters.chain import Processed

            blank = self._background(settings)
            assert blank.rgb is not None
            assert blank.depth is not None
            return done(Processed(blank, blank.rgb, blank.depth))
        image = self._image(sensor, rgb=True, depth=True, asker=asker)
        return then(image, self._process(settings, keeps_work=False))

    def _is_automatic(self, settings: VisionSettings) -> bool:
        """Return whether each simulation step handles a sensor."""
        return self.enabled and not settings.explicit and not settings.external

    def look(
        self,
        handle: int,
        size: tuple[int, int],
        background: tuple[float, float, float] | None = None,
        light: Hashable = None,
    ) -> Future[NDArray[np.uint8]]:
        """Return the present view of a sensor or a camera in another size: (height, width, 3), rows bottom first.

        As `image`, but always rendered: images set by scripts and clients are not used. The perspective angle
        belongs to the larger side here too. `light`: other than None, if the caller has changed the light; the image
        is then not shared with those who see the scene's own.

        Raises:
            CommandError: the handle is not a sensor's or camera's, or the size is impossible.
        """
        self._show_changes()
        sensor = self._found(handle, ObjectKind.VISION_SENSOR, ObjectKind.CAMERA)
        shows_depth = sensor.settings.shows_depth
        view = self._view_of(sensor, size)
        if background is not None:
            view = replace(view, background=background)
        return then(
            self._ask(view, rgb=not shows_depth, depth=shows_depth, light=light),
            lambda made: shown(made, shows_depth),
        )

    def look_from(self, view: CameraView, light: Hashable = None) -> Future[NDArray[np.uint8]]:
        """Return the same as `look` for a view that does not belong to an object."""
        return then(
            self._ask(view, rgb=True, depth=False, light=light), lambda made: shown(made, shows_depth=False)
        )

    def _sensor(self, handle: int) -> Sensor:
        """Return a vision sensor, without an image that is not its present one any more."""
        sensor = self._found(handle, ObjectKind.VISION_SENSOR)
        settings = sensor.settings
        if not settings.explicit and settings.image_step < self._sim.step_count:
            settings.image = None
            if not settings.external:
                settings.forget()
        return sensor

    def _image(
        self, sensor: Sensor, *, rgb: bool = False, depth: bool = False, asker: str = ""
    ) -> Future[CameraImage]:
        settings = sensor.settings
        if settings.image is not None:
            return settings.image
        if not self._is_automatic(settings):
            return done(self._background(settings))
        return self._request(sensor, rgb=rgb, depth=depth, asker=asker)

    def _request(
        self, sensor: Sensor, *, rgb: bool, depth: bool, asker: str = "", entity: int | None = None
    ) -> Future[CameraImage]:
        self._show_changes()
        settings = sensor.settings
        shape = settings.height, settings.width
        with_rgb, with_depth = rgb and settings.has_rgb, depth and settings.has_depth
        if not with_rgb and not with_depth:
            return done(CameraImage(np.zeros((*shape, 3), np.uint8), np.ones(shape, np.float32)))
        made = self._ask(self._view_of(sensor, entity=entity), rgb=with_rgb, depth=with_depth, asker=asker)
        if (with_rgb, with_depth) == (rgb, depth):
            return made
        return then(
            made,
            lambda image: CameraImage(
                image.rgb if with_rgb else np.zeros((*shape, 3), np.uint8),
                image.depth if with_depth else np.ones(shape, np.float32),
            ),
        )

    def _ask(
        self, view: CameraView, *, rgb: bool, depth: bool, asker: str = "", light: Hashable = None
    ) -> Future[CameraImage]:
        sim = self._sim
        sim.physics_calls.refuse("a image cannot be taken", step_only=True)
        sim.refresh()
        version = sim.version if light is None else (sim.version, light)
        return self._rendering.request(
            sim.model, sim.data, view, rgb=rgb, depth=depth, version=version, asker=asker
        )

    def _change_scene(self) -> None:
        """Take switch and background of another scene, and forget all sensors."""
        note = self._sim.scene.annotations.scene
        self.enabled = bool(note.get("vision", True))
        red, green, blue = numbers_of(note["background"]) if "background" in note else BLACK
        self.background = red, green, blue
        self._settings.clear()
        self._handled.clear()
        self._order.forget()

    def _forget_images(self) -> None:
        for settings in self._settings.values():
            settings.forget()
            settings.work = None
        self._are_sensed = False
        self._handled.clear()


def _bytes_of(pixels: NDArray[np.uint8] | None, as_grey: bool) -> bytes:
    """Return (h, w, 3) colours as bytes, or as one grey byte per pixel."""
    assert pixels is not None
    return (grey(pixels) if as_grey else pixels).tobytes()


def _nobody(_handle: int) -> None:
    """Do nothing, while scripts that process images are absent."""
