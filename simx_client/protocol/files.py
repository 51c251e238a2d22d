"""Files of scenes and models, by their endings; shared, since client and server search for the twin of a
V-REP file."""

from __future__ import annotations

SCENE_SUFFIXES = (".xml", ".mjcf", ".urdf", ".mjb", ".zip")
MESH_SUFFIXES = (".stl", ".obj")
UI_SUFFIXES = (".toml", ".json")

VREP_SUFFIXES = (".ttt", ".ttm", ".simscene.xml", ".simmodel.xml")
VREP_UI_SUFFIX = ".ttb"

MAX_FILE = 64 << 20
"""Maximum size of a transferred file in bytes."""


def vrep_stem(name: str) -> str | None:
    """Return the file name of a V-REP scene or model without its ending; None for other files."""
    for suffix in VREP_SUFFIXES:
        if name.lower().endswith(suffix):
            return name[: -len(suffix)]
    return None


def twins(name: str) -> list[str]:
    """Return names of files that may replace a V-REP file, the best first; empty for other files."""
    stem = vrep_stem(name)
    if stem is not None:
        return [stem + suffix for suffix in SCENE_SUFFIXES + MESH_SUFFIXES]
    if name.lower().endswith(VREP_UI_SUFFIX):
        return [name[: -len(VREP_UI_SUFFIX)] + suffix for suffix in UI_SUFFIXES]
    return []
