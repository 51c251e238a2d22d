"""Write a scene with its compiled model as bytes, and make both again in another process.

The model's numbers are MuJoCo's own binary form, so they stay the same bit for bit. The spec, from which the next edit
makes another model, is MJCF with all digits. Data of meshes, textures and height fields lie beside it, because MJCF is
slow to write and to read with them: small ones take their places in the text.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from simx_server.scene.assets.naming import is_name
from simx_server.scene.formats.exporting.folder import text_of
from simx_server.scene.objects import Scene

from .packing import NotPackable, pack, unpack

_OF_SCENE = (
    "objects", "path", "next_handle", "annotations", "parent_overrides", "welded_bodies", "weightless_bodies",
    "hidden_bodies", "unseen_sites", "slots", "is_edited_in_place", "model_properties", "made_static", "withheld",
    "owners",
)  # fmt: skip
"""Attributes of a scene that do not follow from others."""

_GIVEN = ("objects", "path", "next_handle", "annotations")

_MESH: Mapping[str, Any] = dict.fromkeys(
    ("uservert", "userface", "usernormal", "userfacenormal", "usertexcoord", "userfacetexcoord"), ()
)
_TEXTURE: Mapping[str, Any] = {"data": b"", "width": 0, "height": 0}
_HEIGHTS: Mapping[str, Any] = {"userdata": (), "nrow": 0, "ncol": 0}
"""Attributes that hold an asset's data, and their values where a file holds it."""

_KINDS: tuple[tuple[str, str, str, Mapping[str, Any]], ...] = (
    ("meshes", "uservert", "kept/octahedron.obj", _MESH),
    ("textures", "data", "kept/pixel.png", _TEXTURE),
    ("hfields", "userdata", "kept/plain.hfield", _HEIGHTS),
)
"""List of assets, attribute with most of the data, file in its place, all attributes."""

_CORNERS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))
_SIDES = ((1, 3, 5), (3, 2, 5), (2, 4, 5), (4, 1, 5), (3, 1, 6), (2, 3, 6), (4, 2, 6), (1, 4, 6))


_Data = dict[str, dict[str, dict[str, Any]]]
"""By kind of asset and name: attributes."""


def pack_model(scene: Scene, model: mujoco.MjModel) -> bytes:
    """Return scene and model as bytes. Raises NotPackable: the scene has something that MJCF cannot have."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    spec = scene.spec.copy()
    files = dict(scene.spec.assets)
    spec.assets = {**files, **_small_files()}
    try:
        data = _take_data(spec)
        _name_by_whole_paths(spec, files)
        text = text_of(spec)
    except (ValueError, RuntimeError, OSError, mujoco.FatalError) as error:
        raise NotPackable(f"the scene as MJCF: {' '.join(str(error).split())}") from error
    return pack(({name: getattr(scene, name) for name in _OF_SCENE}, text, files, data, buffer.tobytes()))


def unpack_model(packed: bytes) -> tuple[Scene, mujoco.MjModel]:
    """Return what `pack_model` was given. Raises NotPackable."""
    try:
        of_scene, text, files, data, binary = unpack(packed)
        spec = mujoco.MjSpec.from_string(text.decode(), assets={**files, **_small_files()})
        spec.assets = files
        for kind, by_name in data.items():
            assets = {asset.name: asset for asset in getattr(spec, kind)}
            for name, attributes in by_name.items():
                for attribute, value in attributes.items():
                    setattr(assets[name], attribute, value)
        model = mujoco.MjModel.from_binary_path("kept.mjb", {"kept.mjb": binary})
        objects, path, next_handle, annotations = (of_scene[name] for name in _GIVEN)
        scene = Scene(objects, spec, path, next_handle, annotations)
        for name in _OF_SCENE[len(_GIVEN) :]:
            setattr(scene, name, of_scene[name])
    except (ValueError, TypeError, KeyError, RuntimeError, mujoco.FatalError) as error:
        raise NotPackable(f"no packed scene: {' '.join(str(error).split())}") from error
    return scene, model


def _take_data(spec: mujoco.MjSpec) -> _Data:
    """Replace the data of assets by small files, and return it."""
    taken: _Data = {}
    for kind, most, file, plain in _KINDS:
        by_name = taken[kind] = {}
        for asset in getattr(spec, kind):
            if is_name(asset.file):
                by_name[asset.name] = {"file": asset.file}
                asset.file = file
            elif len(getattr(asset, most)):
                by_name[asset.name] = {name: _copied(getattr(asset, name)) for name in plain}
                by_name[asset.name]["file"] = asset.file
                for name, value in plain.items():
                    setattr(asset, name, value)
                asset.file = file
    return taken


@cache
def _small_files() -> Mapping[str, bytes]:
    """Return the files that take the places of data. The mesh is one whose shapes MuJoCo leaves where they are."""
    import cv2

    lines = [f"v {x} {y} {z}" for x, y, z in _CORNERS] + [f"f {a} {b} {c}" for a, b, c in _SIDES]
    _, pixel = cv2.imencode(".png", np.zeros((1, 1, 3), np.uint8))
    contents = ("\n".join(lines).encode(), pixel.tobytes(), struct.pack("<ii4f", 2, 2, 0, 0, 0, 0))
    return {file: content for (_, _, file, _), content in zip(_KINDS, contents, strict=True)}


def _copied(value: Any) -> Any:
    return value if isinstance(value, int | bytes) else np.array(value)


def _name_by_whole_paths(spec: mujoco.MjSpec, files: Mapping[str, bytes]) -> None:
    """Let the spec name files of the disk so that they are found from any folder."""
    folder = Path(spec.modelfiledir or ".")
    many: tuple[tuple[str, str], ...] = (
        ("meshes", spec.meshdir),
        ("hfields", spec.meshdir),
        ("skins", spec.meshdir),
        ("textures", spec.texturedir),
    )
    for kind, below in many:
        for asset in getattr(spec, kind):
            if asset.file and asset.file not in files and (path := folder / below / asset.file).is_file():
                asset.file = str(path.resolve())
