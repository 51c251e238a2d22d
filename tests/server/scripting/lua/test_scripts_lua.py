"""The sandboxed interpreter alone: values, limits, and what a script cannot reach."""

from __future__ import annotations

import logging
import re
import weakref
from collections.abc import Mapping
from typing import Any

import pytest
from echo_api import EchoApi

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Constant, ScriptError, Waiting
from simx_server.scripting.lua import interpreter as lua
from simx_server.scripting.lua import prepared
from simx_server.scripting.lua.crossing.values import _MANY
from simx_server.scripting.lua.interpreter import LuaInterpreter

pytestmark = pytest.mark.slow

pytest.importorskip("lupa")


class LuaEchoApi(EchoApi):
    """Echoes with the number of arguments."""

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        names = ("echo", "refuse", "break_down", "pause", "objectHandle", "callBack")
        return {"sim": {"handle_self": -4, **dict.fromkeys(names)}}

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        if name in ("sim.echo", "sim.objectHandle"):
            return (*arguments, len(arguments))
        return super().invoke(name, arguments)

    def module(self, name: str) -> bytes | None:
        return {"tools": b"local t = {} function t.double(x) return 2 * x end return t"}.get(name)


def script(source: str, *, time_limit: float = 0.1) -> LuaInterpreter:
    interpreter = LuaInterpreter("test.lua", LuaEchoApi(), time_limit=time_limit)
    interpreter.run(source.encode())
    return interpreter


def test_values_cross_exactly() -> None:
    interpreter = script("function f(...) return ... end")
    values = [1, -2.5, True, b"a\0b\xff", [], [1, 2.0, b"x", [False]]]
    assert interpreter.call("f", *values) == values
    assert interpreter.call("f", "text") == [b"text"]
    assert interpreter.call("f", None, None) == [None, None]
    assert interpreter.call("f") == []
    assert [type(value) for value in interpreter.call("f", 2, 2.0)] == [int, float]


def test_tables_are_one_based_lists_or_else_dicts_that_lose_nothing() -> None:
    interpreter = script("function f(t) return t[1], #t, {10, 20, key = 1}, {[0] = 5}, {1, nil, 3} end")
    assert interpreter.call("f", [7, 8, 9]) == [7, 3, {1: 10, 2: 20, "key": 1}, {0: 5}, {1: 1, 3: 3}]
    interpreter = script("function f(t) return #t, t[2], t.key, t[-1] end")
    assert interpreter.call("f", {1: 10, 2: 20, "key": 1, -1: 5}) == [2, 20, 1, 5]


@pytest.mark.parametrize(
    "count",
    [
        "for _ in pairs(sim) do n = n + 1 end",
        "for _ in next, sim do n = n + 1 end",
        "for name in ('echo refuse break_down pause objectHandle callBack handle_self'):gmatch('%S+') do "
        "n = n + (rawget(sim, name) and 1 or 0) end",
        "for _ in getAsString(sim):gmatch('=') do n = n + 1 end",
        "sim.new = 1 for _ in pairs(require('sim')) do n = n + 1 end n = n - 1",
    ],
    ids=["pairs", "next", "rawget", "print", "changed"],
)
def test_lists_of_a_namespace_have_members_that_no_script_has_used(count: str) -> None:
    interpreter = script(f"function f() local n = 0 {count} return n end")
    assert interpreter.call("f") == [len(LuaEchoApi().namespaces()["sim"])]


def test_a_member_of_a_namespace_is_the_same_at_each_use_and_can_be_replaced() -> None:
    interpreter = script(
        "local before = sim.echo function f() return before == sim.echo, before == simEcho, sim.handle_self, "
        "sim_handle_self end "
        "function g() sim.echo = function() return 'mine' end return sim.echo(1) end"
    )
    assert interpreter.call("f") == [True, True, -4, -4]
    assert interpreter.call("g") == [b"mine"]


def test_a_member_of_a_namespace_that_no_script_has_used_is_called_by_its_path() -> None:
    interpreter = script("")
    assert interpreter.has("sim.echo")
    assert not interpreter.has("sim.missing")
    assert interpreter.call("sim.echo", 7) == [7, 1]


