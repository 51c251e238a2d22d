"""Scripts are called before and after objects are made, copied and removed."""

from __future__ import annotations

import pytest
from handler_calls import World
from scripted_world import call, said, scripted

pytest.importorskip("lupa")

TELLS = """
local function list(handles)
    local found = {}
    for handle, value in pairs(handles) do found[#found + 1] = value == true and handle or value end
    table.sort(found)
    return table.concat(found, ',')
end
function sysCall_afterCreate(inData) print('created ' .. list(inData.objectHandles)) end
function sysCall_beforeDelete(inData)
    print('removing ' .. list(inData.objectHandles) .. ' ' .. tostring(inData.allObjects))
end
function sysCall_afterDelete(inData)
    print('removed ' .. list(inData.objectHandles) .. ' ' .. tostring(inData.allObjects))
end
function sysCall_beforeCopy(inData) print('copying ' .. list(inData.objectHandles)) end
function sysCall_afterCopy(inData) print('copied ' .. list(inData.objectHandles)) end
"""


@pytest.fixture
def world() -> World:
    return scripted({"lua:customization:base": TELLS})


def test_what_a_client_makes_and_removes_is_told_when_its_message_is_done(world: World) -> None:
    dummy = world.call("simxCreateDummy", 0.1, None)
    assert said(world) == []
    world.sim.settle()
    assert said(world) == [f"created {dummy}"]
    world.call("simxRemoveObject", dummy)
    world.sim.settle()
    assert said(world) == [f"removing {dummy} false", f"removed {dummy} false"]


def test_a_copy_is_told_of_before_its_original_and_after(world: World) -> None:
    leaf = world.handle("leaf")
    (copy,) = world.call("simxCopyPasteObjects", [leaf])
    assert said(world) == [f"copying {leaf}"]
    world.sim.settle()
    assert said(world) == [f"copied {leaf}", f"created {copy}"]


def test_the_end_of_the_whole_scene_is_told(world: World) -> None:
    handles = ",".join(map(str, sorted(world.sim.scene.objects)))
    world.call("simxRemoveObject", -2)
    world.sim.settle()
    assert said(world)[:1] == [f"removing {handles} true"]


def test_an_object_that_is_not_there_is_not_told_of(world: World) -> None:
    with pytest.raises(Exception, match="no object"):
        world.call("simxRemoveObject", 4711)
    assert said(world) == []


def test_a_script_reads_the_call_backs_effect_when_its_own_call_returns() -> None:
    texts = {
        "lua:customization:base": "function sysCall_afterCreate(inData)"
        " sim.setObjectAlias(inData.objectHandles[1], 'marked') end",
        "lua:left": "function go() print(sim.getObjectAlias(sim.createDummy(0.1))) return {}, {}, {}, '' end",
    }
    world = scripted(texts)
    world.run(0)
    call(world, "go", on="left")
    assert said(world) == ["marked"]


def test_the_objects_of_a_run_are_told_of_at_its_stop(world: World) -> None:
    world.run(0)
    dummy = world.call("simxCreateDummy", 0.1, None)
    world.sim.settle()
    world.sim.stop()
    world.sim.settle()
    assert said(world) == [f"created {dummy}", f"removed {dummy} false"]


def test_a_call_back_that_makes_objects_does_not_go_on_for_ever() -> None:
    world = scripted({"lua:customization:base": "function sysCall_afterCreate() sim.createDummy(0.1) end"})
    before = len(world.sim.scene.objects)
    world.call("simxCreateDummy", 0.1, None)
    world.sim.settle()
    assert len(world.sim.scene.objects) == before + 5
    assert "call-backs without end" in said(world)[0]
    assert world.sim.is_settled


def test_a_python_script_gets_the_same_tables() -> None:
    source = (
        "def sysCall_afterCreate(inData): print('created', inData['objectHandles'])\n"
        "def sysCall_beforeDelete(inData): print('removing', inData['objectHandles'], inData['allObjects'])"
    )
    world = scripted({"python:customization:base": source})
    dummy = world.call("simxCreateDummy", 0.1, None)
    world.sim.settle()
    world.call("simxRemoveObject", dummy)
    world.sim.settle()
    assert said(world) == [f"created [{dummy}]", f"removing {{{dummy}: True}} False"]
    world.sim.close()


def test_no_call_back_comes_when_a_scene_is_loaded_or_closed(world: World) -> None:
    world.sim.close()
    world.sim.settle()
    assert said(world) == []
