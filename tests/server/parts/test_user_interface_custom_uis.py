"""Custom UIs: their files, what programs set and read, what people do to them, events over the operation modes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from handler_calls import World
from real_world import BLOCKING, RealWorld

import simx_client as v
from simx_server.errors import CommandError
from simx_server.limits import Limits
from simx_server.parts.user_interface.add_on import ADD_ON_NAME
from simx_server.parts.user_interface.custom_ui_files import UIFileError, read_ui_file

pytestmark = pytest.mark.slow

PANEL = """
[[ui]]
name = "panel"
title = "Belt"

[[ui.element]]
id = 3
label = "go"

[[ui.element]]
id = 4
kind = "slider"
position = 500
flags = ["borderless"]
place = [0, 1, 4, 1]

[[ui.element]]
id = 5
kind = "button"
label = "up"
down_label = "down"
flags = ["staydown"]

[[ui.element]]
id = 6
kind = "label"
label = "metres per minute"
enabled = false

[[ui.element]]
id = 7
kind = "editbox"

[[ui.element]]
id = 8
flags = ["downupevent"]
"""

BUTTON = v.sim_buttonproperty_button | v.sim_buttonproperty_enabled


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "panel.toml").write_text(PANEL, encoding="utf-8")
    two = {"ui": [{"name": "a", "element": [{"id": 1}]}, {"name": "b", "title": "B"}]}
    (tmp_path / "two.json").write_text(json.dumps(two), encoding="utf-8")
    (tmp_path / "scene.xml").write_text(
        '<mujoco><custom><text name="simx:ui:speed" data="file=panel.toml"/>'
        '<text name="simx:ui:b" data="file=two.json"/>'
        '<text name="simx:ui:c" data="file=two.json"/></custom></mujoco>',
        encoding="utf-8",
    )
    return tmp_path


@pytest.fixture
def world(folder: Path) -> World:
    return World(workspace=folder)


@pytest.fixture
def ui(world: World) -> int:
    (handle,) = world.call("simxLoadUI", "panel.toml", 0)
    return handle


def test_file_becomes_uis_that_are_found_by_name(world: World, ui: int) -> None:
    assert world.call("simxGetUIHandle", "panel") == ui
    handles = world.call("simxLoadUI", "two.json", 0)
    assert [world.call("simxGetUIHandle", name) for name in "ab"] == handles
    (again,) = world.call("simxLoadUI", "panel.ttb", 0)
    assert world.call("simxGetUIHandle", "panel#0") == again
    world.call("simxRemoveUI", ui)
    for command in (("simxGetUIHandle", "panel"), ("simxRemoveUI", ui)):
        with pytest.raises(CommandError, match=r"no custom UI .*there are: 2 \('a'\), 3 \('b'\)"):
            world.call(*command)


def test_program_reads_and_sets_what_a_ui_shows(world: World, ui: int) -> None:
    assert world.call("simxGetUISlider", ui, 4) == 500
    for value, kept in ((700, 700), (-5, 0), (2000, 1000)):
        world.call("simxSetUISlider", ui, 4, value)
        assert world.call("simxGetUISlider", ui, 4) == kept
    assert world.call("simxGetUIButtonProperty", ui, 3) == BUTTON
    assert world.call("simxGetUIButtonProperty", ui, 6) == v.sim_buttonproperty_label
    world.call("simxSetUIButtonProperty", ui, 3, v.sim_buttonproperty_isdown)
    assert world.call("simxGetUIButtonProperty", ui, 3) == v.sim_buttonproperty_isdown
    world.call("simxSetUIButtonLabel", ui, 3, "stop", "stopped")
    (shown,) = world.parts.user_interface.describe()["custom_uis"]
    assert shown["title"] == "Belt"
    assert (shown["elements"][0]["label"], shown["elements"][0]["down_label"]) == ("stop", "stopped")
    assert shown["elements"][1]["place"] == [0, 1, 4, 1]
    assert world.call("simxGetUIEventButton", ui) == (-1, [0, 0]), "events are what people do"


def test_what_is_not_there_or_of_another_kind_is_refused(world: World, ui: int) -> None:
    with pytest.raises(CommandError, match=r"no button 9; it has: 3 \(button\), 4 \(slider\)"):
        world.call("simxGetUISlider", ui, 9)
    with pytest.raises(CommandError, match="button 3 of UI 'panel' is a button, no slider"):
        world.call("simxSetUISlider", ui, 3, 1)
    for prop in (4, 0x8000, -1):
        with pytest.raises(CommandError, match="sim_buttonproperty_ bits"):
            world.call("simxSetUIButtonProperty", ui, 3, prop)
    for name, *arguments in (("simxGetUIButtonProperty", 99, 3), ("simxSetUIButtonLabel", 99, 3, "", "")):
        with pytest.raises(CommandError, match="no custom UI with handle 99"):
            world.call(name, *arguments)
    assert world.call("simxGetUIEventButton", 99) == (-1, [0, 0]), "always a success"


def test_people_operate_it_and_each_event_is_read_once_in_order(world: World, ui: int) -> None:
    people = world.parts.user_interface.custom_uis
    people.get(ui).click(3)
    people.get(ui).move_slider(4, 250)
    people.get(ui).click(5)
    people.get(ui).click(5)
    people.get(ui).type_text(7, "hello")
    people.get(ui).click(8)
    slider = v.sim_buttonproperty_slider | v.sim_buttonproperty_enabled | v.sim_buttonproperty_borderless
    stay = BUTTON | v.sim_buttonproperty_staydown
    box = v.sim_buttonproperty_editbox | v.sim_buttonproperty_enabled
    both = BUTTON | v.sim_buttonproperty_downupevent
    expected = [
        (3, [BUTTON, 1]),
        (4, [slider, 250]),
        (5, [stay | v.sim_buttonproperty_isdown, 1]),
        (5, [stay, 0]),
        (7, [box, 0]),
        (8, [both, 1]),
        (8, [both, 0]),
        (-1, [0, 0]),
    ]
    assert [world.call("simxGetUIEventButton", ui) for _ in expected] == expected
    assert world.call("simxGetUISlider", ui, 4) == 250


def test_what_is_not_enabled_or_closed_cannot_be_used(world: World, ui: int) -> None:
    people = world.parts.user_interface.custom_uis
    world.call("simxSetUIButtonProperty", ui, 3, 0)
    with pytest.raises(CommandError, match="not enabled"):
        people.get(ui).click(3)
    with pytest.raises(CommandError, match="is a slider, no button"):
        people.get(ui).click(4)
    world.call("simxSetUIButtonProperty", ui, 3, BUTTON | v.sim_buttonproperty_rollupaction)
    people.get(ui).click(3)
    assert people.get(ui).is_rolled_up
    world.call("simxSetUIButtonProperty", ui, 3, BUTTON | v.sim_buttonproperty_closeaction)
    people.get(ui).click(3)
    assert not people.get(ui).is_there
    with pytest.raises(CommandError, match="is closed"):
        people.get(ui).move_slider(4, 1)


def test_uis_outlive_a_run_and_go_with_their_scene(world: World, ui: int) -> None:
    world.run()
    world.call("simxSetUISlider", ui, 4, 1)
    world.call("simxStopSimulation")
    assert world.call("simxGetUISlider", ui, 4) == 1
    world.call("simxCloseScene")
    with pytest.raises(CommandError):
        world.call("simxGetUISlider", ui, 4)


def test_scene_brings_its_uis_and_a_bad_one_costs_only_itself(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    world = World(workspace=folder)
    world.call("simxLoadScene", "scene.xml", 0)
    assert world.call("simxGetUISlider", world.call("simxGetUIHandle", "speed"), 4) == 500
    assert world.call("simxGetUIHandle", "b") == 2
    assert "UI 'c' is not there: its file has no UI of that name; it has: a, b" in caplog.text


def test_too_many_uis_are_refused(world: World) -> None:
    for _ in range(Limits().uis // 2):
        world.call("simxLoadUI", "two.json", 0)
    with pytest.raises(CommandError, match=f"at most {Limits().uis} custom UIs"):
        world.call("simxLoadUI", "two.json", 0)


@pytest.mark.parametrize("path", ["nothing.toml", "nothing.ttb", "../outside.toml"])
def test_a_file_that_is_not_there_or_elsewhere_is_refused(world: World, folder: Path, path: str) -> None:
    (folder.parent / "outside.toml").write_text(PANEL, encoding="utf-8")
    with pytest.raises(UIFileError, match=r"workspace|write it as nothing\.toml"):
        world.call("simxLoadUI", path, 0)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[[ui]\n", "cannot be read"),
        ("ui = 3\n", "ui must be a list"),
        ("colour = 3\n", "has the key 'colour'; valid: ui"),
        ("[[ui]]\n", "ui 1 needs a name"),
        ("[[ui]]\nname = 3\n", "name must be a text, not 3"),
        ("[[ui]]\nname = 'a'\n[[ui.element]]\n", r"\('a'\), element 1 needs an id"),
        ("[[ui]]\nname = 'a'\n[[ui.element]]\nid = 1\n[[ui.element]]\nid = 1\n", "two elements with id 1"),
        ("[[ui]]\nname = 'a'\n[[ui.element]]\nid = 1\nkind = 'knob'\n", "one of button, label, slider, edit"),
        ("[[ui]]\nname = 'a'\n[[ui.element]]\nid = 1\nposition = 1001\n", "from 0 to 1000, not 1001"),
        ("[[ui]]\nname = 'a'\n[[ui.element]]\nid = 1\nflags = ['big']\n", "a list of staydown, enabled"),
        ("[[ui]]\nname = 'a'\n[[ui.element]]\nid = 1\nplace = [1, 2]\n", "column, row, columns, rows"),
        ("[[ui]]\nname = 'a'\n[[ui.element]]\nid = 1\nenabled = 1\n", "true or false, not 1"),
    ],
)
def test_a_bad_file_is_refused_with_the_place_and_what_is_valid(
    tmp_path: Path, text: str, complaint: str
) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(UIFileError, match=complaint):
        read_ui_file(file)


# --- over the operation modes, with two clients ---------------------------------------------------


@pytest.fixture
def real(folder: Path) -> Iterator[RealWorld]:
    world = RealWorld(folder / "scene.xml", workspace=folder)
    yield world
    world.close()


def test_event_ends_its_stream_and_leaves_the_inbox_and_no_event_does_neither(real: RealWorld) -> None:
    program, person = real.client(), real.client()
    code, ui = v.simxGetUIHandle(program, "speed", BLOCKING)
    assert code == 0
    assert v.simxGetUIEventButton(program, ui, v.simx_opmode_streaming) == (1, 0, [0, 0])
    v.simxStartSimulation(program, BLOCKING)
    for _ in range(3):
        real.loop.turn()
        assert v.simxGetUIEventButton(program, ui, v.simx_opmode_buffer) == (0, -1, [0, 0])
    operate = (person, ADD_ON_NAME, 2, "click", [ui, 3], [], [], b"", BLOCKING)
    assert v.simxCallScriptFunction(*operate)[0] == 0
    real.loop.turn()
    assert v.simxGetUIEventButton(program, ui, v.simx_opmode_buffer) == (0, 3, [BUTTON, 1])
    assert v.simxGetUIEventButton(program, ui, v.simx_opmode_buffer) == (1, 0, [0, 0])
    v.simxCallScriptFunction(*operate)
    real.loop.turn()
    assert v.simxGetUIEventButton(program, ui, v.simx_opmode_buffer) == (1, 0, [0, 0]), "the stream has ended"
    v.simxGetUIEventButton(program, ui, v.simx_opmode_streaming)
    real.loop.turn()
    assert v.simxGetUIEventButton(program, ui, v.simx_opmode_buffer) == (0, 3, [BUTTON, 1])
    assert v.simxGetUIEventButton(program, ui, BLOCKING) == (0, -1, [0, 0])


def test_one_client_prints_and_asks_another_sees_and_answers(real: RealWorld) -> None:
    program, person = real.client(), real.client()
    v.simxStartSimulation(program, BLOCKING)
    code, console = v.simxAuxiliaryConsoleOpen(program, "log", 5, 1, None, None, None, None, BLOCKING)
    assert code == 0
    v.simxAuxiliaryConsolePrint(program, console, "ready\n", v.simx_opmode_oneshot)
    v.simxAddStatusbarMessage(program, "hello", v.simx_opmode_oneshot)
    code, dialog, _ = v.simxDisplayDialog(
        program, "question", "Go on?", v.sim_dlgstyle_yes_no, "", None, None, BLOCKING
    )
    assert code == 0
    code, _, _, (text,), _ = v.simxCallScriptFunction(
        person, ADD_ON_NAME, 2, "describe", [], [], [], b"", BLOCKING
    )
    shown = json.loads(text)
    assert code == 0
    assert shown["status_bar"][-1] == "hello"
    assert (shown["consoles"][0]["title"], shown["consoles"][0]["lines"]) == ("log", ["ready"])
    assert shown["dialogs"][0]["text"] == "Go on?"
    assert v.simxGetDialogResult(person, dialog, BLOCKING) == (0, v.sim_dlgret_still_open)
    answer = [shown["dialogs"][0]["handle"], v.sim_dlgret_yes]
    v.simxCallScriptFunction(person, ADD_ON_NAME, 2, "answerDialog", answer, [], [], b"", BLOCKING)
    assert v.simxGetDialogResult(program, dialog, BLOCKING) == (0, v.sim_dlgret_yes)
    v.simxStopSimulation(person, BLOCKING)
    assert v.simxGetDialogResult(program, dialog, BLOCKING) == (8, 0)
