"""The messages for the page: everything once, then news only; a mirror of it shows what the server has."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgpack
import mujoco
import numpy as np
import pytest
from real_world import BLOCKING, RealWorld, handle_of

import simx_client as v
from simx_server.errors import CommandError
from simx_server.simulation.simulation import SimulationState
from simx_server.viewer import feed, sent_model
from simx_server.viewer.feed import Feed
from simx_server.viewer.messages import LOOK, ONE_STEP, SPEED, SURVEY
from simx_server.viewer.page.mirror import Mirror

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 0.1"/>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0" range="-90 90"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/>
    </body>
    <body name="post" pos="1 0 0"><geom name="stick" type="box" size="0.1 0.1 0.5" rgba="1 0 0 1"/></body>
    <body name="ball" pos="0 1 0.5"><joint name="turn" type="ball"/><geom type="sphere" size="0.1"/></body>
  </worldbody>
  <actuator><position name="hinge" joint="hinge" kp="10"/></actuator>
</mujoco>
"""


class Told:
    """A world, what its feed says, and a mirror that follows."""

    def __init__(self, world: RealWorld) -> None:
        self.world, self.parts, self.sim, self.client = world, world.parts, world.simulation, world.client()
        self.feed = Feed(world.loop.service, "realm", [19997])
        self.mirror = Mirror()
        self._known = (-1, -1)

    def ask(self, function: str, *ints: int, floats: tuple[float, ...] = ()) -> Any:
        buffer = self.feed.call(function, list(ints), list(floats), [], b"")[3]
        return msgpack.unpackb(buffer, strict_map_key=False) if buffer else None

    def look(self) -> tuple[dict[str, Any], tuple[bool, bool]]:
        seen = self.ask(LOOK, *self._known)
        self._known = seen["model"], seen["arrays_version"]
        return seen, self.mirror.update(seen)

    def is_mirrored(self) -> bool:
        """Whether the mirror has every body where it is."""
        self.sim.refresh()
        assert self.mirror.copy is not None
        return all(
            np.allclose(getattr(self.mirror.copy.data, name), getattr(self.sim.data, name))
            for name in ("xpos", "xquat", "site_xpos", "cam_xpos")
        )


@pytest.fixture
def told(tmp_path: Path) -> Iterator[Told]:
    scene = tmp_path / "told.xml"
    scene.write_text(SCENE)
    world = RealWorld(scene)
    yield Told(world)
    world.close()


def test_model_is_told_once_and_the_state_each_time(told: Told) -> None:
    first, changes = told.look()
    assert first["binary"] is not None
    assert changes == (True, False)
    assert told.is_mirrored()
    told.sim.start()
    for _ in range(5):
        told.parts.step()
    second, changes = told.look()
    assert second["binary"] is None
    assert second["arrays"] is None
    assert (second["running"], second["steps"], second["time"]) == ("running", 5, 0.25)
    assert changes == (False, False)
    assert told.is_mirrored()


def test_what_a_client_moves_or_colours_is_told_and_a_stop_takes_it_back(told: Told) -> None:
    told.look()
    told.sim.start()
    told.look()
    post = handle_of(told.client, "post")
    assert v.simxSetObjectPosition(told.client, post, -1, [0.5, 0.5, 2.0], BLOCKING) == 0
    seen, (is_new, is_reshaped) = told.look()
    assert seen["binary"] is None
    assert not is_new
    assert not is_reshaped  # it looks as before, elsewhere
    assert told.is_mirrored()
    told.sim.model.geom_rgba[told.sim.model.geom("stick").id] = (0, 1, 0, 1)
    told.sim.model_edited()
    _, (_, is_reshaped) = told.look()
    assert is_reshaped
    told.sim.stop()
    _, (_, is_reshaped) = told.look()
    assert is_reshaped
    assert told.mirror.copy is not None
    assert told.mirror.copy.model.geom("stick").rgba.tolist() == [1, 0, 0, 1]
    assert told.is_mirrored()


