"""Child scripts of a scene: when they run, and what a client's call of one of their functions gives."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from handler_calls import World
from scripted_world import scripted

from simx_server.errors import CommandError

pytest.importorskip("lupa")

SEED_SCRIPT = Path(__file__).parents[4] / "shared" / "seed" / "rg2.lua"

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="RG2"><geom size="0.05"/>
      <body name="finger" pos="0 0 0.2">
        <joint name="RG2_openCloseJoint" type="slide" axis="1 0 0" range="-0.1 0.1" limited="true"/>
        <geom size="0.02" mass="0.1"/>
      </body>
    </body>
    <body name="RG2#0" pos="1 0 0"><geom size="0.05"/>
      <body name="finger#0" pos="0 0 0.2"><geom size="0.02"/></body>
    </body>
    <body name="plain" pos="2 0 0"><geom size="0.05"/></body>
  </worldbody>
  <custom>
    <text name="simx:joint:RG2_openCloseJoint" data="mode=force motor=on control=velocity lock=on max_force=50"/>
    <text name="simx:script:RG2" data="file={first}"/>
    {second}
  </custom>
</mujoco>
"""


def scene(folder: Path, first: str | bytes, second: str | None = None) -> World:
    """A scene with a script on RG2, and another one on RG2#0."""
    (folder / "first.lua").write_bytes(first if isinstance(first, bytes) else first.encode())
    more = ""
    if second is not None:
        (folder / "second.lua").write_text(second, encoding="utf-8")
        more = '<text name="simx:script:RG2#0" data="file=second.lua"/>'
    (folder / "scene.xml").write_text(SCENE.format(first="first.lua", second=more), encoding="utf-8")
    return World(file=folder / "scene.xml")


def call(world: World, function: str, *inputs: Any, on: str = "RG2", kind: int = 1) -> Any:
    return world.call("simxCallScriptFunction", on, kind, function, *(inputs or ([], [], [], b"")))


@pytest.mark.skipif(not SEED_SCRIPT.is_file(), reason="the tutorial's script lies beside the repository only")
def test_the_tutorials_gripper_script_runs_as_it_stands(tmp_path: Path) -> None:
    world = scene(tmp_path, SEED_SCRIPT.read_bytes())
    motor = world.handle("RG2_openCloseJoint")
    world.run(10)
    assert world.call("simxGetJointMaxForce", motor) == 20
    assert world.call("simxGetJointPosition", motor) == pytest.approx(0.5 * 0.05, abs=2e-3)
    assert call(world, "rg2Close") == ([], [pytest.approx(-0.05)], [], b"")
    for _ in range(10):
        world.parts.step()
    assert world.call("simxGetJointPosition", motor) == pytest.approx(0.0, abs=4e-3)
    assert call(world, "rg2Open") == ([], [pytest.approx(0.05)], [], b"")
    world.call("simxStopSimulation")
    assert world.call("simxGetJointPosition", motor) == 0


ECHO = """
function echo(ints, floats, strings, buffer) return ints, floats, strings, buffer, 'ignored' end
function kinds(...) return {select('#', ...)}, {}, {type((select(1, ...))), type((select(4, ...)))}, '' end
function few() return {}, {} end
function none() end
function wrong() return {}, {1}, {2, {}}, '' end
function texts() return {1.9, -1.9, true, 4294967295}, {1e300}, {}, '' end
function cut() return {1.9, true, 4294967295}, {0.1, 3}, {'ab\\0cd', 7}, 'x\\0y' end
function boom() local x = nil + 1 end
function endless() while true do end end
deep = {er = {}}
function deep.er.f() return {42}, {}, {}, '' end
"""


def test_four_arguments_go_in_and_four_results_come_back(tmp_path: Path) -> None:
    world = scene(tmp_path, ECHO)
    world.run()
    assert call(world, "echo", [1, -2], [0.5], ["a", "\u4f60"], b"\0\xff") == (
        [1, -2],
        [0.5],
        ["a", "\u4f60"],
        b"\0\xff",
    )
    assert call(world, "echo") == ([], [], [], b"")
    assert call(world, "kinds") == ([4], [], ["table", "string"], b"")
    ints, floats, strings, buffer = call(world, "cut")
    assert ints == [1, 1, -1]
    assert floats == [0.10000000149011612, 3.0]
    assert strings == ["ab", "7"]
    assert buffer == b"x\0y"


