"""Materials of OBJ files: which triangles have which one, and the colours and images in their library (.mtl)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

_LINE = re.compile(rb"^[ \t]*(usemtl|mtllib)[ \t]+(.+?)[ \t\r]*$", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+(.+)$", re.MULTILINE)

Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class ObjMaterial:
    """One material of a library."""

    color: Rgb | None = None
    """Diffuse colour, 0..1."""
    highlights: float = 0.0
    """Mean of their colour."""
    opacity: float = 1.0
    image: str = ""
    """Name of the image file of the diffuse colour, relative to the library."""


@dataclass(frozen=True)
class ObjUse:
    """The materials that an OBJ file uses."""

    library: str
    """Name of its library, relative to the file; empty without one."""
    names: tuple[str, ...]
    """Names of the materials, in the order of their first use; at least one, which may be empty."""
    of_triangle: NDArray[np.int64]
    """(m,) index into `names` of each triangle."""


def library_of(obj: bytes) -> str:
    """Return the name of the library of an OBJ file; empty without one."""
    names = (found[2] for found in _LINE.finditer(obj) if found[1] == b"mtllib")
    return next(names, b"").decode("utf-8", "replace")


def materials_used(obj: bytes, count: int) -> ObjUse:
    """Return the materials of the triangles of an OBJ file, of which `count` were read.

    A polygon has as many triangles as corners but two. Where the numbers do not agree, all triangles have the material
    that is used first.
    """
    library = library_of(obj)
    uses = [
        (found.start(), found[2].decode("utf-8", "replace"))
        for found in _LINE.finditer(obj)
        if found[1] == b"usemtl"
    ]
    names = tuple(dict.fromkeys(name for _, name in uses)) or ("",)
    if len(names) == 1:
        return ObjUse(library, names, np.zeros(count, np.int64))
    ends = [start for start, _ in uses[1:]] + [len(obj)]
    runs = [(names[0], _triangles(obj, 0, uses[0][0]))]
    runs += [(name, _triangles(obj, start, end)) for (start, name), end in zip(uses, ends, strict=True)]
    each = np.repeat([names.index(name) for name, _ in runs], [number for _, number in runs])
    return ObjUse(library, names, each if len(each) == count else np.zeros(count, np.int64))


def _triangles(obj: bytes, start: int, end: int) -> int:
    """Return the number of triangles of the polygons in a part of a file."""
    return sum(max(0, len(face[1].split()) - 2) for face in _FACE.finditer(obj, start, end))


def read_materials(library: bytes) -> Mapping[str, ObjMaterial]:
    """Return the materials of a library by name. Lines that say something else, or nothing valid, are ignored."""
    found: dict[str, ObjMaterial] = {}
    name: str | None = None
    for line in library.decode("utf-8", "replace").splitlines():
        key, _, rest = line.strip().partition(" ")
        words = rest.split()
        if key == "newmtl":
            name = rest.strip()
            found[name] = ObjMaterial()
        elif name is None or not words:
            continue
        elif key == "Kd" and (color := _shares(words, 3)) is not None:
            found[name] = replace(found[name], color=(color[0], color[1], color[2]))
        elif key == "Ks" and (color := _shares(words, 3)) is not None:
            found[name] = replace(found[name], highlights=sum(color) / 3)
        elif key == "d" and (opacity := _shares(words, 1)) is not None:
            found[name] = replace(found[name], opacity=opacity[0])
        elif key == "map_Kd":
            image = words[-1] if words[0].startswith("-") else rest.strip()  # options come before the name
            found[name] = replace(found[name], image=image.replace("\\", "/"))
    return found


def _shares(words: list[str], count: int) -> list[float] | None:
    """Return numbers 0..1, each the nearest; None where there are none."""
    try:
        numbers = [float(word) for word in words[:count]]
    except ValueError:
        return None
    if len(numbers) < count or not np.isfinite(numbers).all():
        return None
    return [min(max(number, 0.0), 1.0) for number in numbers]