def test_a_text_is_executed_whatever_the_script_has_made_of_load() -> None:
    interpreter = script("local hidden = 1 level = 2 function load() return 5 end")
    assert interpreter.evaluate(b"level = level + 1 return level, hidden, {1, 'x'}") == [3, None, [1, b"x"]]
    assert interpreter.evaluate(b"level = 0") == []
    for text, problem in ((b"return 1 +", "unexpected symbol"), (b"error('no luck')", "no luck")):
        with pytest.raises(ScriptError, match=problem):
            interpreter.evaluate(text)
    with pytest.raises(ScriptError, match="took too long"):
        interpreter.evaluate(b"while true do end")
    with pytest.raises(ScriptError, match="cannot leave the script"):
        interpreter.evaluate(b"return coroutine.create(print)")


@pytest.mark.parametrize(
    ("key", "what"), [("0.5", "number with a fraction"), ("true", "boolean"), ("{}", "table")]
)
def test_tables_with_keys_that_cannot_cross_are_an_error(key: str, what: str) -> None:
    interpreter = script(
        f"function f() return {{[{key}] = 1}} end function g() sim.echo({{[{key}] = 1}}) end"
    )
    for function in ("f", "g"):
        with pytest.raises(ScriptError, match=f"a table with a {what} as a key cannot leave"):
            interpreter.call(function)


def test_long_tables_cross_in_pieces_exactly() -> None:
    interpreter = script("function f(t) return t end function named(t) t.key = 1 return t end", time_limit=5)
    count = 2 * _MANY
    numbers, ends = list(range(count)), [1 << 62, -(1 << 63)]
    for values in (
        numbers + ends,
        [number / 2 for number in numbers],
        [*numbers, 0.5, b"x", [1, [2.0]]],
        [*numbers[:-1], "text"],
        [*numbers, 1 << 63],
    ):
        (given,) = interpreter.call("f", values)
        expected = [b"text" if value == "text" else value for value in values]
        assert given == expected
        assert set(map(type, given[:count])) <= {int, float, bytes}
    assert type(given[-1]) is float, "an integer of more than 64 bits"
    (named,) = interpreter.call("named", numbers)
    assert (len(named), named["key"], named[count]) == (count + 1, 1, count - 1)


class Recorder(LuaEchoApi):
    """Keeps the arguments of each call."""

    def __init__(self) -> None:
        super().__init__()
        self.calls: list[list[Any]] = []

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        self.calls.append(arguments)
        return ()


@pytest.mark.parametrize(
    ("arguments", "given"),
    [
        ("{1, 2, 3}", [[1, 2, 3]]),
        ("{1.5, -0.0, 1/0}", [[1.5, -0.0, float("inf")]]),
        ("{1, 2.0, 3}, 7", [[1, 2.0, 3], 7]),
        ("nil, {}, 'x', {math.mininteger, math.maxinteger}", [None, [], b"x", [-(1 << 63), (1 << 63) - 1]]),
        ("{1, 2, name = 3}, {1, nil, 3}", [{1: 1, 2: 2, "name": 3}, {1: 1, 3: 3}]),
        ("{'10', 2}, {true, 1}, {{1.0, 2}, {}}", [[b"10", 2], [True, 1], [[1.0, 2], []]]),
        ("backwards", [[3, 2, 1]]),
        ("long(500, 1), long(500, 0.5)", [list(range(1, 501)), [i / 2 for i in range(1, 501)]]),
        ("long(500, 1, 0.5)", [[0.5 if i == 250 else i for i in range(1, 501)]]),
        ("long(7000, 1)", [list(range(1, 7001))]),
        ("long(300001, 1)", [list(range(1, 300002))]),
        ("lying", [[1, 2]]),
        ("{width = 2, data = long(60, 1)}", [{"width": 2, "data": list(range(1, 61))}]),
        ("{long(60, 1, 0.5), {7}}, 'x'", [[[0.5 if i == 30 else i for i in range(1, 61)], [7]], b"x"]),
    ],
)
def test_lists_of_numbers_reach_functions_with_their_types(arguments: str, given: list[Any]) -> None:
    api = Recorder()
    interpreter = LuaInterpreter("test.lua", api, time_limit=1.0)
    interpreter.run(b"""
        backwards = {} for i = 3, 1, -1 do backwards[i] = 4 - i end
        lying = setmetatable({1, 2}, {__index = function() return 9 end, __len = function() return 5 end})
        function long(count, factor, middle)
            local list = {} for i = 1, count do list[i] = i * factor end
            if middle then list[count // 2] = middle end
            return list
        end""")
    interpreter.evaluate(f"sim.echo({arguments})".encode())
    # 1 is not 1.0, -0.0 is not 0.0.
    assert repr(in_order(api.calls)) == repr(in_order([given]))


