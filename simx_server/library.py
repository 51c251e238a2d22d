"""Finding a scene file: the path as given, else one of the scenes that come with the server."""

from __future__ import annotations

import logging
import re
from pathlib import Path

from simx_client.protocol.files import MESH_SUFFIXES, SCENE_SUFFIXES, vrep_stem
from simx_server.errors import CommandError

MODELS = "models"
"""The folder beside a scene in which its models, and the scripts that these name, may lie."""

MODEL_SUFFIX = ".ttm"

logger = logging.getLogger(__name__)


def shipped_scenes() -> Path:
    """The folder of shipped scenes: package data in a wheel, `scenes/` beside the package in a source tree."""
    package = Path(__file__).resolve().parent
    installed = package / "shipped_scenes"
    return installed if installed.is_dir() else package.parent / "scenes"


def shipped_models() -> Path:
    """The folder of shipped models, beside which lie the scripts that they name."""
    return shipped_scenes() / MODELS


def plain(stem: str) -> str:
    """A V-REP file's stem as ours are written: ``KUKA YouBot`` is ``kuka_youbot``."""
    return re.sub(r"[^a-z0-9]+", "_", stem.lower()).strip("_")


def list_scenes() -> list[str]:
    """Stems of the shipped scenes, sorted; files in sub-folders are parts, not scenes."""
    return sorted({path.stem for path in shipped_scenes().glob("*") if path.suffix in SCENE_SUFFIXES})


def find_scene(text: str | Path, folder: Path | None = None, *, meshes: bool = False) -> Path:
    """The file meant by `text`: an existing path; a shipped scene by name; for a V-REP file, the same stem as MJCF.

    `meshes`: a mesh file will do as well.

    A relative path is looked for in `folder` (default: the working directory) before it may name a shipped scene.

    Raises CommandError when there is no such file; the text lists the shipped scenes.
    """
    given = Path(text) if folder is None else folder / text
    stem = vrep_stem(given.name)
    suffixes = SCENE_SUFFIXES + (MESH_SUFFIXES if meshes else ())
    scenes, models = shipped_scenes(), shipped_models()
    if stem is None:
        if given.is_file():
            return given
        candidates = [scenes / given.name, *_with_suffixes(scenes / given.name, suffixes)]
        candidates += [
            *_with_suffixes(given, suffixes),
            models / given.name,
            *_with_suffixes(models / given.name, suffixes),
        ]
    else:
        candidates = _with_suffixes(given.with_name(stem), suffixes)
        # A shipped robot has a scene of its own, often of the same name: of the two, the file's suffix says which.
        folders = (models, scenes) if given.name.lower().endswith(MODEL_SUFFIX) else (scenes, models)
        candidates += [
            path
            for folder in folders
            for name in (stem, plain(stem))
            for path in _with_suffixes(folder / name, suffixes)
        ]
    for candidate in candidates:
        if candidate.is_file():
            if stem is not None:
                logger.info("'%s' is a V-REP file, '%s' is loaded in its place", given, candidate)
            return candidate
    names = ", ".join(list_scenes()) or "none"
    advice = "convert it to MJCF or URDF" if stem is not None else "give the path of an MJCF or URDF file"
    raise CommandError(f"no scene '{text}'; shipped scenes: {names}; {advice}")


def _with_suffixes(path: Path, suffixes: tuple[str, ...]) -> list[Path]:
    return [path.with_name(path.name + suffix) for suffix in suffixes]
