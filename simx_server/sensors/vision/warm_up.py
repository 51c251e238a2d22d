"""Have pictures ready before somebody asks: when a scene with vision sensors is loaded, or gets its first one.

Only then, since OpenGL costs memory and a few tenths of a second of a core. Later changes of a scene need no
more than its own meshes and textures once again, so what a script edits step by step is not drawn each time.
"""

from __future__ import annotations

from concurrent.futures import Future
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation


def warm_up(sim: Simulation) -> Future[None] | None:
    """Draw each vision sensor of a scene once, on the render thread; None if there is none. Physics thread only."""
    if not sim.scene.of_kind(ObjectKind.VISION_SENSOR):
        return None
    sim.refresh()
    try:
        views = sim.vision.views()
    except CommandError:  # who asks for that picture is told
        views = []
    return sim.rendering.prepare(sim.model, sim.data, views, version=sim.version)


def keep_warm(sim: Simulation) -> None:
    """From now on: warm up for every other scene, and when there is a first vision sensor."""

    def on_model_changed() -> None:
        if not sim.rendering.is_begun:
            warm_up(sim)

    sim.on_load.append(lambda: warm_up(sim))
    sim.on_model_changed.append(on_model_changed)
