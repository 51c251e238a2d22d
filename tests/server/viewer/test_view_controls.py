"""The page as a newcomer meets it: buttons that show the state, the robot first, clients that have left, the floor."""

from __future__ import annotations

import math
import re
import socket
from pathlib import Path
from typing import Any, cast

import mujoco
import numpy as np
import pytest

from simx_client.protocol.cli.installing import extra_line

pytest.importorskip("viser", reason=extra_line("viewer"))

import viser
from browser_panels import Stage, browser
from real_world import BLOCKING, Open, handle_of

import simx_client as v
from simx_server.service.clients.sessions import MAX_DEPARTED
from simx_server.viewer.page.link import Away, Link
from simx_server.viewer.page.mirror import Copy, Mirror
from simx_server.viewer.page.panels.clients import Clients
from simx_server.viewer.page.panels.objects import Objects
from simx_server.viewer.page.panels.run import Run
from simx_server.viewer.page.quiet_viser import set_title
from simx_server.viewer.page.tools.gizmo import Gizmo
from simx_server.viewer.page.tools.plot import Curve, vertical_axis
from simx_server.viewer.page.view.ground import is_ground
from simx_server.viewer.page.view.world import World

pytestmark = pytest.mark.slow

__all__ = ["browser"]

SCENE = """
<mujoco model="cell">
  <worldbody>
    <light name="lamp" pos="0 0 3"/>
    <camera name="overview" pos="0 -3 1"/>
    <body name="floor"><geom type="box" size="2 2 0.05" pos="0 0 -0.05"/></body>
    <body name="table" pos="1 1 0.2"><geom type="box" size="0.3 0.3 0.02"/></body>
    <body name="crate" pos="-1 0 0.2"><freejoint/><geom size="0.1"/></body>
    <body name="door" pos="0 1 0.5"><joint name="hinge"/><geom size="0.1"/></body>
    <body name="robot" pos="0 0 0.5">
      <geom size="0.1"/>
      <body name="upper"><joint name="shoulder"/><geom size="0.1"/>
        <body name="lower" pos="0.3 0 0"><joint name="elbow"/><geom size="0.1"/></body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def stage(world: Open, browser: viser.ViserServer, tmp_path: Path) -> Stage:
    browser.gui.reset()
    (tmp_path / "scene.xml").write_text(SCENE)
    return Stage(*world(str(tmp_path / "scene.xml")), browser)


# --- buttons -------------------------------------------------------------------------------------


def painted(stage: Stage, group: str, style: str) -> list[str]:
    """Labels of a group's buttons whose rule holds a text."""
    groups = {each.label: each for each in stage.all(viser.GuiButtonGroupHandle)}
    beyond = {"Run": "+ div", "Speed": "+ div + div"}[group]
    rule = rf"> \.simx-run\) {re.escape(beyond)} button:nth-of-type\((\d+)\) {{[^}}]*{style}"
    return [groups[group].options[int(number) - 1] for number in re.findall(rule, stage.text())]


@pytest.fixture
def run(stage: Stage) -> Stage:
    stage.panel = Run(stage.gui, stage.hands, "127.0.0.1:19997")
    assert painted(stage, "Run", "opacity") == ["Start", "Pause", "Stop", "One step"], "no server yet"
    stage.show()
    return stage


def test_lit_button_is_the_state_whoever_brought_it_about(run: Stage) -> None:
    assert painted(run, "Run", "background") == ["Stop"]
    assert painted(run, "Run", "opacity") == ["Pause"], "there is nothing to pause"
    assert v.simxSynchronous(run.client, True) == 0
    assert v.simxStartSimulation(run.client, BLOCKING) == 0
    run.show()
    assert painted(run, "Run", "background") == ["Start"]
    assert painted(run, "Run", "opacity") == ["One step"], "a client steps"
    assert v.simxPauseSimulation(run.client, BLOCKING) == 0
    run.show()
    assert painted(run, "Run", "background") == ["Pause"]
    cast(Run, run.panel).away("gone", is_busy=False)
    assert painted(run, "Run", "background") == painted(run, "Speed", "background") == []
    assert len(painted(run, "Speed", "opacity")) == 6


