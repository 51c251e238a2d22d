"""Threads of scripts: sysCall_thread, sysCall_threadmain and coroutines, and what lets them wait."""

from __future__ import annotations

import pytest
from scripted_world import call, said, scripted

pytest.importorskip("lupa")

CLOCK = "local function note(text) print(text .. string.format(' %.2f', sim.getSimulationTime())) end\n"


@pytest.mark.parametrize("name", ["sysCall_thread", "sysCall_threadmain"])
def test_thread_goes_on_once_per_pass_before_the_actuation(name: str) -> None:
    world = scripted(
        {
            "lua:base": CLOCK
            + f"""
            function sysCall_init() note('init') end
            function {name}()
                note('begun')
                sim.switchThread()
                note('second')
                sim.step()
                note('over')
            end
            function sysCall_actuation() note('actuation') end
            function sysCall_cleanup() note('cleanup') end
            """
        }
    )
    world.run(4)
    world.sim.stop()
    assert said(world) == [
        "init 0.00",
        "begun 0.00",
        "actuation 0.00",
        "second 0.05",
        "actuation 0.05",
        "over 0.10",
        "actuation 0.10",
        "actuation 0.15",
        "cleanup 0.20",
    ]


def test_wait_ends_with_the_pass_that_reaches_its_time() -> None:
    world = scripted(
        {
            "lua:base": CLOCK
            + """
            function sysCall_thread()
                note('late by ' .. string.format('%.2f', sim.wait(0.15)))
                note('late by ' .. string.format('%.2f', sim.wait(0.07)))
                sim.wait(0)
                note('at once')
                print(pcall(sim.wait, -1))
            end
            """
        }
    )
    world.run(7)
    lines = said(world)
    assert lines[:3] == ["late by 0.00 0.15", "late by 0.03 0.25", "at once 0.25"]
    assert lines[3].startswith("false, base.lua:8: sim.wait: a time to wait is a number not below 0")


def test_signals_drive_a_thread() -> None:
    world = scripted(
        {
            "lua:base": CLOCK
            + """
            function sysCall_thread()
                while true do
                    local value = sim.waitForSignal('go')
                    note(tostring(value))
                    sim.clearIntegerSignal('go') sim.clearStringSignal('go')
                end
            end
            """
        }
    )
    world.run(2)
    assert said(world) == []
    world.call("simxSetIntegerSignal", "go", 7)
    world.parts.step()
    world.parts.step()
    world.call("simxSetStringSignal", "go", b"word")
    world.parts.step()
    assert said(world) == ["7 0.10", "word 0.20"]


def test_calls_of_sim_give_way_by_themselves_unless_that_is_switched_off() -> None:
    world = scripted(
        {
            "lua:base": """
            rounds = 0
            function sysCall_thread()
                while sim.getIntegerSignal('quiet') == nil do rounds = rounds + 1 end
                local before = sim.setThreadAutomaticSwitch(false)
                for i = 1, 20000 do sim.getSimulationTime() end
                print(before, sim.getThreadAutomaticSwitch(), sim.getSimulationTime())
                sim.setThreadAutomaticSwitch(true)
                while true do sim.getSimulationTime() end
            end
            """
        }
    )
    world.run(3)
    assert said(world) == []
    world.call("simxSetIntegerSignal", "quiet", 1)
    world.parts.step()
    assert said(world) == ["0, false, 0.15"]
    world.parts.step()
    assert world.sim.is_running


@pytest.mark.parametrize(
    "body",
    [
        "sim.setThreadAutomaticSwitch(false) while true do end",
        "table.sort({2, 1}, function() while true do end end)",
    ],
    ids=["switched off", "where Lua cannot yield"],
)
def test_endless_thread_that_cannot_give_way_is_stopped_by_its_limit(body: str) -> None:
    world = scripted({"lua:base": f"function sysCall_thread() {body} end", "lua:plain": "x = 1"})
    world.parts.scripts.time_limit = 0.1
    world.run(2)
    assert "took too long" in said(world)[-1]


def test_coroutines_of_a_script_may_wait_too() -> None:
    world = scripted(
        {
            "lua:base": CLOCK
            + """
            function sysCall_init()
                work = coroutine.create(function()
                    for i = 1, 2 do note('work ' .. i) sim.switchThread() end
                    sim.wait(0.1)
                    note('done')
                end)
                print(pcall(sim.wait, 1))
            end
            function sysCall_actuation()
                if coroutine.status(work) ~= 'dead' then
                    local ok, problem = coroutine.resume(work)
                    if not ok then error(problem) end
                end
            end
            """
        }
    )
    world.run(7)
    lines = said(world)
    assert lines[0].startswith("false, base.lua:9: sim.wait: waits, so it works only in a thread")
    assert lines[1:] == ["work 1 0.00", "work 2 0.05", "done 0.20"]


