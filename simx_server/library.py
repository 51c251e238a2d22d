"""Finding a scene file: the path as given, else one of the scenes that come with the server."""

from __future__ import annotations

import logging
from pathlib import Path

from simx_server.errors import CommandError

logger = logging.getLogger(__name__)

SUFFIXES = (".xml", ".mjcf", ".urdf", ".mjb", ".zip")
VREP_SUFFIXES = (".ttt", ".ttm", ".simscene.xml", ".simmodel.xml")


def shipped_scenes() -> Path:
    """The folder of shipped scenes: package data in a wheel, `scenes/` beside the package in a source tree."""
    package = Path(__file__).resolve().parent
    installed = package / "shipped_scenes"
    return installed if installed.is_dir() else package.parent / "scenes"


def list_scenes() -> list[str]:
    """Stems of the shipped scenes, sorted; files in sub-folders are parts, not scenes."""
    return sorted({path.stem for path in shipped_scenes().glob("*") if path.suffix in SUFFIXES})


def find_scene(text: str | Path, folder: Path | None = None) -> Path:
    """The file meant by `text`: an existing path; a shipped scene by name; for a V-REP file, the same stem as MJCF.

    A relative path is looked for in `folder` (default: the working directory) before it may name a shipped scene.

    Raises CommandError when there is no such file; the text lists the shipped scenes.
    """
    given = Path(text) if folder is None else folder / text
    stem = _vrep_stem(given)
    if stem is None:
        if given.is_file():
            return given
        candidates = [shipped_scenes() / given.name, *_with_suffixes(shipped_scenes() / given.name)]
        candidates += _with_suffixes(given)
    else:
        candidates = _with_suffixes(given.with_name(stem)) + _with_suffixes(shipped_scenes() / stem)
    for candidate in candidates:
        if candidate.is_file():
            if stem is not None:
                logger.info("'%s' is a V-REP file, '%s' is loaded in its place", given, candidate)
            return candidate
    names = ", ".join(list_scenes()) or "none"
    advice = "convert it to MJCF or URDF" if stem is not None else "give the path of an MJCF or URDF file"
    raise CommandError(f"no scene '{text}'; shipped scenes: {names}; {advice}")


def _vrep_stem(path: Path) -> str | None:
    """The name without a V-REP ending, or None when the path has none."""
    for suffix in VREP_SUFFIXES:
        if path.name.lower().endswith(suffix):
            return path.name[: -len(suffix)]
    return None


def _with_suffixes(path: Path) -> list[Path]:
    return [path.with_name(path.name + suffix) for suffix in SUFFIXES]
