"""Calls of every function that a Lua script finds, with absurd arguments: the script gets no object of Python,
others get their turn within a bound, and the interpreter lives on."""

# ruff: noqa: E501, PT017 - long lines are lists of values; not every case raises

from __future__ import annotations

import logging
import random
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Constant, ScriptError, Switching
from simx_server.scripting.lua.interpreter import LuaInterpreter

BOUND = 1.0
"""Processor seconds without a turn of others; the promise is 0.25 s, on a machine that does nothing else."""

LIMIT = 0.05

VALUES = (
    "nil", "true", "0", "-1", "1", "2", "3.7", "1e8", "1e15", "-1e15", "2^53", "0/0", "1/0", "-1/0", "math.maxinteger", "math.mininteger",
    "''", "'a'", "'%d'", "'%q'", "'%s%99.99f'", "'*t'", "'%c'", "'\\0'", "'[^a-z]'", "'(a*)*b'", "'.-.-b'", "'%b()'", "'%f[a]'", "'c99999999'",
    "'10'", "'0x10'", "'k'", "'collect'", "'step'", "'stop'", "'n'", "'#'", "'return 1'", "'a\\0b'", "'broken'", "('a'):rep(2000)", "('x'):rep(3e5)",
    "('%c'):rep(5e5)", "('1'):rep(3e5)", "('a*'):rep(20) .. 'b'", "('s'):rep(3e5)", "('::a::'):rep(9000)", "('[' .. ('b'):rep(9e4) .. ']*c')",
    "big", "zeros", "{}", "{1, 2, 3}", "{'a', 'b'}", "{{}}", "{[1] = 1, [3] = 3}", "{year = 1e15, month = 1, day = 1}", "list", "itself",
    "setmetatable({}, {__len = function() return 1e15 end})", "setmetatable({}, {__index = type})", "setmetatable({}, {__index = rawlen, __len = function() return 1e9 end, __newindex = rawequal})",
    "setmetatable({}, {__tostring = function() return big end})", "setmetatable({}, {__tostring = function() return {} end})", "setmetatable({}, {__call = print})",
    "print", "type", "error", "require", "string.rep", "math.ult", "coroutine.yield", "pcall", "function() end", "function(...) return ... end", "function() while true do end end",
    "function() return 'a' end", "function() require('broken') end", "coroutine.create(print)", "coroutine.create(function() while true do coroutine.yield(1) end end)",
    "coroutine.running()", "coroutine.wrap(function() while true do coroutine.yield('a') end end)", "_G", "sim", "string", "getmetatable('')",
)  # fmt: skip

PRELUDE = """
big, zeros, list, itself = ('a'):rep(3e6), ('\\0'):rep(1e6), {}, {}
for i = 1, 30000 do list[i] = i end
itself[1] = itself
local type, next, pairs, select, error, getmetatable, pcall = type, next, pairs, select, error, getmetatable, pcall
function look_into(value, seen, deep)
    local kind = type(value)
    if kind == 'userdata' then found = true error('an object of the server') end
    if kind == 'table' and not seen[value] and deep < 8 and value ~= list then
        seen[value] = true
        for k, v in next, value do look_into(k, seen, deep + 1) look_into(v, seen, deep + 1) end
    end
    if kind ~= 'string' and value ~= nil then look_into(getmetatable(value), seen, deep + 1) end
end
local function look_all(...)
    for i = 1, select('#', ...) < 50 and select('#', ...) or 50 do look_into((select(i, ...)), {}, 1) end
end
function attack(call) look_all(pcall(call)) end
function good() return found and 'found' or 7 end
function spin() while true do end end
"""

FUNCTIONS = """
local names = {}
for name, value in pairs(_G) do
    if type(value) == 'function' then names[#names + 1] = name end
    if type(value) == 'table' and name ~= '_G' then
        for key, member in pairs(value) do if type(member) == 'function' then names[#names + 1] = name .. '.' .. key end end
    end
end
table.sort(names)
function names_of() return names end
"""


class _Victim:
    """The script's `sim`: functions that fail, and that return what cannot cross."""

    is_ending = False

    def __init__(self) -> None:
        self.switching = Switching()
        self.last, self.longest = time.thread_time(), 0.0

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        return {"sim": {"handle_self": -4, "echo": None, "fail": None, "refuse": None, "strange": None}}

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...]:
        match name:
            case "sim.echo":
                return tuple(arguments)
            case "sim.fail":
                raise RuntimeError("a fault of the server")
            case "sim.strange":
                return (2**80, bytearray(b"x"), [object()])
            case _:
                raise CommandError("refused")

    def function(self, name: str) -> Callable[[Sequence[Any]], tuple[Any, ...]]:
        return lambda values: self.invoke(name, list(values))

    def count_calls(self, count: int) -> None:
        pass

    def module(self, name: str) -> bytes | None:
        if name == "broken" or "\0" in name:
            raise ValueError("embedded null byte")
        return None

    def phases_changed(self) -> None:
        pass

    def serve_others(self) -> None:
        now = time.thread_time()
        self.longest = max(self.longest, now - self.last)
        self.last = now

    def output(self, text: str) -> None:
        pass


class Library:
    """A script whose functions are called with anything; it is made again after a number of cases."""

    AT_ONCE = 200

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._left = 0
        self.longest = 0.0
        self.cases = 0
        logging.getLogger("simx_server.scripting.lua.interpreter").setLevel(logging.CRITICAL)
        self._begin()

    def _begin(self) -> None:
        self._api = _Victim()
        self._lua = LuaInterpreter("fuzz.lua", self._api, time_limit=LIMIT)
        self._lua.run(FUNCTIONS.encode())
        (names,) = self._lua.call("names_of")
        self._names = [name.decode() for name in names]
        self._lua.run(PRELUDE.encode())
        self._left = self.AT_ONCE

    def any_call(self) -> str:
        """One call, sometimes with calls as arguments."""
        pick = self._random
        arguments = [
            self.any_call() if pick.random() < 0.08 else pick.choice(VALUES)
            for _ in range(pick.choice((0, 1, 1, 2, 2, 2, 3, 3, 4)))
        ]
        return f"{pick.choice(self._names)}({', '.join(arguments)})"

    def one(self, call: str) -> None:
        """Make this call; AssertionError for what must not be."""
        if not self._left:
            self._begin()
        self._left -= 1
        self.cases += 1
        api, lua = self._api, self._lua
        api.last, api.longest = time.thread_time(), 0.0
        text = f"attack(function() return {call} end)".encode()
        try:
            lua.run(text)
        except ScriptError as problem:
            assert "an object of the server" not in str(problem), call
        api.serve_others()
        self.longest = max(self.longest, api.longest)
        assert api.longest < BOUND, (call, api.longest)
        try:
            assert lua.call("good") == [7], call
        except ScriptError:  # the case took the functions away, or filled the memory: a new script
            self._left = 0
            return
        if self.cases % 50 == 0:
            try:
                lua.call("spin")
            except ScriptError as problem:
                assert "took too long" in str(problem) or "no function" in str(problem), (call, problem)

    def run(self, cases: int) -> int:
        """Run this many cases; how many they were."""
        for _ in range(cases):
            self.one(self.any_call())
        return cases
