"""The meshes of a URDF: where their files are, and those that MuJoCo does not read as meshes of its spec.

A visual mesh of a COLLADA, PLY or OBJ file becomes one geom for each material of the file, with the colour or the image
of the material; as in RViz the file's own colours precede the URDF's. A colliding mesh stays one geom.
"""

from __future__ import annotations

import copy
import logging
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.files.image_files import Pixels, decoded, encoded, fitted
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.meshes.naming import beside
from simx_server.scene.formats.meshes.parts import Part, as_one
from simx_server.scene.formats.meshes.reading import is_mujocos, lacks_library, read_parts
from simx_server.scene.formats.sources import Sources

from .names import MOST_NAMED, some

logger = logging.getLogger(__name__)

_BY_LIBRARY = (".dae", ".ply")
_READABLE = (".stl", ".obj", ".msh", *_BY_LIBRARY)
_TWINS = (".stl", ".STL", ".obj", ".OBJ")
"""Endings of a mesh that replaces a file with the same stem, for which a library is not installed."""

_LARGEST_SIDE = 1024
"""Pixels of a texture; larger ones become smaller."""


@dataclass
class Meshes:
    """The parts that stand for files, until the spec is there."""

    parts: dict[str, tuple[Part, Path]] = field(default_factory=dict[str, tuple[Part, Path]])
    """Part and its file, by the name that stands for it in the text for MuJoCo."""


def resolve_meshes(root: ElementTree.Element, name: str, file: Path | None, sources: Sources) -> Meshes:
    """Give every mesh a full path, or the names of its parts.

    A visual mesh that is damaged is left out, with a warning.

    Raises:
        SceneError: a mesh is missing, a library for it is missing, or a colliding one cannot be read.
    """
    found = Meshes()
    paths: dict[str, Path | None] = {}
    missing: dict[str, None] = {}
    left_out: dict[str, str] = {}
    read: dict[Path, list[Part] | None] = {}
    for link in root.iter("link"):
        for place in [each for each in link if each.tag in ("visual", "collision")]:
            for mesh in list(place.iter("mesh")):
                uri = mesh.attrib.pop("filename", "")
                if uri not in paths:
                    paths[uri] = find_mesh(uri, root, file, sources)
                path = paths[uri]
                if path is None:
                    missing[uri] = None
                    continue
                try:
                    if path not in read:
                        read[path] = _parts(path, sources)
                    _put(link, place, mesh, path, read[path], found)
                except SceneError as problem:
                    if place.tag == "collision":
                        raise
                    left_out[uri] = str(problem)
                    link.remove(place)
                break
    if missing:
        tried = list(_candidates(next(iter(missing)), root, file, sources))
        raise SceneError(_not_found(name, list(missing), tried, file, sources))
    for uri, problem in list(left_out.items())[:MOST_NAMED]:
        logger.warning("'%s' is drawn without '%s': %s", name, uri, problem)
    return found


def _parts(path: Path, sources: Sources) -> list[Part] | None:
    """Return the parts of a file; None where MuJoCo reads it."""
    if path.suffix.lower() not in _READABLE:
        raise SceneError(
            f"'{path.name}' is no mesh file of a known format; those end with {', '.join(_READABLE)}"
        )
    try:
        if is_mujocos(path, sources.read(path)):
            return None
        return read_parts(path, path.name, sources)
    except OSError as error:
        raise SceneError(f"cannot read '{path.name}': {error.strerror}") from None


def _put(
    link: ElementTree.Element,
    place: ElementTree.Element,
    mesh: ElementTree.Element,
    path: Path,
    parts: list[Part] | None,
    found: Meshes,
) -> None:
    """Write the file, or its parts, into the text."""
    if parts is None:
        mesh.set("filename", path.as_posix())
        return
    if place.tag == "collision":
        parts = [as_one(parts)]
    places = [place, *(copy.deepcopy(place) for _ in parts[1:])]
    at = list(link).index(place)
    for offset, each in enumerate(places[1:], 1):
        each.attrib.pop("name", None)  # names of geoms are unique
        link.insert(at + offset, each)
    for number, (each, part) in enumerate(zip(places, parts, strict=True)):
        stand_in = f"{path.as_posix()}#{place.tag}{number}.obj"
        found.parts[stand_in] = part, path
        for element in each.iter("mesh"):
            element.set("filename", stand_in)


def put_in_parts(spec: mujoco.MjSpec, meshes: Meshes, sources: Sources) -> None:
    """Give the parts to the meshes of a spec that stand for them, and their looks to the geoms."""
    looks: dict[str, tuple[Part, Path]] = {}
    colliding = {geom.meshname for geom in spec.geoms if geom.contype or geom.conaffinity}
    for mesh in spec.meshes:
        if mesh.file not in meshes.parts:
            continue
        part, path = meshes.parts[mesh.file]
        looks[mesh.name] = part, path
        mesh.file = ""
        # The mass of a link without one is that of its colliding hulls; other meshes may be flat.
        inertias = mujoco.mjtMeshInertia
        mesh.inertia = (
            inertias.mjMESH_INERTIA_CONVEX if mesh.name in colliding else inertias.mjMESH_INERTIA_SHELL
        )
        mesh.uservert = part.points.ravel()
        mesh.userface = part.faces.ravel().astype(np.int32)
        if part.coordinates is not None:
            mesh.usertexcoord = part.coordinates.astype(np.float32).ravel()
            mesh.userfacetexcoord = np.arange(3 * len(part.faces), dtype=np.int32)
    painter = _Painter(spec, sources)
    for geom in spec.geoms:
        if geom.meshname in looks and geom.contype == geom.conaffinity == 0:
            painter.paint(geom, *looks[geom.meshname])


