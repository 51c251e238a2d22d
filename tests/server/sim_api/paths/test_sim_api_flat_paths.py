"""Paths of CoppeliaSim 4 in scripts: lists of numbers, path objects with data, shapes along paths."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from sim_api_calls import ScriptWorld, world

from simx_server.errors import CommandError
from simx_server.scene.geometry.sweep import sweep

__all__ = ["world"]

CORNER = "p = {0,0,0, 1,0,0, 1,1,0}\nl, total = sim.getPathLengths(p, 3)\n"


def test_lengths_count_the_first_three_numbers_or_what_a_function_says(world: ScriptWorld) -> None:
    assert world.lua(CORNER + "return l, total") == [[0, 1, 2], 2]
    assert world.lua("return sim.getPathLengths({0,0,0, 9, 3,4,0, -9}, 4)") == [[0, 5], 5]
    assert world.lua(
        "return sim.getPathLengths({1, 4, 2}, 1, function(a, b) return 2 * math.abs(a[1] - b[1]) end)"
    ) == [
        [0, 6, 10],
        10,
    ]
    world.fails("sim.getPathLengths({1, 2, 3}, 2)", "3 numbers do not divide among points of 2")


def test_a_configuration_is_between_its_neighbours(world: ScriptWorld) -> None:
    for position, expected in ((-1, [0, 0, 0]), (0.25, [0.25, 0, 0]), (1.5, [1, 0.5, 0]), (9, [1, 1, 0])):
        found = world.lua(f"{CORNER}return sim.getPathInterpolatedConfig(p, l, {position})")
        assert found == [pytest.approx(expected)]
    for position, strength, expected in (
        (1, 1, [0.875, 0.125, 0]),
        (1, 0.5, [0.9375, 0.0625, 0]),
        (0.7, 0.5, [0.7, 0, 0]),
    ):
        method = f"{{type = 'quadraticBezier', strength = {strength}}}"
        found = world.lua(f"{CORNER}return sim.getPathInterpolatedConfig(p, l, {position}, {method})")
        assert found == [pytest.approx(expected)]
    world.fails(
        CORNER + "sim.getPathInterpolatedConfig(p, l, 1, {type = 'cubic'})", "linear or quadraticBezier"
    )
    world.fails(
        CORNER + "sim.getPathInterpolatedConfig({1, 2}, l, 1)", "2 numbers do not divide among 3 lengths"
    )


def test_a_closed_path_bends_at_its_ends_too_unless_forced_open(world: ScriptWorld) -> None:
    square = "p = {0,0, 1,0, 1,1, 0,1, 0,0}\nl = sim.getPathLengths(p, 2)\n"
    for position in (0, 4):
        for ends, expected in (("", [0.125, 0.125]), (", forceOpen = true", [0, 0])):
            method = f"{{type = 'quadraticBezier'{ends}}}"
            found = world.lua(f"{square}return sim.getPathInterpolatedConfig(p, l, {position}, {method})")
            assert found == [pytest.approx(expected)]


def test_types_go_the_short_way(world: ScriptWorld) -> None:
    (found,) = world.lua("return sim.getPathInterpolatedConfig({3, 3,  -3, -3}, {0, 1}, 0.5, nil, {0, 1})")
    assert found == pytest.approx([0, math.pi])
    half = math.sqrt(0.5)
    (found,) = world.lua(
        f"return sim.getPathInterpolatedConfig({{0,0,0,1, 0,0,{half},{half}}}, {{0, 1}}, 0.5, {{}}, {{2,2,2,2}})"
    )
    assert found == pytest.approx([0, 0, math.sin(math.pi / 8), math.cos(math.pi / 8)])
    assert world.value("sim.getConfigDistance({0, 3}, {4, -3}, {1, 0}, {0, 1})") == pytest.approx(4)
    assert world.value("sim.getConfigDistance({3}, {-3}, nil, {1})") == pytest.approx(2 * math.pi - 6)
    assert world.value(f"sim.getConfigDistance({{0,0,0,1}}, {{0,0,{half},{half}}}, nil, {{2,2,2,2}})") == (
        pytest.approx(math.pi / 2)
    )
    world.fails("sim.getConfigDistance({0, 3}, {4, -3}, nil, {2, 2})", "2 four times for a quaternion")


def test_resampled_points_lie_at_equal_lengths(world: ScriptWorld) -> None:
    assert world.lua(CORNER + "return sim.resamplePath(p, l, 5)") == [
        pytest.approx([0, 0, 0, 0.5, 0, 0, 1, 0, 0, 1, 0.5, 0, 1, 1, 0])
    ]
    world.fails(CORNER + "sim.resamplePath(p, l, 1)", "two points or more, not 1")


def test_the_nearest_position_lies_between_points(world: ScriptWorld) -> None:
    assert world.lua(CORNER + "return sim.getClosestPosOnPath(p, l, {0.3, -5, 0})") == [pytest.approx(0.3)]
    assert world.lua(CORNER + "return sim.getClosestPosOnPath(p, l, {5, 5, 0})") == [pytest.approx(2)]


def test_a_path_object_holds_its_points_as_data(world: ScriptWorld) -> None:
    world.lua(
        "h = sim.createPath({0,0,0, 0,0,0,1,  1,0,0, 0,0,0,1,  1,1,0, 0,0,0,1}, 16, 5, 0, 0, {0, 0, 1})"
    )
    points = world.lua("return sim.unpackDoubleTable(sim.readCustomDataBlock(h, 'PATH'))")[0]
    assert [points[at : at + 3] for at in range(0, 35, 7)] == [
        pytest.approx(each, abs=1e-9) for each in ([0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1, 0.5, 0], [1, 1, 0])
    ]
    # Mode 0: x along the path, y upwards.
    assert world.lua(
        "local points = sim.unpackDoubleTable(sim.readCustomDataBlock(h, 'PATH')) "
        "local m = sim.poseToMatrix({table.unpack(points, 22, 28)})"
        " return {m[1], m[5], m[9]}, {m[2], m[6], m[10]}"
    ) == [pytest.approx([0, 1, 0], abs=1e-9), pytest.approx([0, 0, 1], abs=1e-9)]
    assert len(world.lua("return sim.unpackDoubleTable(sim.readCustomDataBlock(h, 'PATHCTRLPTS'))")[0]) == 21
    world.lua("sim.setObjectPosition(h, -1, {0, 0, 2})")
    assert world.value("sim.getObjectPosition(sim.getObject('/Path/ctrlPt[1]'), -1)") == pytest.approx(
        [1, 0, 2]
    )
    world.fails("sim.createPath({0,0,0, 0,0,0,1})", "two control points or more")
    world.fails("sim.createPath({0,0,0})", "poses are 7 numbers each")


def test_a_closed_path_object_ends_at_its_start_and_is_smooth(world: ScriptWorld) -> None:
    world.lua(
        "h = sim.createPath({0,0,0, 0,0,0,1,  1,0,0, 0,0,0,1,  1,1,0, 0,0,0,1,  0,1,0, 0,0,0,1}, 2, 81)"
    )
    points = world.lua("return sim.unpackDoubleTable(sim.readCustomDataBlock(h, 'PATH'))")[0]
    places = [points[at : at + 3] for at in range(0, len(points), 7)]
    assert len(places) == 81
    assert places[0] == pytest.approx(places[-1])
    assert places[0] == pytest.approx([0.125, 0.125, 0])
    gaps = [math.dist(a, b) for a, b in pairwise(places)]
    assert max(gaps) < 1.02 * min(gaps)


def test_a_shape_along_a_path_is_a_solid_of_its_section(world: ScriptWorld) -> None:
    (shape,) = world.lua(
        "s = sim.generateShapeFromPath({0,0,1, 0,0,0,1,  2,0,1, 0,0,0,1}, "
        "{-0.1,0, 0.1,0, 0.1,0.3, -0.1,0.3, -0.1,0}) return s"
    )
    assert world.sim.scene.get(shape).name == "Shape"
    low, high = (
        [world.value(f"sim.getObjectFloatParam(s, {15 + 3 * end + axis})") for axis in range(3)]
        for end in (0, 1)
    )
    assert [b - a for a, b in zip(low, high, strict=True)] == pytest.approx([2, 0.2, 0.3])
    assert world.value("sim.getObjectPosition(s, -1)") == pytest.approx([1, 0, 1.15])
    vertices, indices, _ = world.lua("return sim.getShapeMesh(s)")
    assert (len(vertices) // 3, len(indices) // 3) == (8, 12)


@pytest.mark.parametrize(
    ("section", "area"),
    [
        ([(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)], 4),  # an L
        ([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], 7),  # a U
        ([(0, 3), (1, 3), (1, 1), (2, 1), (2, 3), (3, 3), (3, 0), (0, 0)], 7),  # the other way round
    ],
)
def test_ends_of_solids_fill_sections_that_are_not_convex(
    section: list[tuple[float, float]], area: float
) -> None:
    poses = [((0.0, 0.0, z), (1.0, 0.0, 0.0, 0.0)) for z in (0.0, 2.0)]
    points, faces = sweep(poses, [*section, section[0]], is_closed=False)
    corners = points[faces]
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volumes.sum() == pytest.approx(2 * area)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    at_ends = abs(normals[:, 2]) > 1e-9
    assert abs(normals[at_ends, 2]).sum() / 2 == pytest.approx(2 * area)  # no triangle beyond the section
    edges = {(int(a), int(b)) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)}
    assert all((b, a) in edges for a, b in edges)


def test_a_section_that_is_not_convex_has_a_limit() -> None:
    star = [(math.cos(a) * (1 + a % 2), math.sin(a) * (1 + a % 2)) for a in np.linspace(0, 6, 300)]
    poses = [((0.0, 0.0, z), (1.0, 0.0, 0.0, 0.0)) for z in (0.0, 2.0)]
    with pytest.raises(CommandError, match="at most 200 points"):
        sweep(poses, [*star, star[0]], is_closed=False)


def test_an_open_section_is_a_sheet_and_a_closed_path_joins_its_ends(world: ScriptWorld) -> None:
    ring = ", ".join(
        f"{math.cos(a / 8 * math.tau)}, {math.sin(a / 8 * math.tau)}, 0, 0,0,0,1" for a in range(8)
    )
    (shape,) = world.lua(f"s = sim.generateShapeFromPath({{{ring}}}, {{-0.1,0, 0.1,0}}, 4) return s")
    indices = world.lua("return sim.getShapeMesh(s)")[1]
    assert len(indices) // 3 == 8 * 2 * 2
    assert shape in world.sim.scene.objects
    world.fails("sim.generateShapeFromPath({0,0,0, 0,0,0,1}, {0,0, 1,0})", "two points of the path")
    world.fails("sim.generateShapeFromPath({0,0,0, 0,0,0,1}, {0,0, 1})", "x and y of each point, not 3")