def in_order(value: Any) -> Any:
    """Return a value with sorted names, which have no order in Lua."""
    if isinstance(value, dict):
        return {key: in_order(value[key]) for key in sorted(value, key=repr)}
    return [in_order(each) for each in value] if isinstance(value, list) else value


def test_long_lists_within_results_leave_and_the_script_keeps_its_own() -> None:
    interpreter = script("""
        local image = {width = 60, data = {}}
        for i = 1, 60 do image.data[i] = i / 2 end
        function give() return image, image.data, 5 end
        function kept() return type(image.data), #image.data, image.data[60] end
    """)
    data = [i / 2 for i in range(1, 61)]
    assert interpreter.call("give") == [{"width": 60, "data": data}, data, 5]
    assert interpreter.call("kept") == [b"table", 60, 30.0]


def test_tables_with_names_are_dicts_both_ways() -> None:
    interpreter = script(
        "function f(t) return t.a, t.b.c, t end function g() return {x = {1, y = 2}, z = {}} end"
    )
    given = {"a": 1, "b": {"c": [1, b"two"]}}
    assert interpreter.call("f", given) == [1, [1, b"two"], given]
    assert interpreter.call("g") == [{"x": {1: 1, "y": 2}, "z": []}]
    assert interpreter.call("f", {"a": None, "b": {}}) == [None, None, {"b": []}]


def test_functions_cross_as_something_that_can_be_called_and_handed_back() -> None:
    interpreter = script("""
        local function double(x) return 2 * x, 'twice' end
        function give() return double, {cb = double} end
        function is(f) return f == double end
        function fail() return function() error('from within') end end
        function through() return sim.echo(double) end
    """)
    function, named = interpreter.call("give")
    assert function(21) == named["cb"](21) == [42, b"twice"]
    assert interpreter.call("is", function) == [True]
    with pytest.raises(ScriptError, match="from within"):
        interpreter.call("fail")[0]()
    assert interpreter.call("through")[0](1) == [2, b"twice"]
    with pytest.raises(CommandError, match="another"):
        script("").call("print", function)
    interpreter.close()
    with pytest.raises(ScriptError, match="has ended"):
        function(1)


def test_sim_functions_take_and_give_several_values() -> None:
    interpreter = script("function f() return sim.echo(1, {2, 3}, nil, 'x') end")
    assert interpreter.call("f") == [1, [2, 3], None, b"x", 4]


def test_functions_in_tables_are_found_by_dots() -> None:
    interpreter = script("a = {b = {}} function a.b.c(x) return x + 1 end")
    assert interpreter.call("a.b.c", 1) == [2]
    for wrong in ("a.b", "a.b.d", "a.b.c.d", "x.y", ""):
        assert not interpreter.has(wrong)
    with pytest.raises(ScriptError, match="has no function 'x'"):
        interpreter.call("x")


def test_errors_name_file_line_and_reason() -> None:
    interpreter = script(
        "function refused()\n  local x = sim.refuse()\nend\nfunction missing() sim.setSomething(1) end\n"
        "function own() error('my reason') end function odd() error({}) end"
    )
    for function, text in (
        ("refused", r"^test\.lua:2: sim\.refuse: no object with handle 7$"),
        ("missing", r"^test\.lua:4: sim\.setSomething: is not provided$"),
        ("own", r"^test\.lua:5: my reason$"),
        ("odd", r"^test\.lua: raised a table value: {}$"),
    ):
        with pytest.raises(ScriptError, match=text):
            interpreter.call(function)
    with pytest.raises(ScriptError, match=r"^test\.lua:1: .*near"):
        script("function (")


def test_fault_of_the_server_is_logged_and_told_without_details(caplog: pytest.LogCaptureFixture) -> None:
    interpreter = script("function f() return pcall(sim.break_down) end")
    ok, text = interpreter.call("f")
    assert ok is False
    assert b"its log says why" in text
    assert "a slip of the server" in caplog.text