def test_a_server_that_is_busy_is_not_a_missing_one(run: Stage) -> None:
    panel = cast(Run, run.panel)
    panel.away("it took longer than 5 s", is_busy=True)
    assert "<b>busy</b>" in run.text()
    assert "no server" not in run.text()
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        link = Link(f"127.0.0.1:{listening.getsockname()[1]}", timeout=0.2)
        with pytest.raises(Away) as busy:
            link.client()
    link = Link(link.address, timeout=0.2)
    with pytest.raises(Away) as gone:
        link.client()
    assert (busy.value.is_busy, gone.value.is_busy) == (True, False)


def test_the_line_that_stopped_a_script_stands_above_the_tabs(run: Stage) -> None:
    survey, look = run.survey(), run.look()
    script = {
        "name": "arm", "problem": "attempt to index a nil value", "line": 7, "code": "x.y = 1", "is_running": False,
        "is_enabled": True,
    }  # fmt: skip
    assert run.panel is not None
    run.panel.update(cast(Any, {**survey, "scripts": [script]}), look)
    assert "line 7" in run.text()
    run.panel.update(survey, look)
    assert "line 7" not in run.text()


@pytest.mark.parametrize(
    ("speed", "label"), [(1.0, ["1x"]), (0.25, ["1/4"]), (4.0, ["4x"]), (math.inf, ["max"]), (3.0, [])]
)
def test_lit_speed_is_the_one_that_holds(run: Stage, speed: float, label: list[str]) -> None:
    survey, look = run.survey(), run.look()
    assert run.panel is not None
    run.panel.update({**survey, "speed": speed}, look)
    assert painted(run, "Speed", "background") == label
    assert painted(run, "Speed", "opacity") == []


def test_style_stands_directly_before_the_buttons_that_it_paints(run: Stage) -> None:
    shown = run.all(object)
    kinds = [
        "style" if "simx-run" in getattr(each, "content", "") else getattr(each, "label", "")
        for each in shown
    ]
    assert kinds[kinds.index("style") + 1 :][:2] == ["Run", "Speed"]


# --- the tree ------------------------------------------------------------------------------------


def test_robot_comes_first_and_cameras_lights_and_floor_come_last(stage: Stage) -> None:
    stage.panel = Objects(stage.gui, stage.hands)
    stage.show()
    labels = [button.label.strip() for button in stage.all(viser.GuiButtonHandle)]
    names = [label.lstrip("▾▸\u2007 ").split("  ·  ")[0] for label in labels]
    top = [name for name in names if name in ("robot", "door", "crate", "table", "floor", "lamp", "overview")]
    assert top[:2] == ["robot", "door"], "most joints first"
    assert set(top[-2:]) == {"lamp", "overview"}
    assert names.index("robot") < names.index("shoulder") < names.index("door"), "families stay together"


# --- clients -------------------------------------------------------------------------------------


def test_calls_of_a_client_that_has_left_stay(stage: Stage) -> None:
    stage.panel = Clients(stage.gui)
    other = stage.world.client()
    for _ in range(3):
        assert v.simxGetJointPosition(other, handle_of(other, "hinge"), BLOCKING)[0] == 0
    assert v.simxSetObjectSelection(stage.client, [], BLOCKING) == 0
    next(iter(stage.world.loop.service.clients.sessions.values())).name = "simx-page"
    list(stage.world.loop.service.clients.sessions.values())[-1].name = "<b>robot.py"
    v.simxFinish(other)
    assert len(stage.world.loop.service.clients.sessions) == 1
    stage.show()
    shown = stage.text()
    assert "&lt;b&gt;robot.py</b>: left 0 s ago, driver" in shown
    assert "simxGetJointPosition 3" in shown
    assert re.search(r"<td[^>]*>simxGetJointPosition</td>", shown), "the table of calls has it, too"
    assert "No program is connected" in shown


