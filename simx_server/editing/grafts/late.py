"""Whether objects that are added may wait for the compile; see `scene/editing/waiting`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.world.world import World

    from .grafting import Graft

_SCRIPT = ObjectKind.SCRIPT.name.lower()


def may_wait(world: World, addition: Graft) -> bool:
    """Return whether nothing has to read the model at once because of these objects.

    Scripts start with their objects, and may read anything. Masks that keep pairs of bodies apart are in the model.
    """
    for notes in addition.annotations.values():
        if not notes.keys().isdisjoint(SCRIPT_NOTES) or notes.get("object", {}).get("type") == _SCRIPT:
            return False
        if "pair_mask" in notes.get("shape", {}):
            return False
    return world.simulation.waiting is not None or not world.object_settings.masks_keep_bodies_apart
