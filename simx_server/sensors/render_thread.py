"""The one thread that makes pictures, and how the physics thread asks it for one without ever waiting.

A request copies the state and returns a future at once. What was asked already is not done twice: requests
for the same view of the same version share one picture, also those of two cameras in one place (a camera for
colours and one for depth are one device), and several views of one version share one copy of the state.
Whoever asks for both channels of each version, one after the other, gets them from one pass.
The renderer, and with it every OpenGL call, lives and dies on this thread.
"""

import functools
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from dataclasses import dataclass, field

import mujoco

from simx_server.limits import Limits
from simx_server.metrics import PictureTimes
from simx_server.sensors.camera_places import CameraPlaces
from simx_server.sensors.gl_backend import RAYCAST, Backend, choose_backend
from simx_server.sensors.picture import CameraView, Picture, Renderer, RenderError
from simx_server.sensors.snapshots import Snapshot, SnapshotPool

logger = logging.getLogger(__name__)

_JOIN_TIMEOUT = 2.0
_OWNER_CHECK = 1.0


@dataclass(eq=False)
class _Job:
    """One picture: waiting, being made, or made and kept as the newest of its camera."""

    model: mujoco.MjModel
    view: CameraView
    version: Hashable
    rgb: bool
    depth: bool
    asked: set[str]
    """Channels somebody asked for, which may be fewer than are made."""
    cameras: set[int]
    """All that asked for it."""
    snapshot: Snapshot | None
    """None once the picture is made."""
    future: "Future[Picture]" = field(default_factory=Future)

    @property
    def key(self) -> tuple[int, CameraView, Hashable]:
        return id(self.model), self.view, self.version


def make_renderer(model: mujoco.MjModel, backend: Backend) -> Renderer:
    """The renderer of a back end; to be called on the thread that will use it."""
    # Imported late: a server without cameras needs neither.
    if backend.name == RAYCAST:
        from simx_server.sensors.raycast import RaycastRenderer

        return RaycastRenderer(model)
    from simx_server.sensors.opengl import OpenGLRenderer

    return OpenGLRenderer(model, backend.name)