def test_generators_within_a_thread_are_not_cut_by_the_automatic_switch() -> None:
    world = scripted(
        {
            "lua:base": """
            local function numbers()
                return coroutine.wrap(function()
                    for i = 1, 3000 do sim.getSimulationTime() coroutine.yield(i) end
                end)
            end
            function sysCall_thread()
                local sum = 0
                for number in numbers() do sum = sum + number end
                print(sum)
            end
            """
        }
    )
    world.run(40)
    assert said(world) == ["4501500"]


def test_thread_goes_on_once_more_at_the_stop_and_then_ends() -> None:
    world = scripted(
        {
            "lua:base": """
            function sysCall_thread()
                while sim.getSimulationState() ~= sim.simulation_advancing_abouttostop do sim.switchThread() end
                for i = 1, 3000 do sim.getSimulationTime() end
                print('cleaned up')
                while true do sim.switchThread() end
            end
            function sysCall_cleanup() print('cleanup') end
            """
        }
    )
    for _ in range(2):
        world.run(2)
        world.sim.stop()
        assert said(world) == ["cleaned up", "cleanup"]


def test_a_thread_that_never_looks_whether_the_simulation_ends_is_left_at_the_stop(
    caplog: pytest.LogCaptureFixture,
) -> None:
    world = scripted(
        {
            "lua:base": f"""
            function sysCall_thread()
                while true do {"sim.getSimulationTime() " * 50} end
            end
            function sysCall_cleanup() print('cleanup') end
            """
        }
    )
    world.run(2)
    world.sim.stop()
    assert said(world) == ["cleanup"]
    assert "took too long" not in caplog.text


def test_error_in_a_thread_ends_its_script() -> None:
    world = scripted(
        {"lua:base": "function sysCall_thread()\n  sim.switchThread()\n  local x = nil + 1\nend"}
    )
    world.run(1)
    assert said(world) == []
    world.parts.step()
    assert "is stopped: base.lua:3: attempt to perform arithmetic on a nil value" in said(world)[-1]


def test_functions_of_a_waiting_script_can_be_called() -> None:
    world = scripted(
        {
            "lua:base": """
            local given
            function sysCall_thread()
                while not given do sim.switchThread() end
                print('given', given)
            end
            function give(ints) given = ints[1] return {}, {}, {}, '' end
            function hold() sim.wait(1) end
            """
        }
    )
    world.run(2)
    with pytest.raises(Exception, match="works only in a thread"):
        call(world, "hold")
    call(world, "give", [5], [], [], b"")
    world.parts.step()
    assert said(world) == ["given, 5"]


def test_threads_of_customization_scripts_go_on_while_stopped() -> None:
    world = scripted(
        {
            "lua:customization:base": """
            function sysCall_thread()
                for i = 1, 3 do print('step ' .. i) sim.switchThread() end
            end
            """
        }
    )
    world.parts.idle()
    world.run(1)
    world.sim.stop()
    world.parts.idle()
    assert said(world) == ["step 1", "step 2", "step 3"]


def test_settings_of_threads_that_mean_nothing_here_are_accepted() -> None:
    world = scripted(
        {
            "lua:base": """
            function sysCall_thread()
                print(sim.setThreadIsFree(true), sim.setThreadResumeLocation(1, 2), sim.getThreadId() > 0)
                local before = sim.setStepping(true)
                print(before, sim.setStepping(before))
            end
            """
        }
    )
    world.run(2)
    assert said(world) == ["0, 0, true", "0, 1"]


def test_later_names_of_threads_functions() -> None:
    world = scripted(
        {
            "lua:base": """
            function sysCall_thread()
                sim.setAutoYieldDelay(0.004)
                print(sim.getAutoYieldDelay(), sim.getThreadSwitchTiming(), sim.isScriptRunningInThread())
                sim.acquireLock()
                print(sim.getThreadSwitchAllowed(), sim.lockResources(0, 0), sim.unlockResources(1))
                sim.releaseLock()
                print(sim.getYieldAllowed(), sim.setThreadSwitchAllowed(false), sim.setYieldAllowed(true))
                sim.waitForSimulationStart()
                sim.yield()
                print(sim.getSimulationTime(), sim.getThreadExitRequest())
            end
            """
        }
    )
    world.run(3)
    assert said(world) == ["0.004, 4.0, 1", "false, 1, 1", "true, 0, 1", "0.05, false"]
