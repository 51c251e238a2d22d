"""Names of files in memory, made from their contents: equal contents have one name, in every scene.

MuJoCo keeps what it has made of a file (a mesh with its hull, an image's pixels) under the file's name. With these
names it finds that again in the next compile, in another scene and after a model was loaded again.
"""

from __future__ import annotations

import hashlib
import re

import mujoco

_FOLDER = "/~simx/"
"""An absolute path: no folder of the scene or of a model is put before it. No such folder is on the disk."""

_NAME = re.compile(rf"{_FOLDER}.*?([0-9a-f]{{32}}\.\w+)")


def name_of(data: bytes, suffix: str) -> str:
    """Return the name of a file with this content; `suffix` with its dot, which tells MuJoCo the format."""
    return f"{_FOLDER}{hashlib.blake2b(data, digest_size=16).hexdigest()}{suffix}"


def is_name(file: str) -> bool:
    """Return whether a file is one in memory."""
    return file.startswith(_FOLDER)


def take_files(spec: mujoco.MjSpec) -> dict[str, bytes]:
    """Take the files in memory from a spec's assets, and return them.

    `MjSpec.attach` would rename them, and warns where only one of two specs has assets.
    """
    files: dict[str, bytes] = spec.assets
    return {name: files.pop(name) for name in list(files) if is_name(name)}


def rename_attached(spec: mujoco.MjSpec) -> None:
    """Restore the names of files in memory that `MjSpec.attach` has given a prefix, as it does beside other files."""
    for asset in (*spec.meshes, *spec.textures):
        found = _NAME.fullmatch(asset.file)
        if found is not None:
            asset.file = _FOLDER + found[1]
