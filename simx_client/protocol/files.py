"""Files a world can be made of, by their endings; shared, as either side may look for the twin of a V-REP file."""

from __future__ import annotations

SCENE_SUFFIXES = (".xml", ".mjcf", ".urdf", ".mjb", ".zip")
MESH_SUFFIXES = (".stl", ".obj")
UI_SUFFIXES = (".toml", ".json")

VREP_SUFFIXES = (".ttt", ".ttm", ".simscene.xml", ".simmodel.xml")
VREP_UI_SUFFIX = ".ttb"

MAX_FILE = 64 << 20
"""Bytes of the largest file that travels."""


def vrep_stem(name: str) -> str | None:
    """The file name of a V-REP scene or model without its ending; None for any other."""
    for suffix in VREP_SUFFIXES:
        if name.lower().endswith(suffix):
            return name[: -len(suffix)]
    return None


def twins(name: str) -> list[str]:
    """Names of the files that may stand for a V-REP file, the best first; empty for any other."""
    stem = vrep_stem(name)
    if stem is not None:
        return [stem + suffix for suffix in SCENE_SUFFIXES + MESH_SUFFIXES]
    if name.lower().endswith(VREP_UI_SUFFIX):
        return [name[: -len(VREP_UI_SUFFIX)] + suffix for suffix in UI_SUFFIXES]
    return []
