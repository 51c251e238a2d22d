"""Objects: names, handles, the tree, removal, selection."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.errors import CommandError, UnknownHandle
from simx_server.parts.communication.simulator_messages import SELECTION_CHANGED
from simx_server.scene import properties
from simx_server.scene.editing import editing, renaming
from simx_server.scene.editing.waiting.removing import remove_shape
from simx_server.service.calls.background import Steps
from simx_server.service.calls.registry import handler
from simx_server.service.warm_up import with_images

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.world.world import World

HANDLE_ALL = -2
_ASSEMBLY_FLAG = 0x400000

_LEAST_DUMMY, _LARGEST_DUMMY = 1e-4, 999.0
"""Limits of a dummy's size in metres; MuJoCo's sites need a size."""


@handler("simxGetObjectHandle")
def get_object_handle(world: World, name: str) -> int | Steps[int]:
    """Raises UnknownName, which lists the nearest names."""
    return with_images(world, world.simulation.scene.resolve(name))


@handler("simxGetObjects")
def get_objects(world: World, object_type: int) -> list[int]:
    """Return an empty list, not an error, for a type without objects."""
    sim = world.simulation
    if object_type == HANDLE_ALL:
        return list(sim.scene.objects)
    return sim.scene.of_kind(object_type)


@handler("simxGetObjectParent", with_client=True)
def get_object_parent(world: World, client: ClientSession, child: int) -> int:
    """Return -1 for an unknown handle too; only the error texts distinguish it from a top-level object."""
    try:
        return world.simulation.scene.get(child).parent
    except UnknownHandle as problem:
        _tell(world, client, f"simxGetObjectParent: {problem}")
        return -1


def _tell(world: World, client: ClientSession, text: str) -> None:
    """Report an error that is not a remote error the same way as all others."""
    if world.parameters.error_report_mode & c.sim_api_errormessage_report:
        client.errors.append(text)


@handler("simxGetObjectChild", with_client=True)
def get_object_child(world: World, client: ClientSession, parent: int, index: int) -> int:
    """Return -1 for an unknown handle too."""
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
    """Accept -1 as parent for the world.

    Differs: predefined assembly is not supported; V-REP assembles when 0x400000 is added and the place is not kept.
    """
    if handle > 0 and handle & _ASSEMBLY_FLAG:
        if not keep_in_place:
            raise CommandError(
                "predefined assembly (handle + 0x400000) is not available; place the object, then set its parent"
            )
        handle &= ~_ASSEMBLY_FLAG
    editing.set_parent(world.simulation, handle, parent, keep_in_place)
    world.object_settings.apply_masks()


@handler("simxRemoveObject")
def remove_object(world: World, handle: int) -> None:
    """Empty the scene for `sim_handle_all`.

    Differs: objects removed while running return after the stop, as everything else does.
    """
    objects = world.simulation.scene.objects
    if handle == HANDLE_ALL:
        world.scripts.phases.objects.before_removal(list(objects))
        editing.remove_all(world.simulation)
    else:
        if handle in objects:
            world.scripts.phases.objects.before_removal([handle])
        if _remove_waiting(world, handle):
            return
        editing.remove_object(world.simulation, handle)
        world.object_settings.apply_masks()


def _remove_waiting(world: World, handle: int) -> bool:
    """Remove a shape from a model that is compiled later; return False if it has to be compiled at once."""
    sim, settings = world.simulation, world.object_settings
    if sim.waiting is None and settings.masks_keep_bodies_apart:
        return False
    if not remove_shape(sim, handle):
        return False
    settings.apply_masks()
    return True


@handler("simxRemoveModel")
def remove_model(world: World, handle: int) -> None:
    """Accept only an object that is marked as a model base."""
    scene = world.simulation.scene
    if handle in scene.objects and scene.is_model_base(handle):
        world.scripts.phases.objects.before_removal([handle, *scene.descendants(handle)])
    editing.remove_model(world.simulation, handle)


@handler("renameObject")
def rename_object(world: World, handle: int, name: str) -> None:
    """Refuse a name that another object has. The stop undoes it in a run."""
    renaming.rename(world.simulation, handle, name)


@handler("simxCopyPasteObjects")
def copy_paste_objects(world: World, handles: list[int]) -> list[int]:
    """Skip unknown handles and keep the selection. The stop removes copies made during the run."""
    from simx_server.editing.copying import copy_objects  # most servers are not edited

    return copy_objects(world, handles)


@handler("simxCreateDummy")
def create_dummy(world: World, size: float, color: list[int] | None) -> int:
    """Accept any size, as V-REP does; scripts that want a mere point pass 0.

    Images do not show dummies. The stop removes dummies created during the run.
    """
    return editing.create_dummy(world.simulation, min(max(size, _LEAST_DUMMY), _LARGEST_DUMMY), color)


@handler("simxGetModelProperty")
def get_model_property(world: World, handle: int) -> int:
    """Return 0xF000 for an object that is not a model base."""
    return world.simulation.scene.model_property(handle)


@handler("simxSetModelProperty")
def set_model_property(world: World, handle: int, bits: int) -> None:
    """Make the object an ordinary one if any bit of 0xF000 is set."""
    properties.set_model_property(world.simulation, handle, bits)


@handler("simxGetObjectSelection")
def get_object_selection(world: World) -> list[int]:
    """Return handles in order of selection, without objects removed since."""
    return [handle for handle in world.selection.handles if handle in world.simulation.scene.objects]


@handler("simxSetObjectSelection")
def set_object_selection(world: World, handles: list[int]) -> None:
    """Ignore unknown handles, as V-REP does."""
    known = dict.fromkeys(handle for handle in handles if handle in world.simulation.scene.objects)
    if world.selection.handles == list(known):
        return
    world.selection.handles = list(known)
    world.simulator_messages.post(SELECTION_CHANGED)
    world.scripts.tell("sysCall_selChange", {"sel": list(known)})
