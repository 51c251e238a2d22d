"""Functions that Lua calculates itself give the results of Python's to the last bit, and are counted as calls of it."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import pytest
from echo_api import EchoApi

from simx_server.errors import CommandError
from simx_server.scene.poses import frames
from simx_server.scripting.interpreter import Constant, Waiting
from simx_server.scripting.lua.interpreter import LuaInterpreter
from simx_server.sim_api.namespaces import signatures
from simx_server.sim_api.values.matrices import MatrixFunctions

pytest.importorskip("lupa")

MATRICES = MatrixFunctions.__new__(MatrixFunctions)  # they need neither a world nor a script

FUNCTIONS = MappingProxyType(
    {"multiplyVector": MatrixFunctions.multiplyVector, "multiplyMatrices": MatrixFunctions.multiplyMatrices}
)
"""Those that Lua calculates."""

SOURCE = """
function vector(m, v) return sim.multiplyVector(m, v) end
function matrices(m, n) return sim.multiplyMatrices(m, n) end
function others() sim.note() end
function many(m, v) for i = 1, 10 do sim.multiplyVector(m, v) end sim.note() sim.multiplyVector(m, v) end
function within(m, v)
    local thread = coroutine.wrap(function() return sim.multiplyVector(m, v) end)
    return thread()
end
function kept(m, v)
    local a, b = sim.multiplyVector(m, v), sim.multiplyVector(m, v)
    a[1] = 7.0
    return b, #a, m[12]
end
"""


class MatrixApi(EchoApi):
    """Calls Python's functions, and counts the calls."""

    def __init__(self) -> None:
        super().__init__()
        self.names: list[tuple[str, int]] = []
        """Functions of Python that were called, and how many calls Lua had told of before."""

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        return {"sim": {"note": None, **dict.fromkeys(FUNCTIONS)}}

    def module(self, name: str) -> bytes | None:
        return None

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        name = name.removeprefix("sim.")
        self.names.append((name, self.calculated))
        if name == "note":
            return ()
        return (FUNCTIONS[name](MATRICES, *signatures("sim")[name].bind(arguments)),)


def script() -> tuple[LuaInterpreter, MatrixApi]:
    api = MatrixApi()
    interpreter = LuaInterpreter("test.lua", api, time_limit=5.0)
    interpreter.run(SOURCE.encode())
    return interpreter, api


def pose(chance: random.Random) -> list[float]:
    """A matrix; of some the numbers are whole, or nearly a rotation only."""
    if chance.random() < 0.2:
        signs = [chance.choice((1, -1)) for _ in range(3)]
        order = chance.sample(range(3), 3)
        rows = [[signs[row] if order[row] == column else 0 for column in range(3)] for row in range(3)]
        return [number for row in rows for number in (*row, chance.choice((0, -0.0, 3, 2.5)))]
    turn = frames.quat_from_euler([chance.uniform(-3.2, 3.2) for _ in range(3)])
    place = chance.uniform(-9, 9), chance.choice((0.0, -0.0, 1e-300, 1e9)), chance.gauss(0, 1)
    inexact = chance.choice((0.0, 0.0, 1e-3))
    return [number + chance.uniform(-inexact, inexact) for number in frames.matrix12((place, turn))]


def test_results_have_the_bits_of_python() -> None:
    interpreter, api = script()
    chance = random.Random(0)
    for _ in range(500):
        first, second = pose(chance), pose(chance)
        point = [chance.choice((0, 1, -2, 0.0, -0.0, 1e200, chance.gauss(0, 5))) for _ in range(3)]
        for name, function, other in (
            ("vector", "multiplyVector", point),
            ("matrices", "multiplyMatrices", second),
        ):
            wanted = FUNCTIONS[function](MATRICES, *signatures("sim")[function].bind([first, other]))
            (found,) = interpreter.call(name, first, other)
            assert repr(found) == repr(wanted)  # -0.0 is not 0.0
    assert not api.names
    assert api.calculated == 1000


IDENTITY = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("matrix", "point"),
    [
        (IDENTITY, [1.0, 2.0]),
        (IDENTITY, [1.0, 2.0, 3.0, 1.0]),
        (IDENTITY, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        (IDENTITY, [1.0, float("nan"), 3.0]),
        (IDENTITY, [1.0, float("inf"), float("-inf")]),
        (IDENTITY, [1.0, "2", 3.0]),
        (IDENTITY, [1.0, True, 3.0]),
        (IDENTITY, {1: 1.0, 3: 3.0}),
        (IDENTITY, None),
        (IDENTITY, 5),
        (IDENTITY[:7], [1.0, 2.0, 3.0]),
        ([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 3.0]),
        ([*IDENTITY, 1.0], [1.0, 2.0, 3.0]),
        ([2.0, *IDENTITY[1:]], [1.0, 2.0, 3.0]),
        ([0.0] * 12, [1.0, 2.0, 3.0]),
        ([1e300, *IDENTITY[1:]], [1.0, 2.0, 3.0]),
        ([float("inf"), *IDENTITY[1:]], [1.0, 2.0, 3.0]),
    ],
)
def test_everything_else_is_left_to_python(matrix: Any, point: Any) -> None:
    interpreter, api = script()
    given = (
        [each.encode() if isinstance(each, str) else each for each in point]
        if isinstance(point, list)
        else point
    )

    def in_python() -> list[Any]:
        return [
            MatrixFunctions.multiplyVector(
                MATRICES, *signatures("sim")["multiplyVector"].bind([matrix, given])
            )
        ]

    wanted, found = outcome(in_python), outcome(lambda: interpreter.call("vector", matrix, point))
    assert found.endswith(wanted)
    assert api.names == [("multiplyVector", 0)]
    assert api.calculated == 0


def outcome(call: Callable[[], list[Any]]) -> str:
    """The results of a call with all their digits, or the text of its error."""
    try:
        return repr(call())
    except CommandError as problem:
        return str(problem)


def test_python_is_told_of_the_calls_in_their_order() -> None:
    interpreter, api = script()
    interpreter.call("many", IDENTITY, [1.0, 2.0, 3.0])
    assert api.names == [("note", 10)]
    assert api.calculated == 11


def test_the_calls_of_a_coroutine_are_pythons_since_their_time_counts() -> None:
    interpreter, api = script()
    assert interpreter.call("within", IDENTITY, [1.0, 2.0, 3.0]) == [[1.0, 2.0, 3.0]]
    assert api.names == [("multiplyVector", 0)]


def test_each_result_is_a_table_of_its_own() -> None:
    interpreter, _ = script()
    assert interpreter.call("kept", [*IDENTITY[:-1], 5.0], [1.0, 2.0, 3.0]) == [[1.0, 2.0, 8.0], 3, 5.0]
