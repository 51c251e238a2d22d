"""A second thread that renders waiting images beside the render thread, in an OpenGL context of its own.

Software OpenGL computes the vertices of an image, two thirds of its work, in the thread that draws. So a program that
reads several cameras in each step gets its images sooner from two threads, where a second processor is free. The second
context holds all meshes and textures again (20 MB for an arm on a table), so the thread ends some seconds after it was
last needed.
"""

from __future__ import annotations

import contextlib
import functools
import logging
import os
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

import mujoco

from simx_server.scene.cameras.image import Renderer

logger = logging.getLogger(__name__)

ENDS_AFTER = 5.0
"""Seconds without an image after which the thread ends and frees its context."""

_OWNER_CHECK = 1.0

J = TypeVar("J")


def has_second_processor() -> bool:
    """Return whether this process may use two processors."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) > 1
    return (os.cpu_count() or 1) > 1


class SecondThread(Generic[J]):
    """Takes images from the render thread's queue while there are any. `start` and `take` need its lock."""

    def __init__(
        self,
        wake: threading.Condition,
        take: Callable[[], tuple[J, mujoco.MjModel] | None],
        make: Callable[[mujoco.MjModel], Renderer],
        draw: Callable[[J, Callable[[], Renderer]], None],
        is_ending: Callable[[], bool],
    ) -> None:
        """Make it without a thread.

        Args:
            wake: the lock of the queue, which is notified of new images.
            take: returns the next image that this thread may make, with its model.
            make: returns a renderer.
            draw: makes an image with a renderer that it gets from a function, and gives it, or the error, to the
                caller who asked for it; raises the errors of the renderer too.
            is_ending: returns whether the thread is to end.
        """
        self._wake, self._take, self._make, self._draw = wake, take, make, draw
        self._is_ending = is_ending
        self._thread: threading.Thread | None = None
        self._has_failed = False
        self.job: J | None = None
        """The image in progress."""

        self.since = 0.0
        """When that image was begun, on the monotonic clock."""

    @property
    def is_usable(self) -> bool:
        """Return whether it may be started: it has not failed."""
        return not self._has_failed

    def start(self, model: mujoco.MjModel) -> None:
        """Start the thread unless it runs; it makes a renderer for a model, and then takes images."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, args=(model,), name="simx-render-2")
            self._thread.start()

    def give_up(self) -> None:
        """Use this thread no more: its driver hangs. The image in progress is the caller's to fail."""
        self.job, self._has_failed = None, True

    def join(self, seconds: float) -> None:
        """Wait until the thread has ended, at most this many seconds."""
        thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(seconds)

    def _run(self, drawn: mujoco.MjModel) -> None:
        try:
            renderer = self._make(drawn)
        except Exception as error:
            self._has_failed = True
            logger.warning("images are made by one thread from now on: %s", error)
            return

        def turned_to(model: mujoco.MjModel) -> Renderer:
            nonlocal drawn
            if model is not drawn:
                renderer.turn_to(model)
                drawn = model
            return renderer

        try:
            while (found := self._next()) is not None:
                job, model = found
                self._draw(job, functools.partial(turned_to, model))
        except Exception as error:
            # The next backlog starts a new one; a driver that is lost fails there, or in the render thread.
            logger.debug("the second thread ends: %s", error)
        finally:
            with contextlib.suppress(Exception):  # a context that is lost cannot be closed
                renderer.close()
            with self._wake:
                self._thread, self.job = None, None

    def _next(self) -> tuple[J, mujoco.MjModel] | None:
        """Wait for the next image; return None when the thread is to end."""
        with self._wake:
            end = time.monotonic() + ENDS_AFTER
            self.job = None
            while not self._is_ending() and self.is_usable:
                if (found := self._take()) is not None:
                    self.job, self.since = found[0], time.monotonic()
                    return found
                if time.monotonic() > end:
                    break
                self._wake.wait(_OWNER_CHECK)
            return None
