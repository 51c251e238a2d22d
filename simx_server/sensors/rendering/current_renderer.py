"""The back end and the renderer that are in use. All of it belongs to the render thread."""

import atexit
import logging
import threading
from collections.abc import Callable

import mujoco

from simx_server.scene.cameras.image import Renderer
from simx_server.sensors.opengl.backend import RAYCAST, Backend

from .jobs import DRAWN_WITHIN

logger = logging.getLogger(__name__)

CHOSEN_WITHIN = 60.0
"""Seconds until a back end must be chosen; after that, images fail until it is.

Eight programs that start at once on two busy processors need half a minute.
"""


def make_renderer(model: mujoco.MjModel, backend: Backend) -> Renderer:
    """Return the renderer of a back end; call it on the thread that will use it."""
    # Imported late: a server without cameras needs neither.
    if backend.name == RAYCAST:
        from simx_server.sensors.ray_casting.renderer import RaycastRenderer

        return RaycastRenderer(model)
    from simx_server.sensors.opengl.renderer import OpenGLRenderer

    return OpenGLRenderer(model, backend.name)


class CurrentRenderer:
    """Chooses a back end with the first image, makes its renderer, and turns it to the model of each image.

    Args:
        choose: chooses the back end.
        make: makes a renderer for a model.
        start: receives the name of a task that starts, and the seconds that it may take.
        close: ends the render thread.
    """

    def __init__(
        self,
        choose: Callable[[], Backend],
        make: Callable[[mujoco.MjModel, Backend], Renderer],
        start: Callable[[str, float], None],
        close: Callable[[], None],
    ) -> None:
        self._choose = choose
        self._make = make
        self._start = start
        self._close = close
        self._renderer: Renderer | None = None
        self._model: mujoco.MjModel | None = None
        self.backend: Backend | None = None
        """The chosen back end; other threads may read it."""
        self.ready = threading.Event()
        """Set once the back end is chosen."""

    def is_for(self, model: mujoco.MjModel) -> bool:
        """Return whether the renderer is made and shows this model."""
        return self._renderer is not None and self._model is model

    def chosen(self) -> Backend:
        """Return the back end, which the first call chooses. Raises the errors of a choice that is given up."""
        if self.backend is None:
            self._start("trying OpenGL back ends", CHOSEN_WITHIN)
            self.backend = self._choose()
            level = logging.WARNING if self.backend.name == RAYCAST else logging.INFO
            logger.log(level, "images are made with %s: %s", self.backend.name, self.backend.reason)
            self.ready.set()
        return self.backend

    def turned_to(self, model: mujoco.MjModel) -> Renderer:
        """Return the renderer, for this model. Raises the errors of a driver."""
        if self._renderer is not None and self._model is model:
            return self._renderer
        backend = self.chosen()
        self._start(f"loading the scene with {backend.name}", DRAWN_WITHIN)
        self._model = None
        if self._renderer is None:
            self._renderer = self._make(model, backend)
            # In a user's program nothing closes the thread before the GL libraries' own functions at exit, which run
            # later than this one because they were registered earlier.
            atexit.register(self._close)
        else:
            self._renderer.turn_to(model)
        self._model = model
        return self._renderer

    def rest(self) -> None:
        """Free memory that the next image does not need."""
        if self._renderer is None:
            return
        self._start("giving memory back", DRAWN_WITHIN)
        try:
            self._renderer.rest()
        except Exception as error:
            logger.warning("a renderer could not give memory back, so a new one is made: %s", error)
            self.drop()

    def drop(self) -> None:
        """Close the renderer; the next image makes a new one."""
        renderer, self._renderer, self._model = self._renderer, None, None
        if renderer is None:
            return
        try:
            renderer.close()
        except Exception:
            # After a failure of the driver closing may fail too; a new context does not depend on it.
            logger.exception("a renderer did not close cleanly")
