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
