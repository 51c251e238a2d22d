"""The page's tabs of objects, joints, dialogs and clients: what they show, and what a click does over the API."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="needs the extra viewer")

from typing import Any, cast
from xml.etree import ElementTree

import viser
from browser_panels import Stage, browser
from real_world import BLOCKING, Open, handle_of

import simx_client as v
from simx_server.parts.user_interface.contents.plot import Curve, Plot
from simx_server.parts.user_interface.contents.tree import Item
from simx_server.parts.user_interface.labels import plain_label
from simx_server.parts.user_interface.xml_windows.reading import read_window
from simx_server.viewer.page.link import Hands
from simx_server.viewer.page.panels.clients import Clients
from simx_server.viewer.page.panels.elements import HELD, Latest
from simx_server.viewer.page.panels.interface import Interface
from simx_server.viewer.page.panels.joints import Joints
from simx_server.viewer.page.panels.objects import ROWS, Objects
from simx_server.viewer.page.panels.plot_drawing import as_svg

pytestmark = pytest.mark.slow

__all__ = ["browser"]

SCENE = """
<mujoco>
  <worldbody>
    <body name="base">
      <geom size="0.1"/>
      <body name="arm" pos="0 0 1">
        <joint name="hinge" axis="0 1 0" range="-90 90"/>
        <geom size="0.1"/>
        <body name="hand" pos="1 0 0">
          <joint name="slide" type="slide" axis="1 0 0"/>
          <geom size="0.1"/>
          <body name="tip &lt;b&gt;`x`" pos="1 0 0"><joint name="ball" type="ball"/><geom size="0.1"/></body>
        </body>
      </body>
      <body name="wheel" pos="0 1 0"><joint name="axle" axis="0 1 0"/><geom size="0.1"/></body>
    </body>
  </worldbody>
  <actuator>
    <velocity name="axle" joint="axle" kv="10"/>
  </actuator>
  <custom>
    <text name="simx:joint:hinge" data="mode=force motor=true control=position"/>
    <text name="simx:joint:slide" data="mode=passive"/>
  </custom>
