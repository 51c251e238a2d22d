"""``simx fit``: a scene whose values were changed gets the true ones back from a run with them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import mujoco
import pytest
from real_world import BLOCKING, handle_of, start_stepped
from recordings import recorded

import simx_client as v
from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_client.protocol.cli.installing import extra_line
from simx_server.app.compare.files import write_run
from simx_server.app.compare.replayed import replayed
from simx_server.app.fit.command import main
from simx_server.app.fit.parameters import free_of
from simx_server.errors import CommandError

needs_sysid = pytest.mark.usefixtures("_sysid")


@pytest.fixture
def _sysid() -> None:
    """Skip the test without it. Its import takes a third of a second, so that it is not for all workers."""
    if not hasattr(pytest.importorskip("mujoco.sysid"), "optimize"):
        pytest.skip(extra_line("fit"))


SCENE = """
<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" friction="0.01"/>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/>
    </body>
    <body name="swing" pos="0 1 1">
      <joint name="pivot" axis="0 1 0" damping="{damping}" armature="{armature}"/>
      <geom type="capsule" fromto="0 0 0 0.3 0 -0.4" size="0.02"/>
    </body>
    <geom name="ramp" type="box" size="2 0.3 0.05" pos="2 -2 1" euler="0 25 0" friction="0.01"/>
    <body name="puck" pos="1 -2 1.6" euler="0 25 0"><freejoint/>
      <geom name="disc" type="box" size="0.1 0.1 0.05" friction="{friction}"/>
    </body>
    <body name="ball" pos="3 2 0.3"><freejoint/><geom size="0.1" solref="{softness} 0.6"/></body>
  </worldbody>
  <custom><text name="simx:joint:hinge" data="motor=on control=position P={P} max_force=50"/></custom>
</mujoco>
"""
TRUE = {"armature": 0.02, "damping": 0.05, "friction": 0.2, "P": 0.15, "softness": 0.05}
WRONG = {"armature": 0.06, "damping": 0.01, "friction": 0.4, "P": 0.05, "softness": 0.02}
OWNERS = {"armature": "pivot", "damping": "pivot", "friction": "puck", "P": "hinge", "softness": "ball"}


def scene(folder: Path, **values: float) -> Path:
    path = folder / f"scene-{len(list(folder.iterdir()))}.xml"
    path.write_text(SCENE.format(**{**TRUE, **values}))
    return path


def run(path: Path, to: Path) -> Path:
    """Record a program that moves the arm; the swing swings, the puck slides, and the ball jumps."""
    with recorded(path, to) as place:
        client = place.client()
        hinge = handle_of(client, "hinge")
        start_stepped(client)
        for step in range(18):
            v.simxSetJointTargetPosition(client, hinge, 1.2 if step < 9 else -0.5, BLOCKING)
            v.simxSynchronousTrigger(client)
        v.simxStopSimulation(client, BLOCKING)
    return to


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fit")


@pytest.fixture(scope="module")
def truth(folder: Path) -> Path:
    """The run of the true scene, as a file of states."""
    path = folder / "true.npz"
    write_run(path, replayed(run(scene(folder), folder / "true.simxlog")))
    return path


@pytest.fixture(scope="module")
def wrong(folder: Path) -> tuple[Path, Path]:
    """A scene with wrong values, and a run in it."""
    path = scene(folder, **WRONG)
    return path, run(path, folder / "wrong.simxlog")


@needs_sysid
def test_five_wrong_values_become_the_true_ones(
    truth: Path, wrong: tuple[Path, Path], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, recording = wrong
    free = [word for name, owner in OWNERS.items() for word in ("--free", f"{owner}.{name}")]
    saved = folder / "fitted.xml"
    words = [recording, "--scene", path, "--recorded", truth, *free, "--save", saved, "--json"]
    assert main(list(map(str, words))) == DONE
    told = json.loads(capsys.readouterr().out)
    found = {name: told["values"][f"{owner}.{name}"]["value"] for name, owner in OWNERS.items()}
    assert found == {name: pytest.approx(value, rel=0.02) for name, value in TRUE.items()}
    assert told["after"] < told["before"] / 50
    model = mujoco.MjModel.from_xml_path(str(saved))
    assert model.joint("pivot").damping[0] == pytest.approx(0.05, rel=0.02)
    assert model.geom("disc").friction[0] == pytest.approx(0.2, rel=0.02)
    (gain,) = re.findall(r"control=position P=([\d.]+)", saved.read_text())
    assert float(gain) == pytest.approx(0.15, rel=0.02)


@needs_sysid
def test_a_value_that_moves_nothing_is_said_not_to_be_told(
    truth: Path, wrong: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    path, recording = wrong
    words = [recording, "--scene", path, "--recorded", truth, "--free", "rod.friction", "--iterations", 2]
    assert main(list(map(str, words))) == DONE
    said = capsys.readouterr().out
    assert re.search(r"rod\.friction: 1 -> [\d.]+, the run does not tell it", said)
    assert "only in recorded" not in said, "the floor is here too, and does not move"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("hinge", "is no value of a scene; valid is OBJECT.NAME"),
        ("hinge.frictoin", "no value 'frictoin'; did you mean 'friction'"),
        ("hinges.damping", "no such object; did you mean 'hinge'"),
        ("pivot.P", "P, I, D, K, C and max_force need an annotation simx:joint"),
        ("hinge.damping=5:1", "two rising numbers above 0"),
        ("hinge.damping=a:b", "two rising numbers above 0"),
    ],
)
def test_a_wrong_value_is_refused_with_what_is_valid(folder: Path, text: str, problem: str) -> None:
    spec = mujoco.MjSpec.from_string(SCENE.format(**TRUE))
    with pytest.raises(CommandError, match=problem):
        free_of(text, spec)


def test_each_value_stands_where_the_scene_has_it() -> None:
    spec: Any = mujoco.MjSpec.from_string(SCENE.format(**TRUE))
    for name, owner in OWNERS.items():
        free = free_of(f"{owner}.{name}=0.001:9", spec)
        assert (free.start, free.least, free.most) == (pytest.approx(TRUE[name]), 0.001, 9)
        free.put(spec, 0.5)
        assert free_of(f"{owner}.{name}", spec).start == pytest.approx(0.5)
    assert spec.joint("pivot").armature == 0.5
    renamed = mujoco.MjSpec.from_string(SCENE.format(**TRUE).replace('name="pivot"', 'name="arm.1"'))
    dotted = free_of("arm.1.damping=0.01:0.9", renamed)
    assert (dotted.owner, dotted.least, dotted.most) == ("arm.1", 0.01, 0.9)
    assert spec.geom("disc").friction[0] == 0.5
    assert free_of("hinge.friction", spec).start == free_of("hinge.friction", spec).least, (
        "0 cannot be fitted"
    )


def test_runs_without_a_common_quantity_are_refused(
    wrong: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, recording = wrong
    table = tmp_path / "other.csv"
    table.write_text("time,elbow.joint\n0.05,1\n0.1,2\n")
    words = [recording, "--scene", path, "--recorded", table, "--free", "hinge.P"]
    assert main(list(map(str, words))) == FAILURE
    problem = capsys.readouterr().err
    assert "no quantity that moves in the recorded run" in problem or "needs packages" in problem
