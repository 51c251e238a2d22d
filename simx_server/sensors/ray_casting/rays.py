"""Rays through the pixels of a camera, and the nearest surfaces that they meet."""

import copy
import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.cameras.image import DEPTH_OFFSET, CameraView
from simx_server.scene.cameras.visibility import drawn, near_the_view

from .surface import Ids, Points

_SEEN_GROUP = 0
_HIDDEN_GROUP = 1


@dataclass(frozen=True, eq=False)
class Rays:
    """Rays of some pixels, world frame. Directions advance 1 m along the view axis, so a distance is a depth."""

    origins: Points
    """(n, 3), or (1, 3) if all rays start in one point. Metres."""
    directions: Points
    """(n, 3) directions."""
    start: float
    """Depth of the origins, metres."""
    forward: NDArray[np.float64]
    """(3,) the view axis, unit length."""

    @classmethod
    def through_pixels(cls, data: mujoco.MjData, view: CameraView, rows: "slice[int, int, Any]") -> "Rays":
        """Make rays through the centres of the pixels of some rows, bottom row first, each left to right."""
        eye, turn = view.pose(data)
        right, up, backward = turn.T
        half_width, half_height = view.half_extent()
        across = half_width * ((np.arange(view.width) + 0.5) * 2 / view.width - 1)
        along = half_height * ((np.arange(rows.start, rows.stop) + 0.5) * 2 / view.height - 1)
        if view.orthographic_size is None:
            upwards = along[:, np.newaxis, np.newaxis] * up - backward
            directions = (upwards + across[:, np.newaxis] * right).reshape(-1, 3)
            return cls(eye[np.newaxis], directions, 0.0, -backward)
        upwards = along[:, np.newaxis, np.newaxis] * up + (eye - view.near * backward)
        origins = (upwards + across[:, np.newaxis] * right).reshape(-1, 3)
        return cls(origins, np.broadcast_to(-backward, origins.shape), view.near, -backward)

    def of(self, chosen: NDArray[np.intp]) -> "Rays":
        """Return the chosen rays, by increasing index."""
        if len(chosen) == len(self.directions):
            return self
        origins = self.origins if len(self.origins) == 1 else self.origins[chosen]
        return Rays(origins, self.directions[chosen], self.start, self.forward)

    def at(self, depths: NDArray[np.float64]) -> Points:
        """Return (n, 3): the point of each ray at its depth."""
        points = self.directions * (depths - self.start)[:, np.newaxis]
        points += self.origins
        return points


class Seeing:
    """Nearest surfaces in one state as one view meets them.

    MuJoCo leaves geoms out by their group, and the model belongs to the physics thread, so groups are set in a
    copy. Leaving out geoms beside the view makes an image of a robot cell three times as fast.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, view: CameraView, is_visible: NDArray[np.bool_]
    ) -> None:
        self.data = data
        self.view = view
        seen = is_visible & drawn(model, view) & near_the_view(model, data, view)
        self._model = copy.copy(model)
        self._hidden = np.where(seen, _SEEN_GROUP, _HIDDEN_GROUP)
        self._groups = np.zeros(mujoco.mjNGROUP, np.uint8)
        self._groups[_SEEN_GROUP] = 1

    def nearest(self, rays: Rays, without: tuple[int, ...]) -> tuple[Ids, NDArray[np.float64], Points]:
        """Return geom ids (n,), -1 for none; depths in metres (n,); outward normals (n, 3); some geoms left out."""
        self._model.geom_group[:] = self._hidden
        self._model.geom_group[list(without)] = _HIDDEN_GROUP
        count = len(rays.directions)
        geom_ids = np.full(count, -1, np.int32)
        distances = np.full(count, -1.0)
        normals = np.zeros((count, 3))
        if len(rays.origins) == 1:
            cutoff = self.view.far * math.hypot(1.0, *self.view.half_extent())
            mujoco.mj_multiRay(
                self._model, self.data, rays.origins[0], rays.directions.ravel(), self._groups, True, -1,
                geom_ids, distances, normals.ravel(), count, cutoff,
            )  # fmt: skip
        else:
            for ray in range(count):
                distances[ray] = mujoco.mj_ray(
                    self._model, self.data, rays.origins[ray], rays.directions[ray], self._groups, True, -1,
                    geom_ids[ray : ray + 1], normals[ray],
                )  # fmt: skip
        distances += rays.start
        return geom_ids, distances, normals

    def drawn_depths(self, rays: Rays, depths: NDArray[np.float64], normals: Points) -> NDArray[np.float64]:
        """Return the depths (n,) in metres that V-REP showed of surfaces: with its polygon offset, at most `far`.

        OpenGL's depth is linear in z (orthographic) or in 1 / z (perspective), so the clip planes cancel out.

        Args:
            rays: the rays that met the surfaces.
            depths: where they met them, metres.
            normals: (n, 3) outward normals there, all towards the eye.
        """
        view = self.view
        _, turn = view.pose(self.data)
        pixel = 2 * view.half_extent()[0] / view.width
        tilt = np.abs(normals @ turn[:, :2]).max(axis=1, initial=0.0)
        tilt /= -np.einsum("ij,ij->i", normals, rays.directions)
        tilt *= DEPTH_OFFSET * pixel
        if view.orthographic_size is not None:
            return np.minimum(depths + tilt, view.far)
        return depths / np.maximum(1.0 - tilt, depths / view.far)
