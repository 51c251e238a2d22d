"""Prepare images in advance: when the first client joins, and when a scene with vision sensors is loaded or gets its
first one. A program that gets the handle of a vision sensor waits for them. One of many servers, and an embedded
simulation, prepare them with that handle, so that those without such programs stay small.

The first image of a scene costs up to a second: the driver, meshes, textures. V-REP had its renderer when a client
came: programs arm a stream of images, sleep 0.1 s and read it. A scene without vision sensors makes no
renderer, which would take 80 MB; nor does a server without clients. Later changes of a scene need only its own meshes
and textures again, so a script's step-by-step edits are not drawn each time.

A server that records prepares images before it is ready instead, because a replay waits for none.
"""

from __future__ import annotations

import time
from concurrent.futures import Future
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.service.calls.background import Steps, Task, beside
from simx_server.service.watcher import Watcher

if TYPE_CHECKING:
    from collections.abc import Callable

    from simx_server.scene.editing.twins import Twins
    from simx_server.sensors.rendering.render_thread import RenderThread
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.world.world import World

WARM_WITHIN = 10.0
"""Seconds that a starting server which records waits for the images of a slow driver or renderer."""

LOADED_WITHIN = 2.0
"""The same for a client's call that loads a scene or a model, which has a time-out."""

_GLANCE = 0.05
"""Seconds between two checks of a preparation."""


def warm_up(world: World) -> Future[None] | None:
    """Draw each vision sensor of a scene once, on the render thread; None if there is none. Physics thread only."""
    sim = world.simulation
    if not sim.scene.of_kind(ObjectKind.VISION_SENSOR):
        return None
    sim.refresh()
    try:
        views = world.vision.views()
    except CommandError:  # a request for that image reports the error
        views = []
    return world.rendering.prepare(sim.model, sim.data, views, version=sim.version)


def wait_until_warm(
    rendering: RenderThread, is_ending: Callable[[], bool], seconds: float = WARM_WITHIN
) -> None:
    """Wait until images are prepared, fail because the driver hangs, or take too long.

    Args:
        rendering: the render thread.
        is_ending: whether to give up.
        seconds: time-out.
    """
    limit = time.monotonic() + seconds
    while not rendering.wait_until_prepared(_GLANCE):
        rendering.watch()
        if is_ending() or rendering.is_hanging or time.monotonic() > limit:
            return


def warmed(world: World) -> Steps[None]:
    """Wait, beside the physics thread, until the images of what a client has loaded are prepared."""
    rendering, sim = world.rendering, world.simulation
    if not rendering.wait_until_prepared(0):
        yield from beside(lambda: wait_until_warm(rendering, lambda: sim.is_ending, LOADED_WITHIN))
    # A replay prepares no images, and executes the calls of others during the wait here too.
    sim.interruptions.script_point()


def with_images(world: World, handle: int) -> int | Steps[int]:
    """Return a handle for a program, of a vision sensor after its images are prepared, where that is due."""
    rendering, scene = world.rendering, world.simulation.scene
    if not rendering.warms_on_demand or scene.get(handle).kind is not ObjectKind.VISION_SENSOR:
        return handle
    if not rendering.is_begun:
        warm_up(world)
    return handle if rendering.wait_until_prepared(0) else _when_warm(world, handle)


def _when_warm(world: World, handle: int) -> Steps[int]:
    """Wait beside the physics thread; a stream, which cannot wait, goes on at once."""
    rendering, sim = world.rendering, world.simulation
    yield Task(
        lambda: wait_until_warm(rendering, lambda: sim.is_ending, LOADED_WITHIN),
        lambda: None,
        may_be_skipped=True,
    )
    return handle


class RenderWatch(Watcher):
    """Watches the render thread, whose driver may hang."""

    def __init__(self, rendering: RenderThread) -> None:
        self._rendering = rendering

    def look(self) -> None:
        self._rendering.watch()


class WarmUp(Watcher):
    """Warms up for the scene that the first client finds, for every later one, and for a scene's first vision sensor.

    Until then only the back end is chosen, and the log says how images are made.
    """

    def __init__(self, world: World, *, at_once: bool = False) -> None:
        """Start to watch.

        Args:
            world: the server's.
            at_once: warm up without waiting for a client.
        """
        self._world = world
        self._is_wanted = at_once
        self.scene_loaded()

    def joined(self, session: ClientSession) -> None:
        if not self._is_wanted:
            self._is_wanted = True
            warm_up(self._world)

    def scene_loaded(self) -> None:
        if self._is_wanted:
            warm_up(self._world)
        elif self._world.simulation.scene.of_kind(ObjectKind.VISION_SENSOR):
            self._world.rendering.choose()

    def model_changed(self, twins: Twins | None) -> None:
        if not self._world.rendering.is_begun:
            self.scene_loaded()
