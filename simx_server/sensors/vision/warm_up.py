"""Prepare images in advance: when a scene with vision sensors is loaded, or gets its first one.

Only then, since OpenGL costs memory and a few tenths of a second of a core. Later changes of a scene need only its
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
    """Warms up for every scene that is loaded, and when a scene gets its first vision sensor."""

    def __init__(self, world: World) -> None:
        self._world = world

    def scene_loaded(self) -> None:
        warm_up(self._world)

    def model_changed(self, twins: Twins | None) -> None:
        if not self._world.rendering.is_begun:
            warm_up(self._world)
