"""Point clouds: create them, add and remove points."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from simx_server.editing.creating import add
from simx_server.errors import CommandError
from simx_server.parts.clouds.clouds import UNSTRUCTURED, Settings
from simx_server.parts.clouds.near import Array, near
from simx_server.parts.clouds.points import Colors
from simx_server.parts.clouds.surface_cells import surface_cells
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.sim_api.base import ApiPart

from .values import colors_of, in_cells, places_of, size_of, triangles_in

_LARGEST_BITS = 0xFFFF


class PointCloudFunctions(ApiPart):
    """Functions for point clouds: metres, colours 0..255. Points that a run adds or removes are as before at its stop.

    Images and sensors regard the points from the next simulation step on, or earlier where a script measures.
    """

    def createPointCloud(self, voxel: float, most: int, options: int, point_size: float = 4.0) -> int:
        """Create an empty point cloud at the origin and return its handle. `voxel`: largest size of the cells for its
        points; `most`: points in a cell; `options`: 1 random colours, 8 neither measured nor detected, 16 emissive.

        Partly: points are drawn as small triangles, whose size depends on the cells, and without light; the structure
        of the cells (option 2) is not drawn.
        """
        settings = _settings(voxel, most, options, point_size)

        handle = add(
            self._world,
            "Point_cloud",
            "body",
            lambda spec, name: spec.worldbody.add_body(name=name),
            {"object": {"type": "point_cloud"}},
        )
        self._world.clouds.define(handle, settings)
        return handle

    def setPointCloudOptions(
        self, cloud: int, voxel: float, most: int, options: int, point_size: float = 4.0
    ) -> int:
        """Set what sim.createPointCloud sets. Partly: as there."""
        handle = self._self(cloud)
        self._world.clouds.points(handle)
        color = self._world.clouds.settings(handle).color
        settings = replace(_settings(voxel, most, options, point_size), color=color)
        self._world.clouds.set_settings(handle, settings)
        return 1

    def getPointCloudOptions(self, cloud: int) -> tuple[float, int, int, float]:
        """Return the largest size of a cell, most points in a cell, option bits, and the size of a point in pixels."""
        self._world.clouds.points(self._self(cloud))
        found = self._world.clouds.settings(self._self(cloud))
        return found.voxel, found.most, found.options, found.point_size

    def getPointCloudPoints(self, cloud: int) -> list[float] | None:
        """Return x, y, z of all points in the frame of the cloud; nil if it has none."""
        points = self._world.clouds.points(self._self(cloud))
        return points.places.ravel().tolist() if len(points) else None

    def insertPointsIntoPointCloud(
        self,
        cloud: int,
        options: int,
        points: list[float],
        color: list[float] | None = None,
        tolerance: float | None = None,
    ) -> int:
        """Add points, given by x, y, z, and return how many the cloud has. `options`: 1 points are in its frame, not in
        the world; 2 `color` has red, green, blue for each point. `tolerance`: points this near (m) to another one are
        left out.
        """
        handle = self._self(cloud)
        self._world.clouds.points(handle)
        places = places_of(self._world, handle, options, points)
        return self._add(
            handle, places, colors_of(self._world, handle, color, options, len(places)), tolerance
        )

    def removePointsFromPointCloud(
        self, cloud: int, options: int, points: list[float] | None = None, tolerance: float = 0.0
    ) -> int:
        """Remove the points that are this near (m) to one of the given ones, or all with nil, and return how many the
        cloud has. `options`: 1 given points are in its frame, not in the world.
        """
        handle = self._self(cloud)
        present = self._world.clouds.points(handle)
        if points is None:
            present.clear()
        else:
            self._refuse_unstructured(handle)
            places = places_of(self._world, handle, options, points)
            present.keep(~near(present.places, places, tolerance))
        self._world.clouds.note_change(handle)
        return len(present)

    def intersectPointsWithPointCloud(
        self, cloud: int, options: int, points: list[float], tolerance: float
    ) -> int:
        """Remove the points that are not this near (m) to any of the given ones, and return how many the cloud has.
        `options`: 1 given points are in its frame, not in the world.
        """
        handle = self._self(cloud)
        present = self._world.clouds.points(handle)
        self._refuse_unstructured(handle)
        present.keep(near(present.places, places_of(self._world, handle, options, points), tolerance))
        self._world.clouds.note_change(handle)
        return len(present)

    def insertObjectIntoPointCloud(
        self,
        cloud: int,
        item: int,
        _options: int,
        grid: float,
        color: list[float] | None = None,
        tolerance: float | None = None,
    ) -> int:
        """Add the points of a point cloud, an octree or a dummy, or those of a shape's surface in a grid of this size
        (m), and return how many the cloud has. `tolerance`: points this near (m) to another one are left out.
        """
        handle, other = self._self(cloud), self._sim.scene.get(self._self(item))
        self._world.clouds.points(handle)
        own_colors: Colors | None = None
        match other.kind:
            case ObjectKind.SHAPE:
                edge = size_of(grid, "a grid's size")
                corners = triangles_in(self._world, other.handle, handle)
                cells = surface_cells(corners, edge, self._sim.interruptions.serve_others)
                places = (cells.astype(np.float64) + 0.5) * edge
            case ObjectKind.POINT_CLOUD:
                own_colors = self._world.clouds.points(other.handle).colors.copy()
                places = self._world.clouds.local(handle, self._world.clouds.places(other.handle))
            case ObjectKind.OCTREE | ObjectKind.DUMMY:
                places = self._world.clouds.local(handle, self._places(other.handle))
            case _:
                raise CommandError(
                    f"'{other.name}' is a {other.kind.text}; points come from shapes, point clouds, octrees and dummies"
                )
        colors = (
            own_colors
            if own_colors is not None and not color
            else colors_of(self._world, handle, color, 0, len(places))
        )
        return self._add(handle, places, colors, tolerance)

    def subtractObjectFromPointCloud(
        self, cloud: int, item: int, _options: int, tolerance: float = 0.0
    ) -> int:
        """Remove the points in the voxels of an octree, or as near (m) as `tolerance` to those of a point cloud or to a
        dummy, and return how many the cloud has.
        """
        handle, other = self._self(cloud), self._sim.scene.get(self._self(item))
        present = self._world.clouds.points(handle)
        self._refuse_unstructured(handle)
        match other.kind:
            case ObjectKind.OCTREE:
                placed = self._world.clouds.places(handle)
                gone = in_cells(
                    self._world.clouds.voxels(other.handle), self._world.clouds.local(other.handle, placed)
                )
            case ObjectKind.POINT_CLOUD | ObjectKind.DUMMY:
                places = self._world.clouds.local(handle, self._places(other.handle))
                gone = near(present.places, places, tolerance)
            case _:
                raise CommandError(
                    f"'{other.name}' is a {other.kind.text}; octrees, point clouds and dummies can be subtracted"
                )
        present.keep(~gone)
        self._world.clouds.note_change(handle)
        return len(present)

    def _places(self, handle: int) -> Array:
        """Return the points of a cloud, an octree or a dummy in the world (n, 3)."""
        if self._sim.scene.get(handle).kind == ObjectKind.DUMMY:
            return np.array([frames.get_pose(self._sim, handle)[0]])
        return self._world.clouds.places(handle)

    def _add(self, handle: int, places: Array, colors: Colors, tolerance: float | None) -> int:
        present = self._world.clouds.points(handle)
        if tolerance is not None and tolerance > 0.0:
            chosen = present.unlike(places, tolerance)
            places, colors = places[chosen], colors[chosen]
        if len(places):
            self._world.clouds.check_room(len(places))
            present.add(places, colors)
            self._world.clouds.note_change(handle)
        return len(present)

    def _refuse_unstructured(self, handle: int) -> None:
        if self._world.clouds.settings(handle).options & UNSTRUCTURED:
            raise CommandError(
                "single points cannot be removed from a point cloud without structure (option 8); unset the option "
                "with sim.setPointCloudOptions"
            )


def _settings(voxel: float, most: int, options: int, point_size: float) -> Settings:
    size_of(voxel, "the largest size of a voxel")
    if most < 1:
        raise CommandError(f"a voxel has at least one point, not {most}")
    if not 0 <= options <= _LARGEST_BITS:
        raise CommandError(f"options are bits from 1 to 16, not {options}")
    if not 0.0 <= point_size < math.inf:
        raise CommandError(f"a point has a size of 0 or more pixels, not {point_size}")
    return Settings(voxel, most, options, point_size)
