"""Scripts find each other, and send each other messages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scripted_world import evaluate, scripted
from sim_api_calls import SCENE, ScriptWorld

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_text

OTHER = """
level = 3
settings = {speed = 1}
function double(value) return value * 2, 'twice' end
function swap(ints, floats, strings, buffer) return floats, ints, strings, buffer end
function state() return level, settings.speed end
"""

NOTES = """
    <text name="simx:script:cube" data="file=other.lua"/>
    <text name="simx:script:wall" data="file=custom.lua type=customization"/>
    <text name="simx:parameters:cube" data="speed=2.5 count=7 name=left loud=true nothing=nil"/>
  </custom>"""

ELSE = "local cube, wall = sim.getObjectHandle('cube'), sim.getObjectHandle('wall')\n"
OTHER_SCRIPT = ELSE + "local other = sim.getScriptAssociatedWithObject(cube)\n"


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    (tmp_path / "other.lua").write_text(OTHER, encoding="utf-8")
    (tmp_path / "custom.lua").write_text("function hello(name) return 'hello ' .. name end", encoding="utf-8")
    return ScriptWorld(tmp_path, SCENE.replace("</custom>", NOTES))


def test_scripts_are_found_by_their_object(world: ScriptWorld) -> None:
    other, custom, none = world.lua(
        OTHER_SCRIPT + "return other, sim.getCustomizationScriptAssociatedWithObject(wall), "
        "sim.getScriptAssociatedWithObject(wall)"
    )
    assert world.parts.scripts.get(other).owner == world.handle("cube")  # type: ignore[union-attr]
    assert world.parts.scripts.get(custom).owner == world.handle("wall")  # type: ignore[union-attr]
    assert none == -1
    assert world.value("sim.getScriptHandle('cube')") == other
    assert world.lua(
        ELSE + "return sim.getScriptHandle(1, 'cube'), sim.getScriptHandle(1, '', cube), "
        "sim.getScriptHandle(sim.scripttype_customizationscript, 'wall'), sim.getScriptHandle(1, 'wall')"
    ) == [other, other, custom, -1], "CoppeliaSim's form, with a script type"
    assert world.lua(
        ELSE + "return sim.getScript(sim.scripttype_childscript, cube), sim.getScript(1, 'cube')"
    ) == [
        other,
        other,
    ]
    assert world.lua(ELSE + "return sim.getScript(6, wall), sim.getScript(0)") == [custom, -1]
    world.fails("sim.getScript(9)", "no type of script of the scene; those are 0 main script")


def test_a_script_knows_itself(world: ScriptWorld) -> None:
    own = world.value("sim.getScriptHandle()")
    assert (
        world.lua("return sim.getScript(sim.handle_self), sim.getScriptHandle(sim.handle_self)") == [own] * 2
    )
    assert world.value("sim.getScriptName(sim.handle_self)") == "robot"
    assert world.value(f"sim.getScriptName({own})") == "robot"
    assert world.value("sim.getObjectAssociatedWithScript(sim.handle_self)") == world.handle("robot")
    world.fails("sim.getScriptName(7)", "no script with handle 7; scripts of this scene: .* of 'robot'")


def test_the_object_of_another_script_is_told(world: ScriptWorld) -> None:
    assert world.lua(
        OTHER_SCRIPT + "return sim.getObjectAssociatedWithScript(other), sim.getScriptName(other)"
    ) == [
        world.handle("cube"),
        "cube",
    ]


def test_any_values_go_to_a_function_of_another_script_and_come_back(world: ScriptWorld) -> None:
    assert world.lua("return sim.callScriptFunction('double@cube', sim.scripttype_childscript, 21)") == [
        42,
        "twice",
    ]
    assert world.lua(OTHER_SCRIPT + "return sim.callScriptFunction('double', other, 1.5)") == [3, "twice"]
    assert world.lua("return sim.callScriptFunction('swap@cube', 1, {1}, {0.5}, {'a'}, 'b')") == [
        [0.5],
        [1],
        ["a"],
        "b",
    ]
    custom = ELSE + "local c = sim.getCustomizationScriptAssociatedWithObject(wall) "
    assert world.lua(custom + "return sim.callScriptFunction('hello', c, 'you')") == ["hello you"]
    assert world.lua("return sim.callScriptFunction('hello@wall', 6, 'all')") == ["hello all"]
    world.fails("sim.callScriptFunction('missing@cube', 1)", "has no function 'missing'")
    world.fails("sim.callScriptFunction('double@wall', 1)", "no child script of 'wall'")


def test_a_script_can_call_itself(world: ScriptWorld) -> None:
    assert world.lua(
        "function mine(x) return x + 1 end return sim.callScriptFunction('mine', sim.handle_self, 1)"
    ) == [2]


def test_variables_of_another_script_are_set(world: ScriptWorld) -> None:
    state = "return sim.callScriptFunction('state@cube', 1)"
    assert world.lua(state) == [3, 1]
    assert world.lua("return sim.setScriptVariable('level@cube', 1, 9)") == [1]
    world.lua(OTHER_SCRIPT + "sim.setScriptVariable('settings.speed', other, 'high')")
    assert world.lua(state) == [9, "high"]
    world.fails("sim.setScriptVariable('level = 1 x@cube', 1, 9)", "no name of a variable")


def test_a_piece_of_lua_runs_in_another_script(world: ScriptWorld) -> None:
    assert world.lua("return sim.executeScriptString('level = level + 1 return level@cube', 1)") == [0, 4]
    assert world.lua(
        OTHER_SCRIPT + "return sim.executeScriptString('return settings.speed, level', other)"
    ) == [0, 1, 4]
    failed, message = world.lua(OTHER_SCRIPT + "return sim.executeScriptString('return 1 +', other)")
    assert (failed, "unexpected" in message) == (-1, True)
    failed, message = world.lua(OTHER_SCRIPT + "return sim.executeScriptString('error(\"no luck\")', other)")
    assert (failed, "no luck" in message) == (-1, True)


PYTHON_SCRIPT = """
level = 3
def double(x):
    return 2 * x
