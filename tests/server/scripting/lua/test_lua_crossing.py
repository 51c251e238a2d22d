"""Values between a Lua script and the functions of the API: flat results, and tables of any layout as arguments."""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from echo_api import EchoApi

from simx_server.scripting.interpreter import Constant, Waiting
from simx_server.scripting.lua.interpreter import LuaInterpreter

pytest.importorskip("lupa")


class GivingApi(EchoApi):
    """Its function returns what the test says, and keeps what it gets."""

    def __init__(self) -> None:
        super().__init__()
        self.results: tuple[Any, ...] = ()
        self.given: list[Any] = []

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        return {"sim": {"give": None}}

    def module(self, name: str) -> bytes | None:
        return None

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        self.given = arguments
        return self.results


def script(source: str) -> tuple[LuaInterpreter, GivingApi]:
    api = GivingApi()
    interpreter = LuaInterpreter("test.lua", api, time_limit=5.0)
    interpreter.run(source.encode())
    return interpreter, api


ONE, MANY = [1.5], [float(number) for number in range(20)]


@pytest.mark.parametrize(
    ("results", "arrived"),
    [
        ((), []),
        ((1,), [1]),
        ((1.5, True, None, b"x", "text"), [1.5, True, None, b"x", b"text"]),
        (([],), [[]]),
        (([], 1, []), [[], 1, []]),
        (([1.0, -0.0, 2.5],), [[1.0, -0.0, 2.5]]),
        (([1, 2, 3], [1, 2.0]), [[1, 2, 3], [1, 2.0]]),
        (((1.0, 2.0), ONE), [[1.0, 2.0], [1.5]]),
        ((1, 0.5, [1.0, 2.0, 3.0], 5, [0.0, 0.0, 1.0]), [1, 0.5, [1.0, 2.0, 3.0], 5, [0.0, 0.0, 1.0]]),
        ((MANY[:16],), [MANY[:16]]),
        ((MANY[:17], ONE), [MANY[:17], ONE]),
        ((MANY[:16],) * 4, [MANY[:16]] * 4),
        ((None, ONE, None), [None, ONE, None]),
        (([True, 1.0], [b"x", "y"], [None, 1.0]), [[True, 1.0], [b"x", b"y"], {2: 1.0}]),
        (({"a": ONE}, ONE), [{"a": ONE}, ONE]),
        ((2**70, ONE, -(1 << 63)), [2.0**70, ONE, -(1 << 63)]),
        (([2**70, 0.5], ONE), [[2.0**70, 0.5], ONE]),
        ((np.float64(2.5), [np.float64(1.5)], np.int32(7)), [2.5, [1.5], 7]),
        (([float("inf"), 1.0],), [[float("inf"), 1.0]]),
    ],
)
def test_results_arrive_as_they_are(results: tuple[Any, ...], arrived: list[Any]) -> None:
    interpreter, api = script("function f() return sim.give() end function g() return (sim.give()) end")
    api.results = results
    for _ in range(2):
        assert repr(interpreter.call("f")) == repr(arrived)  # 1 is not 1.0
    assert interpreter.call("g") == (arrived[:1] or [None])


def test_a_list_that_arrives_grows_as_one_that_a_script_has_filled() -> None:
    """Also the order of `pairs`, which depends on the room that a table has."""
    interpreter, api = script("""
        local function keys(t)
            local o = {}
            for k in pairs(t) do o[#o + 1] = tostring(k) end
            return table.concat(o, " ")
        end
        function order(count, names)
            local filled, arrived = {}, sim.give()
            for i = 1, count do filled[i] = i * 1.0 end
            for _, t in ipairs { filled, arrived } do
                for i = 1, names do t["n" .. i] = i end
                for i = count + 1, count + 4 do t[i] = i end
            end
            return keys(filled), keys(arrived), #filled, #arrived
        end""")
    for count in range(17):
        api.results = ([float(number) for number in range(1, count + 1)],)
        for names in range(7):
            filled, arrived, length, same_length = interpreter.call("order", count, names)
            assert (arrived, same_length) == (filled, length)


def test_tables_of_any_layout_reach_functions_whole() -> None:
    """Names may lie between the numbers of a list, where it was filled in another order."""
    interpreter, api = script("""
        function f(keys, values)
            local t = {}
            for i = 1, #keys do t[keys[i]] = values[i] end
            sim.give(t)
            sim.give(1, t)
            sim.give(t, 1, t)
        end""")
    chance = random.Random(0)
    for _ in range(300):
        keys: list[Any] = [number + 1 for number in range(chance.randrange(9))]
        keys += chance.sample([b"x", b"y", b"z"], chance.randrange(3))
        if len(keys) > 1 and chance.random() < 0.3:
            keys.pop(0)
        chance.shuffle(keys)
        values: list[Any] = [chance.choice((1, 2.5, 3.0, 4)) for _ in keys]
        interpreter.call("f", keys, values)
        whole = {
            key.decode() if isinstance(key, bytes) else key: value
            for key, value in zip(keys, values, strict=True)
        }
        is_list = whole.keys() == set(range(1, len(whole) + 1))
        expected = [whole[number] for number in sorted(whole)] if is_list else whole
        assert api.given == [expected, 1, expected]
        if is_list:
            assert list(map(type, api.given[0])) == list(map(type, expected))


@pytest.mark.parametrize("count", range(8))
def test_any_number_of_arguments_reaches_functions(count: int) -> None:
    interpreter, api = script("function f(...) sim.give(...) end")
    for value in (1, 2.5, None, True, b"text", [1.0, 2.0], [1, 2], [1, 2.5], [], {"a": 1}):
        interpreter.call("f", *[value] * count)
        assert repr(api.given) == repr([value] * count)


def test_the_server_may_keep_a_function_longer_than_the_coroutine_that_passed_it_lives() -> None:
    kept: list[Any] = []
    interpreter, api = script(
        """function pass(count)
            for number = 1, count do coroutine.wrap(function() sim.give(function() return number end) end)() end
        end
        function collect() for number = 1, 100 do local garbage = { number } end collectgarbage() end"""
    )
    for _ in range(3):
        for _ in range(50):
            assert interpreter.call("pass", 1) == []
            kept += api.given
        assert interpreter.call("collect") == []  # the memory of the coroutines is free
        assert [function() for function in kept] == [[1]] * 50
        kept.clear()
        api.given = []
        assert interpreter.call("collect") == []
    interpreter.close()
