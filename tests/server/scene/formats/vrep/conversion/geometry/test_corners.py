"""Points with one normal and one texture coordinate each."""

from __future__ import annotations

import numpy as np
from vrep_shapes import cube, flat_normals

from simx_server.scene.formats.vrep.conversion.geometry.corners import surface


def test_a_flat_cube_has_a_point_per_corner_of_each_side_and_a_smooth_one_per_corner() -> None:
    points, faces = cube()
    flat = surface(points, faces, flat_normals(points, faces))
    assert len(flat.points) == 24
    assert np.allclose(flat.points[flat.faces], points[faces])
    assert flat.normals is not None
    assert np.allclose(flat.normals[flat.faces], flat_normals(points, faces), atol=2e-3)
    smooth = points[faces] / np.linalg.norm(points[faces], axis=2, keepdims=True)
    assert len(surface(points, faces, smooth).points) == 8


def test_missing_and_reversed_normals_become_the_faces_own() -> None:
    points, faces = cube()
    right = flat_normals(points, faces)
    for wrong in (-right, np.zeros_like(right)):
        made = surface(points, faces, wrong)
        assert made.normals is not None
        assert np.allclose(made.normals[made.faces], right, atol=2e-3)


def test_points_split_where_texture_coordinates_differ() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    texture = np.zeros((2, 3, 2), np.float32)
    assert len(surface(points, faces, None, texture).points) == 4
    texture[1] = 0.5
    split = surface(points, faces, None, texture)
    assert len(split.points) == 6
    assert split.texture is not None
    assert np.array_equal(split.texture[split.faces], texture)
    assert split.normals is None