def test_bad_results_and_errors_are_explained(tmp_path: Path) -> None:
    world = scene(tmp_path, ECHO)
    world.run()
    for function, text in (
        ("few", "first.lua: few returned 2 values, but must return four"),
        ("none", "returned 0 values"),
        ("wrong", r"result 3 \(strings\), which must be a table with a string at index 2"),
        ("texts", r"result 2 \(floats\), which must be .* single precision"),
        ("boom", r"first\.lua:\d+: attempt to perform arithmetic on a nil value"),
        ("missing", "the child script of 'RG2' .* has no function 'missing'"),
    ):
        with pytest.raises(CommandError, match=text):
            call(world, function)
    assert call(world, "echo") == ([], [], [], b""), "an error in one call must not end the script"


def test_endless_function_is_stopped_and_the_next_call_works(tmp_path: Path) -> None:
    world = scene(tmp_path, ECHO)
    world.parts.scripts.time_limit = 0.1
    world.run()
    with pytest.raises(CommandError, match="took too long and was stopped"):
        call(world, "endless")
    assert call(world, "echo", [7], [], [], b"") == ([7], [], [], b"")


def test_target_is_found_by_description_or_after_the_function_name(tmp_path: Path) -> None:
    world = scene(tmp_path, ECHO)
    world.run()
    expected = ([42], [], [], b"")
    assert call(world, "deep.er.f") == expected
    assert call(world, "deep.er.f", on="RG2#") == expected
    assert call(world, "deep.er.f", on="/RG2") == expected
    assert call(world, "deep.er.f@RG2", on="") == expected
    assert call(world, "deep.er.f", kind=241) == expected


@pytest.mark.parametrize(
    ("on", "kind", "text"),
    [
        ("plain", 1, "there is no child script of 'plain'; scripts of this scene: child script of 'RG2'"),
        ("RG3", 1, "no object named 'RG3'.*scripts of this scene: child script of 'RG2'"),
        ("", 1, "there is no child script; scripts"),
        ("", 0, "there is no main script; scripts"),
        ("RG2", 6, "there is no customization script of 'RG2'; scripts"),
        ("addon", 2, "there is no add-on of 'addon'"),
        ("", 8, "a client calls functions of the sandbox script through sim.executeScriptString only"),
        ("RG2", 2050005, "there is no script with handle 2050005"),
    ],
)
def test_unknown_target_lists_the_scripts(tmp_path: Path, on: str, kind: int, text: str) -> None:
    world = scene(tmp_path, ECHO)
    world.run()
    with pytest.raises(CommandError, match=text):
        call(world, "echo", on=on, kind=kind)


LIFE = """
local passes = 0
function sysCall_init()
    me = sim.getObjectHandle(sim.handle_self)
    sim.setIntegerSignal('inits', 1 + (sim.getIntegerSignal('inits') or 0))
    sim.setStringSignal('mine', 'yes')
end
function sysCall_actuation() passes = passes + 1 sim.setFloatSignal('actuated', sim.getSimulationTime()) end
function sysCall_sensing() sim.setFloatSignal('step', sim.getSimulationTimeStep()) end
function sysCall_cleanup()
    print('cleaned up after', passes)
    sim.setObjectPosition(sim.handle_self, -1, {9, 9, 9})
end
function state() return {me, passes}, {}, {}, '' end
"""


