"""Which function of which script is called when."""

from __future__ import annotations

from pathlib import Path

import pytest
from handler_calls import World
from real_world import RealWorld
from scripted_world import call, said, scripted

import simx_client as vrep
from simx_server.errors import CommandError
from simx_server.handlers.scene_files import saving
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_text
from simx_server.scripting.interpreter import ScriptError

pytest.importorskip("lupa")

PHASES = [
    "init",
    "actuation",
    "sensing",
    "cleanup",
    "suspend",
    "suspended",
    "resume",
    "nonSimulation",
    "beforeSimulation",
    "afterSimulation",
]


def tell(name: str) -> str:
    """A script that says which of its call-backs is called."""
    return "\n".join(f"function sysCall_{phase}() print('{name} {phase}') end" for phase in PHASES)


def test_child_scripts_are_called_from_the_leaves_to_the_roots() -> None:
    world = scripted({f"lua:{name}": tell(name) for name in ("base", "plain", "right", "leaf", "left")})
    assert said(world) == []
    world.run(1)
    order = ("leaf", "left", "right", "base", "plain")
    assert said(world) == [f"{name} {phase}" for phase in ("init", "actuation", "sensing") for name in order]
    world.sim.pause()
    world.parts.idle()
    world.sim.start()
    phases = ("suspend", "suspended", "resume")
    assert said(world) == [f"{name} {phase}" for phase in phases for name in order]
    world.sim.stop()
    assert said(world) == [f"{name} cleanup" for name in order]
    world.parts.idle()
    assert said(world) == []


def test_a_script_may_refuse_simulation_steps() -> None:
    guard = """
    local asked = 0
    function sysCall_beforeMainScript()
        asked = asked + 1
        print('asked at ' .. sim.getSimulationTime())
        return {doNotRunMainScript = asked % 3 ~= 0}
    end
    function sysCall_beforeSimulation() asked = 0 end
    """
    actor = "function sysCall_actuation() print('acts') end function sysCall_sensing() print('senses') end"
    world = scripted({"lua:customization:base": guard, "lua:leaf": actor})
    world.run(6)
    step = world.sim.time_step
    first, second = f"asked at {0.0}", f"asked at {step}"
    assert said(world) == [*[first] * 3, "acts", "senses", *[second] * 3, "acts", "senses"]
    assert world.sim.step_count == 2
    assert world.sim.time == pytest.approx(2 * step)


def test_answers_without_a_refusal_let_the_step_be_made() -> None:
    for answer in ("", "return {}", "return {doNotRunMainScript = false}", "return 7"):
        world = scripted({"lua:base": f"function sysCall_beforeMainScript() {answer} end"})
        world.run(2)
        assert world.sim.step_count == 2, answer


def test_customization_script_lives_from_load_to_close() -> None:
    world = scripted({"lua:customization:base": tell("custom"), "lua:base": tell("child")})
    assert said(world) == ["custom init"]
    world.parts.idle()
    assert said(world) == ["custom nonSimulation"]
    world.run(1)
    assert said(world) == [
        "custom beforeSimulation",
        "child init",
        "child actuation",
        "custom actuation",
        "child sensing",
        "custom sensing",
    ]
    world.sim.pause()
    world.parts.idle()
    world.sim.start()
    assert said(world) == [
        f"{name} {phase}" for phase in ("suspend", "suspended", "resume") for name in ("child", "custom")
    ]
    world.sim.stop()
    assert said(world) == ["child cleanup", "custom afterSimulation"]
    world.sim.close()
    assert said(world) == ["custom cleanup"]
    assert not world.parts.scripts.phases.want_idle


def test_customization_script_keeps_its_values_and_its_changes_before_a_start_stay() -> None:
    world = scripted(
        {
            "lua:customization:base": """
            starts = 0
            function sysCall_beforeSimulation()
                starts = starts + 1
                sim.setObjectPosition(sim.handle_self, -1, {starts, 0, 0})
            end
            function sysCall_actuation() sim.setObjectPosition(sim.handle_self, -1, {9, 9, 9}) end
            function state() return {starts}, sim.getObjectPosition(sim.handle_self, -1), {}, '' end
            """
        }
    )
    for number in (1, 2):
        world.run(2)
        assert call(world, "state", kind=6) == ([number], [9, 9, 9], [], b"")
        world.sim.stop()
        assert call(world, "state", kind=6) == ([number], [number, 0, 0], [], b"")


