"""Scripts in script objects, as in CoppeliaSim 4.7 and later, and scripts that their file disables."""

from __future__ import annotations

import sys

import pytest
from scripted_world import TREE, evaluate, said, scripted

from simx_server.editing.copying import Kept, copy_objects

pytest.importorskip("lupa")

BODY = f'{TREE}<body name="holder"><geom size="0.1"/><site name="one"/><site name="two"/></body>'
OBJECTS = '<text name="simx:object:one" data="type=script"/><text name="simx:object:two" data="type=script"/>'


def tell(word: str) -> str:
    return f"function sysCall_init() print('{word}', sim.getObjectAlias(sim.getObject('..'))) end"


def test_relative_paths_start_at_the_script_object() -> None:
    source = "function names() return sim.getObjectName(sim.getObject('.')), sim.getObjectName(sim.getObject('..')) end"
    world = scripted({"lua:customization:one": source}, BODY, OBJECTS)
    assert evaluate(world, "return names()", on="holder", kind=6) == [b"one", b"holder"]


def test_an_object_may_have_several() -> None:
    world = scripted({"lua:one": tell("first"), "lua:two": tell("second")}, BODY, OBJECTS)
    world.call("simxStartSimulation")
    assert said(world) == ["first, holder", "second, holder"]


def test_a_script_serves_the_parent_of_its_object() -> None:
    world = scripted({"lua:one": "function f() return {}, {}, {'here'}, '' end"}, BODY, OBJECTS)
    world.call("simxStartSimulation")
    scripts, holder = world.parts.scripts, world.sim.scene.by_name("holder")
    assert [script.owner for script in scripts.all()] == [holder]
    for target in ("holder", "one"):
        assert world.call("simxCallScriptFunction", target, 1, "f", [], [], [], b"")[2] == ["here"]


def test_call_backs_of_a_joint_are_found_in_its_script_object() -> None:
    body = '<body name="arm"><joint name="hinge" axis="0 0 1"/><geom size="0.1" mass="1"/><site name="one"/></body>'
    note = '<text name="simx:object:one" data="type=script parent=hinge"/>'
    note += '<text name="simx:joint:hinge" data="motor=on control=position"/>'
    source = "calls = 0 function sysCall_joint(data) calls = calls + 1 return {velocity = 0, force = 0} end"
    source = source.replace("sysCall_joint", "sysCall_jointCallback")
    world = scripted({"lua:one": source}, body, note)
    world.call("simxStartSimulation")
    world.parts.step()
    assert evaluate(world, "return calls", on="hinge")[0] > 0


def test_a_script_object_at_the_top_serves_no_object() -> None:
    world = scripted(
        {"lua:one": "function sysCall_init() print('runs') end"},
        '<site name="one"/>',
        OBJECTS.split("/>")[0] + "/>",
    )
    world.call("simxStartSimulation")
    assert said(world) == ["runs"]


def test_a_copy_of_the_object_has_a_script_of_its_own() -> None:
    world = scripted(
        {"lua:one": tell("made")}, BODY, OBJECTS + '<text name="simx:model:holder" data="base=yes"/>'
    )
    holder = world.sim.scene.by_name("holder")
    assert holder is not None
    copy_objects(world.parts, [holder])
    world.call("simxStartSimulation")
    assert sorted(said(world)) == ["made, holder", "made, holder"]
    assert len({script.owner for script in world.parts.scripts.all()}) == 2


def test_a_copy_may_go_without_scripts() -> None:
    notes = '<text name="simx:model:holder" data="base=yes"/>' + OBJECTS
    world = scripted(
        {"lua:one": tell("object"), "lua:holder": "function sysCall_init() print('note') end"}, BODY, notes
    )
    holder = world.sim.scene.by_name("holder")
    assert holder is not None
    (copy,) = copy_objects(world.parts, [holder], Kept(scripts=False))
    assert world.sim.scene.children(copy) == []
    world.call("simxStartSimulation")
    assert sorted(said(world)) == ["note", "object, holder"]


