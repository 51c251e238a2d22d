"""Files of scenes and models, by their endings; shared, since client and server search for the file that a name
means."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path, PureWindowsPath

ARCHIVE_SUFFIXES = (".zip", ".mjz")
"""Endings of archives that contain an MJCF file and all that it names; the second is MuJoCo's own."""

SCENE_SUFFIXES = (".xml", ".mjcf", ".urdf", ".mjb", *ARCHIVE_SUFFIXES)
MESH_SUFFIXES = (".stl", ".obj", ".dae", ".ply")
UI_SUFFIXES = (".toml", ".json")

VREP_SCENE_SUFFIX = ".ttt"
VREP_MODEL_SUFFIX = ".ttm"
VREP_FILES = (VREP_SCENE_SUFFIX, VREP_MODEL_SUFFIX)
"""Endings of V-REP's files, which the server reads."""

SAVED_SUFFIXES = (".mjz", ".xml", *VREP_FILES)
"""Endings of the files that the server saves."""

VREP_XML_SUFFIXES = (".simscene.xml", ".simmodel.xml")
"""Endings of CoppeliaSim's XML files, which the server does not read."""

OPENED_SUFFIXES = SCENE_SUFFIXES + VREP_FILES
"""Endings of all files that the server opens as scenes."""

VREP_UI_SUFFIX = ".ttb"

MAX_FILE = 64 << 20
"""Maximum size of a transferred file in bytes."""


def is_vrep_name(name: str) -> bool:
    """Return whether a file name has the ending of a V-REP file that the server reads."""
    return name.lower().endswith(VREP_FILES)


def vrep_stem(name: str) -> str | None:
    """Return the file name of a V-REP scene or model without its ending; None for other files."""
    for suffix in VREP_FILES + VREP_XML_SUFFIXES:
        if name.lower().endswith(suffix):
            return name[: -len(suffix)]
    return None


def twins(name: str) -> list[str]:
    """Return names of files that may replace a V-REP file that is missing or that cannot be read, the best first;
    empty for other files.
    """
    stem = vrep_stem(name)
    if stem is not None:
        return [stem + suffix for suffix in SCENE_SUFFIXES + MESH_SUFFIXES]
    if name.lower().endswith(VREP_UI_SUFFIX):
        return [name[: -len(VREP_UI_SUFFIX)] + suffix for suffix in UI_SUFFIXES]
    return []


def scene_for(script: Path, scene: str) -> str:
    """Return the scene that is meant beside a script: a file there, if the working folder has none of that name."""
    given = Path(scene)
    try:
        if not given.is_absolute() and not given.is_file() and (beside := script.parent / given).is_file():
            return str(beside)
    except (OSError, ValueError):  # not a valid name here
        pass
    return scene


def scenes_beside(script: Path, named: Iterable[str]) -> list[str]:
    """Return V-REP scenes in the folder of a script: those that it names, or else all of them; sorted.

    Args:
        named: paths in the script, perhaps of another system.
    """
    try:
        there = sorted(
            path.name for path in script.parent.iterdir() if path.suffix.lower() == VREP_SCENE_SUFFIX
        )
    except OSError:
        return []
    wanted = {PureWindowsPath(name).name.lower() for name in named}
    return [name for name in there if name.lower() in wanted] or there
