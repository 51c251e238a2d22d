"""Objects: names, handles, the tree, removal, selection."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.errors import CommandError, UnknownHandle
from simx_server.handlers.registry import handler
from simx_server.scene import properties
from simx_server.scene.editing import editing
from simx_server.scene.editing.copying import copy_objects

if TYPE_CHECKING:
    from simx_server.runtime.sessions import ClientSession
    from simx_server.world.world import World

HANDLE_ALL = -2
_ASSEMBLY_FLAG = 0x400000

_LEAST_DUMMY, _LARGEST_DUMMY = 1e-4, 999.0
"""Metres; MuJoCo's sites need a size."""


@handler("simxGetObjectHandle")
def get_object_handle(world: World, name: str) -> int:
    """Raises UnknownName, which lists the nearest names."""
    sim = world.simulation
    return sim.scene.resolve(name)


@handler("simxGetObjects")
def get_objects(world: World, object_type: int) -> list[int]:
    """A type that nothing has gives an empty list, never an error."""
    sim = world.simulation
    if object_type == HANDLE_ALL:
        return list(sim.scene.objects)
    return sim.scene.of_kind(object_type)


@handler("simxGetObjectParent", with_client=True)
def get_object_parent(world: World, client: ClientSession, child: int) -> int:
    """An unknown handle gives -1; only the error texts tell it from a top-level object."""
    sim = world.simulation
    try:
        return sim.scene.get(child).parent
    except UnknownHandle as problem:
        _tell(world, client, f"simxGetObjectParent: {problem}")
        return -1


def _tell(world: World, client: ClientSession, text: str) -> None:
    """Errors that are no remote error: they are told as all others are."""
    if world.parameters.error_report_mode & c.sim_api_errormessage_report:
        client.errors.append(text)


@handler("simxGetObjectChild", with_client=True)
def get_object_child(world: World, client: ClientSession, parent: int, index: int) -> int:
    """-1 after the last child, and for an unknown handle."""
    sim = world.simulation
    try:
        sim.scene.get(parent)
    except UnknownHandle as problem:
        _tell(world, client, f"simxGetObjectChild: {problem}")
        return -1
    children = sim.scene.children(parent)
    return children[index] if 0 <= index < len(children) else -1


@handler("simxSetObjectParent")
def set_object_parent(world: World, handle: int, parent: int, keep_in_place: bool) -> None:
    """Parent -1 is the world.

    Differs: without the predefined assembly that V-REP does when 0x400000 is added and the place is not kept.
    """
    sim = world.simulation
    if handle > 0 and handle & _ASSEMBLY_FLAG:
        if not keep_in_place:
            raise CommandError(
                "predefined assembly (handle + 0x400000) is not available; place the object, then set its parent"
            )
        handle &= ~_ASSEMBLY_FLAG
    editing.set_parent(sim, handle, parent, keep_in_place)
    world.object_settings.apply_masks()


@handler("simxRemoveObject")
def remove_object(world: World, handle: int) -> None:
    """`sim_handle_all` empties the scene.

    Differs: what was removed while running is there again after the stop, as everything else is.
    """
    sim = world.simulation
    if handle == HANDLE_ALL:
        editing.remove_all(sim)
    else:
        editing.remove_object(world.simulation, handle)
        world.object_settings.apply_masks()


@handler("simxRemoveModel")
def remove_model(world: World, handle: int) -> None:
    """Only an object marked as a model base can be removed so."""
    editing.remove_model(world.simulation, handle)


@handler("simxCopyPasteObjects")
def copy_paste_objects(world: World, handles: list[int]) -> list[int]:
    """Unknown handles are skipped, the selection stays. A stop removes the objects that the run copied."""
    return copy_objects(world, handles)


@handler("simxCreateDummy")
def create_dummy(world: World, size: float, color: list[int] | None) -> int:
    """A dummy at the origin, gone after the stop when a run created it; pictures do not show dummies.

    Any size is taken, as in V-REP; scripts that want a mere point say 0.
    """
    return editing.create_dummy(world.simulation, min(max(size, _LEAST_DUMMY), _LARGEST_DUMMY), color)


@handler("simxGetModelProperty")
def get_model_property(world: World, handle: int) -> int:
    """The bits of a model base; 0xF000 for any other object."""
    sim = world.simulation
    return sim.scene.model_property(handle)


@handler("simxSetModelProperty")
def set_model_property(world: World, handle: int, bits: int) -> None:
    """Any bit of 0xF000 makes the object a model base no more."""
    properties.set_model_property(world.simulation, handle, bits)


@handler("simxGetObjectSelection")
def get_object_selection(world: World) -> list[int]:
    """Handles in order of selection; objects that have gone meanwhile are left out."""
    sim = world.simulation
    return [handle for handle in world.selection.handles if handle in sim.scene.objects]


@handler("simxSetObjectSelection")
def set_object_selection(world: World, handles: list[int]) -> None:
    """Handles of no object are ignored, as in V-REP."""
    sim = world.simulation
    known = dict.fromkeys(handle for handle in handles if handle in sim.scene.objects)
    world.selection.handles = list(known)
