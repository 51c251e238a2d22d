"""What V-REP's Lua 5.1 allowed, and scripts of its scenes rely on."""

from __future__ import annotations

from pathlib import Path

import pytest
from handler_calls import World
from scripted_world import said, scripted

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
