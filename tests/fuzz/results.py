"""Results of scripts' functions that clients call: values that clients cannot receive, in Lua and in Python."""

# ruff: noqa: E501 - long lines are lists of values and commands

from __future__ import annotations

import logging
from pathlib import Path

from hypothesis import strategies as st
from real_world import RealWorld

import simx_client as v

_LUA = (
    "{}", "''", "nil", "true", "{1,2,3}", "{1.5}", "{'a','b'}", "0/0", "1/0", "{0/0}", "{1/0}", "{-1/0}", "{2^53}", "{1e308}", "{1e400}",
    "print", "{print}", "coroutine.create(print)", "(function() local t={} t[1]=t return t end)()", "{{1}}", "{a=1}", "{[2]=1}",
    "{[1]=1,[3]=3}", "{[1e9]=1}", "'\\0'", "{'\\255\\254'}", "{'a\\0b'}", "('x'):rep(1000000)", "{('y'):rep(100000)}",
    "(function() local t={} for i=1,50000 do t[i]=i end return t end)()", "setmetatable({},{__index=function() error('x') end})",
    "setmetatable({},{__len=function() return 1e9 end})", "setmetatable({1},{__pairs=function() error('y') end})", "{nil,nil,3}",
    "(function() local t={} local u=t for i=1,200 do u[1]={} u=u[1] end return t end)()", "error('on purpose')", "error({})", "error()",
    "sim", "{sim}", "_G", "os", "io", "string.dump and 1", "{-2^31,2^31-1,2^31,2^63}", "sim.getObject('/nothing')", "{true,false}", "{'1','2'}",
)  # fmt: skip
_PYTHON = (
    "[]", "''", "b''", "None", "True", "[1,2,3]", "[1.5]", "['a']", "float('nan')", "[float('inf')]", "[10**400]", "10**400", "[10**5000]",
    "print", "[print]", "{}", "{'a':1}", "{1:2}", "set()", "object()", "(1,2)", "range(9)", "[[1]]", "'\\ud800'", "['\\ud800']", "'\\udc80'",
    "b'\\xff\\xfe'", "['a\\0b']", "'x'*1000000", "list(range(50000))", "(lambda t: t.append(t) or t)([])", "[None]", "1j", "[1j]", "type",
    "(_ for _ in [])", "bytearray(5)", "memoryview(b'a')", "1/0", "[2**31,-2**31,2**63]", "sim", "[True]", "[b'\\xff']", "10**5000",
    "__import__('os')", "(lambda n: [n(n)])(lambda f: 1)", "{1:{2:{3:[]}}}", "[-0.0,1e-45,3.5e38]", "exit()", "(lambda f: f(f))(lambda f: f(f))",
)  # fmt: skip
SAFE = {"lua": ("{}", "{}", "{}", "''"), "python": ("[]", "[]", "[]", "''")}


def result_of(language: str) -> st.SearchStrategy[str]:
    """The results of a function, in its own language: good values with a bad one or two among them, or too few, or too many."""
    pool = st.sampled_from(_LUA if language == "lua" else _PYTHON)

    def among(places: set[int], bad: str, other: str) -> str:
        values = list(SAFE[language])
        for index in places:
            values[index] = bad if index % 2 else other
        return ", ".join(values)

    mixed = st.builds(among, st.sets(st.integers(0, 3), min_size=1), pool, pool)
    return st.one_of(mixed, mixed, mixed, st.lists(pool, max_size=6).map(", ".join))


_SCENE = """<mujoco><custom>
<text name="simx:lua:lua" data="function text(i,f,s,b) local g=loadstring('return '..b) return g() end"/>
<text name="simx:python:python" data="def text(i, f, s, b):&#10;    return eval(b if isinstance(b, str) else b.decode())&#10;"/>
</custom><worldbody><body name="lua"><geom size="1"/></body><body name="python"><geom size="1"/></body></worldbody></mujoco>"""


class Scripts(logging.Handler):
    """A server with a script of each language whose function returns what it is told to."""

    def __init__(self, folder: Path) -> None:
        super().__init__(logging.ERROR)
        (folder / "scripts.xml").write_text(_SCENE)
        self.world = RealWorld(folder / "scripts.xml", workspace=folder)
        self.failures: list[str] = []
        logging.getLogger("simx_server").addHandler(self)
        self.client, self.witness = self.world.client(), self.world.client()
        v.simxStartSimulation(self.client, v.simx_opmode_blocking)

    def emit(self, record: logging.LogRecord) -> None:
        if record.exc_info:
            self.failures.append(f"{record.getMessage()}: {record.exc_info[1]!r}")

    def endure(self, language: str, results: str) -> int:
        """Have the script return these; the code of the call, 0 or 8."""
        text = results if language == "lua" else f"({results},)" if results else "()"
        before = self.failures[:]
        code, ints, floats, strings, buffer = v.simxCallScriptFunction(
            self.client,
            language,
            v.sim_scripttype_childscript,
            "text",
            [],
            [],
            [],
            text.encode(),
            v.simx_opmode_blocking,
        )
        errors = v.simxGetLastErrors(self.client, v.simx_opmode_blocking)[1]
        assert self.failures == before, (language, results, self.failures)
        assert code in (v.simx_return_ok, v.simx_return_remote_error_flag), (language, results, code, errors)
        assert not any("internal error" in error for error in errors), (language, results, errors)
        if code == v.simx_return_ok:
            assert all(type(each) is int for each in ints), (results, ints)
            assert all(type(each) is float for each in floats), (results, floats)
            assert all(type(each) is str for each in strings), (results, strings)
            assert type(buffer) is bytearray, (results, buffer)
        assert v.simxGetPingTime(self.witness)[0] == v.simx_return_ok
        return code

    def close(self) -> None:
        logging.getLogger("simx_server").removeHandler(self)
        self.world.close()
        super().close()
