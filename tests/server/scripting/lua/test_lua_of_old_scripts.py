"""Features of V-REP's Lua 5.1 that scripts of its scenes rely on."""

from __future__ import annotations

from pathlib import Path

import pytest
from handler_calls import World
from scripted_world import evaluate, said, scripted

pytest.importorskip("lupa")


def printed(source: str) -> list[str]:
    world = scripted({"lua:base": source})
    said(world)
    world.run(0)
    return said(world)


def test_a_seed_may_have_a_fraction() -> None:
    assert "true" in printed(
        "math.randomseed(0.7 * 10000 + 0.5) a = math.random(100) math.randomseed(7000) print(a == math.random(100))"
    )


def test_a_file_is_loaded_from_beside_the_scene_only(tmp_path: Path) -> None:
    (tmp_path / "helper.lua").write_text("x = 7", encoding="utf-8")
    source = (
        "chunk = loadfile([[C:\\\\any\\\\folder/helper.lua]]) chunk() print(x) "
        "print(select(2, loadfile([[/etc/passwd]])))"
    )
    (tmp_path / "scene.xml").write_text(
        "<mujoco><worldbody><body name='base'/></worldbody><custom>"
        f"<text name='simx:lua:base' data='{source}'/></custom></mujoco>",
        encoding="utf-8",
    )
    world = World(file=tmp_path / "scene.xml", workspace=tmp_path)
    world.run(0)
    lines = said(world)
    assert "7" in lines
    assert any("cannot open /etc/passwd" in line for line in lines)


def test_ports_for_started_programs_are_counted() -> None:
    assert "20000, 2000, 20001" in printed(
        "n = sim.getInt32Parameter(sim.intparam_server_port_next) "
        "sim.setInt32Parameter(sim.intparam_server_port_next, n + 1) "
        "print(sim.getInt32Parameter(sim.intparam_server_port_start), "
        "sim.getInt32Parameter(sim.intparam_server_port_range), "
        "sim.getInt32Parameter(sim.intparam_server_port_next))"
    )


def test_texts_of_numbers_are_numbers_and_converted_handles_are_handles() -> None:
    assert "10.0, 7" in printed(
        "h = sim.getObjectHandle('base') sim.setObjectPosition(h, '-1', {'10', 0, '1e0'}) "
        "sim.setShapeColor('@backCompatibility1:' .. h, nil, 0, {0, 0, 1}) "
        "print(sim.getObjectPosition(h, -1)[1], 7)"
    )
    assert any(
        "must be a number, got '10 apples'" in line
        for line in printed("sim.getObjectPosition('10 apples', -1)")
    )


def test_names_of_old_lua_are_there() -> None:
    assert "1, ab, 3, 0.5, 1, true" in printed(
        "table.foreachi({1, 2, 3}, function(i) n = i end) for w in string.gfind('ab', '%a+') do s = w end "
        "package.path = package.path .. ';x/?.lua' m, e = math.frexp(1) "
        "print(math.mod(7, 2), s, n, m, e, getfenv() == _G)"
    )


def test_fractions_are_cut_off_where_whole_numbers_are_needed() -> None:
    assert "[2 2.50 -1], bc, xx, true" in printed(
        "print(string.format('[%d %.2f %i]', 2.5, 2.5, -1.7), ('abcd'):sub(2.2, 3.9), ('x'):rep(2.9), "
        "math.random(1.5, 2.5) <= 2)"
    )


def test_files_of_the_workspace_are_written_only(tmp_path: Path) -> None:
    scene = "<mujoco><worldbody><body name='base'/></worldbody></mujoco>"
    (tmp_path / "scene.xml").write_text(
        scene.replace(
            "</worldbody>",
            "</worldbody><custom><text name='simx:lua:base' data='f = io.open([[/home/me/log.txt]], [[w]]) "
            "f:write([[a]], 1, string.char(10)) f:flush() print(io.open([[scene.xml]])) "
            "g = io.open([[sub/log.txt]], [[a]]) g:write([[b]]) print(io.type(g), g:seek([[end]])) '/></custom>",
        ),
        encoding="utf-8",
    )
    world = World(file=tmp_path / "scene.xml", workspace=tmp_path)
    world.run(0)
    assert (tmp_path / "log.txt").read_bytes() == b"a1\n"
    assert (tmp_path / "sub" / "log.txt").read_bytes() == b""
    assert "file, 1" in said(world)
    world.call("simxStopSimulation")
    world.run(0)
    assert (tmp_path / "sub" / "log.txt").read_bytes() == b"b"


def test_a_file_is_written_by_its_number_too(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(
        "<mujoco><worldbody><body name='base'/></worldbody><custom><text name='simx:lua:base' data='"
        "n = simx.openFile([[log.txt]]) simx.writeFile(n, [[a]]) simx.flushFile(n) "
        "simx.writeFile(n, [[b]]) simx.closeFile(n)'/></custom></mujoco>",
        encoding="utf-8",
    )
    World(file=tmp_path / "scene.xml", workspace=tmp_path).run(0)
    assert (tmp_path / "log.txt").read_text(encoding="utf-8") == "ab"


def test_files_outside_the_workspace_and_the_servers_own_are_not_written(tmp_path: Path) -> None:
    space = tmp_path / "space"
    space.mkdir()
    (space / "scene.xml").write_text(
        "<mujoco><worldbody><body name='base'/></worldbody><custom>"
        "<text name='simx:lua:base' data='x = 1'/></custom></mujoco>",
        encoding="utf-8",
    )
    world = World(file=space / "scene.xml", workspace=space)
    world.run(0)
    for path in ("../out.txt", "/etc/out.txt", "C:\\\\out.txt"):
        assert evaluate(world, f"return io.type(io.open('{path}', 'w'))") == [b"file"]
    assert [each.name for each in tmp_path.iterdir()] == ["space"]
    missing, problem, _ = evaluate(world, "return io.open('.simx-from-clients', 'w')")
    assert missing is None
    assert b"the server's own list" in problem
