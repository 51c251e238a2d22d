"""The thread that renders all images; the physics thread requests images without waiting.

A request copies the state and returns a future at once. Equal work is done once: requests for the same view of the
same version share one image, also those of two cameras at one pose (a camera for colours and one for depth are one
device), and several views of one version share one copy of the state. A caller that requests both channels of each
version, one after the other, gets them from one rendering. The renderer, and with it every OpenGL call, stays on
this thread.

A graphics driver may hang. `watch` detects this, and images fail with the reason until the thread continues.
"""

import atexit
import functools
import logging
import threading
import time
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Future, wait

import mujoco

from simx_server.durations import ImageTimes
from simx_server.limits import Limits
from simx_server.scene.cameras.image import PART, CameraImage, CameraView, Renderer, RenderError, nothing
from simx_server.sensors.opengl.backend import RAYCAST, Backend, Probe, choose_backend

from .current_renderer import CurrentRenderer, make_renderer
from .image_queue import ImageQueue
from .jobs import DRAWN_WITHIN, Doing, ImageJob, Preparation, channels, title
from .newest import NewestImages
from .shared_cameras import CameraPlaces, ViewPairs
from .state_copies import Snapshot, SnapshotPool

logger = logging.getLogger(__name__)

RESTS_AFTER = 5.0
"""Seconds without a request after which the memory of large images is freed."""

_JOIN_TIMEOUT = 2.0
_OWNER_CHECK = 1.0


