"""COLLADA files (.dae) as parts, by the library pycollada, which is in the extra `urdf`.

As in RViz the file's unit applies, and its up axis does not: meshes of robots are drawn in the frames of their links.
"""

from __future__ import annotations

import importlib
import importlib.util
import io
import warnings
from collections.abc import Collection, Iterator, Sequence
from functools import cache
from typing import Any, cast
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.cli.installing import extra_line
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.xml_texts import refuse_entities

from .parts import Look, Part, Rgba, merged

_ZIP = b"PK\x03\x04"

_MOST_PIECES = 100_000
"""Most placed pieces of geometry in one file."""

_BLACK = 0.01
"""Sum of red, green and blue below which a colour is black."""

_UP = {
    "X_UP": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "Y_UP": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
}
"""Rotations of points, so that the up axis of the file becomes z."""


@cache
def is_available() -> bool:
    """Return whether the library is installed."""
    return importlib.util.find_spec("collada") is not None


def prepare() -> None:
    """Import the library now, if it is installed: a trial cannot open files later."""
    if is_available():
        for module in ("collada", "numpy.ma"):
            importlib.import_module(module)


def read_collada(data: bytes, name: str, *, turns: bool) -> list[Part]:
    """Return the visible scene of a COLLADA file.

    Args:
        data: its bytes.
        name: its name in errors.
        turns: whether to turn the file's up axis to z.

    Raises:
        SceneError: it cannot be read, or the library is not installed.
    """
    if not is_available():
        raise SceneError(f"'{name}' is a COLLADA file; a library reads those: {extra_line('urdf')}")
    if data.startswith(_ZIP):
        raise SceneError(f"'{name}' is a packed COLLADA file; unpack it")
    if not refuse_entities(data, name):
        raise SceneError(
            f"cannot read '{name}': it is no valid COLLADA: no well-formed XML in a usual encoding"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PendingDeprecationWarning)  # the library uses numpy.matrix
            return merged(_pieces(_document(data), turns, name), name)
    except (MemoryError, SceneError):
        raise
    except RecursionError:
        raise SceneError(f"'{name}' is nested too deeply") from None
    except Exception as error:  # the library does not say what it raises for a damaged file
        text = " ".join(str(error).split())[:200]
        raise SceneError(
            f"cannot read '{name}': it is no valid COLLADA: {type(error).__name__}: {text}"
        ) from None


def _document(data: bytes) -> Any:
    library: Any = importlib.import_module("collada")
    ignored = [library.common.DaeUnsupportedError, library.common.DaeBrokenRefError]
    document = library.Collada(io.BytesIO(data), ignore=ignored, aux_file_loader=_no_file)
    if any(isinstance(error, library.common.DaeBrokenRefError) for error in document.errors):
        known = {material.id for material in document.materials}
        whole = _without_materials(data, known)
        document = library.Collada(io.BytesIO(whole), ignore=ignored, aux_file_loader=_no_file)
    return document


def _no_file(_name: str) -> bytes:
    """Stand for the content of an image: the library must not open files."""
    return b""


def _without_materials(data: bytes, known: Collection[str]) -> bytes:
    """Return the text without uses of unknown materials, for which the library leaves out the geometry too."""
    root = ElementTree.fromstring(data)
    for parent in root.iter():
        for child in list(parent):
            if child.tag.endswith("instance_material") and child.get("target", "#")[1:] not in known:
                parent.remove(child)
    return ElementTree.tostring(root)


def _pieces(document: Any, turns: bool, name: str) -> Iterator[Part]:
    if document.scene is None:
        return
    scale = float(document.assetInfo.unitmeter or 1.0)
    turn = _UP.get(str(document.assetInfo.upaxis), np.eye(3)) if turns else np.eye(3)
    count = 0
    for geometry in document.scene.objects("geometry"):
        is_mirrored = bool(np.linalg.det(np.asarray(geometry.matrix, float)[:3, :3]) < 0)
        for primitive in geometry.primitives():
            count += 1
            if count > _MOST_PIECES:
                raise SceneError(f"'{name}' has more than {_MOST_PIECES} pieces; join some")
            triangles = primitive.triangleset() if hasattr(primitive, "triangleset") else primitive
            if not hasattr(triangles, "vertex_index") or type(triangles).__name__ == "BoundLineSet":
                continue
            part = _piece(triangles, is_mirrored)
            if part is not None:
                yield Part(part.points * scale @ turn.T, part.faces, part.look, part.coordinates)


def _piece(triangles: Any, is_mirrored: bool) -> Part | None:
    if triangles.vertex_index is None or not len(triangles.vertex_index):
        return None
    faces = np.asarray(triangles.vertex_index, np.int64).reshape(-1, 3)
    points = np.asarray(triangles.vertex, float).reshape(-1, 3)
    look = _look(triangles.material)
    coordinates = _coordinates(triangles, len(faces)) if look.image else None
    if is_mirrored:
        faces = faces[:, ::-1]
        coordinates = None if coordinates is None else coordinates[:, ::-1]
    return Part(points, faces, look, coordinates)


def _coordinates(triangles: Any, count: int) -> NDArray[np.float32] | None:
    if not triangles.texcoordset:
        return None
    places = np.asarray(triangles.texcoordset[0], np.float32)
    index = np.asarray(triangles.texcoord_indexset[0], np.int64).reshape(count, 3)
    return places[index, :2]


def _look(material: Any) -> Look:
    effect = getattr(material, "effect", None)
    if effect is None:
        return Look()
    diffuse, emission = effect.diffuse, _color(effect.emission)
    color, image = _color(diffuse), ""
    if color is None and diffuse is not None:
        image = str(diffuse.sampler.surface.image.path)
        color = (1.0, 1.0, 1.0, 1.0)
    if emission is not None and sum(emission[:3]) > _BLACK and (color is None or sum(color[:3]) < _BLACK):
        color = emission  # some programs write the colour of a mesh as its light
    if color is not None:
        color = (*color[:3], color[3] * _opacity(effect))
    specular = _color(effect.specular)
    return Look(color, None if specular is None else sum(specular[:3]) / 3, image)


def _opacity(effect: Any) -> float:
    """Return 0..1. Some programs write the opposite; an invisible mesh is opaque."""
    transparent, share = _color(effect.transparent), effect.transparency
    if transparent is None and share is None:
        return 1.0
    red, green, blue, alpha = transparent or (0.0, 0.0, 0.0, 1.0)
    amount = float(share) if isinstance(share, int | float) else 1.0
    if effect.opaque_mode == "RGB_ZERO":
        value = 1.0 - (red + green + blue) / 3 * amount
    else:
        value = alpha * amount
    return value if _BLACK < value <= 1.0 else 1.0


def _color(value: Any) -> Rgba | None:
    if not isinstance(value, tuple | list):
        return None
    given = cast("Sequence[Any]", value)
    numbers = [float(each) for each in given[:4]]
    if len(numbers) < 3 or not np.isfinite(numbers).all():
        return None
    red, green, blue, alpha = (min(max(each, 0.0), 1.0) for each in (*numbers, 1.0)[:4])
    return red, green, blue, alpha or 1.0
