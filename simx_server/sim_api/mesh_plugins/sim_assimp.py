"""The namespace ``simAssimp``: mesh files as shapes and back."""

from __future__ import annotations

from types import MappingProxyType
from typing import Annotated, NamedTuple

import numpy as np

from simx_server.editing import shape_looks
from simx_server.editing.imported_meshes import create_shape_of_parts
from simx_server.errors import CommandError
from simx_server.files.mesh_writing import WRITERS, Mesh, mesh_of
from simx_server.handlers.files import store_file
from simx_server.handlers.scene_files.mesh_files import parts_of_file, points_of_file
from simx_server.handlers.scene_files.saving import saved_name
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.poses import compose, inverse
from simx_server.scripting.conversion.signature import Most
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads, writes_files

from .points import placed

_MOST_MESHES = 10_000

_NO_TEXTURES, _NO_COLORS, _TO_FIRST = 1, 2, 512
"""Bits of options."""

_AUTOMATIC, _UP_Z, _UP_Y = 0, 1, 2

_Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


class _Format(NamedTuple):
    description: str
    ending: str
    name: str
    writer: int
    """Its number among `WRITERS`."""


_EXPORTS = (
    _Format("Wavefront OBJ format without material file", "obj", "objnomtl", 0),
    _Format("Stereolithography", "stl", "stl", 3),
    _Format("Stereolithography (binary)", "stl", "stlb", 4),
    _Format("Stanford Polygon Library", "ply", "ply", 6),
    _Format("Stanford Polygon Library (binary)", "ply", "plyb", 7),
)
_IMPORTS = (
    ("Wavefront OBJ format", "obj"),
    ("Stereolithography", "stl"),
    ("COLLADA", "dae"),
    ("Stanford Polygon Library", "ply"),
)


class SimAssimp(ApiPart, effect="changes"):
    """Functions for mesh files of the workspace: OBJ, STL, COLLADA and PLY to read; OBJ, STL and PLY to write. Several
    names stand in one text, with semicolons between them. A scaling of 0 is 1. Upward vector: 0 what a COLLADA file
    says, else the z axis; 1 the z axis, 2 the y axis of the file.
    """

    CONSTANTS = MappingProxyType({"upVector_auto": 0, "upVector_z": 1, "upVector_y": 2})

    def importShapes(
        self, files: str, _largest: int = 512, scaling: float = 0.0, up: int = _AUTOMATIC, options: int = 0
    ) -> list[int]:
        """Create a static shape from each file; return them. `options`: 1 without textures, 2 without colours.

        Partly: `up` 2 is an error; other options are ignored.
        """
        if up == _UP_Y:
            raise CommandError("shapes are imported with the z axis upwards; turn the shape afterwards")
        handles: list[int] = []
        for file in _names(files):
            parts, texture = parts_of_file(
                self._world,
                file,
                scaling or 1.0,
                with_colors=not options & _NO_COLORS,
                with_textures=not options & _NO_TEXTURES,
                turns=up == _AUTOMATIC,
            )
            handles.append(create_shape_of_parts(self._world, parts, "Shape", texture))
        return handles

    def importMeshes(
        self, files: str, scaling: float = 0.0, up: int = _AUTOMATIC, _options: int = 0
    ) -> tuple[list[list[float]], list[list[int]]]:
        """Return the points and the triangles of each file."""
        found = [
            points_of_file(self._world, file, scaling or 1.0, turns=up == _AUTOMATIC)
            for file in _names(files)
        ]
        turn = _Y_TO_Z if up == _UP_Y else np.eye(3)
        return (
            [(points @ turn.T).ravel().tolist() for points, _ in found],
            [faces.ravel().tolist() for _, faces in found],
        )

    @writes_files
    def exportShapes(
        self,
        shapes: list[int],
        file: str,
        form: str,
        scaling: float = 1.0,
        up: int = _UP_Z,
        options: int = 0,
    ) -> None:
        """Write shapes into a file of the workspace, in the world, or with option 512 in the frame of the first one.

        Partly: without colours and textures.
        """
        origin = get_pose(self._sim, self._self(shapes[0])) if shapes and options & _TO_FIRST else None
        meshes: list[Mesh] = []
        for shape in map(self._self, shapes):
            points, faces = shape_looks.triangles(self._world, shape)
            pose = get_pose(self._sim, shape)
            if origin is not None:
                pose = compose(inverse(origin), pose)
            meshes.append(Mesh(placed(points, pose), faces.astype(np.intp)))
        self._write(meshes, file, form, scaling, up)

    @writes_files
    def exportMeshes(
        self,
        vertices: Annotated[list[list[float]], Most(_MOST_MESHES)],
        indices: Annotated[list[list[int]], Most(_MOST_MESHES)],
        file: str,
        form: str,
        scaling: float = 1.0,
        up: int = _UP_Z,
        _options: int = 0,
    ) -> None:
        """Write meshes into a file of the workspace."""
        if len(vertices) != len(indices):
            raise CommandError(f"there are {len(vertices)} tables of vertices and {len(indices)} of indices")
        meshes = [mesh_of(points, faces) for points, faces in zip(vertices, indices, strict=True)]
        self._write(meshes, file, form, scaling, up)

    @reads
    def getExportFormat(self, index: int) -> tuple[str, str, str]:
        """Return description, ending and name of a format to write, by its index from 0; '' after the last."""
        return _EXPORTS[index][:3] if 0 <= index < len(_EXPORTS) else ("", "", "")

    @reads
    def getImportFormat(self, index: int) -> tuple[str, str]:
        """Return description and ending of a format to read, by its index from 0; '' after the last."""
        return _IMPORTS[index] if 0 <= index < len(_IMPORTS) else ("", "")

    def importShapesDlg(self, file: str) -> list[int]:
        """Import a file as simAssimp.importShapes does. Partly: no dialog asks for options."""
        return self.importShapes(file)

    @writes_files
    def exportShapesDlg(self, file: str, shapes: list[int]) -> None:
        """Write shapes as simAssimp.exportShapes does, by the file's ending. Partly: no dialog asks for options."""
        ending = file.rpartition(".")[2].lower()
        form = next((each.name for each in _EXPORTS if each.ending == ending), ending)
        self.exportShapes(shapes, file, form)

    def _write(self, meshes: list[Mesh], file: str, form: str, scaling: float, up: int) -> None:
        found = next((each for each in _EXPORTS if each.name == form), None)
        if found is None:
            known = ", ".join(each.name for each in _EXPORTS)
            raise CommandError(f"formats to write are {known}, not '{form[:40]}'")
        if not meshes:
            raise CommandError("there is nothing to write: no mesh was given")
        turn = _Y_TO_Z.T if up == _UP_Y else np.eye(3)
        turned = [Mesh(mesh.vertices @ turn.T * scaling, mesh.faces) for mesh in meshes]
        store_file(self._world, saved_name(self._world, file), WRITERS[found.writer](turned))


def _names(files: str) -> list[str]:
    return [name for each in files.split(";") if (name := each.strip())]
