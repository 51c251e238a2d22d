"""Scripts as V-REP 3 had them: without call-backs, with the old names, as threads."""

from __future__ import annotations

import pytest
from scripted_world import call, said, scripted

from simx_server.scripting.bodies import with_call_backs

pytest.importorskip("lupa")

OLD_BODY = """
helper=function(inInts,inFloats,inStrings,inBuffer)
    return {handle,count},{},{},''
end
if (sim_call_type==sim_childscriptcall_initialization) then
    handle=simGetObjectAssociatedWithScript(sim_handle_self)
    count=0
    simAddStatusbarMessage('init '..simGetObjectName(handle))
end
if (sim_call_type==sim_childscriptcall_actuation) then
    local fresh
    fresh=(fresh or 0)+1
    count=count+fresh
    simSetObjectPosition(handle,-1,{count,0,0})
end
if (sim_call_type==sim_childscriptcall_sensing) then
    simAddStatusbarMessage('sensing '..count)
end
if (sim_call_type==sim_childscriptcall_cleanup) then
    simAddStatusbarMessage('cleanup')
end
"""

NEWER_BODY = """
if (sim_call_type==sim.syscb_init) then print('init') end
if (sim_call_type==sim.syscb_actuation) then print('actuation') end
if (sim_call_type==sim.syscb_sensing) then print('sensing') end
if (sim_call_type==sim.syscb_cleanup) then print('cleanup') end
"""


def test_body_is_run_at_each_call_and_keeps_its_globals() -> None:
    world = scripted({"lua:plain": OLD_BODY})
    world.run(3)
    assert said(world) == ["init plain", "sensing 1", "sensing 2", "sensing 3"]
    plain = world.handle("plain")
    assert call(world, "helper", on="plain") == ([plain, 3], [], [], b"")
    assert world.call("simxGetObjectPosition", plain, -1) == [3, 0, 0]
    world.sim.stop()
    assert said(world) == ["cleanup"]


def test_body_with_the_names_of_version_3_4() -> None:
    world = scripted({"lua:base": NEWER_BODY})
    world.run(1)
    world.sim.stop()
    assert said(world) == ["init", "actuation", "sensing", "cleanup"]


def test_body_of_a_customization_script_has_its_own_phases() -> None:
    names = [
        "initialization",
        "nonsimulation",
        "lastbeforesimulation",
        "simulationactuation",
        "simulationsensing",
        "simulationpausefirst",
        "simulationpause",
        "simulationpauselast",
        "firstaftersimulation",
        "cleanup",
    ]
    tests = "\n".join(
        f"if (sim_call_type==sim_customizationscriptcall_{name}) then print('{name}') end" for name in names
    )
    world = scripted({"lua:customization:base": tests})
    world.parts.idle()
    world.run(1)
    world.sim.pause()
    world.parts.idle()
    world.sim.start()
    world.sim.stop()
    world.sim.close()
    assert said(world) == names


def test_line_numbers_are_those_of_the_text() -> None:
    world = scripted({"lua:base": "-- first\nif (sim_call_type==sim.syscb_init) then\n  nothing.x = 1\nend"})
    world.run()
    assert "base.lua:3:" in said(world)[-1]


THREADED = """
-- Put some initialization code here
threadFunction=function()
    while simGetSimulationState()~=sim_simulation_advancing_abouttostop do
        simAddStatusbarMessage('round '..simGetSimulationTime())
        if rounds==2 then error('enough') end
        rounds=(rounds or 0)+1
        simSwitchThread()
    end
end
simSetThreadAutomaticSwitch(false)
simAddStatusbarMessage('begin')
res,err=xpcall(threadFunction,function(err) return debug.traceback(err) end)
if not res then
    simAddStatusbarMessage('Lua runtime error: '..err)
end
simSetThreadSwitchTiming(2)
while simGetSimulationState()~=sim_simulation_advancing_abouttostop do simSwitchThread() end
simAddStatusbarMessage('clean-up')
"""


def test_threaded_body_is_one_thread() -> None:
    world = scripted({"lua:base": THREADED})
    world.run(4)
    assert said(world) == [
        "begin",
        "round 0.0",
        "round 0.05",
        "round 0.1",
        "Lua runtime error: base.lua:6: enough\nstack traceback:\n\t[C]: in function 'error'\n"
        "\tbase.lua:6: in function 'threadFunction'\n\t[C]: in function 'xpcall'\n"
        "\tbase.lua:13: in function 'sysCall_threadmain'",
    ]
    world.sim.stop()
    assert said(world) == ["clean-up"]


def test_threaded_body_may_be_marked_as_such() -> None:
    world = scripted({"lua:threaded:base": "for i=1,2 do print(i) simWait(0.05) end print('end')"})
    world.run(4)
    assert said(world) == ["1", "2", "end"]


def test_the_text_of_a_threaded_script_is_a_part_of_its_thread() -> None:
    source = """
    print('text', sim.getSimulationTime()) sim.wait(0.1) print('text', sim.getSimulationTime())
    function sysCall_threadmain() print('main', sim.getSimulationTime()) sim.wait(0.05) error('enough', 0) end
    """
    world = scripted({"lua:base": source}, custom='<text name="simx:script:base" data="threaded=yes"/>')
    world.run(6)
    *said_before, stop = said(world)
    assert said_before == ["text, 0.0", "text, 0.1", "main, 0.15"]
    assert "is stopped: base.lua: enough" in stop


def test_scripts_that_start_the_remote_api_go_on() -> None:
    world = scripted(
        {"lua:base": "simExtRemoteApiStart(19999) sim=require'sim-1' simRemoteApi.start(19998) print(1)"}
    )
    world.run()
    assert said(world) == ["1"]
    assert world.parts.script_ports.named == {19998, 19999}


@pytest.mark.parametrize(
    "source",
    [
        b"function sysCall_init() end -- sim_call_type",
        b"-- sim_call_type was the old way\nx = 1",
        b"--[[ if sim_call_type==0 then threadFunction() ]] function f() end",
    ],
)
def test_other_scripts_are_left_as_they_are(source: bytes) -> None:
    assert with_call_backs(source) == source


def test_old_names_and_unknown_ones() -> None:
    world = scripted(
        {
            "lua:base": """
            function f() return {simGetObjectHandle('hinge'), sim_object_joint_type, sim_handle_all}, {}, {}, '' end
            function g() simGetObjectHandel('hinge') end
            function h() return {simNoSuchThing == nil and 1 or 0}, {}, {}, '' end
            """
        }
    )
    world.run()
    assert call(world, "f")[0] == [world.handle("hinge"), 1, -2]
    with pytest.raises(
        Exception, match=r"base\.lua:3: simGetObjectHandel: is not provided by this server; did you mean"
    ):
        call(world, "g")
    assert call(world, "h")[0] == [1]
