"""Fit a camera to objects: its direction stays, and its image shows all of them, as large as possible."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.editing.object_flags import flags
from simx_server.errors import CommandError
from simx_server.scene.cameras.image import CameraView
from simx_server.scene.objects import NOT_A_MODEL
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import matrix

from .bounding_box import corners_of, of_object
from .poses import set_object_position

if TYPE_CHECKING:
    from simx_server.world.world import World

Points = NDArray[np.float64]

WINDOW, SQUARE = (455, 256), (256, 256)
"""Proportions of an image: those of V-REP's window without a screen, and 1 by 1."""

_IGNORED = 1
"""`sim_objectproperty_ignoreviewfitting`."""

_WIDEST = math.pi * 0.99
_BEYOND = 1.01
"""Distance of the far clipping plane over that of the farthest point, where it would hide something."""


def fit(
    world: World,
    camera: int,
    handles: Sequence[int],
    proportions: tuple[int, int],
    *,
    with_models: bool,
    scaling: float,
) -> None:
    """Move a camera, or resize its view if it is orthographic.

    Args:
        world: the world.
        camera: its handle.
        handles: the objects; if none of them is visible, all that the scene shows.
        proportions: width and height of the image.
        with_models: whether a model base stands for its model.
        scaling: of the opening angle.

    Raises:
        UnknownHandle: no such object.
        CommandError: a scaling that cannot be, or nothing to see.
    """
    if not 0.0 < scaling < math.inf:
        raise CommandError(f"a scaling is a number above 0, not {scaling:g}")
    sim = world.simulation
    wanted = list(handles)
    if with_models:
        bases = [handle for handle in handles if sim.scene.model_property(handle) != NOT_A_MODEL]
        wanted += [each for base in bases for each in sim.scene.descendants(base)]
    points = _points(world, [each for each in wanted if _counts(world, each) and each != camera])
    if not len(points):
        points = _points(
            world, [each for each in sim.scene.objects if _counts(world, each) and each != camera]
        )
    if not len(points):
        raise CommandError("the scene has nothing to which a camera could be fitted")
    view = world.vision.view(camera, proportions)
    eye, turn = view.pose(sim.data)
    own = (points - eye) @ turn
    if view.orthographic_size is None:
        shift = _perspective(own, view, scaling)
    else:
        shift, size = _orthographic(own, view)
        world.vision.change(camera, size=size / scaling)
    farthest = float((shift[2] - own[:, 2]).max())
    if farthest > view.far:
        world.vision.change(camera, far=farthest * _BEYOND)
    origin, _ = frames.get_pose(sim, camera)
    set_object_position(world, camera, -1, (np.array(origin) + turn @ shift).tolist())


def _counts(world: World, handle: int) -> bool:
    return world.object_settings.is_visible(handle) and not flags(world, handle) & _IGNORED


def _points(world: World, handles: Sequence[int]) -> Points:
    """Return (n, 3) the corners of the boxes of objects in the world; those without one have none."""
    found = [np.zeros((0, 3))]
    for handle in dict.fromkeys(handles):
        try:
            low, high = of_object(world, handle, with_volumes=False)
        except CommandError:
            continue
        place, turn = frames.get_pose(world.simulation, handle)
        corners = corners_of(np.array([low, high])) @ np.array(matrix(turn)).T + place
        if np.isfinite(corners).all():
            found.append(corners)
    return np.concatenate(found)


def _perspective(points: Points, view: CameraView, scaling: float) -> Points:
    """Return by how much the eye has to move, in its frame: x to the right, y up, z backward.

    The border planes of the image touch the outermost points.
    """
    wide, high = (math.tan(min(_WIDEST, 2 * math.atan(half) * scaling) / 2) for half in view.half_extent())
    sideways, back_x = _between(points[:, 0], points[:, 2], wide)
    up, back_y = _between(points[:, 1], points[:, 2], high)
    # Nothing may come before the near clipping plane.
    return np.array([sideways, up, max(back_x, back_y, float(points[:, 2].max()) + view.near)])


def _between(across: Points, back: Points, half: float) -> tuple[float, float]:
    """Return where the eye is in a direction, and how far back, if both border planes touch points."""
    low, high = float((-across + half * back).max()), float((across + half * back).max())
    return (high - low) / 2, (high + low) / (2 * half)


def _orthographic(points: Points, view: CameraView) -> tuple[Points, float]:
    """Return by how much the eye has to move, and the size of its view in metres."""
    least, greatest = points.min(axis=0), points.max(axis=0)
    half_width, half_height = view.half_extent()
    assert view.orthographic_size is not None
    share = max((greatest[0] - least[0]) / half_width, (greatest[1] - least[1]) / half_height) / 2
    middle = (least + greatest) / 2
    back = max(0.0, float(greatest[2]) + view.near)
    return np.array([middle[0], middle[1], back]), max(1e-3, float(share) * view.orthographic_size)
