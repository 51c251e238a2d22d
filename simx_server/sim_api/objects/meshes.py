"""Shapes made of triangles: from points, from mesh files, their triangles, hulls and coarser meshes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

from simx_server.constant_tables import number_of
from simx_server.editing import creating, shape_looks
from simx_server.editing.creating import Body
from simx_server.editing.imported_meshes import create_shape_of_parts
from simx_server.errors import CommandError
from simx_server.files.mesh_writing import WRITERS, mesh_of
from simx_server.handlers.files import store_file
from simx_server.handlers.scene_files.mesh_files import parts_of_file, points_of_file
from simx_server.handlers.scene_files.saving import saved_name
from simx_server.scene.geometry.decimating import decimated
from simx_server.scene.geometry.hulls import hull
from simx_server.scripting.conversion.signature import Most
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads, writes_files

if TYPE_CHECKING:
    from simx_server.parts.object_settings import ObjectSettings

_MOST_MESHES = 10_000

_CULLED, _EDGES = 1, 2
"""Bits of the options of sim.createMeshShape."""
_NO_COLORS, _TEXTURES = 8, 16
"""Bits of the options of sim.importShape."""
_VIZ_CULLED, _VIZ_WIREFRAME = 1, 2
"""Bits of the options in the result of sim.getShapeViz."""

_SHADING = number_of("shapefloatparam_shading_angle")
_CULLING = number_of("shapeintparam_culling")
_WIREFRAME = number_of("shapeintparam_wireframe")
_EDGE_VISIBILITY = number_of("shapeintparam_edge_visibility")


class MeshFunctions(ApiPart, effect="changes"):
    """Functions for meshes: metres; points are x, y, z of each, triangles the indices of their corners from 0."""

    def createMeshShape(
        self, options: int, shading_angle: float, vertices: list[float], indices: list[int]
    ) -> int:
        """Create a static shape, not respondable, from points; its frame is at their centre, without rotation.
        `options`: 1 back faces are culled, 2 edges are visible.

        Partly: options and `shading_angle` (rad) are kept as parameters of the shape, and change no image.
        """
        points, faces = _threes(vertices, float), _threes(indices, int)
        handle = creating.create_mesh(self._world, points, faces, "Shape", Body())
        settings = self._world.object_settings
        settings.keep(handle, _SHADING, shading_angle)
        settings.keep(handle, _CULLING, int(bool(options & _CULLED)))
        settings.keep(handle, _EDGE_VISIBILITY, int(bool(options & _EDGES)))
        return handle

    def createShape(
        self, options: int, shading_angle: float, vertices: list[float], indices: list[int]
    ) -> int:
        """Create a mesh: CoppeliaSim 4's name of sim.createMeshShape. Partly: normals and textures are ignored."""
        return self.createMeshShape(options, shading_angle, vertices, indices)

    def importMesh(
        self, _format: int, path: str, _options: int, _tolerance: float, scaling: float
    ) -> tuple[list[list[float]], list[list[int]]]:
        """Return points and indices of an STL, OBJ, COLLADA or PLY file of the workspace, each as one table in a table.

        Partly: other formats are not supported; equal points are not merged.
        """
        points, faces = points_of_file(self._world, path, scaling)
        return [points.ravel().tolist()], [faces.ravel().tolist()]

    @writes_files
    def exportMesh(
        self,
        form: int,
        file: str,
        _options: int,
        scaling: float,
        vertices: Annotated[list[list[float]], Most(_MOST_MESHES)],
        indices: Annotated[list[list[int]], Most(_MOST_MESHES)],
    ) -> None:
        """Write meshes into a file of the workspace; of a path that leads elsewhere only the last part counts.

        `form`: 0 OBJ, 3 text STL, 4 binary STL, 5 COLLADA, 6 text PLY, 7 binary PLY. `vertices` and `indices`: of each
        mesh.
        """
        if form not in WRITERS:
            raise CommandError(
                f"formats are 0 OBJ, 3 text STL, 4 binary STL, 5 COLLADA, 6 text PLY, 7 binary PLY, not {form}"
            )
        if len(vertices) != len(indices) or not vertices:
            raise CommandError(
                f"each mesh has vertices and indices; there are {len(vertices)} and {len(indices)} tables"
            )
        meshes = [mesh_of(points, faces, scaling) for points, faces in zip(vertices, indices, strict=True)]
        store_file(self._world, saved_name(self._world, file), WRITERS[form](meshes))

    def importShape(self, _format: int, path: str, options: int, _tolerance: float, scaling: float) -> int:
        """Create a static shape from an STL, OBJ, COLLADA or PLY file of the workspace, with a part for each material.
        `options`: 8 without its colours, 16 with its textures, as in V-REP, which drops them otherwise.

        Partly: as sim.importMesh; images of clients do not become textures.
        """
        parts, texture = parts_of_file(
            self._world,
            path,
            scaling,
            with_colors=not options & _NO_COLORS,
            with_textures=bool(options & _TEXTURES),
        )
        return create_shape_of_parts(self._world, parts, "Shape", texture)

    @reads
    def getShapeMesh(self, shape: int) -> tuple[list[float], list[int], list[float]]:
        """Return points in the shape's frame, indices, and three normals for each triangle."""
        points, faces = shape_looks.triangles(self._world, self._self(shape))
        normals = np.repeat(shape_looks.normals(points, faces), 3, axis=0)
        return points.ravel().tolist(), faces.ravel().tolist(), normals.ravel().tolist()

    @reads
    def getShapeViz(self, shape: int, index: int) -> dict[str, Any] | None:
        """Return how a part of a shape is drawn, by its index from 0; nil after the last part.

        The fields: `vertices`, `indices`, `normals` (three for each triangle) in the shape's frame; `colors`, RGB of
        ambient and diffuse, highlights, emission; `transparency` 0..1; `shadingAngle` (rad); `options`, 1 back faces
        are culled, 2 wireframe; and `texture` of a mesh with one: `texture` (RGBA), `resolution`, `coordinates` (u, v
        of each corner), `id`, `applyMode`, `options`.
        """
        handle = self._self(shape)
        parts = self._world.shape_colors.parts(handle)
        if not 0 <= index < len(parts):
            return None
        part = parts[index]
        points, faces = shape_looks.indexed(shape_looks.part_corners(self._world, handle, part.geom))
        settings = self._world.object_settings
        found: dict[str, Any] = {
            "vertices": points.ravel().tolist(),
            "indices": faces.ravel().tolist(),
            "normals": np.repeat(shape_looks.normals(points, faces), 3, axis=0).ravel().tolist(),
            "colors": part.colors,
            "transparency": part.transparency,
            "shadingAngle": float(settings.kept(handle, _SHADING, 0.0)),
            "options": _viz_options(settings, handle),
        }
        texture = shape_looks.part_texture(self._sim.model, part.geom)
        if texture is not None:
            rows, columns = texture.pixels.shape[:2]
            found["texture"] = {
                "texture": texture.pixels.tobytes(),
                "resolution": [columns, rows],
                "coordinates": texture.coordinates.ravel().tolist(),
                "id": self._world.textures.of_geom(part.geom),
                "applyMode": 0,
                "options": 0,
            }
        return found

    @reads
    def getQHull(self, vertices: list[float]) -> tuple[list[float], list[int]]:
        """Return the points and triangles of the convex hull of points x, y, z.

        Points in a plane or a line are an error, as in V-REP.
        """
        points, faces = hull(_threes(vertices, float))
        return points.ravel().tolist(), faces.ravel().tolist()

    @reads
    def getDecimatedMesh(
        self, vertices: list[float], indices: list[int], percentage: float
    ) -> tuple[list[float], list[int]]:
        """Return the points and triangles of a coarser mesh. `percentage`: the share of the triangles that stays, above
        0, up to 1. An error without the library of the extra `decimation`.
        """
        with self._at_no_cost():
            points, faces = decimated(_threes(vertices, float), _threes(indices, int), percentage)
        return points.ravel().tolist(), faces.ravel().tolist()


def _viz_options(settings: ObjectSettings, handle: int) -> int:
    culled, wireframe = (bool(settings.kept(handle, each, 0)) for each in (_CULLING, _WIREFRAME))
    return (_VIZ_CULLED if culled else 0) | (_VIZ_WIREFRAME if wireframe else 0)


def _threes(numbers: list[float] | list[int], kind: type[float] | type[int]) -> NDArray[Any]:
    """Return numbers in rows of three; what is left over is ignored, as in V-REP."""
    whole: Sequence[float] = numbers[: len(numbers) // 3 * 3]
    return np.array(whole, dtype=kind).reshape(-1, 3)