def test_idle_passes_are_made_by_the_engine_while_stopped(tmp_path: Path) -> None:
    (tmp_path / "idle.lua").write_text(
        "function sysCall_nonSimulation() n = (n or 0) + 1 sim.setIntegerSignal('idle', n) end"
    )
    (tmp_path / "scene.xml").write_text(
        '<mujoco><worldbody><body name="it"><geom size="0.1"/></body></worldbody><custom>'
        '<text name="simx:script:it" data="file=idle.lua type=customization"/></custom></mujoco>'
    )
    world = RealWorld(tmp_path / "scene.xml")
    try:
        client = world.client()
        while vrep.simxGetIntegerSignal(client, "idle", vrep.simx_opmode_blocking) < (0, 3):
            world.loop.turn(max_wait=0.1)
    finally:
        world.close()


def test_an_object_may_have_a_child_and_a_customization_script_from_files(tmp_path: Path) -> None:
    (tmp_path / "child.lua").write_text("function f() return {1}, {}, {}, '' end")
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "custom.lua").write_text("function f() return {6}, {}, {}, '' end")
    (tmp_path / "main.lua").write_text(
        "function sysCall_actuation() print('main') end function f() return {0}, {}, {}, '' end"
    )
    (tmp_path / "scene.xml").write_text(
        '<mujoco><worldbody><body name="it"><geom size="0.1"/></body></worldbody><custom>'
        '<text name="simx:script:it" data="file=child.lua"/>'
        '<text name="simx:script:customization:it" data="file=custom.lua"/>'
        '<text name="simx:script:main" data="file=main.lua"/></custom></mujoco>'
    )
    world = World(file=tmp_path / "scene.xml")
    assert call(world, "f", on="it", kind=6)[0] == [6]
    with pytest.raises(CommandError, match="only while the simulation runs"):
        call(world, "f", on="it")
    world.run(1)
    assert [call(world, "f", on="it", kind=kind)[0] for kind in (0, 1, 6)] == [[0], [1], [6]]
    assert said(world) == ["main"]


def test_main_script_calls_customization_scripts_where_it_wants() -> None:
    phases = "function sysCall_{0}(x) print('{1} ' .. (x or 'no value')) end "
    main = """
    function sysCall_actuation()
        print(sim.handleCustomizationScripts(sim.syscb_actuation, 7), sim.handleChildScripts(sim.syscb_actuation))
        print(sim.handleCustomizationScripts(sim.syscb_cleanup))
    end
    function sysCall_sensing() print(sim.handleEmbeddedScripts(sim.syscb_sensing)) end
    """
    world = scripted(
        {
            "lua:main": main,
            "lua:customization:base": phases.format("actuation", "custom acts")
            + phases.format("sensing", "custom senses"),
            "lua:leaf": phases.format("actuation", "leaf acts") + phases.format("sensing", "leaf senses"),
            "lua:plain": phases.format("sensing", "plain senses"),
        }
    )
    world.run(1)
    sensed = ["leaf senses no value", "custom senses no value", "plain senses no value"]
    assert said(world) == ["custom acts 7", "leaf acts no value", "1, 1", "0", *sensed, "3"]


def test_main_script_calls_the_child_scripts_when_it_wants() -> None:
    world = scripted(
        {
            "lua:base": tell("child"),
            "lua:customization:base": tell("custom"),
            "lua:main": """
            function sysCall_init() print('main init') end
            function sysCall_actuation()
                print('before', sim.getSimulationTime())
                sim.handleChildScripts(sim.syscb_actuation)
                print('after')
            end
            function sysCall_cleanup() print('main cleanup') end
            """,
        }
    )
    said(world)
    world.run(1)
    assert said(world) == [
        "custom beforeSimulation",
        "main init",
        "child init",
        "before, 0.0",
        "child actuation",
        "after",
        "custom actuation",
        "custom sensing",
    ]
    world.sim.stop()
    assert said(world) == ["main cleanup", "child cleanup", "custom afterSimulation"]


