"""Octrees and point clouds: visible, and there for collision checks, distances and proximity sensors.

Each is a static body with one mesh: the outer faces of an octree's cells, or a small triangle at each point. An
annotation has all points, for the functions of scripts.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.texts.values import encode_bytes
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import PointCloud
from simx_server.scene.geometry.point_forms import MOST_SHOWN, point_form
from simx_server.scene.poses.poses import Pose

from .abilities import annotate_abilities
from .corners import Surface
from .looks import Looks
from .meshes import Meshes

_LEAST_SIZE, _USUAL_SIZE = 1e-5, 0.02
"""Least edge of a cell in metres, and the one of a damaged file."""

_GREY = np.array([[128, 128, 128]], np.uint8)

_THINNED = f"of octrees and point clouds, {MOST_SHOWN} points are shown"
_EMPTY = "octrees and point clouds without points are empty objects"


def add_points(conversion: Conversion, cloud: PointCloud, body: Any, at: Pose) -> None:
    """Add an octree or a point cloud as a separate body.

    Args:
        body: the body on which it rides.
        at: its frame in that body.
    """
    name = conversion.name(cloud)
    own = body.add_body(name=name, pos=at[0], quat=at[1])
    conversion.annotate("object", name, type="octree" if cloud.is_octree else "point_cloud")
    annotate_abilities(conversion, cloud)
    points, colors, tags = _sound(cloud)
    size = _size_of(cloud)
    conversion.annotate(
        "cloud",
        name,
        voxel=size,
        points=encode_bytes(points.astype("<f4").tobytes()) if len(points) else None,
        colors=encode_bytes(colors.tobytes()) if len(points) else None,
        tags=encode_bytes(tags.astype("<u4").tobytes()) if tags.any() else None,
    )
    if not len(points):
        conversion.report.approximate(_EMPTY, name)
        return
    if len(points) > MOST_SHOWN:
        conversion.report.approximate(_THINNED, name)
    form = point_form(points, colors, size, as_cells=cloud.is_octree)
    mesh = Meshes.of(conversion).add(Surface(form.vertices, form.faces, None, form.texture), name)
    geom = own.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, contype=0, conaffinity=0)
    geom.mass = 0.0
    # No light falls on V-REP's points.
    glow = 0.0 if cloud.is_octree else 1.0
    geom.material = Looks.of(conversion).painted(name, form.image, glow)


def _sound(cloud: PointCloud) -> tuple[NDArray[np.float32], NDArray[np.uint8], NDArray[np.uint32]]:
    """Return the finite points (n, 3), their colours (n, 3) and tags (n,)."""
    finite = np.isfinite(cloud.points).all(axis=1)
    points = cloud.points[finite]
    colors = np.repeat(_GREY, len(points), axis=0)
    if cloud.colors is not None and len(cloud.colors) == len(cloud.points):
        colors = cloud.colors[finite, :3]
    tags = np.zeros(len(points), np.uint32)
    if cloud.tags is not None and len(cloud.tags) == len(cloud.points):
        tags = cloud.tags[finite]
    return points, colors, tags


def _size_of(cloud: PointCloud) -> float:
    return cloud.size if math.isfinite(cloud.size) and cloud.size > _LEAST_SIZE else _USUAL_SIZE