OFF = '<text name="simx:script:base" data="enabled=no"/>'
RUNS = "function sysCall_init() print('init') end function sysCall_actuation() print('acts') end"


def test_a_script_that_is_off_does_not_run() -> None:
    world = scripted({"lua:base": RUNS}, custom=OFF)
    world.call("simxStartSimulation")
    world.parts.step()
    assert said(world) == []


def test_another_script_can_enable_it_for_the_run() -> None:
    other = (
        "function sysCall_init() local s = sim.getScriptAssociatedWithObject(sim.getObjectHandle('base'))"
        " sim.setScriptAttribute(s, sim.scriptattribute_enabled, true) end"
    )
    world = scripted({"lua:base": RUNS, "lua:plain": other}, custom=OFF)
    for _ in range(2):
        world.call("simxStartSimulation")
        world.parts.step()
        assert said(world) == ["init", "acts"]
        world.call("simxStopSimulation")
        world.parts.step()
        said(world)


def test_options_belong_to_the_text_of_the_same_kind() -> None:
    options = '<text name="simx:script:base" data="threaded=yes"/>'
    world = scripted(
        {"lua:base": "print('one')\nsim.wait(0)\nprint('two')", "lua:customization:base": "x = 1"},
        custom=options,
    )
    assert [(script.kind.name, script.threaded) for script in world.parts.scripts.all()] == [
        ("CHILD", True), ("CUSTOMIZATION", False),
    ]  # fmt: skip


def test_a_script_object_has_the_properties_of_its_script() -> None:
    source = "function sysCall_actuation() end"
    world = scripted({"lua:customization:one": source, "lua:two": source}, BODY, OBJECTS)
    get = "local two = sim.getObject('../two') return "
    assert evaluate(world, get + "sim.getIntProperty(two, 'scriptType')", on="holder", kind=6) == [1]
    assert evaluate(world, get + "sim.getIntProperty(two, 'scriptState')", on="holder", kind=6) == [1]
    assert evaluate(world, get + "sim.getStringProperty(two, 'language')", on="holder", kind=6) == [b"lua"]
    found = evaluate(world, get + "sim.getStringProperty(two, 'code')", on="holder", kind=6)
    assert source.encode() in found[0]
    change = "local two = sim.getObject('../two') sim.set"
    evaluate(world, change + "BoolProperty(two, 'scriptDisabled', true)", on="holder", kind=6)
    evaluate(
        world, change + "IntProperty(two, 'execPriority', sim.scriptexecorder_last)", on="holder", kind=6
    )
    assert evaluate(world, get + "sim.getBoolProperty(two, 'scriptDisabled')", on="holder", kind=6) == [True]
    script = next(one for one in world.parts.scripts.all() if one.kind == 1)
    assert (script.is_enabled, int(script.order)) == (False, 2)
    assert evaluate(world, get + "sim.getHandleProperty(two, 'detachedScript')", on="holder", kind=6) == [
        script.handle
    ]


@pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")
def test_python_scripts_use_properties_too() -> None:
    source = """
def sysCall_init():
    base = sim.getObject('..')
    sim.setFloatProperty(base, 'mass', 2.5)
    sim.setTableProperty(base, 'customData.t', {'a': [1, 2]})
    sim.setBufferProperty(sim.handle_scene, 'signal.b', b'x')
    print(sim.getFloatProperty(base, 'mass'), sim.getTableProperty(base, 'customData.t'))
    print(sim.getFloatProperty(base, 'none', {'noError': True}), sim.getStringProperty(base, 'objectType'))
"""
    world = scripted({"python:one": source}, BODY, OBJECTS)
    world.call("simxStartSimulation")
    assert said(world) == ["2.5 {'a': [1, 2]}", "None shape"]
    assert world.parts.signals.get_string("b") == b"x"
    world.parts.scripts.close()