def test_script_of_what_is_added_and_removed_while_running() -> None:
    world = scripted({"lua:plain": tell("one"), "lua:customization:plain": tell("custom")})
    world.run(1)
    said(world)
    world.call("simxCopyPasteObjects", [world.handle("plain")])
    assert said(world) == ["one init", "custom init"]
    world.parts.step()
    assert (
        said(world)
        == ["one actuation"] * 2 + ["custom actuation"] * 2 + ["one sensing"] * 2 + ["custom sensing"] * 2
    )
    handles = [script.handle for script in world.parts.scripts.all()]
    assert len(set(handles)) == 4
    world.sim.stop()
    assert len(world.parts.scripts.all()) == 2


def test_script_that_ends_its_own_object_or_the_run_is_no_harm() -> None:
    world = scripted(
        {
            "lua:plain": "function sysCall_actuation() sim.removeObject(sim.handle_self) print('gone') end",
            "lua:base": """
            function sysCall_sensing() if sim.getSimulationTime() > 0.07 then sim.stopSimulation() print('stop') end end
            function sysCall_cleanup() print('cleanup') end
            """,
        }
    )
    world.run(4)
    lines = [line for line in said(world) if "is stopped" not in line]
    assert lines == ["gone", "stop", "cleanup"]
    assert not world.sim.is_running


def test_error_stops_one_script_and_is_told() -> None:
    world = scripted(
        {"lua:base": "function sysCall_sensing()\n  sim.getObjectPostion(1)\nend", "lua:plain": tell("other")}
    )
    world.run(2)
    lines = said(world)
    assert lines.count("other sensing") == 2
    (told,) = [line for line in lines if "is stopped" in line]
    assert told.startswith(
        "child script of 'base' (base.lua) is stopped: base.lua:2: sim.getObjectPostion: is not provided by this "
        "server; did you mean 'getObjectPosition' or "
    )
    with pytest.raises(CommandError, match=r"was stopped by an error: base\.lua:2: sim\.getObjectPostion"):
        call(world, "sysCall_sensing")


def test_text_of_a_script_keeps_its_lines_and_letters() -> None:
    source = 'function f()\n\treturn {1 < 2 and 1 or 0}, {}, {"a\'b & c"}, "" -- comment\nend'
    world = scripted({"lua:base": source})
    world.run()
    assert call(world, "f") == ([1], [], ["a'b & c"], b"")


@pytest.mark.parametrize(
    ("name", "data", "text"),
    [
        ("script:base", "file=a.lua type=sandbox", "valid for type is one of child, customization, main"),
        ("script:base", "path=a.lua", "valid is key=value with a key of file, type, threaded"),
        ("lua:nobody", "x = 1", "names no object of the scene"),
    ],
)
def test_wrong_annotation_is_an_error_of_the_scene(name: str, data: str, text: str) -> None:
    with pytest.raises(SceneError, match=text):
        load_text(
            f'<mujoco><worldbody><body name="base"/></worldbody><custom><text name="simx:{name}" data="{data}"/>'
            "</custom></mujoco>"
        )


JOINT = '<text name="simx:joint:hinge" data="mode=force motor=on control=position max_force=100"/>'


def test_joint_callback_controls_the_motor_before_each_physics_step() -> None:
    """The script's own proportional controller, slower than V-REP's, and as strong as it says."""
    world = scripted(
        {
            "lua:hinge": """
            steps = 0
            function sysCall_jointCallback(inData)
                if inData.first then print('first', inData.passCnt, inData.totalPasses, inData.revolute) end
                steps = steps + 1
                return {velocity = 2 * (inData.targetPos - inData.currentPos), force = inData.maxForce}
            end
            function count() return {steps}, {}, {}, '' end
            """
        },
        custom=JOINT,
    )
    hinge = world.handle("hinge")
    world.run(0)
    world.call("simxSetJointTargetPosition", hinge, 1.0)
    for _ in range(10):
        world.parts.step()
    assert said(world) == [f"first, 1, {world.sim.substeps}, true"]
    assert call(world, "count", on="hinge")[0] == [10 * world.sim.substeps]
    # x' = 2 (1 - x): 1 - exp(-1) after half a second
    assert world.call("simxGetJointPosition", hinge) == pytest.approx(0.632, abs=0.02)