</mujoco>
"""

UIS = """
[[ui]]
name = "belt"
title = "Belt"
[[ui.element]]
id = 3
label = "go"
[[ui.element]]
id = 4
kind = "slider"
label = "speed"
position = 500
[[ui.element]]
id = 6
kind = "label"
label = "<b>not bold</b>"
[[ui.element]]
id = 7
kind = "editbox"
label = "old"
[[ui.element]]
id = 8
label = "off"
enabled = false
"""


@pytest.fixture
def stage(world: Open, browser: viser.ViserServer, tmp_path: Path) -> Stage:
    browser.gui.reset()
    (tmp_path / "scene.xml").write_text(SCENE)
    return Stage(*world(str(tmp_path / "scene.xml")), browser)


@pytest.fixture
def objects(stage: Stage) -> Stage:
    stage.panel = Objects(stage.gui, stage.hands)
    stage.show()
    return stage


@pytest.fixture
def joints(stage: Stage) -> Stage:
    stage.panel = Joints(stage.gui, stage.hands)
    stage.show()
    return stage


@pytest.fixture
def interface(stage: Stage) -> Stage:
    stage.panel = Interface(stage.gui, stage.hands)
    assert v.simxStartSimulation(stage.client, BLOCKING) == 0
    stage.show()
    return stage


# --- objects -------------------------------------------------------------------------------------


def rows(stage: Stage) -> list[str]:
    return [button.label.strip() for button in stage.all(viser.GuiButtonHandle)]


def test_objects_stand_under_their_parents_with_type_and_handle(objects: Stage) -> None:
    shown = rows(objects)
    names = [row.lstrip("▾▸\u2007 ").split("  ·  ")[0] for row in shown]
    assert names.index("base") < names.index("hinge") < names.index("arm")
    assert f"revolute joint  ·  {handle_of(objects.client, 'hinge')}" in shown[names.index("hinge")]
    assert any(row.startswith("▸") for row in shown), "deep objects are folded at first"
    assert "hand" not in names


def test_click_selects_for_all_clients_and_another_click_opens(objects: Stage) -> None:
    slide = handle_of(objects.client, "slide")
    assert v.simxSetObjectSelection(objects.client, [slide], BLOCKING) == 0
    objects.show()
    selected = [button.label for button in objects.all(viser.GuiButtonHandle) if button.icon]
    assert len(selected) == 1, "what is selected elsewhere is opened and marked"
    assert "slide" in selected[0]
    assert "vrep.simxGetObjectHandle(client, &#x27;slide&#x27;, vrep.simx_opmode_blocking)" in objects.text()
    base = handle_of(objects.client, "base")
    objects.click("base")
    assert v.simxGetObjectSelection(objects.client, BLOCKING) == (0, [base])
    objects.show()
    objects.click("base")
    objects.show()
    assert not any("hinge" in row for row in rows(objects))


def test_search_finds_names_paths_types_and_handles(objects: Stage) -> None:
    search = objects.labelled(viser.GuiTextHandle, "Search")
    for query, expected in (
        ("SLID", "slide"),
        ("prismatic", "slide"),
        (str(handle_of(objects.client, "axle")), "axle"),
        ("/base arm ball", "ball"),
    ):
        objects.set(search, query)
        objects.show()
        assert expected in rows(objects)[0]
        assert "/base" in rows(objects)[0]
    objects.set(search, "no such thing")
    objects.show()
    assert rows(objects) == []
    assert "nothing matches" in objects.text()


def test_names_are_text_and_nothing_else(objects: Stage) -> None:
    name = "tip <b>`x`"
    tip = handle_of(objects.client, name)
    assert v.simxSetObjectSelection(objects.client, [tip], BLOCKING) == 0
    objects.show()
    assert "<b>`x`" not in objects.text()
    assert "tip &lt;b&gt;`x`" in objects.text()


def test_nothing_is_sent_when_nothing_changed(objects: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[object] = []
    monkeypatch.setattr(objects.gui._websock_interface, "queue_message", sent.append)
    objects.show()
    assert sent == []
    assert v.simxSetObjectSelection(objects.client, [handle_of(objects.client, "base")], BLOCKING) == 0
    objects.show()
    assert 0 < len(sent) <= 6


def test_hundreds_of_objects_are_shown_in_part(
    world: Open, browser: viser.ViserServer, tmp_path: Path
) -> None:
    browser.gui.reset()
    bodies = "".join(f'<body name="stone{n}" pos="{n} 0 0"><geom size="0.1"/></body>' for n in range(300))
    (tmp_path / "many.xml").write_text(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    stage = Stage(*world(str(tmp_path / "many.xml")), browser)
    stage.panel = Objects(stage.gui, stage.hands)
    stage.show()
    assert len(rows(stage)) == ROWS
    assert "and 220 more" in stage.text()
    stage.set(stage.labelled(viser.GuiTextHandle, "Search"), "stone299")
    stage.show()
    assert len(rows(stage)) == 1


# --- joints --------------------------------------------------------------------------------------


def slider(stage: Stage, name: str) -> viser.GuiSliderHandle:
    return stage.labelled(viser.GuiSliderHandle, f"{name} (")


def test_slider_of_a_kinematic_joint_puts_it_there_in_millimetres(joints: Stage) -> None:
    shown = slider(joints, "slide")
    assert (shown.label, shown.min, shown.max) == ("slide (mm)", -1000.0, 1000.0)
    assert "no limits" in joints.text()
    joints.set(shown, 250.0)
    code, position = v.simxGetJointPosition(joints.client, handle_of(joints.client, "slide"), BLOCKING)
    assert (code, position) == (0, pytest.approx(0.25))
    joints.show()
    assert "is at 250.0 mm, passive mode" in joints.text()


def test_slider_of_a_controlled_joint_sets_the_target_and_moves_it_while_stopped(joints: Stage) -> None:
    shown = slider(joints, "hinge")
    assert (shown.min, shown.max) == (-90.0, 90.0)
    joints.set(shown, 30.0)
    hinge = handle_of(joints.client, "hinge")
    assert v.simxGetJointPosition(joints.client, hinge, BLOCKING)[1] == pytest.approx(math.radians(30))
    assert joints.survey()["joints"][hinge]["target"] == pytest.approx(math.radians(30))
    assert v.simxSynchronous(joints.client, True) == 0
    assert v.simxStartSimulation(joints.client, BLOCKING) == 0
    joints.show()
    joints.set(shown, 31.0)
    now = joints.survey()["joints"][hinge]
    assert now["target"] == pytest.approx(math.radians(31))
    assert now["position"] == pytest.approx(math.radians(30)), "while time passes the motor moves it"


def test_wheel_gets_a_velocity_and_ball_joints_only_a_line(joints: Stage) -> None:
    shown = slider(joints, "axle")
    assert shown.label == "axle (°/s)"
    joints.set(shown, 90.0)
    axle = handle_of(joints.client, "axle")
    assert joints.survey()["joints"][axle]["target_velocity"] == pytest.approx(math.pi / 2)
    assert "ball joint" in joints.text()
    assert not any("ball" in each.label for each in joints.all(viser.GuiSliderHandle))


def test_fast_target_velocity_widens_the_slider(joints: Stage) -> None:
    assert v.simxSetJointTargetVelocity(joints.client, handle_of(joints.client, "axle"), 40.0, BLOCKING) == 0
    joints.show()
    shown = slider(joints, "axle")
    assert shown.max > shown.value == pytest.approx(math.degrees(40.0), abs=0.1)


def test_control_of_a_motor_is_chosen_from_a_list(joints: Stage) -> None:
    hinge = handle_of(joints.client, "hinge")
    assert joints.all(viser.GuiDropdownHandle) == []
    joints.set(joints.labelled(viser.GuiCheckboxHandle, "Change control"), True)
    joints.show()
    choices = joints.all(viser.GuiDropdownHandle)
    assert [each.value for each in choices] == ["position", "velocity"]
    joints.set(choices[0], "velocity")
    code, loop = v.simxGetObjectIntParameter(joints.client, hinge, v.sim_jointintparam_ctrl_enabled, BLOCKING)
    assert (code, loop) == (0, 0)
    joints.show()
    assert slider(joints, "hinge").label == "hinge (°/s)"


def test_panel_does_not_fight_who_drags(joints: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = slider(joints, "slide")
    joints.set(shown, 100.0)
    slide = handle_of(joints.client, "slide")
    assert v.simxSetJointPosition(joints.client, slide, 0.5, BLOCKING) == 0
    joints.show()
    assert shown.value == 100.0
    later = time.monotonic() + HELD
    monkeypatch.setattr(time, "monotonic", lambda: later)
    joints.show()
    assert shown.value == 500.0
    monkeypatch.undo()
    assert v.simxGetJointPosition(joints.client, slide, BLOCKING)[1] == pytest.approx(0.5), (
        "a slider that news moved sets nothing"
    )


def test_of_values_that_wait_only_the_newest_is_sent(stage: Stage) -> None:
    waiting: list[Callable] = []
    sent: list[int] = []
    hands = type("Slow", (), {"do": staticmethod(waiting.append)})()
    latest: Latest[int] = Latest(cast(Hands, hands), lambda client, value: sent.append(value))
    for value in (1, 2, 3):
        latest.change(value)
    for action in waiting:
        action(None)
    assert sent == [3]


# --- dialogs -------------------------------------------------------------------------------------


def dialog(stage: Stage, style: int, text: str = "Go on?", initial: str = "") -> int:
    code, handle, _ = v.simxDisplayDialog(stage.client, "Ask", text, style, initial, None, None, BLOCKING)
    assert code == 0
    stage.show()
    return handle


def test_dialog_opens_a_window_and_its_button_answers_it(interface: Stage) -> None:
    assert "none does now" in interface.text()
    handle = dialog(interface, v.sim_dlgstyle_yes_no, "<i>Go on?</i>")
    assert len(interface.gui._panel_handle_from_uuid) == 1
    assert "&lt;i&gt;Go on?" in interface.text()
    assert "<i>Go on" not in interface.text()
    interface.click("No")
    assert v.simxGetDialogResult(interface.client, handle, BLOCKING) == (0, v.sim_dlgret_no)
    interface.show()
    assert not interface.gui._panel_handle_from_uuid


def test_what_is_typed_comes_with_the_answer(interface: Stage) -> None:
    handle = dialog(interface, v.sim_dlgstyle_input, "How many?", "five")
    box = interface.labelled(viser.GuiTextHandle, "Text")
    assert box.value == "five"
    interface.set(box, "si")
    interface.show()
    assert box.value == "si", "what somebody types stays"
    interface.set(box, "six")
    interface.click("OK")
    assert v.simxGetDialogInput(interface.client, handle, BLOCKING) == (0, "six")


def test_window_goes_when_the_program_ends_the_dialog(interface: Stage) -> None:
    handle = dialog(interface, v.sim_dlgstyle_message)
    assert interface.gui._panel_handle_from_uuid
    assert v.simxEndDialog(interface.client, handle, BLOCKING) == 0
    interface.show()
    assert not interface.gui._panel_handle_from_uuid


WINDOW = """
<ui title="Drive" closeable="true">
  <label text="&lt;b&gt;not bold" id="1"/> <hslider minimum="-5" maximum="5" id="2"/> <button text="go" id="3"/>
  <checkbox text="light" id="4"/> <spinbox minimum="0" maximum="1" step="0.1" id="5"/> <edit value="old" id="6"/>
  <combobox id="7"><item>one</item><item>one</item></combobox> <radiobutton text="A" id="8"/> <progressbar id="9"/>
  <tabs id="10"><tab title="first"><label text="in the first"/></tab><tab title="second">
  <label text="in the second"/></tab></tabs> <table id="11"><row><item>cell &lt;i&gt;</item></row></table> <plot/>