def test_script_lives_from_start_to_stop(tmp_path: Path) -> None:
    world = scene(tmp_path, LIFE)
    with pytest.raises(CommandError, match="only while the simulation runs; start the simulation first"):
        call(world, "state")
    for _ in range(2):
        world.run(3)
        assert call(world, "state")[0] == [world.handle("RG2"), 3]
        assert world.call("simxGetIntegerSignal", "inits") == 1
        assert world.call("simxGetFloatSignal", "actuated") == pytest.approx(0.1)
        assert world.call("simxGetFloatSignal", "step") == 0.05
        world.call("simxStopSimulation")
        assert world.parts.status_bar.messages[-1] == "cleaned up after, 3"
        assert world.call("simxGetObjectPosition", world.handle("RG2"), -1) == [0, 0, 0]
        with pytest.raises(CommandError):
            world.call("simxGetStringSignal", "mine")
    with pytest.raises(CommandError, match="only while the simulation runs"):
        call(world, "state")


def test_error_stops_that_script_only_until_the_next_start(tmp_path: Path) -> None:
    world = scene(tmp_path, "function sysCall_actuation() sim.noSuchFunction() end", ECHO)
    world.run(2)
    with pytest.raises(
        CommandError, match=r"was stopped by an error: first\.lua:1: sim\.noSuchFunction: is not provided"
    ):
        call(world, "echo")
    assert "sim.noSuchFunction" in world.parts.status_bar.messages[-1]
    assert call(world, "echo", on="RG2#0") == ([], [], [], b"")
    world.call("simxStopSimulation")
    (tmp_path / "first.lua").write_text(ECHO, encoding="utf-8")
    world.run()
    assert call(world, "echo") == ([], [], [], b"")


def test_script_of_a_copy_means_its_own_copies(tmp_path: Path) -> None:
    world = scene(
        tmp_path,
        ECHO,
        "function f() return {sim.getObjectHandle('finger'), sim.getObjectHandle('finger#'), "
        "sim.getObject('./finger'), sim.getObjectHandle('nothing@silentError')}, {}, {}, '' end",
    )
    world.run()
    own, other = world.handle("finger#0"), world.handle("finger")
    assert call(world, "f", on="RG2#0")[0] == [own, other, own, -1]


def test_script_of_a_removed_object_ends(tmp_path: Path) -> None:
    world = scene(tmp_path, ECHO, ECHO)
    world.run()
    world.call("simxRemoveObject", world.handle("RG2#0"))
    world.parts.step()
    with pytest.raises(CommandError):
        call(world, "echo", on="RG2#0")
    assert call(world, "echo") == ([], [], [], b"")
    world.call("simxStopSimulation")
    world.run()
    assert call(world, "echo", on="RG2#0") == ([], [], [], b"")


def test_sim_functions_give_what_clients_get(tmp_path: Path) -> None:
    world = scene(
        tmp_path,
        """
        function f(ints)
            local h, j = ints[1], ints[2]
            sim.setJointPosition(j, 0.02)
            local p, o = sim.getObjectPosition(h, -1), sim.getObjectOrientation(h)
            local q = sim.getObjectQuaternion(h, -1)
            local v, w = sim.getObjectVelocity(h)
            sim.addLog(sim.verbosity_msgs, 'logged')
            return {sim.getObjectParent(h), sim.object_shape_type, #v, #w},
                {p[1], p[2], p[3], o[1], q[4], sim.getJointPosition(j)}, {sim.getObjectName(h)}, ''
        end
        function bad() sim.setJointTargetVelocity('a', 1) end
        function nothing() sim.setJointTargetVelocity() end
        function unknown() sim.getObjectPosition(4711, -1) end
        """,
    )
    world.run()
    plain, joint = world.handle("plain"), world.handle("RG2_openCloseJoint")
    ints, floats, strings, _ = call(world, "f", [plain, joint], [], [], b"")
    assert ints == [-1, 0, 3, 3]
    assert floats == pytest.approx([2, 0, 0, 0, 1, 0.02])
    assert strings == ["plain"]
    assert world.parts.status_bar.messages[-1] == "[RG2:info] logged"
    for function, text in (
        ("bad", r"sim\.setJointTargetVelocity: argument 1 \(joint\) must be a number, got 'a'"),
        ("nothing", r"argument 1 \(joint\) must be a number, got nothing"),
        ("unknown", "no object with handle 4711"),
    ):
        with pytest.raises(CommandError, match=text):
            call(world, function)


