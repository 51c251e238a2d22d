"""Prepare images in advance: when the first client joins, and when a scene with vision sensors is loaded or gets its
first one.

Only then, since OpenGL costs 80 MB and a few tenths of a second of a core. Later changes of a scene need only its
own meshes and textures again, so a script's step-by-step edits are not drawn each time.
"""

from __future__ import annotations

from concurrent.futures import Future
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.world.part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.world.world import World


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


class WarmUp(Part):
    """Warms up when the first client joins; then for every scene that is loaded, and for a scene's first vision
    sensor.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._had_client = False

    def client_joined(self) -> None:
        """Warm up for the first client of this server."""
        if not self._had_client:
            self._had_client = True
            warm_up(self._world)

    def scene_loaded(self) -> None:
        if self._had_client:
            warm_up(self._world)

    def model_changed(self, twins: Twins | None) -> None:
        if self._had_client and not self._world.rendering.is_begun:
            warm_up(self._world)