def test_joint_callback_says_how_strong_the_motor_is() -> None:
    world = scripted(
        {"lua:hinge": "function sysCall_jointCallback(inData) return {velocity = 100, force = 0.02} end"},
        custom=JOINT,
    )
    world.run(10)
    hinge = world.handle("hinge")
    assert world.call("simxGetJointForce", hinge) == pytest.approx(-0.02, rel=1e-3)
    weak = world.call("simxGetJointPosition", hinge)
    world.sim.stop()
    world.run(10)
    assert world.call("simxGetJointPosition", hinge) == weak


def test_joint_callback_gets_the_force_that_a_client_reads() -> None:
    source = """
    function sysCall_jointCallback(inData) effort = inData.effort return {velocity = 100, force = 0.02} end
    function last() return {}, {effort}, {}, '' end
    """
    world = scripted({"lua:hinge": source}, custom=JOINT)
    world.run(10)
    (effort,) = call(world, "last", on="hinge")[1]
    assert effort == pytest.approx(-0.02, rel=1e-3)
    assert effort == pytest.approx(world.call("simxGetJointForce", world.handle("hinge")), rel=1e-3)


def test_joint_callback_with_an_error_leaves_the_joint_to_its_own_controller() -> None:
    world = scripted(
        {"lua:hinge": "function sysCall_jointCallback(inData) return nil + 1 end"},
        custom=JOINT,
    )
    world.run(0)
    world.call("simxSetJointTargetPosition", world.handle("hinge"), 0.5)
    for _ in range(30):
        world.parts.step()
    assert "is stopped" in said(world)[-1]
    assert world.call("simxGetJointPosition", world.handle("hinge")) == pytest.approx(0.5, abs=1e-3)


def test_joint_callback_of_a_plain_position_actuator_is_told_that_it_never_comes() -> None:
    source = {"lua:hinge": "function sysCall_jointCallback(inData) print('asked') return {velocity = 1} end"}
    world = scripted(source, custom="</custom><actuator><position joint='hinge' kp='5'/></actuator><custom>")
    world.run(2)
    (line,) = said(world)
    assert "sysCall_jointCallback of the child script of 'hinge'" in line
    assert "is not called" in line
    assert "control=position" in line
    world.sim.stop()
    world.run(2)
    assert said(world) == []
    note = '<text name="simx:joint:hinge" data="control=position"/>'
    world = scripted(
        source, custom=f"{note}</custom><actuator><position joint='hinge' kp='5'/></actuator><custom>"
    )
    world.run(1)
    assert set(said(world)) == {"asked"}


def test_a_script_that_is_switched_off_is_not_called_until_it_is_on_again() -> None:
    counting = """
    count = 0
    function sysCall_init() print('init') end
    function sysCall_actuation() count = count + 1 print(count) end
    function sysCall_thread() while true do print('thread') sim.switchThread() end end
    """
    switching = """
    function switch(ints)
        local other = sim.getScriptAssociatedWithObject(sim.getObjectHandle('left'))
        return {sim.setScriptAttribute(other, sim.childscriptattribute_enabled, ints[1] == 1)}, {}, {}, ''
    end
    """
    world = scripted({"lua:left": counting, "lua:base": switching})
    world.run(1)
    assert said(world) == ["init", "thread", "1"]
    assert call(world, "switch", [0], [], [], b"")[0] == [1]
    world.parts.step()
    assert said(world) == []
    call(world, "switch", [1], [], [], b"")
    world.parts.step()
    assert said(world) == ["thread", "2"]
    call(world, "switch", [0], [], [], b"")
    world.sim.stop()
    said(world)
    world.run(1)
    assert said(world) == ["init", "thread", "1"]