def test_script_file_must_lie_in_the_scenes_folder(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "outside.lua").write_text(ECHO, encoding="utf-8")
    folder = tmp_path / "scene"
    folder.mkdir()
    for file, text in (
        ("../outside.lua", "outside the scene's folder"),
        ("missing.lua", "is not in the scene's folder"),
    ):
        (folder / "scene.xml").write_text(SCENE.format(first=file, second=""), encoding="utf-8")
        world = World(file=folder / "scene.xml")
        assert text in caplog.text
        world.run()
        with pytest.raises(CommandError, match=text):
            call(world, "echo")


def test_shipped_gripper_script_obeys_its_signal() -> None:
    from simx_server.files.library import find_scene

    world = World(file=find_scene("ur5_rg2_kinect"))
    motor = world.handle("RG2_openCloseJoint")
    world.run()
    world.call("simxSetIntegerSignal", "RG2_open", 0)
    world.parts.step()
    assert world.sim.joints.target_velocity(motor) == pytest.approx(-0.05)
    assert call(world, "rg2Open") == ([], [pytest.approx(0.05)], [], b"")


def test_every_kind_of_script_is_a_target_by_type_or_handle() -> None:
    answers = "function where() return {%d}, {}, {}, '' end  tools = {deep = {where = where}}"
    world = scripted(
        {"lua:base": answers % 1, "lua:customization:base": answers % 6, "lua:main": answers % 0}
    )
    world.run()
    scripts = world.parts.scripts.all()
    assert all(script.handle > 1_000_000 for script in scripts)
    for script in scripts:
        by_handle = world.call("simxCallScriptFunction", "", script.handle, "where", [], [], [], b"")
        assert by_handle[0] == [int(script.kind)]
        named = world.call(
            "simxCallScriptFunction", "nobody", script.handle, "tools.deep.where", [], [], [], b""
        )
        assert named == by_handle, "with a handle the name is ignored"
    for description, kind, function, answer in (
        ("base", 1, "where", 1),
        ("/base", 1, "where", 1),
        ("", 1, "where@base", 1),
        ("", 1, "tools.deep.where@/base", 1),
        ("base", 6, "where", 6),
        ("", 6, "where@base", 6),
        ("base", 241, "where", 1),
        ("", 0, "where", 0),
        ("whatever", 0, "where", 0),
    ):
        found = world.call("simxCallScriptFunction", description, kind, function, [], [], [], b"")
        assert found[0] == [answer], (description, kind, function)


def test_customization_script_answers_while_stopped_and_the_others_say_what_to_do() -> None:
    answers = "function where() return {1}, {}, {}, '' end"
    world = scripted({"lua:base": answers, "lua:customization:base": answers, "lua:main": answers})
    assert world.call("simxCallScriptFunction", "base", 6, "where", [], [], [], b"")[0] == [1]
    for kind, name in ((1, "child script of 'base'"), (0, "main script")):
        with pytest.raises(CommandError, match=rf"the {name} \(.*\) exists only while the simulation runs"):
            world.call("simxCallScriptFunction", "base", kind, "where", [], [], [], b"")


def test_results_of_numbers_that_are_texts_or_named_tables_are_refused() -> None:
    world = scripted(
        {
            "lua:base": """
            function named() return {a = 1}, {}, {}, '' end
            function func() return {}, {}, {print}, '' end
            function nothing() return {}, nil, {}, '' end
            function enough() return {}, {}, {}, '', {}, print end
            """
        }
    )
    world.run()
    for function, text in (
        ("named", r"result 1 \(integers\), which must be a table"),
        ("func", r"result 3 \(strings\), which must be a table with a string at index 1"),
        ("nothing", r"returned nil as result 2 \(floats\), which must be a table"),
    ):
        with pytest.raises(CommandError, match=text):
            call(world, function, on="base")
    assert call(world, "enough", on="base") == ([], [], [], b"")