ENDLESS = {
    "loop": "while true do end",
    "swallowed": "while true do pcall(function() while true do end end) end",
    "in a coroutine that cannot yield": "coroutine.wrap(function() table.sort({2, 1}, function() while true do end "
    "end) end)()",
    "coroutines for ever": "while true do pcall(coroutine.wrap(function() while true do end end)) end",
    "resumed": "while true do coroutine.resume(coroutine.create(function() while true do end end)) end",
    "in a message handler": "xpcall(error, function() while true do end end)",
    "handler of the stop": "while true do xpcall(error, function() while true do end end) end",
    "calls of sim": "while true do sim.echo(1) end",
    "compiled at run time": "load('while true do end')()",
    "recursion by tail calls": "local function f() return f() end f()",
}


@pytest.mark.parametrize("body", ENDLESS.values(), ids=ENDLESS)
def test_endless_script_is_stopped_and_the_next_call_works(body: str) -> None:
    interpreter = script(
        f"function endless() {body} end\nfunction add(a, b) return a + b end", time_limit=0.03
    )
    with pytest.raises(ScriptError, match="took too long"):
        interpreter.call("endless")
    assert interpreter.call("add", 1, 2) == [3]


def test_metamethods_of_results_do_not_run_outside_the_limit() -> None:
    interpreter = script("""
        local function hang() while true do end end
        function f() return setmetatable({}, {__index = hang, __len = hang, __pairs = hang}) end
        function g() error(setmetatable({}, {__tostring = hang})) end
    """)
    assert interpreter.call("f") == [[]]
    with pytest.raises(ScriptError, match="table value"):
        interpreter.call("g")


def test_endless_script_text_is_stopped() -> None:
    with pytest.raises(ScriptError, match=r"test\.lua:1: took too long"):
        script("while true do end")


def test_memory_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lua, "MEMORY_LIMIT", 4 << 20)
    interpreter = script(
        "function eat() local s = 'x' while true do s = s .. s end end function ok() return 1 end"
    )
    with pytest.raises(ScriptError, match="memory"):
        interpreter.call("eat")
    assert interpreter.call("ok") == [1]


def test_endless_recursion_is_an_error() -> None:
    interpreter = script("function f() return 1 + f() end")
    with pytest.raises(ScriptError, match=r"stack overflow|memory|took too long"):
        interpreter.call("f")


@pytest.mark.parametrize(
    "name",
    [
        "os.exit",
        "debug.sethook",
        "python",
        "string.dump",
        "warn",
    ],
)
def test_script_cannot_reach(name: str) -> None:
    assert script(f"function f() return {name} == nil, load('return {name}')() == nil end").call("f") == [
        True,
        True,
    ]


def test_script_cannot_reach_python_objects() -> None:
    interpreter = script("""
        function kinds() return type(sim.echo), type(sim), type(print), getmetatable(sim) end
        function index() return sim.echo.__self__ end
        function call(name) return sim[name] end
        function errors() local _, e = pcall(sim.refuse) return type(e) end
        function methods() return (''):dump() end
    """)
    assert interpreter.call("kinds") == [b"function", b"table", b"function", False]
    with pytest.raises(ScriptError, match="index a function value"):
        interpreter.call("index")
    for name in ("__class__", "_api", "__init__", "names"):
        with pytest.raises(ScriptError, match="is not provided"):
            interpreter.call("call", name)
    assert interpreter.call("errors") == [b"string"]
    with pytest.raises(ScriptError):
        interpreter.call("methods")


def test_files_are_refused_with_a_reason() -> None:
    with pytest.raises(ScriptError, match=r"test\.lua:1: io\.lines: scripts read no files"):
        script("io.lines('/etc/passwd')")
    reading = script("function f() return io.open('/etc/passwd') end").call("f")
    assert reading == [
        None,
        b"/etc/passwd: scripts read no files; modes w and a write files of the workspace",
        2,
    ]


def test_programs_and_the_environment_are_not_there() -> None:
    interpreter = script(
        "function f() return os.execute('exit 0'), os.getenv('PATH'), os.remove('/tmp/x') end"
    )
    assert interpreter.call("f")[:2] == [None, None]
    assert interpreter.call("f")[3:] == [b"/tmp/x: scripts change no files of the system", 1]


