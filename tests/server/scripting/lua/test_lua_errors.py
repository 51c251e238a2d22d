"""Errors, their handlers, coroutines and ``debug`` of a script against Lua without a sandbox."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from test_scripts_lua import script

lupa = pytest.importorskip("lupa.lua54")

_TEXT = (Path(__file__).parents[1] / "scripts" / "same_as_lua.lua").read_text()

SAME = dict(re.findall(r"^-- (.+):\n(.*?)\n(?=\n|\Z)", _TEXT, re.DOTALL | re.MULTILINE))

PLAIN = """
function show(...)
    local values = table.pack(...)
    for i = 1, values.n do
        local kind = type(values[i])
        if kind ~= 'string' and kind ~= 'number' and kind ~= 'boolean' and kind ~= 'nil' then values[i] = kind end
    end
    return table.unpack(values, 1, values.n)
end
"""


@pytest.mark.parametrize("source", SAME.values(), ids=SAME)
def test_it_is_as_in_lua_itself(source: str) -> None:
    text = f"function f() {source}\nend{PLAIN}"
    runtime = lupa.LuaRuntime(encoding=None, unpack_returned_tuples=True)
    load = runtime.globals()[b"load"]
    load(text.encode(), b"@test.lua")()
    call = "return show(select(2, coroutine.resume(coroutine.create(f))))"
    assert script(f"{text} function g() {call} end", time_limit=2).call("g") == _cut(
        runtime.execute(call.encode())
    )


def _cut(real: Any) -> list[Any]:
    return list(real) if isinstance(real, tuple) else [real]


def test_a_handler_is_called_also_for_a_stack_that_has_run_over() -> None:
    interpreter = script(
        "local t = setmetatable({}, {__index = function(t, key) return t[key] end})\n"
        "function f() return xpcall(function() return t.x end, function(m) return m:match('stack overflow') end) end"
    )
    assert interpreter.call("f") == [False, b"stack overflow"]


def test_a_failing_handler_gives_its_own_error() -> None:
    ok, text = script("function f() return xpcall(error, function() error('in the handler') end) end").call(
        "f"
    )
    assert (ok, text) == (False, b"test.lua:1: in the handler")


@pytest.mark.parametrize(
    ("call", "text"),
    [
        ("pcall()", "bad argument #1 to 'pcall' (value expected)"),
        ("xpcall(print)", "bad argument #2 to 'xpcall' (function expected, got nil)"),
        ("coroutine.create(1)", "bad argument #1 to 'create' (function expected, got number)"),
        ("coroutine.resume({})", "bad argument #1 to 'resume' (thread expected, got table)"),
        ("coroutine.wrap()", "bad argument #1 to 'wrap' (function expected, got nil)"),
        ("coroutine.close(1)", "bad argument #1 to 'close' (thread expected, got number)"),
        ("debug.traceback('x', 'y')", "bad argument #2 to 'traceback' (number expected, got string)"),
        ("debug.getinfo(1, 'Q')", "bad argument #2 to 'getinfo' (invalid option)"),
        ("debug.getinfo(-1)", "bad argument #1 to 'getinfo' (level out of range)"),
        ("load(5)", "bad argument #1 to 'load' (function expected, got number)"),
    ],
)
def test_wrong_arguments_are_told_with_the_line(call: str, text: str) -> None:
    ok, problem = script(f"function f() return pcall(function() local x = {call} end) end").call("f")
    assert (ok, problem.decode()) == (False, f"test.lua:1: {text}")


def test_debug_shows_nothing_of_the_sandbox() -> None:
    interpreter = script("""
        function f()
            local known = {}
            for level = 0, 30 do
                local info = debug.getinfo(level)
                if not info then break end
                known[#known + 1] = info.short_src
                if info.what == 'C' and level > 0 then error('a function of the sandbox') end
            end
            for _, func in pairs({pcall, sim.echo, coroutine.resume, require}) do
                local info = debug.getinfo(func)
                if info.what ~= 'C' or info.nups ~= 0 or info.activelines then error('open') end
            end
            return known, debug.getlocal, debug.getupvalue, debug.sethook, debug.getregistry, debug.getmetatable
        end
    """)
    assert interpreter.call("f") == [[b"[C]", b"test.lua"], None, None, None, None, None]
