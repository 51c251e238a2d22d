"""Scripts make scripts and change their texts, if the operator allows code of clients."""

from __future__ import annotations

from typing import Any

import pytest
from handler_calls import World
from scripted_world import evaluate, said, scripted

from simx_server.scripting.interpreter import ScriptError

pytest.importorskip("lupa")

SAYS = "function sysCall_init() print('{0}') end function sysCall_cleanup() print('{0} ends') end"
HOST = "function sysCall_init() self = sim.getObject('.') end"


@pytest.fixture
def world() -> World:
    made = scripted({"lua:customization:base": HOST, "lua:customization:left": SAYS.format("left")})
    made.parts.scripts.allows_code = True
    assert said(made) == ["left"]
    return made


def run(world: World, code: str) -> list[Any]:
    return evaluate(world, code, kind=6)


@pytest.mark.parametrize(
    "call",
    [
        "sim.createScript(6, 'x = 1')",
        "sim.addScript(1)",
        "sim.setScriptText(sim.handle_self, '')",
        "sim.setScriptStringParam(sim.handle_self, 10110, '')",
        "sim.initScript(sim.handle_self)",
        "sim.associateScriptWithObject(1, self)",
    ],
)
def test_without_permission_no_script_is_made_or_changed(world: World, call: str) -> None:
    world.parts.scripts.allows_code = False
    with pytest.raises(ScriptError, match="--allow-code"):
        run(world, f"return {call}")


def test_a_new_customization_script_runs_at_once(world: World) -> None:
    (handle,) = run(world, f'return sim.createScript(6, "{SAYS.format("new")}")')
    assert said(world) == ["new"]
    assert world.sim.scene.objects[handle].name == "script"
    world.call("simxRemoveObject", handle)
    assert handle not in world.sim.scene.objects


def test_a_new_child_script_starts_with_the_run_and_serves_its_parent(world: World) -> None:
    source = "function sysCall_init() print(sim.getObjectAlias(sim.getObject('..'))) end"
    run(world, f'sim.setObjectParent(sim.createScript(1, "{source}"), sim.getObject("/right"))')
    assert said(world) == []
    world.run(1)
    assert said(world) == ["right"]


def test_a_new_python_script_keeps_its_language(world: World) -> None:
    with pytest.raises(ScriptError, match="language is lua or python, not 'ruby'"):
        run(world, "sim.createScript(1, '', 0, 'ruby')")
    with pytest.raises(ScriptError, match="of type 1 child or 6 customization, not 0"):
        run(world, "sim.createScript(0, '')")
    run(world, "sim.createScript(1, 'def sysCall_init(): pass', 0, 'python')")
    assert [script.language for script in world.parts.scripts.all()].count("python") == 1


def test_a_script_without_an_object_gets_one_later_and_keeps_its_handle(world: World) -> None:
    code = f"""
    script = sim.addScript(6)
    sim.setScriptText(script, "{SAYS.format("added")}")
    return sim.associateScriptWithObject(script, sim.getObject('/right'))
    """
    assert run(world, code) == [1]
    assert said(world) == ["added"]
    assert run(world, "return script == sim.getScript(6, '/right')") == [True]
    with pytest.raises(ScriptError, match=r"not made by sim\.addScript, or it has an object already"):
        run(world, "sim.associateScriptWithObject(script, sim.getObject('/right'))")
    with pytest.raises(ScriptError, match="'right' has a customization script already"):
        run(world, "sim.associateScriptWithObject(sim.addScript(6), sim.getObject('/right'))")


def test_another_text_counts_after_the_script_has_started_again(world: World) -> None:
    run(world, f"other = sim.getScript(6, '/left') sim.setScriptText(other, \"{SAYS.format('changed')}\")")
    assert said(world) == []
    assert run(world, "return sim.initScript(other)") == [True]
    assert said(world) == ["left ends", "changed"]
    (text,) = run(world, "return sim.getScriptStringParam(other, sim.scriptstringparam_text)")
    assert b"changed" in text
    with pytest.raises(ScriptError, match="cannot start itself again"):
        run(world, "sim.initScript(sim.handle_self)")
    with pytest.raises(ScriptError, match="string parameter 5 of a script cannot be set"):
        run(world, "sim.setScriptStringParam(other, 5, '')")


def test_another_text_is_copied_with_its_object(world: World) -> None:
    run(world, f"sim.setScriptText(sim.getScript(6, '/left'), \"{SAYS.format('changed')}\")")
    world.call("simxCopyPasteObjects", [world.handle("left")])
    assert said(world) == ["changed"]


def test_call_backs_of_steps_that_come_and_go_during_a_run_are_noticed(world: World) -> None:
    code = """
        function sysCall_actuation()
            if sim.getSimulationTime() > 0.12 then sysCall_sensing = nil
            elseif sim.getSimulationTime() > 0.06 then sysCall_sensing = function() print('sensing') end end
        end
    """
    run(world, f"sim.initScript(sim.createScript(6, [[{code}]]))")
    world.run(2)
    assert said(world) == []
    world.run(2)
    heard = said(world)
    assert heard
    assert set(heard) == {"sensing"}
    world.run(4)
    assert said(world) == []