def test_modules_beside_the_scene_and_namespaces_can_be_required() -> None:
    interpreter = script("""
        local sim, tools = require'sim', require('tools')
        function f() return tools.double(4), sim.echo(1), require('tools') == tools, sim == _G.sim end
        function g() require 'missing' end
    """)
    assert interpreter.call("f") == [8, 1, True, True]
    with pytest.raises(ScriptError, match=r"require 'missing': there is no such module"):
        interpreter.call("g")


def test_old_names_reach_the_same_functions_and_constants() -> None:
    interpreter = script("""
        function f() return simEcho(5), sim_handle_self, simObjectHandle(), simNoSuch == nil end
        function g() simNoSuch(1) end
    """)
    assert interpreter.call("f") == [5, -4, 0, True]
    with pytest.raises(ScriptError, match=r"^test\.lua:3: simNoSuch: is not provided$"):
        interpreter.call("g")


def test_binary_chunks_and_finalizers_are_refused() -> None:
    interpreter = script("""
        function binary() return load('\\27Lua') end
        function final() setmetatable({}, {__gc = function() while true do end end}) end
        function late() local m = {} setmetatable({}, m) m.__gc = function() while true do end end collectgarbage() end
    """)
    chunk, problem = interpreter.call("binary")
    assert chunk is None
    assert b"binary" in problem
    with pytest.raises(ScriptError, match="finalizers"):
        interpreter.call("final")
    assert interpreter.call("late") == []


def test_a_random_seed_may_have_a_fraction() -> None:
    interpreter = script("""
        function f(seed) math.randomseed(seed) return math.random(1000) end
        function g() math.randomseed('a') end
    """)
    assert interpreter.call("f", 7.9) == interpreter.call("f", 7)
    assert interpreter.call("f", 1e300) == interpreter.call("f", 0)
    with pytest.raises(ScriptError, match="bad argument #1 to 'randomseed'"):
        interpreter.call("g")


def test_what_lua_51_scripts_expect_is_there() -> None:
    interpreter = script("""
        function string.twice(s) return s .. s end
        function f() return unpack({1, 2}), math.pow(2, 3), math.mod(-5, 3), table.getn({1, 2, 3}),
            loadstring('return 4')(), ('a'):twice() end
    """)
    assert interpreter.call("f") == [1, 8.0, -2, 3, 4, b"aa"]


LISTS = {
    "local t = {1, 2, 3} table.insert(t, 1, 0) table.insert(t, 9) table.insert(t, 6, 7) return t": [
        *(0, 1, 2, 3, 9, 7)
    ],
    "local t = {1, 2, 3} return {table.remove(t), table.remove(t, 1), t[1], #t}": [3, 1, 2, 1],
    "local t = {} return {#{table.remove(t)}, #{table.remove(t, 0)}, #{table.remove(t, 1)}}": [0, 0, 0],
    "local t = many() table.insert(t, 1, 0) return {#t, t[1], t[10001], t[35001]}": [35001, 0, 10000, 35000],
    "local t = many() return {table.remove(t, 1), #t, t[1], t[10001], t[34999]}": [1, 34999, 2, 10002, 35000],
    "local t = table.move(many(), 1, 35000, 5) return {#t, t[4], t[5], t[10005]}": [35004, 4, 1, 10001],
    "local t = table.move(many(), 1, 35000, 2, {0}) return {#t, t[1], t[35001]}": [35001, 0, 35000],
    "return {string.rep('ab', 3, ','), string.rep('', 5), string.rep('', 3, '-'), string.rep(5, '2')}": [
        *(b"ab,ab,ab", b"", b"--", b"55")
    ],
    "return {tonumber('0x10'), tonumber('z', 36), tonumber('7'), utf8.len('a'), ('aB'):upper()}": [
        *(16, 35, 7, 1, b"AB")
    ],
}


@pytest.mark.parametrize("body", LISTS)
def test_the_library_does_what_it_does_in_lua(body: str) -> None:
    many = "function many() local t = {} for i = 1, 35000 do t[i] = i end return t end"
    assert script(f"{many} function f() {body} end").call("f") == [LISTS[body]]