class _Painter:
    """Gives geoms the looks of the parts; equal looks share a material."""

    def __init__(self, spec: mujoco.MjSpec, sources: Sources) -> None:
        self._spec, self._sources = spec, sources
        self._materials: dict[tuple[object, ...], str] = {}
        self._textures: dict[Path, str | None] = {}

    def paint(self, geom: Any, part: Part, path: Path) -> None:
        look = part.look
        if look.color is not None:
            geom.rgba = list(look.color)
        image = None
        if look.image and part.coordinates is not None:
            image = beside(path, self._sources)(look.image)
        texture = None if image is None else self._texture(image)
        if look.color is None or (texture is None and look.highlights is None):
            return
        key = (look.color, look.highlights, texture)
        if key not in self._materials:
            material = self._spec.add_material(name=f"urdf_material{len(self._materials)}")
            material.rgba = list(look.color)
            if look.highlights is not None:
                material.specular = look.highlights
            if texture is not None:
                material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture
            self._materials[key] = material.name
        geom.material = self._materials[key]

    def _texture(self, image: Path) -> str | None:
        if image not in self._textures:
            pixels = self._pixels(image)
            if pixels is None:
                self._textures[image] = None
                return None
            name = f"urdf_texture{len(self._textures)}"
            texture = self._spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D)
            texture.file = f"{name}.png"  # a spec with bare pixels cannot be written as MJCF
            self._spec.assets[texture.file] = encoded(pixels, ".png")
            self._textures[image] = name
        return self._textures[image]

    def _pixels(self, image: Path) -> Pixels | None:
        if self._sources.contents is not None and self._sources.is_of_client is None:
            return None  # a trial, which need not be drawn
        try:
            data = self._sources.read(image)
            if not self._sources.trusts(image, data):
                logger.warning("'%s' does not become a texture: a client has sent it", image.name)
                return None
            pixels = decoded(data, is_trusted=self._sources.within is None)
            # The first row lies at v = 0.
            return fitted(np.ascontiguousarray(pixels[::-1, :, :3]), _LARGEST_SIDE)
        except (CommandError, OSError) as problem:
            logger.warning("'%s' does not become a texture: %s", image.name, problem)
            return None


def find_mesh(uri: str, root: ElementTree.Element, file: Path | None, sources: Sources) -> Path | None:
    """Return the file that a mesh's URI means; None if it is not there.

    For a file whose format needs a missing library, one beside it that MuJoCo reads comes first.
    """
    ending = Path(uri).suffix.lower()
    itself = list(_candidates(uri, root, file, sources))
    if ending in _READABLE and not (ending in _BY_LIBRARY and lacks_library(ending)):
        return sources.first(itself)
    return sources.first(
        [*(path.with_suffix(twin) for path in itself if path.suffix for twin in _TWINS), *itself]
    )


def _candidates(uri: str, root: ElementTree.Element, file: Path | None, sources: Sources) -> Iterator[Path]:
    """Yield the files that a mesh's URI may mean; the last one is that of MuJoCo's own reader."""
    yield from sources.candidates(uri, file)
    if file is not None and "://" not in uri:
        compiler = root.find("mujoco/compiler")
        folder = file.parent / ("" if compiler is None else compiler.get("meshdir", ""))
        yield folder / uri
        yield folder / Path(uri.replace("\\", "/")).name


def _not_found(name: str, missing: list[str], tried: list[Path], file: Path | None, sources: Sources) -> str:
    """Return the error text for missing meshes; `tried`: files searched for the first URI."""
    uri = missing[0]
    packages = [each.split("://", 1)[1].partition("/")[0] for each in missing if "://" in each[:10]]
    packages = [each for each in dict.fromkeys(packages) if each]
    known = [
        each
        for each in packages
        if any(f.is_dir() for f in sources.package_folders(each, file) if sources.allows(f))
    ]
    text = f"'{name}' names {some(missing)}, which {'is' if len(missing) == 1 else 'are'} not there"
    if uri.startswith("file:") or "://" not in uri:
        places = [str(path) for path in dict.fromkeys(tried) if sources.allows(path)]
        return (
            f"{text}; looked for {' and '.join(places) or 'nothing, since it lies outside the open folders'}"
        )
    if unknown := [each for each in packages if each not in known]:
        return (
            f"{text}; no folder of the package {' or '.join(unknown)} was found above the file or in "
            f"ROS_PACKAGE_PATH: start the server with --package {unknown[0]}=DIR"
        )
    places = [str(path) for path in dict.fromkeys(tried) if sources.allows(path) and path.parent.is_dir()]
    return f"{text}; looked for {' and '.join(places[:MOST_NAMED]) or 'it in package ' + packages[0]}"
