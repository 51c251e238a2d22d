"""Find a scene file: the path as given, else one of the scenes shipped with the server."""

from __future__ import annotations

import itertools
import logging
import re
from collections.abc import Iterator
from pathlib import Path

from simx_client.protocol.files import (
    MESH_SUFFIXES,
    OPENED_SUFFIXES,
    SCENE_SUFFIXES,
    VREP_MODEL_SUFFIX,
    is_vrep_name,
    vrep_stem,
)
from simx_client.protocol.nearest import did_you_mean, file_like
from simx_server.errors import CommandError

from .robot_collections import find_robot, is_in_collection

DEFAULT_SCENE = "ur5_rg2_kinect"
"""The scene of the tutorial, which the package ships."""

MODELS = "models"
"""Name of the folder beside a scene that may hold its models and their scripts."""

logger = logging.getLogger(__name__)


def shipped_scenes() -> Path:
    """Return the folder of shipped scenes: package data in a wheel, `scenes/` beside the package in a source tree."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "shipped_scenes"
    return installed if installed.is_dir() else package.parent / "scenes"


def shipped_models() -> Path:
    """Return the folder of shipped models; their scripts lie beside it."""
    return shipped_scenes() / MODELS


def plain(stem: str) -> str:
    """Return the stem of a V-REP file in our spelling: ``KUKA YouBot`` is ``kuka_youbot``."""
    return re.sub(r"[^a-z0-9]+", "_", stem.lower()).strip("_")


def list_scenes() -> list[str]:
    """Return the stems of the shipped scenes, sorted; files in sub-folders are parts, not scenes."""
    return sorted({path.stem for path in shipped_scenes().glob("*") if path.suffix in SCENE_SUFFIXES})


def list_models() -> list[str]:
    """Return the stems of the shipped models, sorted."""
    return sorted({path.stem for path in shipped_models().glob("*") if path.suffix in SCENE_SUFFIXES})


def find_scene(text: str | Path, *, model: bool = False) -> Path:
    """Return the file meant by `text`.

    Args:
        text: an existing path, the name of a shipped scene or model, a missing V-REP file that has a shipped
            equivalent, or a robot of a collection (`robot_collections.py`).
        model: search for a model; a mesh file is accepted too.

    Raises:
        CommandError: the file does not exist; the text lists the shipped ones.
    """
    if is_in_collection(str(text)):
        return find_robot(str(text))
    given = Path(text)
    if given.name in ("", ".."):
        raise CommandError(f"'{text}' is a folder{_scenes_in(given)}; {_ADVICE}")
    stem = vrep_stem(given.name)
    suffixes = OPENED_SUFFIXES + (MESH_SUFFIXES if model else ())
    if stem is None:
        own, names = [given, *_with_suffixes(given, suffixes)], [given.name]
    else:
        twins = _with_suffixes(given.with_name(stem), SCENE_SUFFIXES + (MESH_SUFFIXES if model else ()))
        own, names = in_order(given, twins), [stem, plain(stem)]
        model = given.name.lower().endswith(VREP_MODEL_SUFFIX)
    for candidate in itertools.chain(own, _shipped_as(names, suffixes, model=model)):
        if candidate.is_file():
            if stem is not None and candidate != given:
                tell_of_twin(given, candidate)
            return candidate
    what, listed = ("model", list_models()) if model else ("scene", list_scenes())
    places = f"the shipped {what}s: {', '.join(listed) or 'none'}; {_ADVICE}"
    if given.is_dir():
        raise CommandError(f"'{text}' is a folder{_scenes_in(given)}; {_ADVICE}")
    meant = file_like(given, OPENED_SUFFIXES) or did_you_mean(given.stem, listed) or ";"
    where = given.absolute().parent
    raise CommandError(
        f"no {what} '{text}'{meant} looked in {where}{'' if where.is_dir() else ', which does not exist,'} "
        f"and among {places}"
    )


def _shipped_as(names: list[str], suffixes: tuple[str, ...], *, model: bool) -> Iterator[Path]:
    """Yield the paths that shipped files of these names would have; models first where one is searched."""
    # A shipped robot has its own scene, often with the same name.
    folders = (shipped_models(), shipped_scenes()) if model else (shipped_scenes(), shipped_models())
    for folder in folders:
        for name in names:
            yield from (folder / name, *_with_suffixes(folder / name, suffixes))


_ADVICE = "give the path of a V-REP (.ttt, .ttm), MJCF or URDF file"

_MOST_LISTED = 8
"""Scenes of a folder that a message lists."""


def _scenes_in(folder: Path) -> str:
    """Return the scenes of a folder in words, for the operator."""
    try:
        names = sorted(path.name for path in folder.iterdir() if path.suffix.lower() in OPENED_SUFFIXES)
    except OSError:
        return ""
    more = ", ..." if len(names) > _MOST_LISTED else ""
    return f"; it holds {', '.join(names[:_MOST_LISTED])}{more}" if names else " and holds no scene"


def in_order(given: Path, twins: list[Path]) -> list[Path]:
    """Return a V-REP file and its replacements, the best first: a file that cannot be read comes last."""
    return [given, *twins] if is_vrep_name(given.name) else [*twins, given]


def tell_of_twin(given: str | Path, found: Path) -> None:
    """Log that a file is loaded in place of a V-REP file."""
    why = "is not there" if is_vrep_name(str(given)) else "cannot be read"
    logger.info("'%s' %s, '%s' is loaded in its place", given, why, found)


def _with_suffixes(path: Path, suffixes: tuple[str, ...]) -> list[Path]:
    return [path.with_name(path.name + suffix) for suffix in suffixes]
