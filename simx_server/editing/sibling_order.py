"""Change the place of an object among the children of its parent."""

from __future__ import annotations

from simx_server.errors import CommandError
from simx_server.scene.editing.renaming import annotate
from simx_server.scene.live import LiveScene


def place_among_siblings(sim: LiveScene, handle: int) -> int:
    """Return the place of an object among the children of its parent, from 0. Raises UnknownHandle."""
    return sim.scene.children(sim.scene.get(handle).parent).index(handle)


def move_among_siblings(sim: LiveScene, handle: int, place: int) -> None:
    """Move an object to a place among the children of its parent, from 0. Raises UnknownHandle, CommandError."""
    siblings = sim.scene.children(sim.scene.get(handle).parent)
    if not 0 <= place < len(siblings):
        raise CommandError(
            f"the object has a place from 0 to {len(siblings) - 1} among its siblings, not {place}"
        )
    siblings.remove(handle)
    siblings.insert(place, handle)
    for number, each in enumerate(siblings):
        annotate(sim, each, "object", {"sibling": number})
    sim.scene.reindex()
