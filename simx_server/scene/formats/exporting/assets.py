"""Meshes, textures and height fields of a spec as files, from which MuJoCo reads the same numbers.

Meshes are OBJ: any mesh program reads and writes it, and it keeps vertices, triangles, normals and texture coordinates
apart as V-REP does. Numbers have as many digits as single precision needs, so reading gives the same ones; texture
coordinates count from the other side in OBJ and may change in the last bit.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from .file_names import file_stems

MESHES, TEXTURES, HEIGHTS = "meshes", "textures", "heights"
"""Folders of the files."""

_Indices = NDArray[np.int64]


def take_out(spec: mujoco.MjSpec) -> dict[str, bytes]:
    """Replace data in a spec by names of files; return the files, by path relative to the scene."""
    files: dict[str, bytes] = {}
    meshes = [mesh for mesh in spec.meshes if len(mesh.uservert)]
    for mesh, stem in _with_stems(meshes):
        files[f"{MESHES}/{stem}.obj"] = _obj(mesh)
        mesh.file = f"{MESHES}/{stem}.obj"
        for name in _MESH_DATA:
            setattr(mesh, name, [])
    images = dict(spec.assets)
    textures = [texture for texture in spec.textures if len(texture.data) or texture.file in images]
    for texture, stem in _with_stems(textures):
        files[f"{TEXTURES}/{stem}.png"] = images.get(texture.file) or _png(texture)
        texture.file = f"{TEXTURES}/{stem}.png"
        texture.data = b""
        texture.width = texture.height = 0
    spec.assets = {}
    fields = [field for field in spec.hfields if len(field.userdata)]
    for field, stem in _with_stems(fields):
        files[f"{HEIGHTS}/{stem}.hfield"] = _heights(field)
        field.file = f"{HEIGHTS}/{stem}.hfield"
        field.userdata = []
        field.nrow = field.ncol = 0
    return files


_MESH_DATA = (
    "uservert", "userface", "usernormal", "userfacenormal", "usertexcoord", "userfacetexcoord"
)  # fmt: skip


def _with_stems(assets: list[Any]) -> Iterator[tuple[Any, str]]:
    stems = file_stems(asset.name for asset in assets)
    return ((asset, stems[asset.name]) for asset in assets)


def _obj(mesh: Any) -> bytes:
    lines = [f"# {mesh.name}"]
    lines += _rows("v", _floats(mesh.uservert, 3))
    coordinates = _floats(mesh.usertexcoord, 2)
    coordinates[:, 1] = 1 - coordinates[:, 1]
    lines += _rows("vt", coordinates)
    lines += _rows("vn", _floats(mesh.usernormal, 3))
    corners = _indices(mesh.userface)
    parts = [
        corners,
        _corners_of(mesh.userfacetexcoord, mesh.usertexcoord, corners),
        _corners_of(mesh.userfacenormal, mesh.usernormal, corners),
    ]
    written = ["" if part is None else np.char.mod("%d", part + 1) for part in parts]
    joined = np.char.add(np.char.add(written[0], "/"), np.char.add(np.char.add(written[1], "/"), written[2]))
    plain = np.char.rstrip(joined, "/")
    lines += [f"f {a} {b} {c}" for a, b, c in plain.tolist()]
    return ("\n".join(lines) + "\n").encode()


def _corners_of(own: Any, values: Any, corners: _Indices) -> _Indices | None:
    """Return the indices of a mesh's normals or coordinates: its own ones, or those of the corners; None without."""
    if len(own):
        return _indices(own)
    return corners if len(values) else None


def _rows(word: str, numbers: NDArray[np.float32]) -> list[str]:
    return [" ".join([word, *map(str, row)]) for row in numbers]


def _floats(values: Any, columns: int) -> NDArray[np.float32]:
    return np.array(values, np.float32).reshape(-1, columns)


def _indices(values: Any) -> _Indices:
    return np.array(values, np.int64).reshape(-1, 3)


def _png(texture: Any) -> bytes:
    pixels = np.frombuffer(bytes(texture.data), np.uint8)
    pixels = pixels.reshape(texture.height, texture.width, texture.nchannel)
    order = {1: [0], 3: [2, 1, 0], 4: [2, 1, 0, 3]}[texture.nchannel]
    _, data = cv2.imencode(".png", pixels[..., order])
    return data.tobytes()


def _heights(field: Any) -> bytes:
    return struct.pack("<ii", field.nrow, field.ncol) + np.array(field.userdata, "<f4").tobytes()
