"""The bytes of the files that a spec names: meshes, textures, height fields, skins."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

import mujoco

from simx_server.files.regular_files import is_file, read_of_client
from simx_server.scene.formats.annotations import SceneError

_ENDINGS = ((b"\x89PNG", ".png"), (b"solid", ".stl"), (b"KTX", ".ktx"))
"""First bytes of files, and the ending that tells MuJoCo their format."""


class AssetFiles:
    """The files that one spec names: those that it holds, and those of the disk."""

    def __init__(self, spec: mujoco.MjSpec) -> None:
        self._held: dict[str, bytes] = dict(spec.assets)
        self._folder = spec.modelfiledir
        self._folders = dict.fromkeys(("", spec.meshdir, spec.texturedir))

    def read(self, file: str) -> bytes:
        """Return the bytes of a file. Raises SceneError: it is not there any more."""
        for place in self._places(file):
            if (data := self._held.get(place)) is not None:
                return data
        path = self.path(file)
        if path is not None:
            return read_of_client(path)
        raise SceneError(
            f"the scene names the file '{file}', which is not there any more; bring it back to where the scene is"
        )

    def path(self, file: str) -> Path | None:
        """Return the path of a file of the disk; None for one that the spec holds, or that is not there."""
        if any(place in self._held for place in self._places(file)):
            return None
        places = (place for place in map(Path, self._places(file)) if place.is_absolute() and is_file(place))
        return next(places, None)

    def suffix_of(self, file: str) -> str:
        """Return the ending of a file whose name has none, by its content."""
        start = self.read(file)[:8]
        return next((ending for first, ending in _ENDINGS if start.startswith(first)), "")

    def _places(self, file: str) -> Iterator[str]:
        """Yield the names and paths under which a file may be found, as MuJoCo searches it."""
        for folder in self._folders:
            yield os.path.join(folder, file)
            yield os.path.normpath(os.path.join(self._folder, folder, file))
        yield PurePosixPath(file).name


def give_full_paths(spec: mujoco.MjSpec) -> None:
    """Name the files of the disk by their full paths: a spec that is added to another one loses its folder."""
    known = AssetFiles(spec)
    for assets in (spec.meshes, spec.textures, spec.hfields, spec.skins):
        for asset in assets:
            if asset.file and (path := known.path(asset.file)) is not None:
                asset.file = path.as_posix()
