"""The namespaces ``simConvex``, convex hulls and decompositions, and ``simOpenMesh``, coarser meshes."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from simx_server.editing import creating, shape_looks
from simx_server.editing.compounds import decomposing, ungrouping
from simx_server.editing.creating import Body
from simx_server.errors import CommandError
from simx_server.scene.geometry.decimating import decimated
from simx_server.scene.geometry.hulls import hull
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.frames import get_pose
from simx_server.scripting.conversion.signature import Most
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

from .points import placed

_MOST_NUMBERS = 3_000_000

_USUAL_SHARE = 0.8


class SimConvex(ApiPart, effect="changes"):
    """Functions for convex shapes: metres, in the world where a shape is made."""

    def hull(self, objects: list[int], growth: float = 0.0) -> int:
        """Create the convex hull of shapes, dummies, octrees and point clouds; return the shape. `growth`: how far
        its corners move away from its middle (m).
        """
        points = [self._points(self._self(handle)) for handle in objects]
        corners, faces = _grown(np.concatenate([np.empty((0, 3)), *points]), growth)
        return creating.create_mesh(self._world, corners, faces, "Convex", Body())

    @reads
    def qhull(
        self, points: Annotated[list[float], Most(_MOST_NUMBERS)], growth: float = 0.0
    ) -> tuple[list[float], list[int]]:
        """Return points and triangles of the convex hull of points x, y, z."""
        corners, faces = _grown(np.array(points[: len(points) // 3 * 3], dtype=float).reshape(-1, 3), growth)
        return corners.ravel().tolist(), faces.ravel().tolist()

    def vhacd(self, shape: int, _parameters: dict[str, Any] | None = None) -> list[int]:
        """Create convex shapes that fill a closed one; return them. An error without the library of the extra
        `convex`.

        Partly: the parameters of V-REP's libraries are ignored; CoACD has its own.
        """
        with self._at_no_cost():
            whole = decomposing.convex_shape(self._world, self._self(shape), morph=False)
        return ungrouping.ungroup(self._world, whole)

    hacd = vhacd

    def _points(self, handle: int) -> NDArray[np.float64]:
        """Return the points (n, 3) of an object in the world."""
        item = self._sim.scene.get(handle)
        pose = get_pose(self._sim, handle)
        match item.kind:
            case ObjectKind.SHAPE:
                return placed(shape_looks.triangles(self._world, handle)[0], pose)
            case ObjectKind.DUMMY:
                return np.array([pose[0]])
            case ObjectKind.OCTREE:
                return placed(self._world.clouds.voxels(handle).places, pose)
            case ObjectKind.POINT_CLOUD:
                return placed(self._world.clouds.points(handle).places, pose)
            case _:
                raise CommandError(
                    f"'{item.name}' is a {item.kind.text}; hulls are made of shapes, dummies, octrees and point clouds"
                )


class SimOpenMesh(ApiPart, effect="changes"):
    """Functions for coarser meshes."""

    def decimate(self, shape: int, parameters: dict[str, Any] | None = None) -> int:
        """Create a shape with fewer triangles in the place of another one; return it. Entry `percentage`: the share
        that stays, 0.8. An error without the library of the extra `decimation`.
        """
        handle = self._self(shape)
        share = (parameters or {}).get("percentage", _USUAL_SHARE)
        if not isinstance(share, int | float):
            raise CommandError(f"'percentage' is a number above 0, up to 1, not {share!r}")
        points, faces = shape_looks.triangles(self._world, handle)
        with self._at_no_cost():
            coarse, corners = decimated(points, faces, float(share))
        return creating.create_mesh(
            self._world, placed(coarse, get_pose(self._sim, handle)), corners, "Decimated", Body()
        )


def _grown(points: NDArray[np.float64], growth: float) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    corners, faces = hull(points)
    if growth:
        away = corners - corners.mean(axis=0)
        corners = corners + growth * away / np.linalg.norm(away, axis=1, keepdims=True)
    return corners, faces
