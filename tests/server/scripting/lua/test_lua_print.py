"""The output of ``print`` in a script."""

from __future__ import annotations

import pytest
from test_scripts_lua import LuaEchoApi

from simx_server.scripting.lua.interpreter import LuaInterpreter

pytest.importorskip("lupa")


def printed(source: str) -> list[str]:
    api = LuaEchoApi()
    LuaInterpreter("test.lua", api, time_limit=2).run(source.encode())
    return api.printed


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ("", ""),
        ("'text'", "text"),
        ("1, 2.5, 1.0, true, nil, 'x', nil", "1, 2.5, 1.0, true, nil, x, nil"),
        ("{1, 2, 3}", "{1, 2, 3}"),
        ("{}", "{}"),
        ("{a=1, b='x'}", '{a=1, b="x"}'),
        ("{c=3, a=1, b={true, {z='y'}}}", '{a=1, b={true, {z="y"}}, c=3}'),
        ("{1, nil, 3}", "{1=1, 3=3}"),
        ("{[10]='j', [2]='b', [true]=1, [false]=0, x=5}", '{false=0, true=1, 2="b", 10="j", x=5}'),
        ("{2, 3, nil, n=2}", "{1=2, 2=3, n=2}"),
        ("{[{1}]=2}", "{{1}=2}"),
        ("print, {function() end}, coroutine.create(print)", "[function], {[function]}, [thread]"),
        ("setmetatable({}, {__tostring=function() return 'mine' end})", "mine"),
        ("{setmetatable({}, {__tostring=function() return 'mine' end})}", "{mine}"),
        ("setmetatable({1}, {__index=function() error('asked') end, __pairs=error, __len=error})", "{1}"),
        ("{'grün', 'a\\nb', 'a\\0b', '\\255'}", '{"grün", "a\nb", [buffer string], [buffer string]}'),
        ("{string.rep('x', 161)}", "{[long string]}"),
        ("sim.handle_self", "-4"),
    ],
)
def test_values_are_shown_as_coppeliasim_shows_them(values: str, text: str) -> None:
    assert printed(f"print({values})") == [text]


def test_a_table_within_itself_is_shown_once_and_siblings_each_time() -> None:
    assert printed("local t = {1} t[2] = t print(t) local s = {7} print({s, s})") == [
        "{1, {...}}",
        "{{7}, {7}}",
    ]


def test_long_and_deep_tables_are_cut() -> None:
    (long, deep) = printed(
        "local l = {} for i = 1, 1e6 // 10 do l[i] = i end print(l) local d = {} for i = 1, 100 do d = {d} end print(d)"
    )
    assert len(long) < 11_000
    assert long.endswith(", ...}")
    assert deep == "{" * 16 + "{...}" + "}" * 16


def test_no_line_shows_an_address() -> None:
    assert "0x" not in "".join(printed("print({{}, print, {a={}}}, print, {}) print(getAsString({}, print))"))


def test_get_as_string_and_printf_do_the_same() -> None:
    assert printed(
        "print(getAsString('a')) print(getAsString('a', {1}, nil)) printf('%s %d %s', {x=1}, 5, nil)"
    ) == [
        "a",
        '"a", {1}, nil',
        "{x=1} 5 nil",
    ]
