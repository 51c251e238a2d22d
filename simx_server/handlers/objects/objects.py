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
    from simx_server.world.simulation import Simulation

HANDLE_ALL = -2
_ASSEMBLY_FLAG = 0x400000

_LEAST_DUMMY, _LARGEST_DUMMY = 1e-4, 999.0
"""Metres; MuJoCo's sites need a size."""


@handler("simxGetObjectHandle")
def get_object_handle(sim: Simulation, name: str) -> int:
    """Raises UnknownName, which lists the nearest names."""
    return sim.scene.resolve(name)


@handler("simxGetObjects")
def get_objects(sim: Simulation, object_type: int) -> list[int]:
    """A type that nothing has gives an empty list, never an error."""
    if object_type == HANDLE_ALL:
        return list(sim.scene.objects)
    return sim.scene.of_kind(object_type)


@handler("simxGetObjectParent", with_client=True)
def get_object_parent(sim: Simulation, client: ClientSession, child: int) -> int:
    """An unknown handle gives -1; only the error texts tell it from a top-level object."""
    try:
        return sim.scene.get(child).parent
    except UnknownHandle as problem:
        _tell(sim, client, f"simxGetObjectParent: {problem}")
        return -1


def _tell(sim: Simulation, client: ClientSession, text: str) -> None:
    """Errors that are no remote error: they are told as all others are."""
    if sim.parameters.error_report_mode & c.sim_api_errormessage_report:
        client.errors.append(text)


@handler("simxGetObjectChild", with_client=True)
def get_object_child(sim: Simulation, client: ClientSession, parent: int, index: int) -> int:
    """-1 after the last child, and for an unknown handle."""
    try:
        sim.scene.get(parent)
    except UnknownHandle as problem:
        _tell(sim, client, f"simxGetObjectChild: {problem}")
        return -1
    children = sim.scene.children(parent)
    return children[index] if 0 <= index < len(children) else -1


@handler("simxSetObjectParent")
def set_object_parent(sim: Simulation, handle: int, parent: int, keep_in_place: bool) -> None:
    """Parent -1 is the world.

    Differs: without the predefined assembly that V-REP does when 0x400000 is added and the place is not kept.
    """
    if handle > 0 and handle & _ASSEMBLY_FLAG:
        if not keep_in_place:
            raise CommandError(
                "predefined assembly (handle + 0x400000) is not available; place the object, then set its parent"
            )
        handle &= ~_ASSEMBLY_FLAG
    editing.set_parent(sim, handle, parent, keep_in_place)
    sim.object_settings.apply_masks()


@handler("simxRemoveObject")
def remove_object(sim: Simulation, handle: int) -> None:
    """`sim_handle_all` empties the scene.

    Differs: what was removed while running is there again after the stop, as everything else is.
    """
    if handle == HANDLE_ALL:
        editing.remove_all(sim)
    else:
        editing.remove_object(sim, handle)
        sim.object_settings.apply_masks()


@handler("simxRemoveModel")
def remove_model(sim: Simulation, handle: int) -> None:
    """Only an object marked as a model base can be removed so."""
    editing.remove_model(sim, handle)


@handler("simxCopyPasteObjects")
def copy_paste_objects(sim: Simulation, handles: list[int]) -> list[int]:
    """Unknown handles are skipped, the selection stays. A stop removes the objects that the run copied."""
    return copy_objects(sim, handles)


@handler("simxCreateDummy")
def create_dummy(sim: Simulation, size: float, color: list[int] | None) -> int:
    """A dummy at the origin, gone after the stop when a run created it; pictures do not show dummies.

    Any size is taken, as in V-REP; scripts that want a mere point say 0.
    """
    return editing.create_dummy(sim, min(max(size, _LEAST_DUMMY), _LARGEST_DUMMY), color)


@handler("simxGetModelProperty")
def get_model_property(sim: Simulation, handle: int) -> int:
    """The bits of a model base; 0xF000 for any other object."""
    return sim.scene.model_property(handle)


@handler("simxSetModelProperty")
def set_model_property(sim: Simulation, handle: int, bits: int) -> None:
    """Any bit of 0xF000 makes the object a model base no more."""
    properties.set_model_property(sim, handle, bits)


@handler("simxGetObjectSelection")
def get_object_selection(sim: Simulation) -> list[int]:
    """Handles in order of selection; objects that have gone meanwhile are left out."""
    return [handle for handle in sim.selection if handle in sim.scene.objects]


@handler("simxSetObjectSelection")
def set_object_selection(sim: Simulation, handles: list[int]) -> None:
    """Handles of no object are ignored, as in V-REP."""
    known = dict.fromkeys(handle for handle in handles if handle in sim.scene.objects)
    sim.selection = list(known)
