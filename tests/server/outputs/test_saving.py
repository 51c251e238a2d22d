"""The file of --save: an old one stays as it is until the new one is complete."""

from __future__ import annotations

from pathlib import Path

import pytest
from handler_calls import World

from simx_server.outputs.packages import OutputError
from simx_server.outputs.saving import write_saved

SCENE = '<mujoco><worldbody><body name="box"><geom size="0.1"/></body></worldbody></mujoco>'


@pytest.fixture
def world(tmp_path: Path) -> World:
    (tmp_path / "scene.xml").write_text(SCENE)
    return World(file=tmp_path / "scene.xml", workspace=tmp_path)


def test_an_existing_file_is_replaced_and_keeps_its_rights(world: World, tmp_path: Path) -> None:
    saved = tmp_path / "saved.mjz"
    saved.write_bytes(b"old")
    saved.chmod(0o640)
    write_saved(world.parts, saved, None)
    assert saved.read_bytes()[:2] == b"PK"
    assert saved.stat().st_mode & 0o777 == 0o640


def test_a_file_that_cannot_be_written_leaves_the_old_one(
    world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_self: Path, _target: Path) -> Path:
        raise OSError(28, "No space left on device")

    saved = tmp_path / "saved.mjz"
    saved.write_bytes(b"old")
    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(OutputError, match="No space left"):
        write_saved(world.parts, saved, None)
    assert saved.read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["saved.mjz", "scene.xml"]
