"""The names that the simulator's own Lua has beside Lua's: matrices, and additions to string, table, math and sim."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from handler_calls import World
from scripted_world import evaluate, scripted

from simx_server.sim_api.listing.lacking import offered

pytest.importorskip("lupa")


@pytest.fixture(scope="module")
def world() -> World:
    world = scripted({"lua:base": "filter = nil"})
    world.run(0)
    return world


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("string.split('a, b,c', ', *')[2], #('a,b'):split(',')", [b"b", 2]),
        ("('x y'):startswith('x'), ('x y'):endswith('z'), (' x '):trim()", [True, False, b"x"]),
        ("('a.b'):gsub(string.escpat('.'), '-')", [b"a-b", 1]),
        ("#string.qsplit('a \"b c\" d', ' '), ('ab'):pad(-4), ('ab'):capitalize()", [3, b"  ab", b"Ab"]),
        ("table.eq({1, {a = 2}}, {1, {a = 2}}), table.eq({1}, {2})", [True, False]),
        ("table.find({5, 6}, 6), table.slice({1, 2, 3}, 2)", [2, [2, 3]]),
        ("table.add({1}, {2}), table.rep(7, 2), table.reversed({1, 2})", [[1, 2], [7, 7], [2, 1]]),
        ("table.flatten({a = {b = 1}}), table.unflatten({['a.b'] = 1})", [{"a.b": 1}, {"a": {"b": 1}}]),
        ("math.hypot(3, 4), math.sign(-2), math.median({3, 1, 2})", [5, -1, 2]),
        ("math.random2() < 1, math.random2(3) <= 3, math.random2(5, 5)", [True, True, 5]),
        ("map(function(x) return 2 * x end, {1, 2}), sum({1, 2, 3}), #range(3)", [[2, 4], 6, 3]),
        ("filter == nil", [True]),
        (
            "getAsDisplayString(1), wrap(4, function(x) return x + 1 end), quit == sim.quitSimulator",
            [b"1", 5, True],
        ),
        ("sim.getQuaternionInverse({1, 2, 3, 4}), sim.boolOr(1, 4)", [[-1, -2, -3, 4], 5]),
        (
            "sim.getNamedBoolParam('none') == nil, sim.setNamedFloatParam('f', 2.5), sim.getSettingFloat('f')",
            [True, 1, 2.5],
        ),
        ("#sim.getObjectsWithTag('none'), sim.throttle(1, print)", [0]),
        ("sim.no_such_constant", [None]),
    ],
)
def test_additions_to_luas_libraries(world: World, expression: str, value: list[Any]) -> None:
    assert evaluate(world, f"return {expression}") == value


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("(Matrix(2, 2, {1, 2, 3, 4}) * Vector{1, 1}):data()", [[3, 7]]),
        ("Matrix{{1, 2}, {3, 4}}:t():totable(), Matrix{{1, 2}, {3, 4}}:det()", [[[1, 3], [2, 4]], -2]),
        ("(Matrix{{2, 0}, {1, 4}}:inv() * Matrix{{2, 0}, {1, 4}} == Matrix:eye(2))", [True]),
        ("Vector3{3, 4, 0}:norm(), (Vector3{1, 0, 0} ^ Vector3{0, 1, 0}):data()", [5, [0, 0, 1]]),
        (
            "Vector3{1, 2, 3} .. Vector3{1, 1, 1}, (2 * Vector{1, 2} - 1):data(), #Vector{1, 2}",
            [6, [1, 3], 2],
        ),
        ("Matrix{{1, 9}, {3, 4}}:max()", [9, 1, 2]),
        ("Matrix{{1, 9}, {3, 4}}:sum(1):data(), Vector:linspace(0, 1, 3):data()", [[4, 13], [0, 0.5, 1]]),
        ("tostring(Matrix(1, 2)), Matrix(2, -1, {1, 2, 3, 4}):cols()", [b"Matrix(1, 2, {0, 0})", 2]),
        ("Matrix4x4:topose(Matrix4x4:frompose({1, 2, 3, 0, 0, 0, 1}))", [[1, 2, 3, 0, 0, 0, 1]]),
        ("Matrix3x3:toquaternion(Matrix3x3:fromquaternion({1, 0, 0, 0}))", [[1, 0, 0, 0]]),
        ("Matrix4x4(sim.getObjectMatrix(sim.getObject('/base'))):rows()", [4]),
        ("require('matrix-2').Matrix == Matrix, Matrix:horzcat(Vector{1}) ~= nil", [True, True]),
    ],
)
def test_matrices_are_calculated_with(world: World, expression: str, value: list[Any]) -> None:
    assert evaluate(world, f"return {expression}") == value


def test_elements_of_a_matrix_are_set_by_row_and_column(world: World) -> None:
    code = "local m = Matrix:eye(2) m[1][2] = 5 m[2] = {7, 8} m:set(1, 1, 9) local v = Vector{1, 2} v[2] = 4"
    assert evaluate(world, f"{code} return m:data(), v:data(), m[1][3]") == [[9, 5, 7, 8], [1, 4], None]


def test_transformations_agree_with_the_simulator(world: World) -> None:
    code = (
        "local a = {0.3, -0.4, 0.5} local m = sim.buildMatrix({1, 2, 3}, a) local n = Matrix4x4:fromeuler(a)"
    )
    ours, theirs, inverse, *_ = evaluate(
        world,
        f"{code} return n:slice(1, 1, 3, 3):data(), {{m[1], m[2], m[3], m[5], m[6], m[7], m[9], m[10], m[11]}}, "
        "(Matrix4x4:inv(Matrix4x4(m)) * Matrix4x4(m) - Matrix:eye(4)):abs():max()",
    )
    assert ours == pytest.approx(theirs, abs=1e-12)
    assert inverse == pytest.approx(0, abs=1e-12)


def test_what_a_script_defines_is_not_replaced() -> None:
    world = scripted(
        {
            "lua:base": "if not map then map = {} end function string.trim() return 'own' end x = (' a '):rtrim()"
        }
    )
    world.run(0)
    assert evaluate(world, "return type(map), (' a '):trim(), x") == [b"table", b"own", b" a"]


def test_import_makes_members_globals(world: World) -> None:
    code = "import('base64', 'encode') import 'functional.*' import 'matrix-2'"
    assert evaluate(world, f"{code} return type(encode), type(reduce), type(matrix.Matrix)") == [
        b"function",
        b"function",
        b"table",
    ]


def test_an_included_file_is_preceded_by_its_command(tmp_path: Path) -> None:
    (tmp_path / "helper.lua").write_text("y = (x or 0) + 1", encoding="utf-8")
    (tmp_path / "scene.xml").write_text(
        "<mujoco><worldbody><body name='base'/></worldbody><custom>"
        "<text name='simx:lua:base' data='include([[/lua/helper.lua]], [[x = 6]])'/></custom></mujoco>",
        encoding="utf-8",
    )
    world = World(file=tmp_path / "scene.xml", workspace=tmp_path)
    world.run(0)
    assert evaluate(world, "return y") == [7]


def test_a_joint_group_moves_its_joints() -> None:
    world = scripted({"lua:base": "require 'models.jointGroup_customization'"})
    world.run(0)
    evaluate(world, "sim.setReferencedHandles(sim.getObject('/base'), {sim.getObject('/hinge')})")
    evaluate(world, "moveToConfig{targetPos = {0.5}, maxVel = {2}, maxAccel = {20}, maxJerk = {200}}")
    world.run(60)
    assert evaluate(world, "return isMoveToConfigRunning(), getConfig()[1]") == [
        False,
        pytest.approx(0.5, abs=1e-3),
    ]


def test_functions_written_in_lua_are_not_reported_as_missing() -> None:
    assert {"getObjectsWithTag", "throttle", "getSettingBool"} <= offered()["sim"]