class RenderThread:
    """Owns the renderer. `request` and `prepare` return at once, on any thread. Close it at the end.

    The thread starts with the first request or `choose`, and so does the choice of a back end (about half a second).

    Args:
        choose: chooses the back end, on the render thread; by default `choose_backend`.
        make: makes a renderer for a model, on the render thread.
        probe: tries back ends for `choose_backend`.
        limits: only `pictures` is used here.
    """

    def __init__(
        self,
        choose: Callable[[], Backend] | None = None,
        make: Callable[[mujoco.MjModel, Backend], Renderer] = make_renderer,
        limits: Limits | None = None,
        probe: Probe | None = None,
    ) -> None:
        self._limits = limits or Limits()
        self.times = ImageTimes()
        self._closing = threading.Event()
        choose = choose or functools.partial(choose_backend, probe=probe, give_up=self._closing)
        self._current = CurrentRenderer(choose, make, self._begin, self.close)

        self._wake = threading.Condition()
        self._waiting: ImageQueue[ImageJob] = ImageQueue(self._limits.pictures)
        self._pending: dict[Hashable, ImageJob] = {}  # waiting or running, by key
        self._newest: NewestImages[ImageJob] = NewestImages()
        self._places = CameraPlaces()
        self._pairs = ViewPairs()
        self._running: ImageJob | None = None
        self._doing: Doing | None = None
        self._is_hanging = False
        self.warms_on_demand = False
        """See `warm_on_demand`."""

        self._is_to_choose = False
        self._is_begun = False
        self._to_prepare: Preparation | None = None
        self._prepared = _nothing_to_do()
        """The newest preparation."""

        self._pool = SnapshotPool()
        self._thread: threading.Thread | None = None

        self._is_rested = True

    @property
    def backend(self) -> Backend | None:
        """Return the chosen back end; None before it is chosen."""
        return self._current.backend

    @property
    def ready(self) -> threading.Event:
        """Return what is set once the back end is chosen."""
        return self._current.ready

    @property
    def is_begun(self) -> bool:
        """Return whether an image or its preparation was requested yet, so that there is a renderer or soon will be."""
        return self._is_begun

    @property
    def is_hanging(self) -> bool:
        """Return whether `watch` has found that the render thread hangs, so that images fail now."""
        return self._is_hanging

    @property
    def is_stuck(self) -> bool:
        """Return whether, after `close`, the thread cannot be ended, and so blocks a normal exit of the process."""
        return self._closing.is_set() and self._thread is not None and self._thread.is_alive()

    @property
    def waiting(self) -> int:
        """Return the number of requested images that are not in progress yet."""
        return len(self._waiting)

    def request(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        view: CameraView,
        *,
        rgb: bool,
        depth: bool,
        version: Hashable,
        asker: str = "",
    ) -> "Future[CameraImage]":
        """Request an image of the state `data` (forward kinematics done) without waiting.

        Args:
            model: the model.
            data: the state.
            view: the camera view.
            rgb: whether to render colours.
            depth: whether to render depth.
            version: identifies the state: equal versions of one model must mean equal states.
            asker: the caller; callers share the thread's time equally.

        Returns:
            A future that may be shared with other callers, so do not cancel it; its image may hold a channel that
                was not requested. Its callbacks run on the render thread. It fails with RenderError.
        """
        with self._wake:
            future, failed = self._request(model, data, view, rgb, depth, version, asker)
        if failed is not None and failed.future.set_running_or_notify_cancel():
            problem = self._limits.reached("pictures", "ask less often or for a smaller resolution")
            failed.future.set_exception(RenderError(str(problem)))
        return future

    def _request(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        view: CameraView,
        rgb: bool,
        depth: bool,
        version: Hashable,
        asker: str,
    ) -> "tuple[Future[CameraImage], ImageJob | None]":
        """Return the future, and a job to drop because there are too many. Needs the lock."""
        if self._closing.is_set():
            return _failed("rendering is closed; the server is shutting down"), None
        if self._doing is not None and self._doing.is_overdue():
            return _failed(self._doing.reason()), None
        self._is_begun = True
        camera, asked = view.camera_id, channels(rgb, depth)
        view = self._places.by_first(model, data, view)
        key = (id(model), view, version)
        before, other = self._newest.of(camera), self._pairs.requested(view, camera, version)
        known = self._pending.get(key) or self._newest.find(key)
        if known is not None and not known.future.cancelled():
            known.asked |= asked
            known.cameras.add(camera)
            if known.snapshot is not None and not known.future.running():
                # It still waits: one rendering makes both channels.
                known.rgb, known.depth = known.rgb or rgb, known.depth or depth
            if known.rgb >= rgb and known.depth >= depth:
                return known.future, None
            asked |= known.asked
        if asked != channels(rgb, depth) or (before is not None and len(before.asked) == 2):
            # A caller that then requested the other channel is likely to do so again.
            rgb = depth = True
        snapshot = self._pool.take(model, data, version)
        job = ImageJob(model, view, version, rgb, depth, asked, {camera}, snapshot, asker)
        self._pending[key] = job
        if other is not None and rgb:
            twin = job.expect(other)
            self._pending.setdefault(twin.key, twin)
        failed = self._waiting.put(job, asker)
        if failed is not None:
            self._forget(failed)
        self._start_or_wake()
        return job.future, failed

    def choose(self) -> None:
        """Choose the back end, so that the log says how images are made, or why not. It takes no memory yet."""
        with self._wake:
            if self.backend is None and not self._closing.is_set():
                self._is_to_choose = True
                self._start_or_wake()

    def prepare(
        self, model: mujoco.MjModel, data: mujoco.MjData, views: Sequence[CameraView], *, version: Hashable
    ) -> "Future[None]":
        """Prepare the first image: the back end, the renderer, and the driver's work on first use.

        For that each of `views` is drawn once in the state `data`, unless an image is requested meanwhile. Failure
        is only logged.

        Returns:
            A future that is done afterwards, or when a later preparation replaces this one.
        """
        with self._wake:
            if self._closing.is_set():
                return _nothing_to_do()
            self._is_begun = True
            snapshot = self._pool.take(model, data, version) if views else None
            preparation = Preparation(model, views, snapshot)
            before, self._to_prepare = self._to_prepare, preparation
            self._prepared = preparation.done
            if before is not None:
                self._end_preparation(before)
            self._start_or_wake()
        if before is not None:
            before.done.set_result(None)
        return preparation.done

    def wait_until_prepared(self, seconds: float) -> bool:
        """Wait for the newest preparation, at most this many seconds; return whether it is done, or there is none."""
        return bool(wait([self._prepared], seconds).done)

    def warm_on_demand(self) -> None:
        """Have a program that gets the handle of a vision sensor wait for its images; see `warm_up`."""
        self.warms_on_demand = True

    def watch(self) -> None:
        """Fail all images if the render thread hangs. Call it about every second, on any thread."""
        doing = self._doing
        if doing is None or not doing.is_overdue():
            return
        with self._wake:
            if self._doing is not doing:
                return
            failed = self._waiting.clear()
            for job in failed:
                self._forget(job)
            running = self._give_up_running()
            is_news, self._is_hanging = not self._is_hanging, True
        reason = doing.reason()
        if is_news:
            logger.error("%s", reason)
        for job in failed:
            if job.future.set_running_or_notify_cancel():
                job.future.set_exception(RenderError(reason))
        if running is not None:
            running.future.set_exception(RenderError(reason))

    def _give_up_running(self) -> ImageJob | None:
        """Return the job in progress, which is to fail now; its result is not used. Needs the lock."""
        job = self._running
        if job is None or job.is_given_up:
            return None
        job.is_given_up = True
        self._unlist(job)
        return job

    def close(self) -> None:
        """Fail waiting images, finish the one in progress, end the thread. A second call does nothing."""
        atexit.unregister(self.close)
        with self._wake:
            self._closing.set()
            preparation, self._to_prepare = self._to_prepare, None
            waiting = self._waiting.clear()
            self._pending.clear()
            self._newest.clear()
            self._wake.notify()
        if preparation is not None:
            preparation.done.set_result(None)
        for job in waiting:
            if job.future.set_running_or_notify_cancel():
                job.future.set_exception(RenderError("the picture was not made because rendering is closing"))
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(_JOIN_TIMEOUT)
            if self._thread.is_alive():
                logger.error("the render thread is still busy after %.0f s", _JOIN_TIMEOUT)
                with self._wake:
                    running = self._give_up_running()
                if running is not None:
                    running.future.set_exception(
                        RenderError("the picture was not made, as rendering is closed")
                    )

    def _start_or_wake(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="simx-render")
            self._thread.start()
        self._wake.notify()

    # From here on: the render thread.

    def _run(self) -> None:
        try:
            while (work := self._next()) is not None:
                work()
        finally:
            self._current.drop()

    def _next(self) -> Callable[[], None] | None:
        """Return the next image to render, else a preparation; None when closing."""
        with self._wake:
            self._running = self._doing = None
            if self._is_hanging:
                self._is_hanging = False
                logger.warning("the render thread has come back; images can be made again")
            idle_since = time.monotonic()
            while True:
                # A program that fails without closing must still be able to end.
                if self._closing.is_set() or not threading.main_thread().is_alive():
                    return None
                if (job := self._next_job()) is not None:
                    return functools.partial(self._do, *job)
                if self._to_prepare is not None:
                    preparation, self._to_prepare = self._to_prepare, None
                    return functools.partial(self._prepare, preparation)
                if self._is_to_choose:
                    self._is_to_choose = False
                    return self._choose
                if not self._is_rested and time.monotonic() > idle_since + RESTS_AFTER:
                    return self._rest
                self._wake.wait(_OWNER_CHECK)

    def _begin(self, what: str, limit: float) -> None:
        self._is_rested = False
        self._doing = Doing(what, time.monotonic(), limit)

    def _rest(self) -> None:
        """Free memory that the next image does not need, after a time without requests."""
        with self._wake:
            self._newest.clear()
            self._pool.rest()
        self._current.rest()
        self._is_rested = True

    def _next_job(self, suits: Callable[[ImageJob], bool] | None = None) -> tuple[ImageJob, Snapshot] | None:
        """Return the next image that is still requested, and mark it as in progress. Needs the lock."""
        while (job := self._waiting.take(suits)) is not None:
            if job.snapshot is not None and job.future.set_running_or_notify_cancel():
                self._running = job
                return job, job.snapshot
            self._forget(job)
        return None

    def _do(self, job: ImageJob, snapshot: Snapshot) -> None:
        """Render an image. Errors of a driver or a renderer go to the caller; the thread continues."""
        try:
            self._make_image(job, snapshot, self._let_in(job))
        except Exception:  # the caller has received the error
            self._current.drop()

    def _let_in(self, large: ImageJob) -> Callable[[], None]:
        """Return a function to call between two parts of a large image.

        It renders small images, for the duration of a part.
        """
        part_began = time.perf_counter()

        def suits(job: ImageJob) -> bool:
            return job.model is large.model and job.view.width * job.view.height <= PART

        def let_in() -> None:
            nonlocal part_began
            now = time.perf_counter()
            until = 2 * now - part_began
            while time.perf_counter() < until:
                with self._wake:
                    small = None if self._closing.is_set() else self._next_job(suits)
                if small is None:
                    break
                try:
                    self._make_image(*small, nothing)
                except RenderError:
                    pass  # not an error of the driver
                finally:
                    with self._wake:
                        self._running = large
            self._begin(f"drawing {title(large.view)}", DRAWN_WITHIN)
            part_began = time.perf_counter()

        return let_in

    def _make_image(self, job: ImageJob, snapshot: Snapshot, let_in: Callable[[], None]) -> None:
        """Render an image, or report the error to the caller. Raises the errors of a driver or a renderer."""
        began = time.perf_counter()
        try:
            renderer = self._renderer_for(job.model)
            self._begin(f"drawing {title(job.view)}", DRAWN_WITHIN)
            images = job.draw(renderer, snapshot, let_in)
            took = time.perf_counter() - began
            self.times.made(job.camera_name, took)
        except Exception as error:
            self._end_job(job, time.perf_counter() - began, {})
            self._tell_failure(job, error)
            raise
        self._end_job(job, took, images)
        if not job.is_given_up:
            for made, image in images.items():
                made.future.set_result(image)

    def _end_job(self, job: ImageJob, took: float, images: dict[ImageJob, CameraImage]) -> None:
        with self._wake:
            self._forget(job)
            self._running = None
            self._waiting.took(job.asker, took)
            if not self._closing.is_set() and not job.is_given_up:
                for made, image in images.items():
                    self._newest.keep(made, image.nbytes)

    def _tell_failure(self, job: ImageJob, error: Exception) -> None:
        explained = job.explained(self.backend, error)
        self.times.not_made(str(explained))
        if not job.is_given_up:
            job.future.set_exception(explained)

    def _forget(self, job: ImageJob) -> None:
        """Release what a job holds while it is pending. Needs the lock."""
        self._unlist(job)
        if job.snapshot is not None:
            self._pool.give_back(job.snapshot)
            job.snapshot = None

    def _unlist(self, job: ImageJob) -> None:
        """Have no later request share a job. Needs the lock."""
        for each in (job, job.twin):
            if each is not None and self._pending.get(each.key) is each:
                del self._pending[each.key]

    def _choose(self) -> None:
        try:
            self._current.chosen()
        except Exception as error:
            self._tell_of(error)

    def _tell_of(self, error: Exception) -> None:
        if not self._closing.is_set():
            logger.warning("cannot render: %s", error)

    def _prepare(self, preparation: Preparation) -> None:
        try:
            renderer = self._renderer_for(preparation.model)
            # Rays leave no work for the first use.
            is_cast = self.backend is not None and self.backend.name == RAYCAST
            for view in () if is_cast else preparation.views:
                if self._waiting or self._closing.is_set() or preparation.snapshot is None:
                    break
                self._begin(f"drawing {title(view)}", DRAWN_WITHIN)
                renderer.render(preparation.snapshot.data, view, True, True)
        except Exception as error:
            self._current.drop()
            self._tell_of(error)
        with self._wake:
            self._end_preparation(preparation)
        preparation.done.set_result(None)

    def _end_preparation(self, preparation: Preparation) -> None:
        """Release what a preparation holds. Needs the lock."""
        if preparation.snapshot is not None:
            self._pool.give_back(preparation.snapshot)
            preparation.snapshot = None

    def _renderer_for(self, model: mujoco.MjModel) -> Renderer:
        if not self._current.is_for(model):
            with self._wake:
                self._newest.clear()
        return self._current.turned_to(model)


def _nothing_to_do() -> "Future[None]":
    future: Future[None] = Future()
    future.set_result(None)
    return future


def _failed(reason: str) -> "Future[CameraImage]":
    future: Future[CameraImage] = Future()
    future.set_exception(RenderError(reason))
    return future
