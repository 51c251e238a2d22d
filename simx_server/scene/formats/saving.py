"""Save a scene file as one MJCF file, for example a converted URDF for further editing."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import mujoco

from .annotations import SceneError
from .loader import compile_spec
from .sources import Sources
from .specs import read_scene
from .whole_files import is_whole_file


def save_mjcf(file: Path, target: Path, sources: Sources) -> None:
    """Write a scene as MJCF, with its annotations; meshes and textures stay where they are, named from there.

    Raises SceneError: the scene cannot be read or written.
    """
    file = file.resolve()
    if is_whole_file(file):
        raise SceneError(
            f"'{file.name}' contains meshes, textures and scripts, which do not fit into one MJCF file; write a "
            "folder with --convert FOLDER"
        )
    spec = read_scene(file, sources).spec
    if any(texture.file in spec.assets for texture in spec.textures):
        raise SceneError(
            f"the meshes of '{file.name}' have images, which do not fit into one MJCF file; write a folder with "
            "--convert FOLDER"
        )
    try:
        compile_spec(spec)
        for assets, folder in (
            (spec.meshes, spec.meshdir),
            (spec.hfields, spec.meshdir),
            (spec.skins, spec.meshdir),
            (spec.textures, spec.texturedir),
        ):
            for asset in assets:
                _rename_file(asset, file.parent / folder, target.parent)
        spec.meshdir = spec.texturedir = ""
        spec.modelfiledir = str(target.parent)
        text = spec.to_xml()
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"'{target}' cannot be written: {error.strerror}") from None
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise SceneError(
            f"'{file.name}' cannot be written as MJCF: {' '.join(str(error).split())}"
        ) from error


def _rename_file(asset: Any, folder: Path, target: Path) -> None:
    if asset.file and (path := folder / asset.file).is_file():
        try:
            asset.file = Path(os.path.relpath(path.resolve(), target.resolve())).as_posix()
        except ValueError:  # another drive of Windows
            asset.file = path.resolve().as_posix()