def test_an_edit_and_another_scene_bring_another_model(told: Told) -> None:
    first, _ = told.look()
    post = handle_of(told.client, "post")
    assert v.simxCopyPasteObjects(told.client, [post], BLOCKING)[0] == 0
    second, changes = told.look()
    assert second["model"] != first["model"]
    assert changes[0]
    assert told.is_mirrored()
    told.sim.close()
    third, changes = told.look()
    assert third["model"] != second["model"]
    assert changes[0]


def test_models_of_two_servers_are_not_taken_for_one() -> None:
    command = [
        sys.executable,
        "-c",
        "from simx_server.viewer import sent_model; print(next(sent_model._models))",
    ]
    told = {subprocess.run(command, capture_output=True, check=True, timeout=60).stdout for _ in range(2)}
    assert len(told) == 2, "a page may miss that its server was started anew"


def test_survey_has_the_tree_and_joints_and_what_is_known_is_left_out(told: Told) -> None:
    survey = told.ask(SURVEY, -1, -1)
    by_name = {each["name"]: each for each in survey["tree"]}
    hinge = by_name["hinge"]
    assert hinge["handle"] == handle_of(told.client, "hinge")
    assert (hinge["joint"], hinge["element"]) == ("revolute", "joint")
    joint = survey["joints"][hinge["handle"]]
    assert (joint["position"], joint["target"], joint["mode"]) == (0, 0, v.sim_jointmode_force)
    assert joint["minimum"] == pytest.approx(-np.pi / 2)
    assert joint["range"] == pytest.approx(np.pi)
    assert survey["joints"][by_name["turn"]["handle"]]["position"] is None  # a ball joint has no one number
    assert survey["metrics"]["clients"][0]["streams"] == 0
    again = told.ask(SURVEY, survey["tree_version"], survey["drawings_version"])
    assert again["tree"] is None
    assert again["drawings"] is None
    told.sim.scene.objects[hinge["handle"]].name = "elbow"
    assert "elbow" in [each["name"] for each in told.ask(SURVEY, survey["tree_version"], -1)["tree"]]


def test_survey_has_signals_streams_drawings_and_messages(told: Told) -> None:
    v.simxSetIntegerSignal(told.client, "count", 3, BLOCKING)
    v.simxSetStringSignal(told.client, "blob", bytes(5000), BLOCKING)
    v.simxAddStatusbarMessage(told.client, "x" * 5000, BLOCKING)
    v.simxGetObjectPosition(told.client, handle_of(told.client, "arm"), -1, v.simx_opmode_streaming)
    told.world.loop.turn()
    line = told.parts.drawings.create(1, 2.0, 0.0, -1, 10, (1.0, 0.0, 0.0))
    told.parts.drawings.draw(line, [0, 0, 0, 1, 1, 1])
    survey = told.ask(SURVEY, -1, -1)
    assert survey["signals"]["integers"] == {"count": 3}
    assert survey["signals"]["strings"]["blob"]["size"] == 5000
    assert len(survey["signals"]["strings"]["blob"]["beginning"]) < 500
    assert [each["command"] for each in survey["streams"]] == ["simxGetObjectPosition"]
    assert survey["drawings"][0]["items"] == [[0, 0, 0, 1, 1, 1]]
    assert len(survey["interface"]["status_bar"][-1]) < 5000


def test_of_thousands_of_signals_the_first_are_told(told: Told) -> None:
    told.parts.signals.integers.update({f"n{number}": number for number in range(5000)})
    told.parts.signals.floats["gain"] = 0.5
    signals = told.ask(SURVEY, -1, -1)["signals"]
    assert list(signals["integers"])[:2] == ["n0", "n1"]
    assert len(signals["integers"]) < 2000
    assert signals["floats"] == {"gain": 0.5}
    assert signals["count"] == 5001


