"""The content of a scene, which its first view should show: everything that users see, except the ground.

A V-REP model stands on a floor of 5 m; in an image of the whole floor, a robot of 10 cm has a dozen pixels.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.cameras.image import CameraView, Viewpoint
from simx_server.scene.cameras.visibility import near_the_view, seen_by_users

_FLAT = 0.1
"""Height of a ground as a share of its narrower side, at most."""

_WIDE = 0.5
"""Narrower side of a ground as a share of the scene's extent, at least."""

_FILLED = 0.25
"""Share of an image's height or width that the content must fill at least; otherwise the eye comes nearer."""

_MARGIN = 1.15
"""Distance of the eye over the one at which the content touches the border of the image."""

_SMALLEST = 1e-3
"""Least radius in metres of a content."""

Vectors = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Content:
    """A box along the world's axes around what there is to see."""

    low: Vectors
    high: Vectors

    @property
    def centre(self) -> Vectors:
        """Return the middle, metres, shape (3,)."""
        return (self.low + self.high) / 2

    @property
    def radius(self) -> float:
        """Return the radius of the sphere around the box, metres."""
        return max(_SMALLEST, float(np.linalg.norm(self.high - self.low)) / 2)

    def distance(self, forward: Vectors, half_extent: tuple[float, float]) -> float:
        """Return how far from the centre an eye has to be to see all of the box, metres.

        Args:
            forward: unit vector, the direction of view.
            half_extent: tangents of half the opening angles across and up.
        """
        right, up = _across(forward)
        corners = np.array(np.meshgrid(*zip(self.low, self.high, strict=True))).reshape(3, -1).T - self.centre
        depth = corners @ forward
        needed = [
            np.abs(corners @ axis) / half - depth for axis, half in zip((right, up), half_extent, strict=True)
        ]
        return max(_SMALLEST, float(np.max(needed))) * _MARGIN


def content_of(model: mujoco.MjModel, data: mujoco.MjData) -> Content | None:
    """Return the content of a scene; its ground where there is nothing else, None where there is nothing to see."""
    low, high = geom_boxes(model, data)
    chosen = _things(model, low, high)
    return Content(low[chosen].min(axis=0), high[chosen].max(axis=0)) if chosen.any() else None


def framed(
    model: mujoco.MjModel, data: mujoco.MjData, view: CameraView, free: CameraView, *, whole: bool = False
) -> Viewpoint | None:
    """Return a viewpoint that shows the content, None where a view shows it already.

    Args:
        model: the model.
        data: its state, with forward kinematics done.
        view: a perspective view; its direction is kept where it sees a part of the content.
        free: a view from a viewpoint, which can be elsewhere; gives the direction otherwise.
        whole: whether the image shall show all of the content, as large as possible.
    """
    content = content_of(model, data)
    far = free.viewpoint
    if content is None or far is None or view.orthographic_size is not None:
        return None
    eye, turn = view.pose(data)
    half_width, half_height = view.half_extent()
    is_seen = bool(np.any(near_the_view(model, data, view) & _things(model, *geom_boxes(model, data))))
    depth = float((content.centre - eye) @ -turn[:, 2])
    if is_seen and not whole and content.radius >= _FILLED * max(depth, 0.0) * max(half_width, half_height):
        return None
    forward = -turn[:, 2] if is_seen else _forward(far)
    azimuth = float(np.degrees(np.arctan2(forward[1], forward[0])))
    elevation = float(np.degrees(np.arcsin(np.clip(forward[2], -1.0, 1.0))))
    distance = content.distance(forward, free.half_extent())
    x, y, z = content.centre.tolist()
    return replace(far, lookat=(x, y, z), distance=distance, azimuth_deg=azimuth, elevation_deg=elevation)


def geom_boxes(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Vectors, Vectors]:
    """Return the least and greatest coordinates of each geom in the world, shape (ngeom, 3) each."""
    turns = data.geom_xmat.reshape(-1, 3, 3)
    boxes = model.geom_aabb  # centre and half sides, in the geom's frame
    centres = data.geom_xpos + np.einsum("gij,gj->gi", turns, boxes[:, :3])
    halves = np.einsum("gij,gj->gi", np.abs(turns), boxes[:, 3:])
    return centres - halves, centres + halves


def is_flat_and_wide(low: Vectors, high: Vectors, extent: float) -> NDArray[np.bool_]:
    """Return whether boxes (..., 3) are as flat and as wide as a ground in a scene of this extent."""
    sides = high - low
    width = sides[..., :2].min(axis=-1)
    return (sides[..., 2] <= _FLAT * width) & (width >= _WIDE * extent)


def _things(model: mujoco.MjModel, low: Vectors, high: Vectors) -> NDArray[np.bool_]:
    """Return (ngeom,): the geoms that are content. A ground lies below everything else."""
    seen = seen_by_users(model) & (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE.value)
    seen &= np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
    if not seen.any():
        return seen
    lowest, highest = low[seen].min(axis=0), high[seen].max(axis=0)
    width = (high - low)[:, :2].min(axis=1)
    ground = model.body_weldid[model.geom_bodyid] == 0
    ground &= is_flat_and_wide(low, high, float((highest - lowest)[:2].max()))
    ground &= low[:, 2] <= lowest[2] + _FLAT * width
    return seen & ~ground if (seen & ~ground).any() else seen


def _forward(viewpoint: Viewpoint) -> Vectors:
    return -viewpoint.pose()[1][:, 2]


def _across(forward: Vectors) -> tuple[Vectors, Vectors]:
    """Return the directions to the right and up of an upright image."""
    right = np.cross(forward, (0.0, 0.0, 1.0))
    if np.linalg.norm(right) < 1e-6:  # straight down
        right = np.array((1.0, 0.0, 0.0))
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward)
