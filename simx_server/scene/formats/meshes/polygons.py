"""PLY files, and STL files that MuJoCo does not read, as parts, by the library trimesh of the extra `urdf`."""

from __future__ import annotations

import importlib
import importlib.util
import io
import logging
from functools import cache
from typing import Any

import numpy as np

from simx_client.protocol.cli.installing import extra_line
from simx_server.scene.formats.annotations import SceneError

from .parts import MOST_TRIANGLES, Look, Part, merged

_STL_HEAD, _STL_TRIANGLE = 84, 50
"""Bytes of a binary STL file."""

_MUJOCO_TRIANGLES = 200_000
"""Most triangles of an STL file that MuJoCo reads."""

_FULL = 255.0


@cache
def is_available() -> bool:
    """Return whether the library is installed."""
    return importlib.util.find_spec("trimesh") is not None


def prepare() -> None:
    """Import the library now, if it is installed: a trial cannot open files later."""
    if is_available():
        for module in ("trimesh", "trimesh.exchange.ply", "trimesh.exchange.stl"):
            importlib.import_module(module)


def is_unusual_stl(data: bytes) -> bool:
    """Return whether MuJoCo does not read an STL file: a text, or one of too many triangles."""
    count = int.from_bytes(data[_STL_HEAD - 4 : _STL_HEAD], "little")
    if len(data) < _STL_HEAD or len(data) != _STL_HEAD + count * _STL_TRIANGLE:
        return data.lstrip()[:5].lower() == b"solid"
    return count > _MUJOCO_TRIANGLES


def read_polygons(data: bytes, name: str, ending: str) -> list[Part]:
    """Return the triangles of a PLY or STL file; many colours become their mean.

    Args:
        data: its bytes.
        name: its name in errors.
        ending: ``ply`` or ``stl``.

    Raises:
        SceneError: it cannot be read, or the library is not installed.
    """
    if not is_available():
        what = "a PLY file" if ending == "ply" else "an STL file as text or of very many triangles"
        raise SceneError(f"'{name}' is {what}; a library reads those: {extra_line('urdf')}")
    library: Any = importlib.import_module("trimesh")
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # it logs tracebacks of damaged files
    try:
        read = library.load(io.BytesIO(data), file_type=ending, process=False, force="mesh")
        points, faces = np.asarray(read.vertices, float), np.asarray(read.faces, np.int64)
        if len(faces) > MOST_TRIANGLES:
            raise SceneError(f"'{name}' has more than {MOST_TRIANGLES} triangles; make it coarser")
        return merged([Part(points, faces, _look(read))], name)
    except (MemoryError, SceneError):
        raise
    except Exception as error:  # the library does not say what it raises for a damaged file
        text = " ".join(str(error).split())[:200]
        raise SceneError(f"cannot read '{name}': {type(error).__name__}: {text}") from None


def _look(read: Any) -> Look:
    visual = read.visual
    if getattr(visual, "kind", None) not in ("vertex", "face"):
        return Look()
    colors = visual.vertex_colors if visual.kind == "vertex" else visual.face_colors
    red, green, blue, alpha = (float(each) for each in np.asarray(colors, float).mean(axis=0) / _FULL)
    return Look((red, green, blue, alpha))