"""


def test_a_piece_of_python_runs_in_a_script_of_python() -> None:
    world = scripted({"lua:base": "x = 1", "python:plain": PYTHON_SCRIPT})
    world.sim.start()
    other = "sim.getScript(sim.scripttype_childscript, sim.getObject('/plain'))"

    def run(text: str) -> list[Any]:
        return evaluate(world, f"return sim.executeScriptString({text}, {other})")

    assert run("'double(level)'") == [0, 6]
    assert run("'level = level + 1@python'") == [0]
    assert run("'level, [1]'") == [0, 4, [1]]
    assert run("'for i in range(3): level += double(i)'") == [0]
    assert run("' level '") == [0, 10]
    code, message = run("'level = = 1'")
    assert (code, b"invalid syntax" in message) == (-1, True)
    code, message = run("'1 / 0'")
    assert (code, b"ZeroDivisionError" in message) == (-1, True)
    assert run("'return 1@lua'") == [-1, b"the script is written in python, not in lua"]
    world.sim.stop()


def test_the_text_of_a_script_is_read(world: ScriptWorld) -> None:
    (text,) = world.lua(OTHER_SCRIPT + "return sim.getScriptText(other)")
    assert text == OTHER


def test_attributes_are_read_and_keep_what_they_are(world: ScriptWorld) -> None:
    other = world.value("sim.getScriptHandle('cube')")
    read = "return sim.getScriptAttribute({0}, sim.scriptattribute_enabled), "
    read += "sim.getScriptAttribute({0}, sim.scriptattribute_executionorder), "
    read += "sim.getScriptAttribute({0}, sim.scriptattribute_scripttype), "
    read += "sim.getScriptAttribute({0}, sim.scriptattribute_scripthandle)"
    assert world.lua(read.format(other)) == [True, 1, 1, other]
    assert world.value(f"sim.setScriptAttribute({other}, sim.scriptattribute_enabled, true)") == 1
    assert world.value(f"sim.setScriptAttribute({other}, 4, false)") == 1
    assert world.value(f"sim.getScriptAttribute({other}, 4)") is False
    assert world.value(f"sim.setScriptAttribute({other}, 4, true)") == 1
    assert world.value(f"sim.getScriptAttribute({other}, 4)") is True
    assert world.value(f"sim.getScriptInt32Param({other}, sim.scriptintparam_execorder)") == 1
    assert world.value(f"sim.setScriptInt32Param({other}, sim.scriptintparam_execorder, 2)") == 1
    assert world.value(f"sim.getScriptAttribute({other}, 1)") == 2
    assert "function" in world.value(f"sim.getScriptStringParam({other}, sim.scriptstringparam_text)")
    assert world.value(f"sim.getScriptStringParam({other}, sim.scriptstringparam_lang)") == "lua"
    world.fails(f"sim.setScriptText({other}, 'x = 1')", "start the server with --allow-code")
    world.goes_on(f"sim.setScriptAttribute({other}, 1, 9)", "cannot be set to 9; those that can", -1)
    world.goes_on(f"sim.getScriptAttribute({other}, 99)", "attribute 99 of scripts is not known", -1)
    world.goes_on(
        f"sim.setScriptAttribute({other}, 3, false)", "attribute 3 of scripts has nothing to act on", 1
    )


def test_parameters_of_the_scene_are_numbers_switches_and_texts(world: ScriptWorld) -> None:
    get = (
        OTHER_SCRIPT
        + "local function get(...) return sim.getScriptSimulationParameter(other, ...) end return "
    )
    assert world.lua(get + "get('speed'), get('count'), get('name'), get('loud'), (get('nothing'))") == [
        2.5,
        7,
        "left",
        True,
        None,
    ]
    assert world.lua(get + "get('speed', true), get('loud', true), (get('unknown'))") == ["2.5", "true", None]


def test_parameters_that_are_set_last_until_the_stop(world: ScriptWorld) -> None:
    put = OTHER_SCRIPT + "return sim.setScriptSimulationParameter({}, '{}', {})"
    assert world.lua(put.format("other", "speed", "4")) == [1]
    assert world.lua(put.format("other", "own", "'text'")) == [1]
    assert world.lua(put.format("other", "flag", "false")) == [1]
    get = (
        OTHER_SCRIPT
        + "local function get(...) return sim.getScriptSimulationParameter(other, ...) end return "
    )
    assert world.lua(get + "get('speed'), get('own'), get('flag')") == [4, "text", False]
    world.call("simxStopSimulation")
    world.run(0)
    assert world.lua(get + "get('speed'), (get('own')), (get('flag'))") == [2.5, None, None]


def test_parameters_of_scripts_below_and_above_are_set_and_read_together() -> None:
    has = {f"parameters:{name}": "speed=1" for name in ("base", "left", "leaf", "plain")}
    world = scripted({f"lua:{name}": "x = 1" for name in ("base", "left", "leaf", "right", "plain")} | has)
    world.run(0)
    parameter = "ScriptSimulationParameter(sim.handle_%s, 'speed'"

    def speeds() -> list[float | None]:
        return [
            evaluate(world, f"return (sim.get{parameter % 'self'}))", on=name)[0]
            for name in ("base", "left", "leaf", "right", "plain")
        ]

    assert evaluate(world, f"return sim.set{parameter % 'tree'}, 2)") == [2]
    assert speeds() == [1, 2, 2, None, 1]
    assert evaluate(world, f"return sim.set{parameter % 'chain'}, 3)", on="leaf") == [2]
    assert speeds() == [3, 3, 2, None, 1]
    assert evaluate(world, f"return sim.set{parameter % 'all'}, 4)") == [4]
    assert speeds() == [4, 4, 4, None, 4]
    values, handles = evaluate(world, f"return sim.get{parameter % 'tree'})")
    assert (values, len(handles)) == ([4, 4], 2)
    assert evaluate(world, f"return sim.get{parameter % 'tree'})", on="right") == []


def test_parameters_need_a_value_and_an_object() -> None:
    text = '<mujoco><worldbody><body name="a"><geom size="1"/></body></worldbody><custom>{}</custom></mujoco>'
    note = '<text name="simx:parameters:{}" data="{}"/>'
    with pytest.raises(SceneError, match="valid is key=value"):
        load_text(text.format(note.format("a", "speed")))
    with pytest.raises(SceneError, match="names no object"):
        load_text(text.format(note.format("b", "speed=1")))


def test_child_scripts_are_handled_by_a_main_script_only(world: ScriptWorld) -> None:
    world.goes_on(
        "sim.handleChildScripts(sim.syscb_actuation)", "sim.handleChildScripts: only a main script", -1
    )
    world.goes_on(
        "sim.handleChildScript(sim.handle_all_except_explicit)",
        "sim.handleChildScript: only a main script",
        0,
    )


def test_the_text_of_a_scripts_last_error_is_read_once(world: ScriptWorld) -> None:
    world.lua(
        "function f() error('too hot') end script = sim.getScript(sim.scripttype_childscript, sim.getObject('.'))"
    )
    world.lua("pcall(sim.callScriptFunction, 'f', script)")
    text, after = world.lua("return sim.getStackTraceback(script), sim.getStackTraceback()")
    assert "too hot" in text
    assert after == ""
    world.fails("sim.getStackTraceback(99999)", "no script with handle 99999")


def test_the_variables_of_a_script_are_those_that_it_has_set(world: ScriptWorld) -> None:
    found = world.lua("mine, other = 7, {1} function f() end return sim.getUserVariables()")
    assert found == [{"mine": 7, "other": [1]}]


MAIN = """
function sysCall_init()
    sim.handleSimulationStart()
    sim.openModule(sim.handle_all)
    sim.handleGraph(sim.handle_all_except_explicit, 0)
