"""Mesh files that scripts import: their triangles, and the colours and textures of their materials."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.editing.creating import GREY
from simx_server.editing.imported_meshes import MeshPart
from simx_server.errors import CommandError
from simx_server.files.image_files import Pixels, fitted
from simx_server.scene.formats.meshes.naming import plain_name
from simx_server.scene.formats.meshes.obj_materials import ObjMaterial, ObjUse, materials_used, read_materials
from simx_server.scene.formats.meshes.parts import Part
from simx_server.scene.formats.meshes.reading import COLORED, by_material

from .script_files import file_of_server, read_image, read_mesh, read_mesh_parts

if TYPE_CHECKING:
    from simx_server.world.world import World

_LARGEST_SIDE = 512
"""Pixels: V-REP makes larger textures of imported files smaller."""

_LARGEST_LIBRARY = 1 << 20
"""Bytes of a library of materials."""


def points_of_file(
    world: World, path: str, scaling: float, *, turns: bool = True
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return points (n, 3) in metres and faces (m, 3) of a mesh file.

    Args:
        turns: whether to turn the up axis of a COLLADA file to z.

    Raises:
        CommandError, SceneError: it is not a mesh file.
    """
    read = read_mesh(world, path, turns=turns)
    return read.points * scaling, read.faces.astype(np.int64)


def parts_of_file(
    world: World, path: str, scaling: float, *, with_colors: bool, with_textures: bool, turns: bool = True
) -> tuple[list[MeshPart], str]:
    """Return the parts of a mesh file, one for each material, and a name for their textures.

    A library or an image that cannot be used is named in the status bar; the parts are grey then.

    Raises:
        CommandError, SceneError: it is not a mesh file.
    """
    if PurePosixPath(path).suffix.lower() in COLORED:
        found, folder = read_mesh_parts(world, path, turns=turns), path
    else:
        found, folder = _parts_of_materials(world, path, has_looks=with_colors or with_textures)
    parts: list[MeshPart] = []
    texture = "texture"
    for part in found:
        look, pixels = part.look, None
        if with_textures and look.image and part.coordinates is not None:
            image = plain_name(look.image)
            pixels = _image(world, _beside(folder, image))
            texture = PurePosixPath(image).stem if not parts else texture
        color = (look.color if with_colors else None) or GREY
        coordinates = None if pixels is None else part.coordinates
        highlights = look.highlights if with_colors else None
        parts.append(MeshPart(part.points * scaling, part.faces, color, highlights, coordinates, pixels))
    return parts, texture


def _parts_of_materials(world: World, path: str, *, has_looks: bool) -> tuple[list[Part], str]:
    """Return the parts of a file whose colours are in a library, if anywhere, and that library's path."""
    read = read_mesh(world, path)
    faces = read.faces.astype(np.int64)
    use, known = ObjUse("", ("",), np.zeros(len(faces), np.int64)), dict[str, ObjMaterial]()
    if path.lower().endswith(".obj") and has_looks:
        use = materials_used(file_of_server(world, path).read_bytes(), len(faces))
        known = dict(_library(world, path, use.library))
    pieces = by_material(read.points, faces, read.places, use, known)
    return [_with_used_points(each) for each in pieces if len(each.faces)], _beside(path, use.library)


def _with_used_points(part: Part) -> Part:
    """Return a part with the points that its faces use; MuJoCo takes four points at least."""
    used, index = np.unique(part.faces, return_inverse=True)
    kept = part.points[used]
    if len(kept) < 4:
        kept = np.vstack([kept, np.repeat(kept.mean(axis=0, keepdims=True), 4 - len(kept), axis=0)])
    return replace(part, points=kept, faces=index.reshape(-1, 3).astype(np.int64))


def _library(world: World, path: str, name: str) -> Mapping[str, ObjMaterial]:
    if not name:
        return {}
    try:
        found = file_of_server(world, _beside(path, name))
        if found.stat().st_size > _LARGEST_LIBRARY:
            raise CommandError(f"'{name}' has more than {_LARGEST_LIBRARY} bytes")
        return read_materials(found.read_bytes())
    except (CommandError, OSError) as problem:
        world.scripts.told_once.tell(f"the materials of '{path}' are not used: {problem}")
        return {}


def _image(world: World, path: str) -> Pixels | None:
    try:
        return fitted(read_image(world, path), _LARGEST_SIDE)
    except CommandError as problem:
        world.scripts.told_once.tell(f"a mesh has no texture: {problem}")
        return None


def _beside(path: str, name: str) -> str:
    """Return the path of a file that another one names."""
    return str(PurePosixPath(path).parent / name)
