"""Scripts that are removed: they end when their present call returns, and are not called any more."""

from __future__ import annotations

import pytest
from handler_calls import World
from scripted_world import said, scripted

pytest.importorskip("lupa")

CUSTOMIZATION = "lua:customization:base"


def test_a_script_that_removes_itself_ends_after_its_call_with_its_cleanup() -> None:
    world = scripted(
        {
            CUSTOMIZATION: """
            function sysCall_init() sim.removeScript(sim.handle_self) print('still here') end
            function sysCall_nonSimulation() print('called again') end
            function sysCall_cleanup() print('cleaned up') end
            """
        }
    )
    assert [line for line in said(world) if "never called" not in line] == ["still here", "cleaned up"]
    world.parts.scripts.phases.idle()
    assert said(world) == []
    assert not world.parts.scripts.all()


def test_an_old_body_ends_itself_at_its_first_call() -> None:
    world = scripted(
        {
            CUSTOMIZATION: """
            if sim_call_type == sim.customizationscriptcall_nonsimulation then
                print('once') simRemoveScript(sim_handle_self)
            end
            """
        }
    )
    said(world)
    world.parts.scripts.phases.idle()
    world.parts.scripts.phases.idle()
    assert said(world) == ["once"]


def test_a_text_that_removes_its_script_while_it_is_loaded_ends_it() -> None:
    world = scripted({CUSTOMIZATION: "sim.removeScript() function sysCall_init() print('init') end"})
    assert said(world) == []
    assert not world.parts.scripts.all()


def test_one_script_removes_another_in_the_same_phase() -> None:
    body = "function sysCall_actuation() print('leaf') end"
    other = """
    function sysCall_actuation()
        sim.removeScript(sim.getScript(sim.scripttype_childscript, 'base'))
    end
    """
    world = scripted({"lua:base": body, "lua:leaf": other})
    said(world)
    world.run(1)
    assert said(world) == []


def test_a_copy_of_the_object_and_a_later_edit_do_not_bring_it_back() -> None:
    world = scripted({CUSTOMIZATION: "sim.removeScript(sim.handle_self) print('loaded')"})
    assert said(world) == ["loaded"]
    world.call("simxCopyPasteObjects", [world.handle("base")])
    world.call("simxCreateDummy", 0.1, None)
    assert said(world) == []


def test_a_main_script_can_be_removed_too() -> None:
    world: World = scripted(
        {
            "lua:main": "function sysCall_init() sim.removeScript(sim.handle_self) end",
            "lua:base": "function sysCall_actuation() print('child') end",
        }
    )
    world.run(1)
    assert "child" in said(world), "without a main script the server calls the child scripts"


def test_a_script_that_removes_its_object_ends_without_an_error(caplog: pytest.LogCaptureFixture) -> None:
    world = scripted(
        {
            CUSTOMIZATION: "function sysCall_init() sim.removeObject(sim.getObjectHandle('base')) print('gone') end"
        }
    )
    world.parts.scripts.phases.idle()
    world.run(1)
    assert said(world) == ["gone"]
    assert "is stopped" not in caplog.text