end
function sysCall_actuation()
    sim.resumeThreads(sim.scriptthreadresume_default)
    sim.launchThreadedChildScripts()
    sim.setIntegerSignal('called', sim.handleChildScripts(sim.syscb_actuation))
    sim.handleCustomizationScripts(sim.syscb_actuation)
    sim.handleAddOnScripts(sim.syscb_actuation)
    sim.handleSandboxScript(sim.syscb_actuation)
    sim.handleModule(sim.handle_all, false)
    sim.handleJointMotion()
    sim.handleMechanism(sim.handle_all_except_explicit)
    sim.handleDynamics(sim.getSimulationTimeStep())
    sim.handleMill(sim.handle_all_except_explicit)
end
function sysCall_sensing()
    sim.handleSensingStart()
    sim.handleCollision(sim.handle_all_except_explicit)
    sim.handleDistance(sim.handle_all_except_explicit)
    sim.handleProximitySensor(sim.handle_all_except_explicit)
    sim.handleVisionSensor(sim.handle_all_except_explicit)
    sim.handleChildScripts(sim.syscb_sensing)
    sim.handleGraph(sim.handle_all_except_explicit, sim.getSimulationTime() + sim.getSimulationTimeStep())
end
function sysCall_cleanup()
    sim.resetMill(sim.handle_all_except_explicit)
    sim.resetCollision(sim.handle_all_except_explicit)
    sim.resetDistance(sim.handle_all_except_explicit)
    sim.resetProximitySensor(sim.handle_all_except_explicit)
    sim.resetVisionSensor(sim.handle_all_except_explicit)
    sim.closeModule(sim.handle_all)
