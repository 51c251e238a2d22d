"""Triangles of meshes: which are sound, which parts are closed, which way these face."""

from __future__ import annotations

import numpy as np
from vrep_shapes import cube

from simx_server.scene.formats.vrep.conversion.geometry.topology import (
    both_sides,
    connected,
    is_convex,
    sound,
    thickness,
)


def volume(points: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (points[faces[:, corner]].astype(float) for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def test_slivers_and_faces_of_missing_points_are_not_sound() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], np.float32)
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 0, 1], [0, 1, 4], [0, -1, 2]], np.int32)
    assert sound(points, faces).tolist() == [True, False, False, False, False]
    assert sound(points[:0], faces).tolist() == [False] * 5


def test_closed_mesh_is_drawn_once_and_an_open_one_from_both_sides() -> None:
    points, faces = cube()
    drawn, source = both_sides(points, faces)
    assert np.array_equal(drawn, faces)
    assert source.tolist() == list(range(12))
    drawn, source = both_sides(points, faces[2:])  # a box without one side
    assert len(drawn) == 20
    assert np.array_equal(drawn[10:], faces[2:, ::-1])
    assert source.tolist() == [*range(10), *range(10)]


def test_closed_mesh_that_is_inside_out_is_turned() -> None:
    points, faces = cube()
    drawn, _ = both_sides(points + 10, faces[:, ::-1])
    assert volume(points, drawn) > 0


def test_each_part_of_a_mesh_is_judged_alone() -> None:
    points, faces = cube()
    everything = np.concatenate([points, points + 3, points - 3])
    parts = np.concatenate([faces, faces[:, ::-1] + 8, faces[2:] + 16])
    drawn, source = both_sides(everything, parts)
    assert len(drawn) == 12 + 12 + 20
    assert volume(points + 3, drawn[12:24] - 8) > 0
    assert set(source[34:]) == set(range(24, 34))
    number = connected(everything, parts)
    assert sorted(set(number[:12])) + sorted(set(number[12:24])) + sorted(set(number[24:])) == [1, 2, 0]


def test_points_at_one_place_hang_together() -> None:
    points, faces = cube()
    apart = points[faces.ravel()]  # as in an STL file: three points of its own for each face
    drawn, _ = both_sides(apart, np.arange(36, dtype=np.int32).reshape(-1, 3))
    assert len(drawn) == 12


def test_convex_meshes_are_told_from_others_whichever_way_they_face() -> None:
    points, faces = cube()
    assert is_convex(points, faces)
    assert is_convex(points, faces[:, ::-1])
    dented = points.copy()
    dented[0] = 0.2, 0.2, 0.2
    assert not is_convex(dented, faces)


def test_thickness_is_measured_across_the_plane_of_a_mesh() -> None:
    points, _ = cube((2.0, 0.01, 3.0))
    middle, across, spread = thickness(points + np.float32(5))
    assert np.allclose(middle, 5)
    assert np.allclose(np.abs(across), [0, 1, 0], atol=1e-4)
    assert abs(spread - 0.01) < 1e-5
