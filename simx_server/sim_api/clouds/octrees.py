"""Octrees: create them, fill and empty their voxels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simx_server.editing.creating import add
from simx_server.errors import CommandError
from simx_server.parts.clouds.clouds import Settings, tags_of
from simx_server.parts.clouds.near import Array
from simx_server.parts.clouds.points import Colors
from simx_server.parts.clouds.surface_cells import surface_cells
from simx_server.parts.clouds.voxels import Cells
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.sim_api.base import ApiPart

from .values import EACH, colors_of, in_cells, inside_of, places_of, size_of, triangles_in

_TAG = 0xFFFFFFFF


class OctreeFunctions(ApiPart):
    """Functions for octrees: metres, colours 0..255. Voxels that a run fills or empties are as before at its stop.

    The origin of an octree is a corner of eight voxels. Images and sensors regard the voxels from the next simulation
    step on, or earlier where a script measures.
    """

    def createOctree(self, voxel: float, options: int, _point_size: float = 2.0) -> int:
        """Create an empty octree with voxels of this size (m) at the origin and return its handle. `options`: 1 random
        colours, 4 voxels are drawn as points, 16 emissive.

        Partly: the size of the points depends on the voxels; the structure of the octree (option 2) is not drawn.
        """
        settings = Settings(size_of(voxel, "a voxel's size"), options=options & 0xFFFF)
        handle = add(
            self._world,
            "Octree",
            "body",
            lambda spec, name: spec.worldbody.add_body(name=name),
            {"object": {"type": "octree"}},
        )
        self._world.clouds.define(handle, settings)
        return handle

    def getOctreeVoxels(self, octree: int) -> list[float] | None:
        """Return x, y, z of the middles of all filled voxels in the frame of the octree; nil if there are none."""
        voxels = self._world.clouds.voxels(self._self(octree))
        return voxels.places.ravel().tolist() if len(voxels) else None

    def insertVoxelsIntoOctree(
        self,
        octree: int,
        options: int,
        points: list[float],
        color: list[float] | None = None,
        tag: list[int] | None = None,
    ) -> int:
        """Fill the voxels that contain points, given by x, y, z, and return how many are filled. `options`: 1 points
        are in its frame, not in the world; 2 `color` has red, green, blue and `tag` a number for each point.
        """
        handle = self._self(octree)
        voxels = self._world.clouds.voxels(handle)
        places = places_of(self._world, handle, options, points)
        colors = colors_of(self._world, handle, color, options, len(places))
        return self._fill(handle, voxels.cells_of(places), colors, _tags(tag, options, len(places)))

    def removeVoxelsFromOctree(self, octree: int, options: int, points: list[float] | None = None) -> int:
        """Empty the voxels that contain points, or all with nil, and return how many are filled. `options`: 1 points
        are in its frame, not in the world.
        """
        handle = self._self(octree)
        voxels = self._world.clouds.voxels(handle)
        if points is None:
            voxels.clear()
        else:
            self._empty(handle, places_of(self._world, handle, options, points))
        self._world.clouds.note_change(handle)
        return len(voxels)

    def insertObjectIntoOctree(
        self, octree: int, item: int, _options: int, color: list[float] | None = None, tag: int = 0
    ) -> int:
        """Fill the voxels that the surface of a shape meets, or the voxels of another octree, or the points of a point
        cloud, or a dummy, and return how many are filled.
        """
        handle = self._self(octree)
        cells = self._cells_of_object(handle, self._self(item))
        return self._fill(
            handle,
            cells,
            colors_of(self._world, handle, color, 0, len(cells)),
            tags_of(tag & _TAG, len(cells)),
        )

    def subtractObjectFromOctree(self, octree: int, item: int, _options: int) -> int:
        """Empty the voxels that sim.insertObjectIntoOctree would fill, and return how many are filled."""
        handle = self._self(octree)
        self._world.clouds.voxels(handle).empty(self._cells_of_object(handle, self._self(item)))
        self._world.clouds.note_change(handle)
        return len(self._world.clouds.voxels(handle))

    def checkOctreePointOccupancy(
        self, octree: int, options: int, points: list[float]
    ) -> tuple[int, int, int, int] | int:
        """Return 1 if any of the points lies in a filled voxel, else 0; of a single point then also the tag of its
        voxel, and its location as V-REP's number of 64 bits: the lower and the upper 32. `options`: 1 points are in its
        frame, not in the world.
        """
        handle = self._self(octree)
        voxels = self._world.clouds.voxels(handle)
        places = places_of(self._world, handle, options, points)
        hits = in_cells(voxels, places)
        if not hits.any():
            return 0
        if len(places) > 1:
            return 1
        cell = voxels.cells_of(places)[0]
        location = voxels.location(cell)
        return 1, voxels.tag(cell), location & _TAG, location >> 32

    def _fill(self, handle: int, cells: Cells, colors: Colors, tags: NDArray[np.uint32]) -> int:
        voxels = self._world.clouds.voxels(handle)
        if len(cells):
            self._world.clouds.check_room(voxels.count_of_new(cells))
            voxels.fill(cells, colors, tags)
            self._world.clouds.note_change(handle)
        return len(voxels)

    def _empty(self, handle: int, places: Array) -> None:
        voxels = self._world.clouds.voxels(handle)
        within = (np.abs(places) < voxels.reach).all(axis=1)
        voxels.empty(voxels.cells_of(places[within]))

    def _cells_of_object(self, handle: int, item: int) -> Cells:
        """Return the voxels (n, 3) of an octree that another object meets. Raises CommandError."""
        clouds, other = self._world.clouds, self._sim.scene.get(item)
        voxels = clouds.voxels(handle)
        match other.kind:
            case ObjectKind.SHAPE:
                corners = triangles_in(self._world, item, handle)
                return surface_cells(corners, voxels.size, self._sim.interruptions.serve_others)
            case ObjectKind.OCTREE:
                places = inside_of(self._world, item, handle, voxels.size)
            case ObjectKind.POINT_CLOUD:
                places = clouds.local(handle, clouds.places(item))
            case ObjectKind.DUMMY:
                places = clouds.local(handle, np.array([frames.get_pose(self._sim, item)[0]]))
            case _:
                raise CommandError(
                    f"'{other.name}' is a {other.kind.text}; voxels come from shapes, octrees, point clouds and dummies"
                )
        return np.unique(voxels.cells_of(places), axis=0)


def _tags(given: list[int] | None, options: int, count: int) -> NDArray[np.uint32]:
    if not given:
        return tags_of(0, count)
    if options & EACH:
        if len(given) < count:
            raise CommandError(f"{count} points have {count} tags; got {len(given)}")
        return np.array([tag & _TAG for tag in given[:count]], np.uint32)
    return tags_of(given[0] & _TAG, count)