def test_only_the_last_clients_that_left_are_remembered_and_none_that_is_back(stage: Stage) -> None:
    loop = stage.world.loop
    link = cast(Any, type("Nowhere", (), {"close": lambda self: None})())
    for number in range(MAX_DEPARTED + 5):
        loop.service.clients.join(f"client-{number}", f"script {number}", 19997, link)
        loop.service.clients.leave(f"client-{number}")
    told = stage.survey()["metrics"].get("departed", [])
    assert [each["name"] for each in told] == [f"script {number}" for number in range(5, MAX_DEPARTED + 5)]
    loop.service.clients.join(f"client-{MAX_DEPARTED}", "back", 19997, link)
    assert f"client-{MAX_DEPARTED}" not in [each.client for each in loop.service.clients.departed]
    loop.service.clients.leave(f"client-{MAX_DEPARTED}")


# --- plots ---------------------------------------------------------------------------------------

JOINT = Curve("joint / rad", ("position",), lambda survey, copy: None, least=0.01)


def test_noise_of_a_joint_at_rest_does_not_fill_the_plot() -> None:
    noise = 1e-9 * np.random.default_rng(1).normal(size=(2, 100))
    for rest in (0.0, 1.5708, -0.31237):
        axis = vertical_axis(rest + noise, JOINT, None)
        assert axis is not None
        low, high = axis
        assert low < rest - 0.004
        assert high > rest + 0.004
        assert vertical_axis(rest + 1e-3 + noise, JOINT, axis) == axis, "what lies within moves no axis"
        assert vertical_axis(rest + 1.0 + noise, JOINT, axis) != axis


def test_what_moves_has_the_axis_of_its_values() -> None:
    assert vertical_axis(np.array([[0.0, 0.5, 1.0]]), JOINT, (-0.01, 0.01)) is None


def test_values_without_a_unit_are_judged_by_their_size() -> None:
    signal = Curve("float signal", ("f",), lambda survey, copy: None, least_share=1e-3)
    assert vertical_axis(np.array([[1e-6, 2e-6]]), signal, None) is None
    assert vertical_axis(np.array([[1e6, 1e6 + 1]]), signal, None) is not None
    assert vertical_axis(np.zeros((1, 5)), signal, None) is None


# --- the floor and the tab -----------------------------------------------------------------------


@pytest.fixture
def cell() -> Copy:
    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return Copy(model, data)


def test_ground_is_what_lies_flat_and_wide_or_is_a_plane(cell: Copy) -> None:
    ground = [cell.model.body(n).name for n in range(cell.model.nbody) if is_ground(cell, n)]
    assert ground == ["floor"]
    plane = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='slope'><geom type='plane' size='1 1 1' euler='0 10 0'/></body>"
        "</worldbody></mujoco>"
    )
    assert is_ground(Copy(plane, mujoco.MjData(plane)), 1)


def test_click_selects_a_table_and_on_the_floor_nothing(stage: Stage, browser: viser.ViserServer) -> None:
    mirror = Mirror()
    world = World(browser, stage.hands, mirror, Gizmo(browser, stage.hands), lambda _: None)
    world.update(stage.look())
    world.survey(stage.survey())
    assert mirror.copy is not None
    for name, selected in (("table", True), ("robot", True), ("floor", False)):
        world._clicked(mirror.copy.model.body(name).id)
        expected = [handle_of(stage.client, name)] if selected else []
        assert v.simxGetObjectSelection(stage.client, BLOCKING) == (0, expected), name


def test_tab_is_called_by_the_scene_as_text(
    browser: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[Any] = []
    monkeypatch.setattr(browser.gui._websock_interface, "queue_message", sent.append)
    set_title(browser, 'a"; alert(1); "\u2028')
    assert [each.source for each in sent] == ['document.title = "a\\"; alert(1); \\"\\u2028";']
