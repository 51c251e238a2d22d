"""Texture coordinates by V-REP's projections."""

from __future__ import annotations

import math

import numpy as np
import pytest
from vrep_shapes import cube, mesh_leaf

from simx_server.scene.formats.vrep.conversion.geometry.texture_mapping import coordinates_of
from simx_server.scene.formats.vrep.objects import Leaf, TextureUse
from simx_server.scene.poses.poses import NO_TURN, about

Z = (0.0, 0.0, 1.0)


def sheet(**parts: object) -> Leaf:
    points = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    return mesh_leaf(points, [[0, 1, 2], [0, 2, 3]], **parts)


def tube(corners: int = 12) -> Leaf:
    angles = np.linspace(0, 2 * math.pi, corners, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(corners)], axis=1)
    points = np.concatenate([ring, ring + np.array([0, 0, 2])])
    a = np.arange(corners)
    b = (a + 1) % corners
    faces = np.concatenate([np.stack([a, b, b + corners], 1), np.stack([a, b + corners, a + corners], 1)])
    return mesh_leaf(points, faces)


def test_plane_is_centred_on_its_frame_and_scaled_in_metres() -> None:
    use = TextureUse(texture=1, scale=(0.5, 4.0))
    expected = sheet().vertices[sheet().triangles][..., :2] / [0.5, 4.0] + 0.5
    assert np.allclose(coordinates_of(sheet(), use), expected)


def test_frame_is_that_of_the_shape_and_the_leaf_lies_in_it() -> None:
    leaf = sheet(pose=((3.0, 0.0, 0.0), NO_TURN))
    use = TextureUse(texture=1, frame=((0.0, 1.0, 0.0), about(Z, math.pi / 2)))
    corner = coordinates_of(leaf, use)[
        0, 0
    ]  # at (2, -1) in the shape: (2, -2) from the frame, which is turned
    assert corner == pytest.approx([-2 + 0.5, -2 + 0.5], abs=1e-6)


def test_a_cylinder_goes_once_around_without_a_jump_within_a_triangle() -> None:
    coordinates = coordinates_of(tube(), TextureUse(texture=1, mode=1))
    width = np.ptp(coordinates[..., 0], axis=1)
    assert width.max() == pytest.approx(1 / 12, abs=1e-5)
    assert np.ptp(coordinates[..., 1]) == pytest.approx(2.0)
    assert np.isin(np.round(coordinates[..., 0] % 1 * 12) % 12, range(12)).all()
    assert len(np.unique(np.round(coordinates[..., 0] % 1 * 12) % 12)) == 12


def test_a_sphere_has_its_poles_at_the_upper_and_lower_edge() -> None:
    points = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, -1]]
    coordinates = coordinates_of(mesh_leaf(points, [[0, 1, 2], [3, 2, 1]]), TextureUse(texture=1, mode=2))
    assert coordinates[0, :, 1] == pytest.approx([1.0, 0.5, 0.5])
    assert coordinates[1, 0, 1] == pytest.approx(0.0)
    assert coordinates[0, 2, 0] - coordinates[0, 1, 0] == pytest.approx(0.25)
    assert coordinates[0, 0, 0] == pytest.approx(coordinates[0, 1:, 0].mean())


def test_each_side_of_a_box_shows_the_whole_texture_upright() -> None:
    leaf = mesh_leaf(*cube())
    coordinates = coordinates_of(leaf, TextureUse(texture=1, mode=3))
    assert coordinates.min() == pytest.approx(0.0)
    assert coordinates.max() == pytest.approx(1.0)
    normals = leaf.normals
    assert normals is not None
    corners = leaf.vertices[leaf.triangles]
    around = np.abs(normals[:, 0, 2]) < 0.5
    assert np.allclose(coordinates[around, :, 1], corners[around][..., 2] + 0.5)
    for face in range(len(corners)):  # not mirrored, seen from outside
        u, v = coordinates[face, 1] - coordinates[face, 0], coordinates[face, 2] - coordinates[face, 0]
        assert u[0] * v[1] - u[1] * v[0] > 0


def test_fixed_coordinates_win_over_a_projection() -> None:
    fixed = np.arange(12, dtype=np.float32).reshape(6, 2)
    use = TextureUse(texture=1, coordinates=fixed, mode=1)
    assert np.array_equal(coordinates_of(sheet(), use).reshape(-1, 2), fixed)
    use.coordinates = fixed[:3]  # too few: damaged
    assert coordinates_of(sheet(), use).shape == (2, 3, 2)


def test_scale_that_is_no_number_counts_as_a_metre() -> None:
    for scale in ((0.0, math.nan), (math.inf, 0.0)):
        assert np.isfinite(coordinates_of(sheet(), TextureUse(texture=1, scale=scale))).all()
