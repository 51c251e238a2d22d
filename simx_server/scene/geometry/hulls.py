"""Convex hulls of points, by the library that MuJoCo uses for meshes."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError

MOST_POINTS = 1_000_000


def hull(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the corners (n, 3) and the faces (m, 3), counter-clockwise from outside, of the convex hull of points.

    Raises:
        CommandError: the points are too many, or too few, or lie in a plane or nearly so.
    """
    if not 4 <= len(points) <= MOST_POINTS:
        raise CommandError(f"a convex hull has from 4 to {MOST_POINTS} points, not {len(points)}")
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    size = float(np.ptp(points, axis=0).max())
    if not np.isfinite(size) or size <= 0.0:
        raise CommandError("all points of the convex hull lie in one place")
    spec: Any = mujoco.MjSpec()
    mesh = spec.add_mesh(name="hull", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
    mesh.uservert = ((points - middle) / size).ravel()
    spec.worldbody.add_body().add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH, meshname="hull", contype=1, density=1.0
    )
    try:
        model = spec.compile()
    except ValueError as problem:
        raise CommandError("points in a plane or a line have no convex hull") from problem
    used, place = np.unique(_faces(model.mesh_graph), return_inverse=True)
    return points[used], place.reshape(-1, 3).astype(np.int64)


def _faces(graph: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the faces (m, 3) of MuJoCo's description of a hull, as indices of the mesh's vertices.

    MuJoCo keeps the vertices in their order. The description holds the numbers of vertices and faces, an address and an
    index for each vertex, the edges, and the faces.
    """
    count = int(graph[1])
    return graph[len(graph) - 3 * count :].reshape(-1, 3)