class RenderThread:
    """Owns the renderer. `request` and `prepare` return at once, on any thread. Close it at the end.

    The thread starts with the first request, and so does the choice of a back end (about half a second).

    Args:
        choose: chooses the back end, on the render thread; by default `choose_backend`.
        make: makes a renderer for a model, on the render thread.
        limits: of which `pictures` counts here.
    """

    def __init__(
        self,
        choose: Callable[[], Backend] | None = None,
        make: Callable[[mujoco.MjModel, Backend], Renderer] = make_renderer,
        limits: Limits | None = None,
    ) -> None:
        self._limits = limits or Limits()
        self.ready = threading.Event()
        """Set once the back end is chosen."""
        self.times = PictureTimes()
        self._closing = threading.Event()
        self._choose = choose or functools.partial(choose_backend, give_up=self._closing)
        self._make = make
        self._backend: Backend | None = None

        self._wake = threading.Condition()
        self._waiting: deque[_Job] = deque()
        self._pending: dict[Hashable, _Job] = {}  # waiting or running, by key
        self._newest: dict[int, _Job] = {}  # by camera
        self._places = CameraPlaces()
        self._to_prepare: mujoco.MjModel | None = None
        self._pool = SnapshotPool()
        self._thread: threading.Thread | None = None

        # Touched by the render thread alone.
        self._renderer: Renderer | None = None
        self._renderer_model: mujoco.MjModel | None = None

    @property
    def backend(self) -> Backend | None:
        """The back end taken; None until the first picture was wanted."""
        return self._backend

    @property
    def waiting(self) -> int:
        """Pictures that were asked for and are not begun."""
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
    ) -> "Future[Picture]":
        """Ask for a picture of the state `data` (forward kinematics done) and go on.

        `version` names the state: equal versions of one model must mean equal states. The future may be
        shared with other askers, so do not cancel it; its picture may hold a channel more than asked for. Its
        callbacks run on the render thread. It fails with RenderError.
        """
        with self._wake:
            if self._closing.is_set():
                return _failed("rendering is closed; the server is shutting down")
            camera, asked = view.camera_id, _names(rgb, depth)
            view = self._places.by_first(model, data, view)
            key = (id(model), view, version)
            before = self._newest.get(camera)
            known = self._pending.get(key) or self._made(key)
            if known is not None and not known.future.cancelled():
                known.asked |= asked
                known.cameras.add(camera)
                if known.snapshot is not None and not known.future.running():
                    # It still waits: one pass makes both channels.
                    known.rgb, known.depth = known.rgb or rgb, known.depth or depth
                if known.rgb >= rgb and known.depth >= depth:
                    return known.future
                asked |= known.asked
            if asked != _names(rgb, depth) or (before is not None and len(before.asked) == 2):
                # Whoever asked for the other channel afterwards is likely to do so again.
                rgb = depth = True
            if len(self._waiting) >= self._limits.pictures:
                problem = self._limits.reached("pictures", "ask less often or for a smaller resolution")
                return _failed(str(problem))
            snapshot = self._pool.take(model, data, version)
            job = _Job(model, view, version, rgb, depth, asked, {camera}, snapshot)
            self._waiting.append(job)
            self._pending[key] = job
            self._start_or_wake()
            return job.future

    def _made(self, key: Hashable) -> _Job | None:
        """A picture that is there already. Needs the lock."""
        return next((job for job in self._newest.values() if job.key == key), None)

    def prepare(self, model: mujoco.MjModel) -> None:
        """Choose the back end and make the renderer ahead of the first picture; failure is only logged."""
        with self._wake:
            if not self._closing.is_set():
                self._to_prepare = model
                self._start_or_wake()

    def close(self) -> None:
        """Fail what waits, finish what is under way, end the thread. Twice does no harm."""
        with self._wake:
            self._closing.set()
            waiting = list(self._waiting)
            self._waiting.clear()
            self._pending.clear()
            self._newest.clear()
            self._wake.notify()
        for job in waiting:
            if job.future.set_running_or_notify_cancel():
                job.future.set_exception(RenderError("the picture was not made because rendering is closing"))
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(_JOIN_TIMEOUT)
            if self._thread.is_alive():
                logger.error("the render thread is still busy after %.0f s", _JOIN_TIMEOUT)

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
            self._drop_renderer()

    def _next(self) -> Callable[[], None] | None:
        """The next picture to make, else the model to prepare for; None when closing."""
        with self._wake:
            while True:
                # A program that fails without closing must still be able to end.
                if self._closing.is_set() or not threading.main_thread().is_alive():
                    return None
                while self._waiting:
                    job = self._waiting.popleft()
                    if job.snapshot is not None and job.future.set_running_or_notify_cancel():
                        return functools.partial(self._do, job, job.snapshot)
                    self._forget(job)
                if self._to_prepare is not None:
                    model, self._to_prepare = self._to_prepare, None
                    return functools.partial(self._prepare, model)
                self._wake.wait(_OWNER_CHECK)

    def _do(self, job: _Job, snapshot: Snapshot) -> None:
        try:
            renderer = self._renderer_for(job.model)
            began = time.perf_counter()
            picture = renderer.render(snapshot.data, job.view, job.rgb, job.depth)
            self.times.made(_camera_name(job), time.perf_counter() - began)
        # Whatever a driver or a renderer does wrong is the asker's to hear, and no reason to end the thread.
        except Exception as error:
            self._drop_renderer()
            with self._wake:
                self._forget(job)
            explained = _explained(job, self._backend, error)
            self.times.not_made(str(explained))
            job.future.set_exception(explained)
            return
        with self._wake:
            self._forget(job)
            if not self._closing.is_set():
                self._newest |= dict.fromkeys(job.cameras, job)
        job.future.set_result(picture)

    def _forget(self, job: _Job) -> None:
        """Give back what a job holds while it is pending. Needs the lock."""
        if self._pending.get(job.key) is job:
            del self._pending[job.key]
        if job.snapshot is not None:
            self._pool.give_back(job.snapshot)
            job.snapshot = None

    def _prepare(self, model: mujoco.MjModel) -> None:
        try:
            self._renderer_for(model)
        except Exception as error:
            self._drop_renderer()
            if not self._closing.is_set():
                logger.warning("cannot render: %s", error)

    def _renderer_for(self, model: mujoco.MjModel) -> Renderer:
        if self._renderer is None or self._renderer_model is not model:
            self._drop_renderer()
            with self._wake:
                self._newest.clear()
            backend = self._backend or self._take_backend()
            self._renderer = self._make(model, backend)
            self._renderer_model = model
        return self._renderer

    def _take_backend(self) -> Backend:
        backend = self._choose()
        level = logging.WARNING if backend.name == RAYCAST else logging.INFO
        logger.log(level, "pictures are made with %s: %s", backend.name, backend.reason)
        self._backend = backend
        self.ready.set()
        return backend

    def _drop_renderer(self) -> None:
        renderer, self._renderer, self._renderer_model = self._renderer, None, None
        if renderer is None:
            return
        try:
            renderer.close()
        except Exception:
            # After a failure of the driver closing may fail too; a new context does not depend on it.
            logger.exception("a renderer did not close cleanly")


def _names(rgb: bool, depth: bool) -> set[str]:
    return {name for name, is_asked in (("rgb", rgb), ("depth", depth)) if is_asked}


def _camera_name(job: _Job) -> str:
    if job.view.viewpoint is not None:
        return "(overview)"
    camera = job.view.camera_id
    return mujoco.mj_id2name(job.model, mujoco.mjtObj.mjOBJ_CAMERA, camera) or f"camera {camera}"


def _told(view: CameraView) -> str:
    return "the overview" if view.viewpoint is not None else f"camera id {view.camera_id}"


def _failed(reason: str) -> "Future[Picture]":
    future: Future[Picture] = Future()
    future.set_exception(RenderError(reason))
    return future


def _explained(job: _Job, backend: Backend | None, error: Exception) -> RenderError:
    means = f" with {backend.name}" if backend is not None else ""
    explained = RenderError(
        f"the {job.view.width} x {job.view.height} picture of {_told(job.view)} "
        f"could not be rendered{means}: {error}"
    )
    explained.__cause__ = error
    return explained
