"""Meshes, textures and height fields of a spec as files, from which MuJoCo reads the same numbers.

Meshes are OBJ: any mesh program reads and writes it, and it keeps vertices, triangles, normals and texture coordinates
apart as V-REP does. Numbers have as many digits as single precision needs, so reading gives the same ones; texture
coordinates count from the other side in OBJ and may change in the last bit.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from pathlib import PurePosixPath
from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from .asset_files import AssetFiles
from .file_names import file_stems

MESHES, TEXTURES, HEIGHTS, SKINS = "meshes", "textures", "heights", "skins"
"""Folders of the files."""

_Indices = NDArray[np.int64]


def take_out(spec: mujoco.MjSpec, folder: str = "") -> dict[str, bytes]:
    """Replace data in a spec, and the files that it names, by names of files.

    Args:
        folder: start of the names, with a slash at its end.

    Returns:
        The files, by path relative to the scene.

    Raises:
        SceneError: a file that the spec names is not there any more.
    """
    named, files = _take_files(spec, folder), dict[str, bytes]()
    for mesh, stem in _with_stems(spec.meshes):
        if not len(mesh.uservert):
            continue
        mesh.file = f"{folder}{MESHES}/{stem}.obj"
        files[mesh.file] = _obj(mesh)
        for name in _MESH_DATA:
            setattr(mesh, name, [])
    for texture, stem in _with_stems(spec.textures):
        if not len(texture.data):
            continue
        texture.file = f"{folder}{TEXTURES}/{stem}.png"
        files[texture.file] = _png(texture)
        texture.data = b""
        texture.width = texture.height = 0
    spec.assets = {}
    for field, stem in _with_stems(spec.hfields):
        if not len(field.userdata):
            continue
        field.file = f"{folder}{HEIGHTS}/{stem}.hfield"
        files[field.file] = _heights(field)
        field.userdata = []
        field.nrow = field.ncol = 0
    return files | named


def _take_files(spec: mujoco.MjSpec, start: str) -> dict[str, bytes]:
    """Give the files that a spec names new names; return them by these."""
    known, files = AssetFiles(spec), dict[str, bytes]()

    def taken(file: str, folder: str, stem: str) -> str:
        name = f"{start}{folder}/{stem}{PurePosixPath(file).suffix.lower() or known.suffix_of(file)}"
        files[name] = known.read(file)
        return name

    for assets, folder in (
        (spec.meshes, MESHES),
        (spec.textures, TEXTURES),
        (spec.hfields, HEIGHTS),
        (spec.skins, SKINS),
    ):
        for asset, stem in _with_stems(assets):
            if asset.file:
                asset.file = taken(asset.file, folder, stem)
            for side, file in enumerate(getattr(asset, "cubefiles", ())):
                if file:
                    asset.cubefiles[side] = taken(file, folder, f"{stem}_{side}")
    return files


_MESH_DATA = (
    "uservert", "userface", "usernormal", "userfacenormal", "usertexcoord", "userfacetexcoord"
)  # fmt: skip


def _with_stems(assets: Iterable[Any]) -> Iterator[tuple[Any, str]]:
    """Yield all assets of a kind with the stem of their files; no two stems are the same."""
    assets = list(assets)
    stems = file_stems(asset.name for asset in assets)
    return ((asset, stems[asset.name]) for asset in assets)


def _obj(mesh: Any) -> bytes:
    text = f"# {' '.join(mesh.name.split())}\n"
    text += _rows("v", _floats(mesh.uservert, 3))
    coordinates = _floats(mesh.usertexcoord, 2)
    coordinates[:, 1] = 1 - coordinates[:, 1]
    text += _rows("vt", coordinates)
    text += _rows("vn", _floats(mesh.usernormal, 3))
    corners = _indices(mesh.userface)
    parts = [
        corners,
        _corners_of(mesh.userfacetexcoord, mesh.usertexcoord, corners),
        _corners_of(mesh.userfacenormal, mesh.usernormal, corners),
    ]
    present = [part.ravel() + 1 for part in parts if part is not None]
    corner = "/".join("" if part is None else "%d" for part in parts).rstrip("/")
    text += (
        f"f {corner} {corner} {corner}\n" * len(corners) % tuple(np.stack(present, axis=1).ravel().tolist())
    )
    return text.encode()


def _corners_of(own: Any, values: Any, corners: _Indices) -> _Indices | None:
    """Return the indices of a mesh's normals or coordinates: its own ones, or those of the corners; None without."""
    if len(own):
        return _indices(own)
    return corners if len(values) else None


def _rows(word: str, numbers: NDArray[np.float32]) -> str:
    """Return a line for each row; nine digits are enough for any number in single precision."""
    form = " ".join([word, *["%.9g"] * numbers.shape[1]]) + "\n"
    return form * len(numbers) % tuple(numbers.ravel().tolist())


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
