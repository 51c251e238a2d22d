"""File names of scenes and models, which client and server take for the same things."""

from __future__ import annotations

from pathlib import Path

import pytest

from simx_client.protocol.files import is_vrep_name, scene_for, scenes_beside, vrep_stem


@pytest.mark.parametrize(
    ("name", "stem", "is_read"),
    [
        ("robot.ttt", "robot", True),
        ("Robot.TTM", "Robot", True),
        ("my.robot.ttt", "my.robot", True),
        ("robot.simscene.xml", "robot", False),
        ("robot.simmodel.xml", "robot", False),
        ("robot.xml", None, False),
        ("robot.ttb", None, False),
    ],
)
def test_stem_is_what_comes_before_the_ending_of_a_vrep_file(
    name: str, stem: str | None, is_read: bool
) -> None:
    assert vrep_stem(name) == stem
    assert is_vrep_name(name) is is_read


def test_scene_is_taken_from_the_scripts_folder_if_the_working_folder_has_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    project = tmp_path / "project"
    project.mkdir()
    monkeypatch.chdir(tmp_path)
    script = Path("project/drive.py")
    (project / "lab.ttt").write_bytes(b"")
    assert scene_for(script, "lab.ttt") == str(Path("project/lab.ttt"))
    assert scene_for(script, "ur5_rg2_kinect") == "ur5_rg2_kinect"
    assert scene_for(script, "a\0b") == "a\0b"
    (tmp_path / "lab.ttt").write_bytes(b"")
    assert scene_for(script, "lab.ttt") == "lab.ttt"


def test_scenes_that_a_script_names_come_before_all_others(tmp_path: Path) -> None:
    for name in ("a.ttt", "B.TTT", "model.ttm", "c.xml"):
        (tmp_path / name).write_bytes(b"")
    script = tmp_path / "drive.py"
    assert scenes_beside(script, []) == ["B.TTT", "a.ttt"]
    assert scenes_beside(script, ["C:\\Users\\me\\A.ttt"]) == ["a.ttt"]
    assert scenes_beside(script, ["missing.ttt"]) == ["B.TTT", "a.ttt"]
    assert scenes_beside(tmp_path / "nowhere" / "x.py", []) == []
