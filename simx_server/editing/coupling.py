"""Let a joint that starts to follow another one exchange forces with it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.scene.dependencies import add_equality
from simx_server.scene.editing.recompile import edit

if TYPE_CHECKING:
    from simx_server.world.world import World


def couple(world: World, handle: int) -> None:
    """Give a joint that follows another one the equality of `scene/dependencies.py`, if it has none."""
    sim = world.simulation
    if not sim.joints.is_coupled(handle):
        item = sim.scene.get(handle)
        edit(sim, lambda spec: add_equality(spec, item.element_name), set())
