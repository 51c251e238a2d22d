"""Counting the turns of loops changes nothing else in a script: `scripting/lua/turns.py`."""

from __future__ import annotations

from typing import Any

import pytest

from simx_server.scripting.lua.turns import may_make_coroutines, with_turns

lupa = pytest.importorskip("lupa.lua54")

PROGRAMS = {
    "nested loops": (
        "local n = 0 for i = 1, 3 do for j in pairs({1, 2}) do while n < i * j do n = n + 1 end end end return n",
        15,
    ),
    "a do block in a condition": (
        "local n = 0 while (function() do local x = n end return n < 4 end)() do n = n + 1 end return n",
        4,
    ),
    "a loop in a condition": (
        "local n = 0 while (function() for i = 1, 2 do n = n + 1 end return n < 9 end)() do end return n",
        14,
    ),
    "a function between for and do": (
        "local n = 0 for i in (function() local k = 0 return function() k = k + 1 if k < 4 then return k end end "
        "end)() do n = n + i end return n",
        4,
    ),
    "strings": (
        'local s = \'while true do\' .. "for do \\" repeat" .. [[ goto x do ]] .. [==[ ]] while do ]==] '
        "for i = 1, 2 do s = s .. '\\'do\\\\' end return #s",
        2,
    ),
    "string over lines": (
        "local s = 'a\\\n do' .. 'b\\z   \n   while' for i = 1, 2 do s = s .. i end return s",
        2,
    ),
    "comments": (
        "-- while do 'it\n--[[ for do \n ]] local n = 0 --[==[ ]] repeat ]==] repeat n = n + 1 -- until do\n"
        "until n > 2 return n --",
        4,
    ),
    "comment after a number": ("local n = 0xe--while do\nfor i = 1, 2 do n = n+1 end return n", 2),
    "names with words in them": (
        "local forx, dodo, whiler, e1do = 1, 2, 3, {endx = 4} for i = 1, 2 do forx = forx + e1do.endx end return forx",
        2,
    ),
    "goto": ("local n = 0 ::top:: n = n + 1 if n < 5 then goto top end return n", 4),
    "continue": (
        "local n = 0 for i = 1, 9 do if i % 2 == 0 then goto continue end local k = i n = n + k ::continue:: end "
        "return n",
        13,
    ),
    "tail calls": (
        "local function f(n, s) if n == 0 then return s end return f(n - 1, s + n) end return f(10, 0)",
        11,
    ),
    "tail calls behind comments": (
        "local t = {} local function f(n) if n == 0 then return 0 elseif n == 1 then return --[[x]] f(n - 1) "
        "elseif n == 2 then return f--[[x]](n - 1) elseif n == 3 then return t.--[[x]]f(n - 1) end "
        "return f --x\n (n - 1) end t.f = f return f(4) + 0",
        5,
    ),
    "method tail call": (
        "local t = {n = 0} function t:up() self.n = self.n + 1 if self.n < 3 then return self:up() end "
        "return self.n end local n = t:up() return n",
        2,
    ),
    "what only looks like one": (
        "local x, t = 4, {5} local function f() return x end local y = f() return x + t[1] + y",
        0,
    ),
    "vararg of the chunk": (
        "local n = 0 for _, v in ipairs({...}) do n = n + v end return n, select('#', ...)",
        3,
    ),
    "return in the middle": ("for i = 1, 3 do if i == 2 then do return i end end end", 2),
    "until sees its locals": (
        "local n = 0 repeat local is_over = n >= 3 n = n + 1 until is_over return n",
        4,
    ),
    "end of the file in a comment": ("for i = 1, 2 do end return 7 -- the end", 2),
    "attribs": (
        "local n <const> = 3 local s = 0 for i = 1, n do local k <const> = i s = s + k end return s",
        3,
    ),
    "integer division and bits": ("local n = 7 // 2 ~ 1 while n > 0 do n = n - 1 end return n << 2", 2),
}


def run(source: str, counted: bytes | None) -> tuple[Any, int]:
    runtime = lupa.LuaRuntime(encoding="latin-1", unpack_returned_tuples=True)
    load = runtime.globals()["load"]
    if counted is None:
        return load(source, "=c")(1, 2, 3), 0
    maker = load(counted.decode("latin-1"), "=c")
    assert not isinstance(maker, tuple), maker
    chunk = maker()
    turns = runtime.eval("""function(chunk)
        local left = math.maxinteger
        local function shared() return left end
        for i = 1, 9 do
            if debug.getupvalue(chunk, i) == 'simx_left' then debug.upvaluejoin(chunk, i, shared, 1) end
        end
        return function() return math.maxinteger - left end
    end""")(chunk)
    return chunk(1, 2, 3), turns()


@pytest.mark.parametrize(("source", "turns"), PROGRAMS.values(), ids=PROGRAMS)
def test_a_program_does_the_same_with_its_turns_counted(source: str, turns: int) -> None:
    counted = with_turns(source.encode("latin-1"))
    assert (counted is None) == (turns == 0)
    assert run(source, counted) == (run(source, None)[0], turns)
    assert counted is None or counted.count(b"\n") == source.count("\n") + 1  # one for the end


def test_lines_of_errors_stay() -> None:
    source = "local n = 0\nfor i = 1, 2 do\n\n  n = n + i\nend\nlocal t = nil\nwhile true do\n  n = t.x\nend"
    runtime = lupa.LuaRuntime(encoding=None)
    counted = with_turns(source.encode())
    assert counted is not None
    with pytest.raises(lupa.LuaError, match=r"c:8: attempt to index a nil value \(local 't'\)"):
        runtime.execute(b"return load(..., '=c')()()", counted.replace(b"simx_left-1", b"(simx_left or 9)-1"))


@pytest.mark.parametrize("name", ["simx_left", "simx_turn"])
def test_a_script_cannot_reach_the_counters(name: str) -> None:
    assert with_turns(f"for i = 1, 2 do {name} = 5 end".encode()) is None


@pytest.mark.parametrize(
    "source",
    [
        "local co = coroutine.wrap(f)",
        "function sysCall_threadmain() end",
        "simSetThreadSwitchTiming(2)",
        "local t = _G['corou' .. 'tine']",
        "local f = load('return ' .. word)",
        "local m = require 'mine'",
        "local m = require('sim' .. word)",
        "local r = require",
    ],
)
def test_loops_are_counted_where_a_coroutine_may_run_them(source: str) -> None:
    assert may_make_coroutines(source.encode())


@pytest.mark.parametrize(
    "source",
    [
        "function sysCall_actuation() for i = 1, 9 do x = x + i end end",
        "sim = require'sim'\nsimIK = require('simIK')\nlocal simUI = require \"simUI-1\"",
        "local reload, preloaded, debugging = 1, 2, 3",
    ],
)
def test_loops_of_other_scripts_have_no_counters(source: str) -> None:
    assert not may_make_coroutines(source.encode())