def test_an_error_of_the_library_names_the_line_of_the_script() -> None:
    interpreter = script("function f(name, ...)\n local found = table[name](...)\n return found\nend")
    for call, problem in (
        (("concat", [1, []]), "invalid value (table) at index 2 in table for 'concat'"),
        (("insert", [1], 5, 1), "bad argument #2 to 'insert' (position out of bounds)"),
        (("remove", [1], 5), "bad argument #2 to 'remove' (position out of bounds)"),
        (("sort", [1, b"a"]), "attempt to compare"),
    ):
        with pytest.raises(ScriptError, match=re.escape(f"test.lua:2: {problem}")):
            interpreter.call("f", *call)


def test_random_numbers_repeat_in_the_next_interpreter() -> None:
    source = "function f() return math.random(), math.random(1000) end"
    assert script(source).call("f") == script(source).call("f")


def test_print_goes_to_the_output_of_the_simulation() -> None:
    api = LuaEchoApi()
    LuaInterpreter("test.lua", api).run(b"print(1, 'a', nil, true)")
    assert api.printed == ["1, a, nil, true"]


def test_coroutines_and_endless_tables_cannot_leave() -> None:
    interpreter = script(
        "function f() return coroutine.create(f) end function g() local t = {} t[1] = t return t end"
    )
    with pytest.raises(ScriptError, match="a thread cannot leave"):
        interpreter.call("f")
    with pytest.raises(ScriptError, match="nested too deeply"):
        interpreter.call("g")


def test_closed_interpreter_is_freed() -> None:
    interpreter = script("function f() return 1 end")
    freed = weakref.ref(interpreter)
    interpreter.close()
    del interpreter
    assert freed() is None


def test_missing_lupa_is_said_with_the_line_that_installs_it(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def missing(_name: str) -> None:
        raise ImportError

    monkeypatch.setattr(prepared.importlib, "import_module", missing)
    with caplog.at_level(logging.ERROR), pytest.raises(ScriptError, match="install 'lupa>="):
        script("")


PATTERNS = [
    ("(%w+)%s*=%s*(.-)%s*$", "key  =  some value  ", "%2:%1"),
    ("(a*(.)%w(%s*))", "ab cd ef", "<%0>"),
    ("%b()", "f(a(b)c) (d)", "[%0]"),
    ("%f[%w]%w+", "THE (quick) fox", "x"),
    ("()a?()", "baab", "%1-%2"),
    ("(.)%1", "aabbc", "%1"),
    ("^%s*(%d+)", "  12 13", "n"),
    ("[^%s,]*", "a, bc,,d", "<%0>"),
    (".-b.-c.-$", "abcabc", "%%"),
]


@pytest.mark.parametrize(("pattern", "subject", "replacement"), PATTERNS)
def test_patterns_give_the_same_by_either_matcher(pattern: str, subject: str, replacement: str) -> None:
    """A subject that is longer by a tail it never reaches is matched by the interruptible matcher."""
    interpreter = script(
        """
        local function all(s, pattern, replacement)
            local found = {string.find(s, pattern)}
            for piece in string.gmatch(s, pattern) do found[#found + 1] = piece end
            found[#found + 1] = string.match(s, pattern, 2) or 'none'
            found[#found + 1] = string.gsub(s, pattern, replacement)
            found[#found + 1] = string.gsub(s, pattern, function(...) return #{...} end)
            return found
        end
        function both(s, pattern, replacement)
            -- repetitions of what is not there change nothing but the estimate
            local costly = pattern:gsub('%$?$', string.rep('\\1*', 12) .. '%0', 1)
            return all(s, pattern, replacement), all(s, costly, replacement)
        end
        """,
        time_limit=5,
    )
    quick, slow = interpreter.call("both", subject, pattern, replacement)
    assert quick == slow


def test_a_call_within_a_call_keeps_the_limit_of_the_outer_one() -> None:
    interpreter = script("""
        function inner() return 1 end
        function outer() sim.callBack(inner) while true do end end
    """)
    interpreter._api.invoke = lambda name, arguments: tuple(arguments[0]())  # type: ignore[method-assign]
    with pytest.raises(ScriptError, match="took too long"):
        interpreter.call("outer")