end
"""


def test_a_main_script_that_does_what_the_default_one_did_runs(tmp_path: Path) -> None:
    (tmp_path / "other.lua").write_text(
        "function sysCall_actuation() sim.setIntegerSignal('acted', 1) end\n"
        "function sysCall_sensing() sim.setIntegerSignal('sensed', 1) end",
        encoding="utf-8",
    )
    (tmp_path / "main.lua").write_text(MAIN, encoding="utf-8")
    notes = '<text name="simx:script:cube" data="file=other.lua"/>'
    notes += '<text name="simx:script:main" data="file=main.lua type=main"/></custom>'
    world = ScriptWorld(tmp_path, SCENE.replace("</custom>", notes))
    world.passes(2)
    signals = (
        "return sim.getIntegerSignal('acted'), sim.getIntegerSignal('sensed'), sim.getIntegerSignal('called')"
    )
    assert world.lua(signals) == [1, 1, 1]
    assert world.lua("return sim.getScriptName(sim.getScript(0))") == [""]
    assert world.lua("return sim.getScriptAttribute(sim.getScript(0), 4)") == [True]  # no error ended it
    (main,) = [script for script in world.parts.scripts.all() if script.owner == -1]
    world.call("simxStopSimulation")
    assert main.problem == ""


def test_passes_are_counted_and_threads_told_apart(world: ScriptWorld) -> None:
    world.passes(3)
    assert world.lua("return sim.getScriptExecutionCount(), sim.isScriptExecutionThreaded()") == [3, 0]


def test_a_copied_table_is_another_one(world: ScriptWorld) -> None:
    assert world.lua(
        "local t = {1, {2}, name = 'x'} local u = sim.copyTable(t) u[2][1] = 9 return t, u, t == u"
    ) == [{1: 1, 2: [2], "name": "x"}, {1: 1, 2: [9], "name": "x"}, False]


def test_an_unknown_constant_is_nil_and_named_once(world: ScriptWorld) -> None:
    assert world.lua("return sim.simulator_stopped, sim.simulator_stopped") == [None, None]
    told = [line for line in world.parts.status_bar.messages if "simulator_stopped" in line]
    assert told == ["sim.simulator_stopped is no constant of V-REP: a script reads nil there"]
    world.fails("sim.simulatorStopped()", "is not provided by this server")


def test_a_script_that_reads_countless_unknown_constants_fills_no_memory(world: ScriptWorld) -> None:
    world.lua(
        "for i = 1, 12000 do local _ = sim['no_such_' .. i] end local _ = sim['no_' .. string.rep('x', 1000000)]"
    )
    assert world.parts.status_bar.count < 11_000
    assert sum(map(len, world.parts.scripts.told_once._known)) < 1_000_000
