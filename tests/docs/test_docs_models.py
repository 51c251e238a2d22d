"""The page of scenes and robots names what there is: every shipped scene, its picture, its V-REP file, its objects."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from handler_calls import World

from simx_server.files.library import find_scene, list_scenes, shipped_models

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "models.md"
ROWS = {
    row[2]: row
    for row in re.finditer(r"^\| !\[\]\((\S+)\) `(\w+)` \| (.*?) \| (.*) \|$", PAGE.read_text(), re.MULTILINE)
}
VARIANTS = {"ur5_rg2_kinect_ball"}
"""Scenes that differ from a listed one in a detail."""

WITHOUT_OBJECTS = {"empty"}
"""Scenes that a sentence of the page describes."""

SIGNALS = {"RG2_open"}


def test_every_shipped_scene_is_on_the_page() -> None:
    assert set(ROWS) == set(list_scenes()) - VARIANTS - WITHOUT_OBJECTS
    assert all(f"\n`{scene}` is " in PAGE.read_text() for scene in WITHOUT_OBJECTS)


@pytest.mark.parametrize("scene", ROWS)
def test_a_scene_of_the_page_has_its_image_its_files_and_its_objects(scene: str) -> None:
    picture, _, files, names = ROWS[scene].groups()
    assert (PAGE.parent / picture).is_file()
    for file in re.findall(r"`([^`]+\.ttm)`", files):
        assert find_scene(f"models/somewhere/{file}").parent == shipped_models()
    world = World(file=find_scene(scene))
    for name in re.findall(r"`(\w*[A-Za-z]\w*)`", names):
        assert name in SIGNALS or world.handle(name) > 0


def test_models_without_a_scene_are_found_by_their_file_names() -> None:
    listed = PAGE.read_text().partition("`scenes/models/`:")[2].partition("\n\n")[0]
    found = [find_scene(f"{name}.ttm") for name in re.findall(r"`([^`]+)`", listed)]
    with_a_scene = {name for row in ROWS.values() for name in re.findall(r"`([^`]+\.ttm)`", row[3])}
    named = {path.stem for path in (*found, *map(find_scene, with_a_scene))}
    assert named | set(ROWS) >= {path.stem for path in shipped_models().glob("*.xml")}
