"""Modules that scripts require: beside the scene, namespaces, and those of the simulator's own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from handler_calls import World
from scripted_world import said, scripted

from simx_server.scripting.modules import own_module, own_modules

pytest.importorskip("lupa")


def printed(source: str, *, language: str = "lua") -> list[str]:
    """The lines that a child script prints when it starts."""
    world = scripted({f"{language}:base": source})
    said(world)
    world.run(0)
    world.parts.scripts.close()
    return said(world)


def test_a_module_of_the_simulators_own_is_required_by_its_name() -> None:
    lines = printed("g = require('graph_customization') print(type(g), require('graph_customization') == g)")
    assert "table, true" in lines
    assert "table" in printed("print(type(require 'models.graph_customization-2'))")


def test_a_script_of_a_graph_records_with_the_module_of_graphs() -> None:
    world = scripted(
        {
            "lua:customization:base": """
            graph = require('graph_customization')
            function sysCall_init()
                h = sim.getObject('.')
                stream = sim.addGraphStream(h, 'x', 'm')
                graph.init() graph.updateCurves() graph.reset()
            end
            function sysCall_sensing()
                sim.setGraphStreamValue(h, stream, 1)
                if sim.getSimulationTime() < 0.07 then graph.handle() end
            end
            """
        }
    )
    world.run(4)
    ((stream,),) = (
        graph.streams.values() for graph in map(world.parts.graphs.get, world.parts.graphs.handles())
    )
    assert [time for time, _ in stream.samples] == pytest.approx([0.05, 0.1])


def test_hooks_are_called_around_functions_that_the_script_defines_later() -> None:
    lines = printed(
        """
        function before() print('before') end
        print(simRegisterScriptFuncHook('sysCall_init', 'before', true))
        sim.registerScriptFuncHook('sysCall_init', function() print('after') end, false)
        function sysCall_init() print('init') end
        """
    )
    assert lines == ["1", "before", "init", "after"]


def test_hooks_leave_the_results_of_the_function(world_with_hook: World) -> None:
    results = world_with_hook.call("simxCallScriptFunction", "base", 1, "both", [], [], [], b"")
    assert results == ([1], [2.5], ["three"], b"four")


@pytest.fixture
def world_with_hook() -> Iterator[World]:
    world = scripted(
        {
            "lua:base": """
            function both() return {1}, {2.5}, {'three'}, 'four' end
            sim.registerScriptFuncHook('both', function() end, true)
            """
        }
    )
    world.run(1)
    yield world
    world.parts.scripts.close()


def test_a_namespace_is_required_with_its_version() -> None:
    assert "true, true" in printed("print(require('sim-1') == require 'sim', require 'simIK-1' == simIK)")
    assert "true" in printed("print(require('simIK-2').createEnvironment == simIK.createEnvironment)")
    assert "true, true" in printed(
        "local sim2 = require('sim-2') print(sim2 ~= sim, sim2.getObject == sim.getObject)"
    )


def test_python_scripts_require_a_namespace_with_its_version() -> None:
    assert "True" in printed("print(require('sim-1') is sim)", language="python")
    assert "True" in printed("print(require('sim-2').getObject is sim.getObject)", language="python")


def test_the_log_says_once_that_a_module_is_a_stand_in() -> None:
    text = "require 'graph_customization'"
    world = scripted({"lua:base": text, "lua:plain": text})
    said(world)
    world.run(0)
    assert sum("graphs open no window" in line for line in said(world)) == 1


def test_a_file_beside_the_scene_goes_before_the_simulators_own(tmp_path: Path) -> None:
    (tmp_path / "graph_customization.lua").write_text("return 'beside the scene'", encoding="utf-8")
    (tmp_path / "scene.xml").write_text(
        "<mujoco><worldbody><body name='base'/></worldbody><custom>"
        "<text name='simx:lua:base' data='print(require([[graph_customization]]))'/></custom></mujoco>",
        encoding="utf-8",
    )
    world = World(file=tmp_path / "scene.xml", workspace=tmp_path)
    world.run(0)
    assert "beside the scene" in said(world)


def test_an_unknown_module_is_refused_with_the_names_that_exist() -> None:
    (line,) = (line for line in printed("require 'no_such_module'") if "is stopped" in line)
    assert "there is no such module beside the scene" in line
    assert "simVision" in line
    assert "graph_customization" in line


@pytest.mark.parametrize("name", ["../secret", "models/../../secret", "", "models", "init"])
def test_only_the_modules_themselves_can_be_required(name: str) -> None:
    assert own_module(name, "lua") is None


@pytest.mark.parametrize("name", own_modules("lua"))
def test_every_module_can_be_loaded_by_an_empty_script(name: str) -> None:
    lines = printed(f"require '{name}'")
    assert not [line for line in lines if "is stopped" in line]


def lua(source: str) -> list[str]:
    """The lines that a script prints, each value of `check` on its own line; an error fails the test."""
    lines = printed(source)
    assert not [line for line in lines if "is stopped" in line], lines
    return [line for line in lines if "are not there" not in line]


def test_bytes_as_text_and_back() -> None:
    assert lua(
        """
        local base16, base64 = require 'base16', require 'base64'
        print(base16.encode('\\0\\255a'), base16.decode('00fF61') == '\\0\\255a', pcall(base16.decode, 'abc'))
        for _, text in ipairs { '', 'f', 'fo', 'foo', 'foob', '\\0\\255' } do
            print(base64.encode(text), base64.decode(base64.encode(text)) == text)
        end
        """
    ) == [
        "00ff61, true, false, base16.decode: not a hexadecimal text",
        ", true",
        "Zg==, true",
        "Zm8=, true",
        "Zm9v, true",
        "Zm9vYg==, true",
        "AP8=, true",
    ]


CBOR = {
    "0": "00", "23": "17", "24": "1818", "1000": "1903e8", "1000000": "1a000f4240", "-1": "20", "-1000": "3903e7",
    "1.1": "fb3ff199999999999a", "false": "f4", "true": "f5", "nil": "f6", "''": "60", "'IETF'": "6449455446",
    "'\\255'": "41ff", "{1, 2, 3}": "83010203", "{a = 1}": "a1616101", "{{}, {b = {2}}}": "8280a161628102",
}  # fmt: skip
"""Values of Lua with their bytes, from RFC 8949."""


def test_cbor_encodes_and_decodes() -> None:
    checks = "\n".join(f"check({value}, '{data}')" for value, data in CBOR.items())
    assert (
        lua(
            f"""
        local cbor, base16 = require 'org.conman.cbor', require 'base16'
        function check(value, bytes)
            local data = cbor.encode(value)
            if base16.encode(data) ~= bytes then print(value, base16.encode(data)) end
            local back, place = cbor.decode(base16.decode(bytes))
            if getAsString(back) ~= getAsString(value) or place ~= #data + 1 then print(value, back, place) end
        end
        {checks}
        """
        )
        == []
    )


def test_cbor_decodes_other_forms_and_refuses_broken_ones() -> None:
    lines = lua(
        """
        local cbor, base16 = require 'org.conman.cbor', require 'base16'
        for _, bytes in ipairs { 'f93c00', 'fa47c35000', '9f0102ff', 'bf616101ff', 'c100' } do
            print((cbor.decode(base16.decode(bytes))))
        end
        for _, bytes in ipairs { '', '83', '5b7fffffffffffffff00', '1c', 'fb00', string.rep('81', 200) .. '00' } do
            print(select(2, pcall(cbor.decode, base16.decode(bytes))))
        end
        """
    )
    assert lines[:5] == ["1.0", "100000.0", "{1, 2}", "{a=1}", "0"]
    assert ["too early" in line for line in lines[5:]] == [True, True, True, False, True, False]
    assert "begins no value" in lines[8]
    assert "nested too deeply" in lines[10]


def test_arguments_are_checked_and_filled_in() -> None:
    lines = lua(
        """
        require 'checkargs'
        local function f(...)
            return checkargs({ { type = 'string' }, { type = 'float', default = 1 }, { type = 'int', default = NIL,
                nullable = true }, { type = 'table', size = 2, item_type = 'float', default = NIL } }, ...)
        end
        print(f('a')) print(f('a', 2, 3, { 1, 2 }))
        local wrong = { {}, { 1 }, { 'a', 'b' }, { 'a', 1, 1.5 }, { 'a', 1, 1, { 1 } }, { 'a', 1, 1, {}, 5 } }
        for _, values in ipairs(wrong) do print((select(2, pcall(f, table.unpack(values))))) end
        """
    )
    assert lines[:2] == ["a, 1, nil, nil", "a, 2, 3, {1, 2}"]
    assert [line.rpartition(": ")[2] for line in lines[2:]] == [
        "at least 1 arguments expected, got 0",
        "argument 1 must be a string, not a number",
        "argument 2 must be a number",
        "argument 3 must be a whole number",
        "argument 4 must have 2 elements, and has 1",
        "at most 4 arguments expected, got 5",
    ]


def test_functions_of_functions() -> None:
    assert lua(
        """
        local F = require 'functional'
        print(F.map(function(a, b) return a + b end, { 1, 2 }, { 10, 20 }))
        print(filter(function(a) return a > 1 end, { 1, 2, 3 }))
        print(reduce(function(a, b) return a * b end, range(4)), sum { 1, 2 }, any(function(a) return a end, { false }))
        print(all(function(a) return a end, { true, true }), zip({ 1, 2 }, { 3, 4 }), partial(math.max, 3)(1))
        """
    ) == ["{11, 22}", "{2, 3}", "24, 3, false", "true, {{1, 3}, {2, 4}}, 3"]


def test_settings_of_a_model_are_kept_in_its_custom_data() -> None:
    assert lua(
        """
        local ConfigUI = require 'configUi'
        local made
        local ui = ConfigUI('Box', { size = { type = 'float', minimum = 0.5 }, on = { type = 'bool', default = true } },
            function(config) made = config.size end)
        print(ui.config.size, ui.config.on)
        ui.config.size = 2 ui:writeConfig() ui:generate()
        print(made, ConfigUI('Box', ui.schema).config.size)
        """
    ) == ["0.5, true", "2, 2"]


def test_helpers_that_texts_require() -> None:
    assert lua(
        """
        local utils = require 'utils'
        local base = sim.getObjectHandle('base')
        sim.writeCustomDataBlock(base, 'tag', 'x')
        print(#getObjectsWithTag('tag'), #utils.getObjectsWithTag('none'), getObjectHandle_noError('nobody'))
        print(stringToArray('1, 2'), stringToArray('('), executeCode('return 3'), string.split('a;b;;c', ';'))
        print(string.splitlines('a\\r\\nb'), math.hypotn({ 0, 0 }, { 3, 4 }), (pcall(assertnumber, 'x', 'size')))
        local ui = simUI.create('<ui><combobox id="1"/></ui>')
        print(customUi_populateCombobox(ui, 1, { { 'b', 2 }, { 'a', 1 } }, nil, 'b', true, { { 'none', -1 } }))
        """
    ) == [
        "1, 0, -1",
        '{1, 2}, nil, 3, {"a", "b", "", "c"}',
        '{"a", "b"}, 5.0, false',
        '{{"none", -1}, {"a", 1}, {"b", 2}}, 2',
    ]


def test_values_of_an_object_are_kept_for_the_session_and_a_window_has_a_frame() -> None:
    assert lua(
        """
        local utils = require 'utils'
        local base = sim.getObjectHandle('base')
        local before = utils.readSessionPersistentObjectData(base, 'place')
        utils.writeSessionPersistentObjectData(base, 'place', { 1, 2 }, 'wide')
        print(before, utils.readSessionPersistentObjectData(base, 'place'))
        local ui = utils.createCustomUi('<label text="x" id="1"/>', 'A & B', { 10, 20 }, true, 'closed')
        print(simUI.getTitle(ui), ({ simUI.getPosition(ui) })[1])
        """
    ) == ["nil, {1, 2}, wide", "A & B, 10"]


def test_a_model_is_scaled_along_the_axes_of_its_base() -> None:
    world = scripted(
        {"lua:base": "require 'utils' scaleModelNonIsometrically(sim.getObjectHandle('base'), 1, 2, 1)"}
    )
    world.run(0)
    left = world.call("simxGetObjectPosition", world.handle("left"), world.handle("base"))
    assert left == pytest.approx([0, 0.4, 0])


def test_a_main_script_may_take_over_the_default_one() -> None:
    world = scripted(
        {
            "lua:main": "require 'defaultMainScript' function sysCall_sensing() print('own') end",
            "lua:base": "function sysCall_actuation() print('act') end function sysCall_sensing() print('sense') end",
        }
    )
    said(world)
    world.run(1)
    assert said(world) == ["act", "own"]
