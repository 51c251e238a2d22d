"""Mesh files that scripts import: their triangles, and the colours and textures of their materials."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.editing.creating import GREY
from simx_server.editing.imported_meshes import Color, MeshPart
from simx_server.errors import CommandError
from simx_server.files.image_files import Pixels, fitted
from simx_server.scene.formats.meshes.naming import plain_name
from simx_server.scene.formats.meshes.obj_materials import ObjMaterial, ObjUse, materials_used, read_materials
from simx_server.scene.formats.meshes.parts import Part
from simx_server.scene.formats.meshes.reading import COLORED

from .script_files import file_of_server, read_image, read_mesh, read_mesh_parts

if TYPE_CHECKING:
    from simx_server.world.world import World

_LARGEST_SIDE = 512
"""Pixels: V-REP makes larger textures of imported files smaller."""

_MIRROR, _SHIFT = np.array([1.0, -1.0], np.float32), np.array([0.0, 1.0], np.float32)

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
        read_parts = read_mesh_parts(world, path, turns=turns)
        return _colored_parts(world, path, read_parts, scaling, with_colors, with_textures)
    read = read_mesh(world, path)
    points, faces = read.points * scaling, read.faces.astype(np.int64)
    # MuJoCo turns the places of OBJ files upside down, as it does with images.
    places = None if read.places is None else read.places * _MIRROR + _SHIFT
    use, known = ObjUse("", ("",), np.zeros(len(faces), np.int64)), dict[str, ObjMaterial]()
    if path.lower().endswith(".obj") and (with_colors or with_textures):
        use = materials_used(file_of_server(world, path).read_bytes(), len(faces))
        known = dict(_library(world, path, use.library))
    parts: list[MeshPart] = []
    texture = "texture"
    for number, name in enumerate(use.names):
        chosen = use.of_triangle == number
        if not chosen.any():
            continue
        material = known.get(name, ObjMaterial())
        pixels = None
        if with_textures and material.image and places is not None:
            pixels = _image(world, _beside(_beside(path, use.library), material.image))
            texture = PurePosixPath(material.image).stem if not parts else texture
        own_points, own_faces = _used(points, faces[chosen])
        color = _color(material) if with_colors else GREY
        own_places = None if pixels is None or places is None else places[chosen]
        highlights = material.highlights if with_colors and name in known else None
        parts.append(MeshPart(own_points, own_faces, color, highlights, own_places, pixels))
    return parts, texture


def _colored_parts(
    world: World, path: str, found: list[Part], scaling: float, with_colors: bool, with_textures: bool
) -> tuple[list[MeshPart], str]:
    """Return what `parts_of_file` does, of the parts of a format with its own colours."""
    parts: list[MeshPart] = []
    texture = "texture"
    for part in found:
        look, pixels = part.look, None
        if with_textures and look.image and part.coordinates is not None:
            image = plain_name(look.image)
            pixels = _image(world, _beside(path, image))
            texture = PurePosixPath(image).stem if not parts else texture
        color = (look.color if with_colors else None) or GREY
        coordinates = None if pixels is None else part.coordinates
        highlights = look.highlights if with_colors else None
        parts.append(MeshPart(part.points * scaling, part.faces, color, highlights, coordinates, pixels))
    return parts, texture


def _used(
    points: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the points that faces use, and the faces with their indices; MuJoCo takes four points at least."""
    used, index = np.unique(faces, return_inverse=True)
    kept = points[used]
    if len(kept) < 4:
        kept = np.vstack([kept, np.repeat(kept.mean(axis=0, keepdims=True), 4 - len(kept), axis=0)])
    return kept, index.reshape(-1, 3).astype(np.int64)


def _library(world: World, path: str, name: str) -> Mapping[str, ObjMaterial]:
    if not name:
        return {}
    try:
        found = file_of_server(world, _beside(path, name))
        if found.stat().st_size > _LARGEST_LIBRARY:
            raise CommandError(f"'{name}' has more than {_LARGEST_LIBRARY} bytes")
        return read_materials(found.read_bytes())
    except (CommandError, OSError) as problem:
        world.scripts.say_once(f"the materials of '{path}' are not used: {problem}")
        return {}


def _image(world: World, path: str) -> Pixels | None:
    try:
        return fitted(read_image(world, path), _LARGEST_SIDE)
    except CommandError as problem:
        world.scripts.say_once(f"a mesh has no texture: {problem}")
        return None


def _beside(path: str, name: str) -> str:
    """Return the path of a file that another one names."""
    return str(PurePosixPath(path).parent / name)


def _color(material: ObjMaterial) -> Color:
    red, green, blue = material.color or GREY[:3]
    return red, green, blue, material.opacity
