"""Bounding boxes of objects and models, in their own frames (V-REP's parameters 15 to 26).

The box of a model is around the boxes of its objects, as in V-REP: where these are turned, it is larger than the
objects. The boxes of sensors contain what they sense; in CoppeliaSim since 4.3 they do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol import constants as c
from simx_server.editing.object_flags import flags
from simx_server.errors import CommandError
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import compose, inverse, matrix

from .own_boxes import own_box

if TYPE_CHECKING:
    from simx_server.world.world import World

Box = tuple[list[float], list[float]]
"""Least and greatest x, y, z in metres."""

_NOT_INSIDE_MODEL = 0x400
"""`sim_modelproperty_not_showasinsidemodel`, which the legacy constants lack."""

_CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
_AXES = np.arange(3)


def of_object(world: World, handle: int, *, whole_model: bool = False, with_volumes: bool = True) -> Box:
    """Return the box of an object alone, or of its whole model: of everything below it too.

    Objects with the flag `sim_objectproperty_dontshowasinsidemodel` do not count for a model, nor do models below that
    have the property `sim_modelproperty_not_showasinsidemodel`.

    Args:
        world: the world.
        handle: the object.
        whole_model: whether the box is that of the model.
        with_volumes: whether the boxes of sensors contain what they sense.

    Raises:
        UnknownHandle: the handle is unknown.
        CommandError: nothing there has a box.
    """
    sim = world.simulation
    item, instant = sim.scene.get(handle), world.instants.now()
    if not whole_model:
        box = own_box(world, instant, item, with_volumes=with_volumes)
        if box is None:
            raise CommandError(f"'{item.name}', a {item.kind.text} without a form, has no bounding box here")
        return box[0].tolist(), box[1].tolist()
    corners: list[NDArray[np.float64]] = []
    back = inverse(frames.get_pose(sim, handle))
    for each in _inside_model(world, handle):
        box = own_box(world, instant, sim.scene.objects[each], with_volumes=with_volumes)
        if box is not None:
            place, turn = compose(back, frames.get_pose(sim, each))
            corners.append(corners_of(box) @ np.array(matrix(turn)).T + place)
    if not corners:
        raise CommandError(f"no object of the model '{item.name}' counts for its bounding box")
    all_corners = np.concatenate(corners)
    return all_corners.min(axis=0).tolist(), all_corners.max(axis=0).tolist()


def _inside_model(world: World, base: int) -> Iterator[int]:
    """Yield the objects that count for the box of a model."""
    scene, waiting = world.simulation.scene, [base]
    while waiting:
        handle = waiting.pop()
        if handle != base and scene.own_model_bits(handle) & _NOT_INSIDE_MODEL:
            continue
        if not flags(world, handle) & c.sim_objectproperty_dontshowasinsidemodel:
            yield handle
        waiting += scene.children(handle)


def corners_of(box: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (8, 3) the corners of a box."""
    return box[_CORNERS, _AXES]
