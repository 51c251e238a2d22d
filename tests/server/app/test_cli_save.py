"""`simx-server SCENE --save FILE`: the scene, also after a run, in any of the forms."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest
from vrep_writer import VrepWriter

from simx_server.app import cli
from simx_server.scene.formats.archives.archive import is_archive_file
from simx_server.scene.formats.vrep.container import unpack

pytestmark = pytest.mark.system

_TEXT = """<mujoco><worldbody><body name="ball" pos="0 0 5"><freejoint/><geom size="0.1"/></body></worldbody>
  <custom><text name="simx:model:ball" data="base=yes"/></custom></mujoco>"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "falling.xml"
    path.write_text(_TEXT)
    return path


def height(path: Path) -> float:
    model = mujoco.MjSpec.from_file(str(path)).compile()
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    return float(data.qpos[2])


@pytest.mark.parametrize("name", ["out.mjz", "out.xml"])
def test_a_scene_is_saved_as_it_was_loaded_or_after_a_run(file: Path, name: str) -> None:
    target = file.with_name(name)
    assert cli.main([str(file), "--save", str(target)]) == 0
    assert height(target) == 5
    assert cli.main([str(file), "--save", str(target), "--duration", "0.5"]) == 0
    assert height(target) == pytest.approx(5 - 9.81 * 0.125, abs=0.05)


def test_the_only_model_is_saved_as_one(file: Path, caplog: pytest.LogCaptureFixture) -> None:
    target = file.with_name("ball.ttm")
    assert cli.main([str(file), "--save", str(target)]) == 0
    assert is_archive_file(target)
    file.write_text(_TEXT.replace("base=yes", "base=no"))
    assert cli.main([str(file), "--save", str(target)]) == 1
    assert "must have one model" in caplog.text


def test_files_of_vrep_are_saved_as_such(tmp_path: Path) -> None:
    writer = VrepWriter(25, is_model=True)
    writer.shape("gripper", cuboid=(0.1, 0.1, 0.1), model_base=True)
    file = tmp_path / "gripper.ttm"
    file.write_bytes(writer.bytes())
    target = tmp_path / "again.ttm"
    assert cli.main([str(file), "--save", str(target)]) == 0
    assert bytes(unpack(target.read_bytes())[1]) == bytes(unpack(file.read_bytes())[1])


def test_other_endings_and_flags_are_refused(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main([str(file), "--save", str(file.with_name("x.png"))])
    assert "ends in .mjz or .xml or .ttt or .ttm" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        cli.main([str(file), "--save", str(file.with_name("x.mjz")), "--zmq"])
    assert "has no meaning beside --save" in capsys.readouterr().err
