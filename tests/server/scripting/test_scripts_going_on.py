"""Calls that V-REP accepted do not stop a script: errors that are off, old versions, numbers for texts."""

from __future__ import annotations

from pathlib import Path

import pytest
from sim_api_calls import ScriptWorld

UNKNOWN = "sim.getObjectHandle('nothing like it')"


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path)


@pytest.fixture
def old(tmp_path: Path) -> ScriptWorld:
    """A script of V-REP before 3.4, which printed errors of its functions and let the script go on."""
    world = ScriptWorld(tmp_path)
    text = world.scene_file.read_text(encoding="utf-8").replace("type=child", "type=child stops_at_errors=no")
    world.scene_file.write_text(text, encoding="utf-8")
    world.sim.stop()
    world.sim.load(world.scene_file)
    world.run(0)
    return world


def test_with_the_error_report_mode_off_a_call_that_fails_gives_minus_one(world: ScriptWorld) -> None:
    """As scripts look whether an object is there."""
    world.fails(UNKNOWN, "no object named")
    source = "before = sim.getInt32Param(sim.intparam_error_report_mode) "
    source += "sim.setInt32Param(sim.intparam_error_report_mode, 0) "
    assert world.lua(source + f"return {UNKNOWN}, before") == [-1, 1]
    assert world.lua("return sim.getObjectPosition(4711, -1)") == []
    assert world.lua("return sim.setObjectPosition(4711, -1, {0, 0})") == [-1]
    world.lua("sim.setInt32Param(sim.intparam_error_report_mode, before)")
    world.fails(UNKNOWN, "no object named")


def test_the_mode_is_that_of_one_script_until_its_end(world: ScriptWorld) -> None:
    world.lua("sim.setInt32Param(sim.intparam_error_report_mode, 0)")
    assert world.parts.parameters.error_report_mode == 1
    world.sim.stop()
    world.run(0)
    world.fails(UNKNOWN, "no object named")


def test_a_script_of_an_old_version_goes_on_and_each_function_is_told_once(old: ScriptWorld) -> None:
    for _ in range(3):
        assert old.lua(f"return {UNKNOWN}") == [-1]
    told = old.parts.status_bar.messages
    assert sum(message.startswith("sim.getObjectHandle: no object named") for message in told) == 1


def test_what_lua_itself_cannot_do_stops_an_old_script_too(old: ScriptWorld) -> None:
    old.fails("simNoSuchFunction()", "nil value|not provided")


def test_a_number_is_a_text_where_one_is_wanted(world: ScriptWorld) -> None:
    world.lua("sim.addStatusbarMessage(0.5) sim.addStatusbarMessage(6 / 2)")
    assert world.parts.status_bar.messages[-2:] == ["0.5", "3"]
    assert world.lua("sim.setStringSignal('speed', 1e-7) return sim.getStringSignal('speed')") == ["1e-07"]
    world.fails("sim.addStatusbarMessage(true)", "must be a string, got True")


def test_numbers_after_those_that_are_wanted_are_ignored(world: ScriptWorld) -> None:
    source = "local cube = sim.getObject('/cube') sim.setObjectPosition(cube, -1, {1, 2, 3, 4}) "
    assert world.lua(source + "return sim.getObjectPosition(cube, -1)") == [pytest.approx([1, 2, 3])]


def test_old_functions_of_the_window_return_what_they_returned(world: ScriptWorld) -> None:
    world.goes_on("sim.addBanner('hello', 0.1, 0, nil, sim.handle_self)", "are not drawn", 1)
    assert world.lua("return sim.removeBanner(1), sim.modifyGhost(0, 1, 2, 0), sim.getLastError()")[:2] == [
        1,
        1,
    ]
    world.fails("sim.addGhost(0, 4711, 0, 0, 0)", "no object with handle 4711")


def test_data_under_numbers_is_stored_with_objects_and_the_scene(world: ScriptWorld) -> None:
    world.lua("cube = sim.getObject('/cube') sim.addObjectCustomData(cube, 125487, 'a\\0b')")
    assert world.lua("return sim.getObjectCustomData(cube, 125487)") == ["a\0b"]
    assert world.lua("simAddSceneCustomData(1, 'x') return simGetSceneCustomData(1)") == ["x"]
    assert world.lua("return sim.readCustomDataBlockTags(cube)") in ([], [None])


def test_a_part_of_packed_numbers_that_is_not_there_is_nil(world: ScriptWorld) -> None:
    source = "local packed = sim.packFloatTable({1, 2, 3}) "
    assert world.lua(source + "return sim.unpackFloatTable(packed, 1, 99)") == [[2, 3]]
    assert world.lua(source + "return sim.unpackFloatTable(packed, 7)") in ([], [None])
    assert world.lua("return sim.unpackFloatTable('ab', 0, 0, 5)") == [[]]


def test_names_of_v_rep_2_are_those_of_its_later_functions(world: ScriptWorld) -> None:
    """The old user interfaces were 2D elements, and vision sensors rendering sensors."""
    made = """
        ui = simCreate2DElement('panel', 0, {4, 3}, {14, 14})
        button = simCreate2DElementButton(ui, {1, 1}, {2, 1}, 0x2058)
        simSet2DElementButtonLabel(ui, button, 0.5)
        simSet2DElementButtonProperty(ui, button, simGet2DElementButtonProperty(ui, button))
        simSet2DElementButtonColor(ui, button, {1, 0, 0})
        simCreate2DElementButtonArray(ui, button) simSet2DElementButtonArrayColor(ui, button, {0, 0}, {1, 1, 1})
        simDelete2DElementButtonArray(ui, button)
        slider = simCreate2DElementButton(ui, {1, 2}, {2, 1}, 0x2052)
        simSet2DElementSlider(ui, slider, 250)
        simSet2DElementProperty(ui, simGet2DElementProperty(ui)) simSet2DElementPosition(ui, {7, 8})
        local size, position = simGet2DElementButtonSize(ui, button), simGet2DElementPosition(ui)
        return simGet2DElementButtonLabel(ui, button), simGet2DElementSlider(ui, slider), size, position,
            simGet2DElementHandle('panel') == ui, (simGet2DElementEventButton(ui))
    """
    assert world.lua(made) == ["0.5", 250, [2, 1], [7, 8], True, -1]
    world.lua("simRemove2DElement(ui)")
    for call in (
        "simHandleRenderingSensor(4711)", "simReadRenderingSensor(4711)", "simResetRenderingSensor(4711)",
        "simCheckRenderingSensor(4711, 1)", "simCheckRenderingSensorEx(4711, 1, true)",
        "simGetRenderingSensorResolution(4711)", "simGetRenderingSensorImage(4711)",
        "simSetRenderingSensorImage(4711, {0})", "simGetRenderingSensorDepthBuffer(4711)",
    ):  # fmt: skip
        world.fails(call, "no object with handle 4711")
    world.goes_on("simHandleSensingChildScripts()", "only a main script", -1)
    assert world.lua("return simGetInstanceIndex(), simGetVisibleInstanceIndex()") == [0, 0]


def test_consoles_that_were_never_open_are_answered_with_zero(world: ScriptWorld) -> None:
    world.goes_on("sim.auxiliaryConsoleShow(4194305, true)", "no console with handle 4194305", 0)
