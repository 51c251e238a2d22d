"""V-REP's primitives as geoms of MuJoCo."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from vrep_meshes import mesh_of
from vrep_shapes import box_leaf

from simx_server.scene.formats.vrep.conversion.geometry.primitives import form_of, looks_round
from simx_server.scene.formats.vrep.objects import Leaf, Primitive

GEOM = mujoco.mjtGeom


@pytest.mark.parametrize(
    ("primitive", "size", "type", "expected"),
    [
        (Primitive.CUBOID, (0.2, 0.4, 0.6), GEOM.mjGEOM_BOX, (0.1, 0.2, 0.3)),
        (Primitive.SPHEROID, (0.2, 0.2, 0.2), GEOM.mjGEOM_SPHERE, (0.1, 0, 0)),
        (Primitive.SPHEROID, (0.2, 0.4, 0.2), GEOM.mjGEOM_ELLIPSOID, (0.1, 0.2, 0.1)),
        (Primitive.CYLINDER, (0.2, 0.2, 0.6), GEOM.mjGEOM_CYLINDER, (0.1, 0.3, 0)),
        (Primitive.CAPSULE, (0.2, 0.2, 0.6), GEOM.mjGEOM_CAPSULE, (0.1, 0.2, 0)),
        (Primitive.CAPSULE, (0.2, 0.2, 0.2), GEOM.mjGEOM_SPHERE, (0.1, 0, 0)),
    ],
)
def test_geom_has_half_of_each_size(
    primitive: Primitive, size: tuple[float, float, float], type: int, expected: tuple[float, float, float]
) -> None:
    form = form_of(Leaf(primitive=primitive, size=size))
    assert form is not None
    assert form.type == type
    assert form.size == pytest.approx(expected)


@pytest.mark.parametrize(
    ("primitive", "size"),
    [
        (Primitive.MESH, (1, 1, 1)),
        (Primitive.CONE, (1, 1, 1)),
        (Primitive.PLANE, (1, 1, 0)),
        (Primitive.DISC, (1, 1, 0)),
        (Primitive.CYLINDER, (0.2, 0.3, 0.6)),
        (Primitive.CUBOID, (math.nan, 1, 1)),
        (Primitive.CUBOID, (-1, 1, 1)),
        (Primitive.SPHEROID, (math.inf, 1, 1)),
    ],
)
def test_others_have_none(primitive: Primitive, size: tuple[float, float, float]) -> None:
    assert form_of(Leaf(primitive=primitive, size=size)) is None


def test_mesh_decides_where_it_contradicts_the_size() -> None:
    leaf = box_leaf((1.0, 2.0, 3.0))
    assert form_of(leaf) is not None
    leaf.vertices = leaf.vertices * np.float32(2)
    assert form_of(leaf) is None


def test_round_primitives_of_few_corners_look_angular() -> None:
    points, faces = mesh_of("cylinder", (1, 1, 1))
    leaf = Leaf(
        primitive=Primitive.CYLINDER, size=(1, 1, 1), vertices=points.astype(np.float32), triangles=faces
    )
    assert looks_round(leaf)
    leaf.vertices = leaf.vertices[:14]
    assert not looks_round(leaf)
    assert looks_round(box_leaf())