</ui>
"""


def test_window_of_a_script_is_operated_and_shows_what_the_script_sets(
    interface: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    windows = interface.world.parts.user_interface.windows
    window = read_window(WINDOW)
    calls: list[tuple[Any, ...]] = []
    window.fire = lambda function, values: calls.append((function, *values))
    window.widget(3).events["on-click"] = "clicked"
    windows.add(window)
    interface.show()
    assert "&lt;b&gt;not bold" in interface.text()
    assert "cell &lt;i&gt;" in interface.text()
    assert "in the first" in interface.text()
    assert "in the second" not in interface.text()
    interface.click("go")
    assert calls == [("clicked", window.handle, 3)]
    slider, spinner = interface.all(viser.GuiSliderHandle)[0], interface.all(viser.GuiNumberHandle)[0]
    interface.set(slider, -2)
    interface.set(spinner, 0.3)
    interface.set(interface.labelled(viser.GuiCheckboxHandle, "light"), True)
    interface.set(interface.all(viser.GuiTextHandle)[0], "new")
    interface.click("A")
    choice, tabs = interface.all(viser.GuiDropdownHandle)
    interface.set(choice, "one (1)")
    interface.set(tabs, "second")
    values = [window.widget(each).value for each in (2, 4, 5, 7, 8, 10)]
    assert values == [-2, 2, pytest.approx(0.3), 1, 1, 1]
    assert window.widget(6).text == "new"
    window.widget(2).value, window.widget(6).is_enabled, window.widget(9).value = 4, False, 50
    later = time.monotonic() + 2 * HELD
    monkeypatch.setattr(time, "monotonic", lambda: later)
    interface.show()
    assert slider.value == 4
    assert interface.all(viser.GuiTextHandle)[0].disabled
    assert interface.all(type(interface.gui.add_progress_bar(0.0)))[0].value == 50
    assert "in the second" in interface.text()
    assert interface.labelled(viser.GuiButtonHandle, "A").label == "◉ A"
    interface.click("Close")
    interface.show()
    assert not interface.all(viser.GuiSliderHandle), "hidden, as no function of the script is asked"


def drawn(plot: Plot) -> Any:
    """The drawing of a plot, as elements."""
    return ElementTree.fromstring(as_svg(plot.view()))


def test_the_plot_of_a_window_is_drawn(interface: Stage) -> None:
    window = read_window(WINDOW)
    (widget,) = [each for each in window.widgets.values() if each.kind == "plot"]
    widget.plot.curves["a"] = curve = Curve(color=(255, 0, 0), line_size=2)
    curve.add([], [0, 5, 10], [0, 4, 2])
    interface.world.parts.user_interface.windows.add(window)
    interface.show()
    assert 'stroke="rgb(255,0,0)" stroke-width="2"' in interface.text()


def test_trees_and_images_of_a_window_are_shown(interface: Stage) -> None:
    window = read_window("<ui><tree id='1'/><image id='2'/></ui>")
    window.widget(1).tree.put(5, Item(["a <b>", "second"], 0, True))
    window.widget(1).tree.put(6, Item(["child"], 5))
    window.widget(1).tree.selected = 6
    interface.world.parts.user_interface.windows.add(window)
    interface.show()
    assert "a &lt;b&gt;" in interface.text()
    assert "font-weight:bold><td" in interface.text()
    assert "<img" not in interface.text()
    window.widget(2).kept["png"] = "AAAA"
    interface.show()
    assert "data:image/png;base64,AAAA" in interface.text()


def test_curves_are_drawn_within_the_frame_in_their_styles() -> None:
    curve = Curve()
    curve.add([], [0, 5, 10, math.inf], [0, 4, 2, 1])
    plot = Plot({"<a>": curve}, labels=["time & more", "y"], has_legend=True)
    drawing = drawn(plot)
    (path,) = drawing.iter("path")
    assert path.get("d") == "M46.00 166.00L179.00 8.00L312.00 87.00"
    assert {each.text for each in drawing.iter("text")} == {"0", "10", "4", "time & more", "y", "<a>"}
    for style, corners in (("step_left", 7), ("step_center", 7), ("impulse", 6), ("line_and_scatter", 3)):
        curve.style = style
        (path,) = drawn(plot).iter("path")
        assert len(path.get("d").replace("M", "L").split("L")[1:]) == corners, style
    assert len(list(drawn(plot).iter("circle"))) == 3
    curve.style = "scatter"
    assert not list(drawn(plot).iter("path"))
    plot.ranges[0] = (1e9, 2e9)
    assert all(float(each.get("cx")) > -3000 for each in drawn(plot).iter("circle"))


def test_custom_ui_is_operated_and_shows_what_its_program_sets(
    interface: Stage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "belt.toml").write_text(UIS)
    code, (ui,) = v.simxLoadUI(interface.client, str(tmp_path / "belt.toml"), 1, BLOCKING)
    assert code == 0
    interface.show()
    assert "&lt;b&gt;not bold" in interface.text()
    assert interface.labelled(viser.GuiButtonHandle, "off").disabled
    interface.click("go")
    assert v.simxGetUIEventButton(interface.client, ui, BLOCKING)[1] == 3
    interface.set(interface.labelled(viser.GuiSliderHandle, "speed"), 800)
    assert v.simxGetUISlider(interface.client, ui, 4, BLOCKING) == (0, 800)
    box = interface.labelled(viser.GuiTextHandle, "Text")
    interface.set(box, "new")
    interface.show()
    assert interface.survey()["interface"]["windows"][0]["widgets"][3]["text"] == "old"
    later = time.monotonic() + HELD
    monkeypatch.setattr(time, "monotonic", lambda: later)
    interface.show()
    monkeypatch.undo()
    assert interface.survey()["interface"]["windows"][0]["widgets"][3]["text"] == "new"
    assert v.simxSetUISlider(interface.client, ui, 4, 100, BLOCKING) == 0
    assert v.simxSetUIButtonLabel(interface.client, ui, 3, "halt", "", BLOCKING) == 0
    monkeypatch.setattr(time, "monotonic", lambda: later + HELD)
    interface.show()
    assert interface.labelled(viser.GuiSliderHandle, "speed").value == 100
    assert interface.labelled(viser.GuiButtonHandle, "halt")


def test_console_shows_its_lines_in_its_colours_and_can_be_closed(interface: Stage) -> None:
    def open_console(title: str, mode: int) -> int:
        code, handle = v.simxAuxiliaryConsoleOpen(
            interface.client, title, 5, mode, None, None, (1, 0, 0), (0, 0, 0.5), BLOCKING
        )
        assert code == 0
        return handle

    shown = open_console("log", 4)
    open_console("kept", 0)
    assert v.simxAuxiliaryConsolePrint(interface.client, shown, "1 < 2\nnext", BLOCKING) == 0
    interface.show()
    assert "1 &lt; 2\nnext" in interface.text()
    assert "color:rgb(255,0,0);background-color:rgb(0,0,128)" in interface.text()
    assert [each.label for each in interface.all(viser.GuiFolderHandle) if each.label] == [
        "log",
        "kept",
        "Status bar",
    ]
    interface.click("Close")
    interface.show()
    assert "1 &lt; 2" not in interface.text()
    assert interface.all(viser.GuiButtonHandle) == [], "a console without that mode bit has no such button"


def test_status_bar_shows_whole_messages(interface: Stage) -> None:
    assert v.simxAddStatusbarMessage(interface.client, "<u>" + "long " * 100, BLOCKING) == 0
    interface.show()
    assert "&lt;u&gt;" + "long " * 99 in interface.text()


def test_unchanged_interface_sends_nothing(interface: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    dialog(interface, v.sim_dlgstyle_input)
    sent: list[object] = []
    monkeypatch.setattr(interface.gui._websock_interface, "queue_message", sent.append)
    interface.show()
    assert sent == []


# --- clients -------------------------------------------------------------------------------------


def test_clients_are_shown_with_what_they_call(stage: Stage) -> None:
    stage.panel = Clients(stage.gui)
    hinge = handle_of(stage.client, "hinge")
    for _ in range(7):
        assert v.simxGetJointPosition(stage.client, hinge, BLOCKING)[0] == 0
    v.simxGetJointPosition(stage.client, hinge, v.simx_opmode_streaming)
    assert v.simxGetObjectHandle(stage.client, "<b>nobody", BLOCKING)[0] == 8
    session = next(iter(stage.world.loop.service.clients.sessions.values()))
    session.name = "<b>robot.py"
    stage.show()
    shown = stage.text()
    assert "<b>&lt;b&gt;robot.py</b>: driver" in shown
    assert "simxGetJointPosition 8" in shown
    assert f"streams: simxGetJointPosition({hinge})" in shown
    assert "&lt;b&gt;nobody" in shown, "the last error is told"
    assert "<b>nobody" not in shown
    assert "No program is connected" not in shown


def test_clients_of_the_page_stand_apart(stage: Stage) -> None:
    stage.panel = Clients(stage.gui)
    assert v.simxSetObjectSelection(stage.client, [], BLOCKING) == 0
    next(iter(stage.world.loop.service.clients.sessions.values())).name = "simx-page"
    stage.show()
    assert "No program is connected" in stage.text()
    assert "simxSetObjectSelection" not in stage.text()
    assert "This page itself: 1 clients" in stage.text()


def test_metrics_tell_what_each_client_calls(stage: Stage) -> None:
    other = stage.world.client()
    for _ in range(3):
        v.simxGetIntegerParameter(stage.client, v.sim_intparam_program_version, BLOCKING)
    assert v.simxGetObjectHandle(other, "hinge", BLOCKING)[0] == 0
    assert v.simxGetObjectHandle(other, "nobody", BLOCKING)[0] == 8
    mine, others = (each.get("commands", {}) for each in stage.survey()["metrics"]["clients"])
    assert sum(mine.values()) >= 3
    assert "simxGetObjectHandle" not in mine
    assert others["simxGetObjectHandle"] == 2


@pytest.mark.parametrize(
    ("label", "shown"),
    [
        ("plain & simple", "plain & simple"),
        ("&&fg999&&Check", "✓"),
        ("&&fg777&&Pause", "||"),
        ("&&NoSuchSymbol", "NoSuchSymbol"),
        ("first&&nSecond", "first\nSecond"),
        ("&&bg123text", "text"),
        ("a && b", "a && b"),
    ],
)
def test_symbols_and_commands_in_labels_of_v_rep_become_text(label: str, shown: str) -> None:
    assert plain_label(label) == shown
