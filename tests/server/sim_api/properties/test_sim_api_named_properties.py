"""Properties that scripts make: customData.NAME, signal.NAME and namedParam.NAME."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path

import pytest
from sim_api_calls import SCENE, ScriptWorld, world

from simx_server.limits import Limits

__all__ = ["world"]

VALUES = [
    ("Bool", "true", True),
    ("Int", "-7", -7),
    ("Long", "1 << 40", 1 << 40),
    ("Float", "0.1", 0.1),
    ("String", "'text'", "text"),
    ("String", "''", ""),
    ("Buffer", "'a\\0\\255'", "a\0\xff"),
    ("Table", "{1, 2.5, {x='y'}}", [1, 2.5, {"x": "y"}]),
    ("Vector2", "{1, 2}", [1.0, 2.0]),
    ("Vector3", "{1, 2, 3}", [1.0, 2.0, 3.0]),
    ("Quaternion", "{0, 0, 0, 1}", [0.0, 0.0, 0.0, 1.0]),
    ("Pose", "{1, 2, 3, 0, 0, 0, 1}", [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]),
    ("Color", "{1, 0.5, 0}", [1.0, 0.5, 0.0]),
    ("Matrix", "{{1, 2}, {3, 4}}", [[1.0, 2.0], [3.0, 4.0]]),
    ("IntArray", "{1, 2, 3}", [1, 2, 3]),
    ("IntArray2", "{1, 2}", [1, 2]),
    ("FloatArray", "{0.5, 1}", [0.5, 1.0]),
    ("Handle", "cube", None),
    ("HandleArray", "{5, 6}", [5, 6]),
    ("StringArray", "{'a', 'b'}", ["a", "b"]),
]
TARGETS = ("cube", "sim.handle_self", "sim.handle_scene", "sim.handle_app")


@pytest.fixture(autouse=True)
def _handles(world: ScriptWorld) -> None:
    world.lua("cube, hinge = sim.getObject('/cube'), sim.getObject('/hinge', {noError=true})")


@pytest.mark.parametrize("start", ["customData", "signal"])
def test_values_of_all_types_are_kept_with_every_target(world: ScriptWorld, start: str) -> None:
    for target in TARGETS:
        for kind, value, expected in VALUES:
            name = f"{start}.of{kind}"
            world.lua(f"sim.set{kind}Property({target}, '{name}', {value})")
            wanted = world.handle("cube") if expected is None else expected
            assert world.value(f"sim.get{kind}Property({target}, '{name}')") == wanted
            assert world.value(f"sim.getProperty({target}, '{name}')") == wanted
            assert world.lua(f"return sim.getPropertyInfo({target}, '{name}')")[1] == 4
            world.lua(f"sim.removeProperty({target}, '{name}')")
            world.fails(f"sim.getProperty({target}, '{name}')", "has no property")
            assert world.value(f"sim.get{kind}Property({target}, '{name}', {{noError=true}})") is None


def test_a_name_has_one_type(world: ScriptWorld) -> None:
    world.lua("sim.setIntProperty(cube, 'customData.a', 5)")
    world.fails(
        "sim.getFloatProperty(cube, 'customData.a')", "is of type int, not float; use sim.getIntProperty"
    )
    world.lua("sim.setFloatProperty(cube, 'customData.a', 0.5)")
    assert world.value("sim.getProperty(cube, 'customData.a')") == 0.5
    world.fails("sim.getIntProperty(cube, 'customData.a')", "is of type float")
    assert world.value("sim.getProperties(cube)['customData.a']") == 0.5
    assert world.lua("return sim.getPropertyName(cube, 0, {prefix='customData.'})") == [
        "customData.a",
        "object",
    ]
    assert world.lua("return sim.getPropertyName(cube, 1, {prefix='customData.'})") == [None, None]


def test_a_value_without_a_type_gets_its_own(world: ScriptWorld) -> None:
    for value, kind in (
        ("true", 0),
        ("3", 1),
        ("1 << 40", 16),
        ("0.5", 2),
        ("'x'", 3),
        ("'\\255'", 4),
        ("{1}", 12),
    ):
        world.lua(f"sim.setProperty(cube, 'customData.new', {value})")
        assert world.lua("return sim.getPropertyInfo(cube, 'customData.new')")[0] == kind
    world.lua("sim.setVector3Property(cube, 'customData.v', {1, 2, 3})")
    world.lua("sim.setProperty(cube, 'customData.v', {4, 5, 6})")
    assert world.value("sim.getVector3Property(cube, 'customData.v')") == [4, 5, 6]
    world.lua("sim.setFloatProperty(cube, 'customData.f', 1); sim.setProperty(cube, 'customData.f', 2)")
    assert world.value("sim.getFloatProperty(cube, 'customData.f')") == 2
    world.fails(
        "sim.setProperty(cube, 'customData.g', print)", "must be a boolean, a number, a string or a table"
    )


def test_buffers_are_blocks_of_custom_data(world: ScriptWorld) -> None:
    world.lua("sim.writeCustomDataBlock(cube, 'block', 'abc')")
    assert world.value("sim.getBufferProperty(cube, 'customData.block')") == "abc"
    world.lua("sim.setBufferProperty(cube, 'customData.other', sim.packDoubleTable{1, 2})")
    assert world.value("sim.unpackDoubleTable(sim.readCustomDataBlock(cube, 'other'))") == [1, 2]
    world.lua("sim.setIntProperty(cube, 'customData.block', 3)")
    assert world.value("sim.readCustomDataBlock(cube, 'block')") is None
    world.lua("sim.writeCustomDataBlock(cube, 'block', 'again')")
    assert world.value("sim.getStringProperty(cube, 'customData.block')") == "again"
    world.lua("sim.setIntProperty(cube, 'customData.n', 1); sim.writeCustomDataBlock(cube, '', nil)")
    assert world.value("sim.getProperty(cube, 'customData.n', {noError=true})") is None


BLOCKS = {"&int&.count": b"\5\0\0\0", "&vect3&.bad": b"abc", "&new&.x": b"yz"}
DATA = " ".join(f"{escape(name)}={base64.b64encode(data).decode()}" for name, data in BLOCKS.items())
FILE = SCENE.replace("</custom>", f'<text name="simx:data:cube" data="{DATA}"/></custom>')


def test_data_of_a_file_have_their_type(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, xml=FILE)
    world.lua("cube = sim.getObjectHandle('cube')")
    assert world.value("sim.getIntProperty(cube, 'customData.count')") == 5
    assert world.value("sim.getBufferProperty(cube, 'customData.x')") == "yz"
    world.fails("sim.getVector3Property(cube, 'customData.bad')", "the 3 bytes are damaged")
    assert world.value("sim.getProperties(cube)['customData.bad']") is None
    world.lua("sim.setIntProperty(cube, 'customData.count', 6)")
    assert world.value("sim.readCustomDataBlock(cube, '&int&.count')") == "\6\0\0\0"


def test_copies_have_the_data_and_temporary_data_end_with_the_run(world: ScriptWorld) -> None:
    world.lua(
        "sim.setIntProperty(cube, 'customData.n', 1); sim.setIntProperty(cube, 'customData.@tmpN', 2);"
        "copy = sim.copyPasteObjects({cube}, 0)[1]; bare = sim.copyPasteObjects({cube}, 4)[1]"
    )
    assert world.value("sim.getIntProperty(copy, 'customData.n')") == 1
    assert world.value("sim.getProperty(bare, 'customData.n', {noError=true})") is None
    world.call("simxStopSimulation")
    cube = world.handle("cube")
    assert world.parts.custom_data.typed_names(cube) == ["n"]


def test_the_scenes_signals_are_those_of_clients(world: ScriptWorld) -> None:
    world.lua("sim.setIntProperty(sim.handle_scene, 'signal.RG2_open', 1)")
    assert world.value("sim.getInt32Signal('RG2_open')") == 1
    world.lua("sim.setFloatSignal('speed', 0.5); sim.setStringSignal('data', 'a\\0b')")
    assert world.value("sim.getFloatProperty(sim.handle_scene, 'signal.speed')") == 0.5
    assert world.value("sim.getBufferProperty(sim.handle_scene, 'signal.data')") == "a\0b"
    world.lua("sim.setFloatSignal('RG2_open', 0.25)")
    assert world.value("sim.getIntProperty(sim.handle_scene, 'signal.RG2_open')") == 1
    assert world.value("sim.getFloatProperty(sim.handle_scene, 'signal.RG2_open')") == 0.25
    world.lua("sim.removeProperty(sim.handle_scene, 'signal.RG2_open')")
    assert world.lua("return (sim.getInt32Signal('RG2_open')), (sim.getFloatSignal('RG2_open'))") == [
        None,
        None,
    ]
    assert world.value("sim.getIntProperty(sim.handle_app, 'signal.speed', {noError=true})") is None


def test_signals_end_with_their_script_and_their_scene(world: ScriptWorld) -> None:
    world.lua(
        "sim.setBoolProperty(cube, 'signal.mine', true); sim.setIntProperty(sim.handle_scene, 'signal.n', 1)"
    )
    typed, cube = world.parts.signals.typed, world.handle("cube")
    typed.set(cube, "kept", "Int", b"\1\0\0\0", None)
    assert typed.names(cube) == ["mine", "kept"]
    world.call("simxStopSimulation")
    assert typed.names(cube) == ["kept"]
    assert world.parts.signals.get_integer("n") is None
    world.sim.load(world.scene_file)
    assert typed.names(cube) == []


def test_named_parameters_are_texts_of_the_server(world: ScriptWorld) -> None:
    world.lua("sim.setStringProperty(sim.handle_app, 'namedParam.mode', 'fast')")
    assert world.value("sim.getNamedStringParam('mode')") == "fast"
    assert world.value("sim.getStringProperty(sim.handle_app, 'namedParam.mode')") == "fast"
    world.fails("sim.setIntProperty(sim.handle_app, 'namedParam.mode', 1)", "a named parameter is a string")
    world.fails("sim.getStringProperty(cube, 'namedParam.mode')", "no properties 'namedParam")
    world.lua("sim.removeProperty(sim.handle_app, 'namedParam.mode')")
    assert world.value("sim.getNamedStringParam('mode')") is None


def test_references_are_handles_of_other_objects(world: ScriptWorld) -> None:
    world.lua("sim.setHandleArrayProperty(cube, 'refs.friends', {sim.handle_self, cube})")
    world.lua("sim.setReferencedHandles(cube, {cube}, 'own')")
    assert world.value("sim.getHandleArrayProperty(cube, 'refs.own')[1] == cube")
    assert world.value("sim.getReferencedHandles(cube, 'friends')[2] == cube")
    world.lua("copy = sim.copyPasteObjects({cube}, 0)[1]")
    assert world.value("sim.getHandleArrayProperty(copy, 'refs.own')[1] == copy")
    world.fails("sim.setFloatProperty(cube, 'refs.own', 1)", "use sim.setHandleArrayProperty")
    world.fails("sim.getProperty(sim.handle_scene, 'refs.own')", "every object has")
    world.lua("sim.removeProperty(cube, 'refs.own')")
    assert world.value("sim.getReferencedHandles(cube, 'own')") == []


def test_a_missing_one_is_refused_with_those_that_exist(world: ScriptWorld) -> None:
    world.lua("sim.setIntProperty(cube, 'customData.counter', 1)")
    world.fails("sim.getIntProperty(cube, 'customData.count')", "did you mean 'counter'\\?")
    world.fails("sim.removeProperty(cube, 'customData.zzz')", "it has counter \\(customData")
    world.fails(
        "sim.removeProperty(cube, 'mass')",
        "cannot be removed; those that can start with customData., signal.",
    )
    world.fails("sim.setIntProperty(cube, 'customData.', 1)", "needs a name after the dot")
    world.lua("for i = 1, 300 do sim.setIntProperty(cube, 'signal.s' .. i, i) end")
    world.fails("sim.getIntProperty(cube, 'signal.zzz')", "s100, .* and 200 more")
    world.fails("sim.setIntProperty(cube, 'signal.' .. ('x'):rep(2000), 1)", "at most 1000 characters")


def test_custom_data_are_limited(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path)
    world.sim.limits = Limits.of(["custom_data=100"])
    world.fails("sim.setStringProperty(sim.handle_scene, 'customData.a', ('x'):rep(200))", "100")


def test_each_type_has_its_two_functions(world: ScriptWorld) -> None:
    world.lua(
        """
        local p = 'customData.'
        sim.setBoolProperty(cube, p .. 'bool', true) assert(sim.getBoolProperty(cube, p .. 'bool'))
        sim.setIntProperty(cube, p .. 'int', 1) assert(sim.getIntProperty(cube, p .. 'int') == 1)
        sim.setLongProperty(cube, p .. 'long', 1) assert(sim.getLongProperty(cube, p .. 'long') == 1)
        sim.setFloatProperty(cube, p .. 'float', 1) assert(sim.getFloatProperty(cube, p .. 'float') == 1)
        sim.setStringProperty(cube, p .. 'text', 'a') assert(sim.getStringProperty(cube, p .. 'text') == 'a')
        sim.setBufferProperty(cube, p .. 'data', 'a') assert(sim.getBufferProperty(cube, p .. 'data') == 'a')
        sim.setTableProperty(cube, p .. 'table', {1}) assert(sim.getTableProperty(cube, p .. 'table')[1] == 1)
        sim.setVector2Property(cube, p .. 'two', {1, 2}) assert(sim.getVector2Property(cube, p .. 'two')[2] == 2)
        sim.setVector3Property(cube, p .. 'xyz', {1, 2, 3}) assert(sim.getVector3Property(cube, p .. 'xyz')[3] == 3)
        sim.setQuaternionProperty(cube, p .. 'q', {0, 0, 0, 1}) assert(#sim.getQuaternionProperty(cube, p .. 'q') == 4)
        sim.setPoseProperty(cube, 'pose', {1, 2, 3, 0, 0, 0, 1}) assert(sim.getPoseProperty(cube, 'pose')[7] == 1)
        sim.setColorProperty(cube, p .. 'rgb', {1, 0, 0}) assert(sim.getColorProperty(cube, p .. 'rgb')[1] == 1)
        sim.setIntArrayProperty(cube, p .. 'ints', {5}) assert(sim.getIntArrayProperty(cube, p .. 'ints')[1] == 5)
        sim.setIntArray2Property(cube, p .. 'pair', {5, 6}) assert(sim.getIntArray2Property(cube, p .. 'pair')[2] == 6)
        sim.setFloatArrayProperty(cube, p .. 'all', {5}) assert(sim.getFloatArrayProperty(cube, p .. 'all')[1] == 5)
        sim.setHandleProperty(cube, p .. 'h', cube) assert(sim.getHandleProperty(cube, p .. 'h') == cube)
        sim.setHandleArrayProperty(cube, p .. 'hs', {cube}) assert(#sim.getHandleArrayProperty(cube, p .. 'hs') == 1)
        sim.setStringArrayProperty(cube, p .. 'ts', {'a'}) assert(sim.getStringArrayProperty(cube, p .. 'ts')[1] == 'a')
        """
    )
