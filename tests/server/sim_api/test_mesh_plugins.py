"""Namespaces for meshes: simConvex, simOpenMesh, simAssimp, simURDF."""

from __future__ import annotations

from pathlib import Path

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

ROBOT = """
<robot name="pendulum">
  <link name="foot"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
  <link name="rod"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><box size="0.02 0.02 0.5"/></geometry></visual></link>
  <joint name="swing" type="continuous"><parent link="foot"/><child link="rod"/><axis xyz="0 1 0"/></joint>
</robot>
"""


def box_of(world: ScriptWorld, handle: str) -> list[float]:
    points = world.value(f"(sim.getShapeMesh({handle}))")
    place = world.value(f"sim.getObjectPosition({handle})")
    return [round(edge(points[axis::3]) + place[axis], 6) for edge in (min, max) for axis in range(3)]


def test_a_hull_is_around_shapes_and_dummies(world: ScriptWorld) -> None:
    world.lua("cube = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.2, 0.2, 0.2})")
    world.lua(
        "dummy = sim.createDummy(0.01) "
        "sim.setObjectPosition(cube, {1, 0, 0.5}) sim.setObjectPosition(dummy, {2, 0, 0.5})"
    )
    world.lua("simConvex = require 'simConvex' hull = simConvex.hull({cube, dummy})")
    assert box_of(world, "hull") == pytest.approx([0.9, -0.1, 0.4, 2.0, 0.1, 0.6])
    world.fails("simConvex.hull({sim.getObject('hinge')})", "hulls are made of shapes, dummies")
    world.fails("simConvex.hull({dummy})", ".")


def test_the_hull_of_points_may_grow(world: ScriptWorld) -> None:
    world.lua("points = {} for i = 0, 7 do table.extend(points, {i & 1, i >> 1 & 1, i >> 2}) end")
    vertices, indices = world.lua(
        "table.insert(points, 0.5) table.insert(points, 0.5) table.insert(points, 0.5) return simConvex.qhull(points)"
    )
    assert (len(vertices), len(indices)) == (24, 36)
    grown, _ = world.lua("return simConvex.qhull(points, math.sqrt(3))")
    assert sorted({round(each, 6) for each in grown}) == [-1, 2]


def test_a_shape_gets_coarser(world: ScriptWorld) -> None:
    pytest.importorskip("fast_simplification")
    world.lua("ball = sim.createPrimitiveShape(sim.primitiveshape_spheroid, {1, 1, 1})")
    world.lua(
        "before = #select(2, sim.getShapeMesh(ball)) coarse = simOpenMesh.decimate(ball, {percentage = 0.3})"
    )
    assert world.value("#select(2, sim.getShapeMesh(coarse)) < 0.4 * before") is True
    world.fails("simOpenMesh.decimate(ball, {percentage = 'x'})", "'percentage' is a number")


def test_a_closed_shape_is_filled_with_convex_ones(world: ScriptWorld) -> None:
    pytest.importorskip("coacd")
    world.lua("cube = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.2, 0.2, 0.2})")
    handles = world.value("simConvex.vhacd(cube)")
    assert len(handles) == 1
    assert world.value("#simConvex.hacd(cube, {})") == 1


def test_shapes_are_written_and_read_again(world: ScriptWorld, tmp_path: Path) -> None:
    world.lua(
        "cube = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.2, 0.4, 0.6}) "
        "sim.setObjectPosition(cube, {1, 0, 0})"
    )
    for index in (0, 2):  # the formats that are read too
        ending, name = world.lua(f"return select(2, simAssimp.getExportFormat({index}))")
        world.lua(f"simAssimp.exportShapes({{cube}}, 'out{index}.{ending}', '{name}', 2)")
        world.lua(f"found = simAssimp.importShapes('out{index}.{ending}; out{index}.{ending}', 512, 0.5)")
        assert world.value("#found") == 2
        assert box_of(world, "found[1]") == pytest.approx([0.9, -0.2, -0.3, 1.1, 0.2, 0.3])
    world.lua(
        "simAssimp.exportShapesDlg('first.obj', {cube}) simAssimp.exportShapes({cube}, 'own.stl', 'stlb', 1, 1, 512)"
    )
    points, _ = world.lua("return simAssimp.importMeshes('own.stl')")
    assert max(points[0]) == pytest.approx(0.3)
    points, _ = world.lua("return simAssimp.importMeshes('own.stl', 1, 2)")
    assert [round(max(points[0][axis::3]), 6) for axis in range(3)] == [0.1, 0.3, 0.2]
    assert world.value("#simAssimp.importShapesDlg('first.obj')") == 1
    world.lua("v, i = simAssimp.importMeshes('own.stl') simAssimp.exportMeshes(v, i, 'mesh.ply', 'ply')")
    assert (tmp_path / "mesh.ply").read_bytes().startswith(b"ply\nformat ascii")
    assert world.lua("return simAssimp.getImportFormat(0)")[1] == "obj"
    assert world.lua("return simAssimp.getImportFormat(9)") == ["", ""]
    world.fails("simAssimp.exportShapes({cube}, 'a.fbx', 'fbx')", "formats to write are objnomtl, stl")
    world.fails("simAssimp.exportShapes({}, 'a.stl', 'stl')", "nothing to write")
    world.fails("simAssimp.importShapes('none.stl')", "none.stl")


def test_a_robot_is_loaded(world: ScriptWorld, tmp_path: Path) -> None:
    (tmp_path / "pendulum.urdf").write_text(ROBOT)
    world.lua("simURDF = require 'simURDF'")
    name, handles = world.lua("return simURDF.import('pendulum.urdf')")
    assert name in ("pendulum", "foot")
    swing = world.value("sim.getObject('/swing')")
    assert handles[0] == world.value(f"sim.getObject('/{name}')")
    assert swing in handles
    assert world.value(f"sim.getObjectInt32Param({swing}, sim.jointintparam_ctrl_enabled)") == 1
    _, others = world.lua("return simURDF.import('pendulum.urdf', 64 + 256)")
    assert world.value(f"sim.getModelProperty({others[0]}) & sim.modelproperty_not_model") != 0
    joint = others[handles.index(swing)]
    assert world.value(f"sim.getObjectInt32Param({joint}, sim.jointintparam_ctrl_enabled)") == 0
    assert world.value("sim.getJointType(sim.getObject('/swing'))") == 10
    world.fails("simURDF.export(1, 'a.urdf')", "models are not written as URDF")
