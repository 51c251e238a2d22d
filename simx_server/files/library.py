"""Finding a scene file: the path as given, else one of the scenes that come with the server."""

from __future__ import annotations

import logging
import re
from pathlib import Path

from simx_client.protocol.files import MESH_SUFFIXES, SCENE_SUFFIXES, vrep_stem
from simx_client.protocol.nearest import did_you_mean, file_like
from simx_server.errors import CommandError

DEFAULT_SCENE = "ur5_rg2_kinect"
"""The tutorial's scene, which the package ships."""

MODELS = "models"
"""The folder beside a scene in which its models, and the scripts that these name, may lie."""

MODEL_SUFFIX = ".ttm"

logger = logging.getLogger(__name__)


def shipped_scenes() -> Path:
    """The folder of shipped scenes: package data in a wheel, `scenes/` beside the package in a source tree."""
    package = Path(__file__).resolve().parents[1]
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


def list_models() -> list[str]:
    """Stems of the shipped models, sorted."""
    return sorted({path.stem for path in shipped_models().glob("*") if path.suffix in SCENE_SUFFIXES})


def find_scene(text: str | Path, folder: Path | None = None, *, model: bool = False) -> Path:
    """The file meant by `text`: an existing path; a shipped scene or model by name; for a V-REP file, its twin's.

    `model`: a model is wanted, for which a mesh file will do as well.

    A relative path is looked for in `folder` (default: the working directory) before it may name a shipped file.

    Raises CommandError when there is no such file; the text lists the shipped ones.
    """
    given = Path(text) if folder is None else folder / text
    stem = vrep_stem(given.name)
    suffixes = SCENE_SUFFIXES + (MESH_SUFFIXES if model else ())
    if stem is None:
        own, names = [given, *_with_suffixes(given, suffixes)], [given.name]
    else:
        own, names = _with_suffixes(given.with_name(stem), suffixes), [stem, plain(stem)]
        model = given.name.lower().endswith(MODEL_SUFFIX)
    # A shipped robot has a scene of its own, often of the same name.
    folders = (shipped_models(), shipped_scenes()) if model else (shipped_scenes(), shipped_models())
    shipped = [
        path
        for each in folders
        for name in names
        for path in (each / name, *_with_suffixes(each / name, suffixes))
    ]
    candidates = [*own, *shipped]
    for candidate in candidates:
        if candidate.is_file():
            if stem is not None:
                logger.info("'%s' is a V-REP file, '%s' is loaded in its place", given, candidate)
            return candidate
    what, listed = ("model", list_models()) if model else ("scene", list_scenes())
    advice = "convert it to MJCF or URDF" if stem is not None else "give the path of an MJCF or URDF file"
    meant = _like(given, listed, beside=folder is None) or ";"
    raise CommandError(f"no {what} '{text}'{meant} shipped {what}s: {', '.join(listed) or 'none'}; {advice}")


def _like(given: Path, shipped: list[str], *, beside: bool) -> str:
    """``; did you mean ...?``, of the shipped names and, for who starts the server, of the files `beside` it.

    A client is not told what files there are.
    """
    return (file_like(given, SCENE_SUFFIXES) if beside else "") or did_you_mean(given.stem, shipped)


def _with_suffixes(path: Path, suffixes: tuple[str, ...]) -> list[Path]:
    return [path.with_name(path.name + suffix) for suffix in suffixes]