def test_a_large_model_travels_as_it_is(told: Told, monkeypatch: pytest.MonkeyPatch) -> None:
    small = len(told.ask(LOOK, -1, -1)["binary"])
    monkeypatch.setattr(sent_model, "_MOST_COMPRESSED", 0)
    told.feed.model_changed(None)
    large, _ = told.look()
    assert large["binary"] is not None
    assert told.mirror.copy is not None
    assert told.mirror.copy.model.nbody == told.sim.model.nbody
    assert len(large["binary"]) > mujoco.mj_sizeModel(told.sim.model) > small


def test_of_many_drawing_items_the_last_are_told_where_they_are(
    told: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(feed, "_MOST_ITEMS", 3)
    drawings = told.parts.drawings
    carried = drawings.create(0, 2.0, 0.0, handle_of(told.client, "post"), 10)
    drawings.draw(carried, [0, 0, 0, 1, 0, 0])
    fixed = drawings.create(0, 2.0, 0.0, -1, 10)
    drawings.draw(fixed, [0, 0, 0, 2, 0, 0])
    assert v.simxSetObjectPosition(told.client, handle_of(told.client, "post"), -1, [1, 5, 0], BLOCKING) == 0
    told.sim.refresh()
    first, second = told.ask(SURVEY, -1, -1)["drawings"]
    assert np.allclose(first["items"], [[0, 5, 0], [1, 5, 0]])
    assert second["items"] == [[2, 0, 0]]


def test_paths_are_lines(tmp_path: Path) -> None:
    scene = tmp_path / "paths.xml"
    scene.write_text(
        '<mujoco><worldbody><site name="rail" pos="0 0 1"/></worldbody><custom>'
        '<text name="simx:object:rail" data="type=path"/>'
        '<text name="simx:path:rail" data="points=0,0,0,1,0,0,0;1,0,0,1,0,0,0;1,2,0,1,0,0,0"/></custom></mujoco>'
    )
    world = RealWorld(scene)
    told = Told(world)
    (line,) = told.ask(SURVEY, -1, -1)["drawings"]
    assert line["items"] == [[0, 0, 1, 1, 0, 1], [1, 0, 1, 1, 2, 1]]
    world.close()


def test_one_pass_is_one_pass_from_any_state(told: Told) -> None:
    for expected in (1, 2):
        told.ask(ONE_STEP)
        assert told.sim.state is SimulationState.RUNNING
        for _ in range(3):
            told.world.loop.turn()
        assert told.sim.state is SimulationState.PAUSED
        assert told.sim.step_count == expected
    told.sim.start()
    told.ask(ONE_STEP)
    assert told.sim.state is SimulationState.PAUSED


def test_one_pass_is_refused_while_a_client_steps(told: Told) -> None:
    v.simxSynchronous(told.client, True)
    v.simxStartSimulation(told.client, BLOCKING)
    with pytest.raises(CommandError, match="end its stepped mode first"):
        told.ask(ONE_STEP)


def test_a_pause_that_was_due_does_not_outlive_the_run(told: Told) -> None:
    told.ask(ONE_STEP)
    told.sim.stop()
    told.sim.start()
    for _ in range(3):
        told.world.loop.turn()
    assert told.sim.state is SimulationState.RUNNING


def test_speed_is_set_and_nonsense_is_refused(told: Told) -> None:
    told.ask(SPEED, floats=(2.0,))
    assert told.ask(SURVEY, -1, -1)["speed"] == 2.0
    for nonsense in (0.0, -1.0, float("nan")):
        with pytest.raises(CommandError, match="above 0"):
            told.ask(SPEED, floats=(nonsense,))
    with pytest.raises(CommandError, match="it has: look, survey, onePass, speed, past, sensing"):
        told.ask("glance")
    with pytest.raises(CommandError, match="takes 2 integers"):
        told.ask(LOOK, 1)
