"""Loops without calls of ``sim``: a script's thread yields after a number of turns, the same in each run."""

from __future__ import annotations

import sys

import pytest
from scripted_world import call, said, scripted

pytestmark = pytest.mark.slow

pytest.importorskip("lupa")

TEMPLATE = """
function sysCall_init()
    corout=coroutine.create(coroutineMain)
end

function sysCall_actuation()
    if coroutine.status(corout)~='dead' then
        local ok,errorMsg=coroutine.resume(corout)
        if errorMsg then
            error(debug.traceback(corout,errorMsg),2)
        end
    end
end

function give(ints) go = ints[1] return {turns or 0}, {}, {}, '' end
"""
"""The threaded script that CoppeliaSim 4 gives a new object, and a function for a client."""

WAITS = {
    "while": "while not go do end",
    "counted": "while not go do turns = (turns or 0) + 1 end",
    "repeat": "repeat local here = go until here",
    "goto": "::again:: if not go then goto again end",
    "for": "for i = 1, math.huge do if go then break end end",
    "iterator": "for _ in function() return true end do if go then break end end",
    "tail calls": "local function wait() if not go then return wait() end end wait()",
    "tail calls of fields": "local t = {} function t.wait() if not go then return t.wait() end end t.wait()",
    "pcall": "pcall(function() while not go do end end)",
    "metamethod": "local t = setmetatable({}, {__index = function() while not go do end end}) local _ = t.x",
    "close": "do local x <close> = setmetatable({}, {__close = function() while not go do end end}) end",
    "loaded": "load('while not go do end')()",
    "loaded in pieces": "local n = 0 load(function() n = n + 1 return ({'while not', ' go do end'})[n] end)()",
    "within a generator": "for _ in coroutine.wrap(function() while not go do end coroutine.yield() end) do end",
}


@pytest.mark.parametrize("wait", WAITS.values(), ids=WAITS)
def test_a_loop_that_waits_for_a_remote_call_gives_way(wait: str) -> None:
    world = scripted(
        {
            "lua:base": f"function coroutineMain()\n {wait}\n print('gone', sim.getSimulationTime())\nend"
            + TEMPLATE
        }
    )
    world.run(2)
    assert said(world) == []
    call(world, "give", [1], [], [], b"")
    world.parts.step()
    assert said(world) == ["gone, 0.1"]


@pytest.mark.parametrize(
    ("language", "source"),
    [
        ("lua", "function sysCall_thread() while not go do end print('gone', sim.getSimulationTime()) end"),
        (
            "lua",
            "function sysCall_threadmain() while not go do end print('gone', sim.getSimulationTime()) end",
        ),
        ("lua:threaded", "while not go do end print('gone', simGetSimulationTime())"),
        pytest.param(
            "python",
            "go = False\ndef sysCall_thread():\n    while not go: pass\n    print('gone,', sim.getSimulationTime())\n"
            "def give(ints, *_):\n    global go\n    go = True\n    return [], [], [], ''\n",
            marks=pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only"),
        ),
    ],
    ids=["thread", "threadmain", "body", "python"],
)
def test_threads_of_the_server_give_way_too(language: str, source: str) -> None:
    give = "" if language == "python" else "\nfunction give() go = true return {}, {}, {}, '' end"
    if language == "lua:threaded":
        source, give = f"function give() go = true return {{}}, {{}}, {{}}, '' end {source}", ""
    world = scripted({f"{language}:base": source + give})
    world.run(2)
    call(world, "give", [], [], [], b"")
    world.parts.step()
    assert said(world) == ["gone, 0.1"]
    world.sim.stop()  # which ends the process of a script in Python


def test_the_number_of_turns_is_the_same_in_each_run_and_follows_the_timing() -> None:
    source = """
    function coroutineMain()
        while true do turns = (turns or 0) + 1 end
    end
    """
    counts: list[list[int]] = []
    for _ in range(2):
        world = scripted({"lua:base": source + TEMPLATE})
        counts.append([])
        world.run(0)
        for _ in range(4):
            world.parts.step()
            counts[-1].append(call(world, "give", [0], [], [], b"")[0][0])
    assert counts[0] == counts[1]
    first, second, third, fourth = counts[0]
    assert second - first == third - second == fourth - third == pytest.approx(first, abs=1)

    world = scripted({"lua:base": source.replace("while", "sim.setThreadSwitchTiming(4) while") + TEMPLATE})
    world.run(1)
    assert call(world, "give", [0], [], [], b"")[0][0] == pytest.approx(2 * first, rel=0.1)


