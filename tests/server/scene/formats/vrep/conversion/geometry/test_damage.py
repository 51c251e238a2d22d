"""Shapes with numbers that cannot be: each becomes something that MuJoCo takes, and the report says so."""

from __future__ import annotations

import dataclasses
import math
import random
import warnings
from enum import IntEnum
from typing import Any

import numpy as np
import pytest
from seeds import seeds
from vrep_meshes import mesh_of
from vrep_shapes import box_leaf, converted, cube, file_of, material, mesh_leaf, shape_of

from simx_server.scene.formats.vrep.conversion.geometry.damage import FARTHEST, undamaged
from simx_server.scene.formats.vrep.objects import Leaf, Material, Primitive, Shape, Texture, TextureUse

ODD = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1e30, -1e30, 1e-30, 1e308, 5.0)
CASES = 200


def test_sound_leaf_stays_what_it_is() -> None:
    leaf = box_leaf(texture=TextureUse(texture=1, coordinates=np.zeros((36, 2), np.float32)))
    same = undamaged(leaf)
    assert same is not None
    assert same.vertices is leaf.vertices
    assert same.triangles is leaf.triangles
    assert same.normals is leaf.normals
    assert same.primitive == Primitive.CUBOID


def test_faces_of_missing_and_of_impossible_points_are_dropped_with_their_normals_and_coordinates() -> None:
    points, faces = cube()
    points[7] = math.nan, 0, 0
    faces[0, 0], faces[1, 1] = -1, 8
    coordinates = np.arange(72, dtype=np.float32).reshape(36, 2)
    leaf = mesh_leaf(*cube(), texture=TextureUse(texture=1, coordinates=coordinates))
    leaf.vertices, leaf.triangles = points, faces
    found = undamaged(leaf)
    assert found is not None
    assert found.normals is not None
    assert found.texture is not None
    assert found.texture.coordinates is not None
    kept = [face for face in range(2, 12) if 7 not in faces[face]]
    assert found.triangles.tolist() == faces[kept].tolist()
    assert found.texture.coordinates.reshape(-1, 6).tolist() == coordinates.reshape(-1, 6)[kept].tolist()
    assert len(found.normals) == len(kept)
    assert np.isfinite(found.vertices).all()


@pytest.mark.parametrize(
    "pose",
    [
        ((math.nan, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
        ((0.0, 2 * FARTHEST, 0.0), (1.0, 0.0, 0.0, 0.0)),
    ],
)
def test_leaf_at_no_place_is_left_out_and_the_others_stay(pose: Any) -> None:
    assert undamaged(box_leaf(pose=pose)) is None
    conversion = converted(file_of(shape_of(box_leaf(), box_leaf(pose=pose))))
    assert conversion.spec.compile().ngeom == 1
    assert list(conversion.report.left_out.values()) == [["shape1"]]


def mutated(value: Any, rng: random.Random) -> Any:
    """A value with one part changed to something odd."""
    match value:
        case bool():
            return not value
        case IntEnum() | str() | None:
            return value
        case int():
            return rng.choice((0, -1, 1, 255, 2**31 - 1, -(2**31)))
        case float():
            return rng.choice(ODD)
        case tuple() | list():
            parts: list[Any] = list(value)
            if parts:
                place = rng.randrange(len(parts))
                parts[place] = mutated(parts[place], rng)
            return type(value)(parts)
        case np.ndarray():
            changed = value[: rng.randrange(len(value) + 1)].copy() if rng.random() < 0.3 else value.copy()
            for _ in range(rng.choice((1, 3, 20)) if changed.size else 0):
                odd = rng.choice(ODD) if changed.dtype.kind == "f" else rng.choice((0, 1, 2, -1, 999))
                with np.errstate(all="ignore"):
                    changed.flat[rng.randrange(changed.size)] = odd
            return changed
        case dict():
            return {key: mutated(each, rng) for key, each in value.items()}
        case _ if dataclasses.is_dataclass(value):
            name = rng.choice(dataclasses.fields(value)).name
            setattr(value, name, mutated(getattr(value, name), rng))
            return value
        case _:
            return value


def some_leaf(rng: random.Random) -> Leaf:
    kind = rng.choice(("plane", "disc", "cuboid", "spheroid", "cylinder", "cone"))
    size = (1.0, 1.0, 0.0 if kind in ("plane", "disc") else 1.0)
    leaf = mesh_leaf(*mesh_of(kind, size), material=Material(), is_convex=rng.random() < 0.5)
    leaf.primitive = rng.choice((Primitive.MESH, Primitive[kind.upper()]))
    leaf.size = size
    if rng.random() < 0.4:
        leaf.texture = TextureUse(texture=1, mode=rng.randrange(4), flags=rng.randrange(16))
    if rng.random() < 0.1:
        leaf.primitive, leaf.heights = Primitive.HEIGHT_FIELD, np.zeros((3, 3))
    return leaf


@pytest.mark.parametrize("seed", seeds(1))
@pytest.mark.usefixtures("decomposes_nothing")
def test_damaged_shapes_compile_without_a_warning(seed: int) -> None:
    rng = random.Random(seed)
    image = Texture(id=1, pixels=np.zeros((2, 2, 3), np.uint8))
    for _ in range(CASES):
        shape = shape_of(
            *(some_leaf(rng) for _ in range(rng.randrange(1, 3))),
            is_respondable=True,
            is_dynamic=rng.random() < 0.5,
            mass=1.0,
            inertia=(0.1, 0.1, 0.1),
            surface=material(),
        )
        for _ in range(rng.randrange(1, 5)):
            target: Any = rng.choice((*shape.leaves, shape)) if shape.leaves else shape
            mutated(target, rng)
        sane = Shape(**{field.name: getattr(shape, field.name) for field in dataclasses.fields(shape)})
        sane.handle, sane.parent, sane.name, sane.pose = 1, -1, "shape1", shape_of().pose
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)  # of NumPy
            conversion = converted(file_of(sane, textures={1: image}))
        conversion.write_notes()
        assert conversion.spec.compile().ngeom >= 1