def test_an_error_through_calls_of_scripts_names_the_outermost_and_what_went_wrong() -> None:
    text = """
    function f(n)
        if n == 0 then error('boom') end
        sim.callScriptFunction('f@' .. (n % 2 == 0 and 'left' or 'base'), 1, n - 1)
    end
    function go() f(4) return {}, {}, {}, '' end
    """
    world = scripted({"lua:base": text, "lua:left": text})
    world.run(0)
    with pytest.raises(ScriptError) as failed:
        call(world, "go")
    assert str(failed.value) == "base.lua:4: sim.callScriptFunction: base.lua:3: boom"


def test_the_namespace_of_a_missing_plugin_is_told_of_when_it_is_used() -> None:
    world = scripted({"lua:base": "print(simMine == nil) function go() simMine.create('') end"})
    world.run(0)
    assert said(world) == ["true"]
    with pytest.raises(ScriptError, match="no plug-in simMine; namespaces that scripts find are sim, simIK"):
        call(world, "go")


@pytest.mark.parametrize(
    ("plugin", "advice"),
    [
        ("simThymio", "moves its wheels with sim.setJointTargetVelocity"),
        ("simSubprocess", "scripts start no programs on the server"),
        ("simOctomap", "octrees are not read from files"),
    ],
)
def test_a_missing_plugin_of_coppeliasim_comes_with_advice(plugin: str, advice: str) -> None:
    world = scripted({"lua:base": f"function go() {plugin}.create('') end"})
    world.run(0)
    with pytest.raises(ScriptError, match=f"no plug-in {plugin}: .*{advice}"):
        call(world, "go")
    needing = scripted({"lua:base": f"{plugin} = require '{plugin}'"})
    needing.run(0)
    assert advice in said(needing)[0]


def test_an_old_function_of_a_missing_plugin_comes_with_advice() -> None:
    world = scripted(
        {
            "lua:base": "function go() simExtOctomap_prune(1) end",
            "lua:left": "function go() simExtVision_no() end",
        }
    )
    world.run(0)
    with pytest.raises(ScriptError, match="no plug-in simOctomap: octrees are not read from files"):
        call(world, "go")
    with pytest.raises(ScriptError, match="is not provided by this server"):
        call(world, "go", on="left")


def test_call_back_that_never_comes_is_told() -> None:
    world = scripted({"lua:base": "function sysCall_userConfig() end"})
    world.run()
    assert said(world) == [
        "sysCall_userConfig of the child script of 'base' (base.lua) is never called: it answers a double click in "
        "V-REP's window, and there is none"
    ]


def test_scripts_are_called_after_a_load_before_and_after_a_save_and_for_a_selection() -> None:
    source = """
    function sysCall_init() sim = require('sim') print('init') end
    function sysCall_afterLoad() print('loaded') end
    function sysCall_beforeSave(inData) print('before', inData.regularSave, inData.file) end
    function sysCall_afterSave(inData) print('after', inData.regularSave, inData.file) end
    function sysCall_selChange(inData) print('selected', #inData.sel, inData.sel[1]) end
    """
    world = scripted({"lua:customization:base": source})
    assert said(world) == ["init", "loaded"]
    world.call("simxSetObjectSelection", [world.handle("leaf")])
    world.call("simxSetObjectSelection", [world.handle("leaf")])
    assert said(world) == [f"selected, 1, {world.handle('leaf')}"]
    saving.scene_content(world.parts)  # a buffer has no file
    assert said(world) == ["before, true, ", "after, true, "]


def test_a_script_that_requires_a_missing_plugin_goes_on_until_it_calls_it() -> None:
    source = "simIGL = require 'simIGL' function go() simIGL.volume(1) end"
    world = scripted({"lua:base": source})
    world.run(0)
    assert said(world) == [
        "this server has no plug-in simIGL: simConvex, simOpenMesh and sim.getQHull work on meshes"
    ]
    with pytest.raises(ScriptError, match=r"base.lua:1: simIGL.volume: this server has no plug-in simIGL: "):
        call(world, "go")