def test_generators_in_a_thread_are_not_cut_within_a_loop() -> None:
    world = scripted(
        {
            "lua:base": """
            local function numbers()
                return coroutine.wrap(function()
                    for i = 1, 5 do
                        for j = 1, 30000 do end
                        coroutine.yield(i)
                    end
                end)
            end
            function sysCall_thread()
                local sum = 0
                for number in numbers() do sum = sum + number end
                print(sum, sim.getSimulationTime() > 0.5)
            end
            """
        }
    )
    world.run(20)
    assert said(world) == ["15, true"]


def test_where_lua_cannot_yield_a_loop_goes_on() -> None:
    world = scripted(
        {
            "lua:base": """
            local function long() for i = 1, 30000 do end end
            function sysCall_thread()
                local list = {3, 1, 2}
                table.sort(list, function(a, b) long() return a < b end)
                local text = string.gsub('abc', '%w', function(c) long() return c:upper() end)
                local shown = tostring(setmetatable({}, {__tostring = function() long() return 'shown' end}))
                print(list, text, shown, sim.getSimulationTime())
                table.sort(list, function(a, b)
                    for _ in coroutine.wrap(function() long() coroutine.yield(1) end) do end
                    return a > b
                end)
                print(list)
            end
            """
        }
    )
    world.run(3)
    assert said(world) == ["{1, 2, 3}, ABC, shown, 0.0", "{3, 2, 1}"]


def test_values_given_to_a_coroutine_are_those_of_its_own_yields() -> None:
    world = scripted(
        {
            "lua:base": """
            function sysCall_init()
                work = coroutine.create(function(first)
                    print('first', first)
                    for i = 1, 15000 do end
                    print('second', coroutine.yield('given'))
                    return 'over'
                end)
            end
            function sysCall_actuation()
                if coroutine.status(work) == 'suspended' then print(coroutine.resume(work, sim.getSimulationTime())) end
            end
            """
        }
    )
    world.run(4)
    assert said(world) == [
        "first, 0.0",
        "true",
        "true, given",
        "second, 0.1",
        "true, over",
    ]


def test_a_thread_that_waits_in_vain_does_not_hold_up_the_stop() -> None:
    world = scripted(
        {
            "lua:base": """
            function sysCall_thread() while not go do end end
            function sysCall_cleanup() print('cleanup') end
            """
        }
    )
    for _ in range(2):
        world.run(1)
        world.sim.stop()
        assert said(world) == ["cleanup"]


def test_an_error_in_the_stock_template_is_told_with_script_line_and_message() -> None:
    world = scripted(
        {
            "lua:base": "function coroutineMain()\n  sim.switchThread()\n  local x = nothing.here\nend"
            + TEMPLATE
        }
    )
    world.run(2)
    assert said(world) == [
        "child script of 'base' (base.lua) is stopped: "
        "base.lua:3: attempt to index a nil value (global 'nothing')\n"
        "stack traceback:\n\tbase.lua:3: in function 'coroutineMain'"
    ]


def test_generators_outside_a_thread_are_not_cut_within_a_loop() -> None:
    world = scripted(
        {
            "lua:base": """
            local function long() for i = 1, 20000 do end end
            local function count() for i = 1, 3 do coroutine.yield(i) long() end return 'over' end
            function sysCall_actuation()
                print(coroutine.wrap(function() long() return 'whole' end)())
                local list = {}
                for i in coroutine.wrap(function() for i = 1, 3 do long() coroutine.yield(i) end end) do
                    list[i] = i
                end
                local producer = coroutine.create(count)
                for i = 1, 4 do list[#list + 1] = select(2, coroutine.resume(producer)) end
                print(list)
            end
            """
        }
    )
    world.run(1)
    assert said(world)[:2] == ["whole", '{1, 2, 3, 1, 2, 3, "over"}']


def test_an_endless_generator_outside_a_thread_is_stopped() -> None:
    world = scripted({"lua:base": "coroutine.wrap(function() while true do end end)()"})
    world.parts.scripts.time_limit = 0.05
    world.run(1)
    assert "took too long" in said(world)[0]


def test_the_names_of_the_counters_are_globals_like_others() -> None:
    world = scripted({"lua:base": "for i = 1, 2 do print(simx_left, simx_turn) simx_left = i end"})
    world.run(1)
    assert said(world)[:2] == ["nil, nil", "1, nil"]
