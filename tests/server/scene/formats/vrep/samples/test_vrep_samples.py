"""All sample files decode, and what holds in every file of the format holds in the result."""

from __future__ import annotations

import math
from enum import Enum
from functools import cache
from pathlib import Path

import numpy as np
from vrep_samples import ALL, OF_EACH_KIND, each_sample, needs_samples
from vrep_samples import decoded as decode

from simx_server.scene.formats.vrep.chunks import MARKERS, Body, heads
from simx_server.scene.formats.vrep.container import unpack
from simx_server.scene.formats.vrep.objects import (
    Dummy,
    Joint,
    PointCloud,
    Primitive,
    Shape,
)
from simx_server.scene.formats.vrep.objects import (
    Path as PathObject,
)

decoded = cache(decode)
"""Each file is decoded once; these tests change nothing."""

EXACT = (Primitive.CUBOID, Primitive.SPHEROID, Primitive.CYLINDER, Primitive.CONE)
"""Primitives whose vertices have exactly the primitive's extent."""


@each_sample
def test_records_end_where_the_next_begins_and_the_mark_is_last(path: Path) -> None:
    header, data = unpack(path.read_bytes())
    found = list(heads(Body(data, header.writer), 0, len(data)))
    assert found[-1] == (b"EOF", len(data), len(data))
    assert [tag for tag, _, _ in found if tag in MARKERS] == [b"EOF"]


@each_sample
def test_nothing_is_odd_and_nothing_but_plans_of_paths_is_left_out(path: Path) -> None:
    file = decoded(path)
    assert file.notes == []
    assert set(file.skipped) <= {"PPL"}


@each_sample
def test_names_are_unique_and_parents_there(path: Path) -> None:
    objects = decoded(path).objects
    names = [item.name for item in objects.values()]
    assert len(set(names)) == len(names) > 0
    assert all(names)
    assert {item.parent for item in objects.values()} <= {-1, *objects}


@each_sample
def test_a_model_has_one_root_and_that_is_its_base(path: Path) -> None:
    file = decoded(path)
    roots = [item for item in file.objects.values() if item.parent == -1]
    assert file.is_model is (path.suffix == ".ttm")
    if file.is_model:
        assert [item.is_model_base for item in roots] == [True]


@each_sample
def test_poses_are_finite_and_turns_have_length_one(path: Path) -> None:
    for item in decoded(path).objects.values():
        position, turn = item.pose
        assert all(map(math.isfinite, position)), item.name
        assert math.isclose(math.hypot(*turn), 1.0, abs_tol=1e-9), item.name


@each_sample
def test_meshes_are_whole(path: Path) -> None:
    for item in decoded(path).objects.values():
        for leaf in item.leaves if isinstance(item, Shape) else ():
            assert len(leaf.vertices) >= 3, item.name
            assert len(leaf.triangles) >= 1, item.name
            assert 0 <= leaf.triangles.min() <= leaf.triangles.max() < len(leaf.vertices), item.name
            assert np.isfinite(leaf.vertices).all(), item.name


@each_sample
def test_vertices_of_primitives_have_the_primitives_size(path: Path) -> None:
    for item in decoded(path).objects.values():
        for leaf in item.leaves if isinstance(item, Shape) else ():
            if leaf.primitive in EXACT:
                assert np.allclose(np.ptp(leaf.vertices, axis=0), leaf.size, rtol=1e-3, atol=1e-5), item.name


@each_sample
def test_normals_agree_with_the_triangles(path: Path) -> None:
    """Only invisible groups of primitives lack normals: theirs are given in another frame."""
    for item in decoded(path).objects.values():
        for leaf in item.leaves if isinstance(item, Shape) else ():
            if leaf.normals is None:
                assert isinstance(item, Shape)
                assert (item.is_grouped, item.layers) == (True, 0x100), item.name
                continue
            a, b, c = (leaf.vertices[leaf.triangles[:, corner]].astype(float) for corner in range(3))
            flat = np.cross(b - a, c - a)
            lengths = np.linalg.norm(flat, axis=1)
            solid = lengths > 1e-12
            assert leaf.normals.shape == (len(leaf.triangles), 3, 3), item.name
            middle = leaf.normals[solid].mean(axis=1)
            agreement = np.einsum("ij,ij->i", middle, flat[solid] / lengths[solid, None])
            assert np.mean(agreement > 0.5) > 0.9, item.name


@each_sample
def test_links_of_dummies_are_mutual(path: Path) -> None:
    objects = decoded(path).objects
    for item in objects.values():
        if isinstance(item, Dummy) and item.linked in objects:
            other = objects[item.linked]
            assert isinstance(other, Dummy), item.name
            assert other.linked == item.handle, item.name


@each_sample
def test_dependent_joints_stand_where_their_masters_put_them(path: Path) -> None:
    objects = decoded(path).objects
    for item in objects.values():
        if isinstance(item, Joint) and item.mode == 4 and item.master >= 0:
            master = objects[item.master]
            assert isinstance(master, Joint), item.name
            expected = item.offset + item.factor * master.position
            assert math.isclose(item.position, expected, abs_tol=1e-4), item.name


@each_sample
def test_script_texts_are_clean_and_owned(path: Path) -> None:
    file = decoded(path)
    for script in file.scripts:
        odd = {letter for letter in script.text if ord(letter) < 32 and letter not in "\r\n\t"}
        assert not odd, script.id
        assert "\ufffd" not in script.text, script.id
        assert (script.owner in file.objects) or script.type == 0, script.id
    assert sum(script.type == 0 for script in file.scripts) == (0 if file.is_model else 1)


@each_sample
def test_textures_that_are_used_are_there(path: Path) -> None:
    file = decoded(path)
    for item in file.objects.values():
        for leaf in item.leaves if isinstance(item, Shape) else ():
            if leaf.texture is not None:
                assert leaf.texture.texture in {*file.textures, *file.objects}, item.name


@each_sample
def test_every_file_has_a_thumbnail(path: Path) -> None:
    thumbnail = decoded(path).thumbnail
    assert thumbnail is not None
    assert thumbnail.shape == (128, 128, 3)
    assert np.ptp(thumbnail) > 100


@each_sample
def test_points_of_clouds_fill_their_bounds(path: Path) -> None:
    for item in decoded(path).objects.values():
        if isinstance(item, PointCloud) and len(item.points):
            rim = item.size / 2 if item.is_octree else 0.0
            bounds = [*(item.points.min(axis=0) - rim), *(item.points.max(axis=0) + rim)]
            assert np.allclose(bounds, item.bounds, atol=1e-5), item.name


@each_sample
def test_paths_that_are_closed_end_where_they_begin(path: Path) -> None:
    for item in decoded(path).objects.values():
        if isinstance(item, PathObject):
            assert len(item.points) >= 2, item.name
            ends = [np.array(item.points[place].pose[0]) for place in (0, -1)]
            longest = max(
                float(np.linalg.norm(np.subtract(one.pose[0], two.pose[0])))
                for one, two in zip(item.points, item.points[1:], strict=False)
            )
            gap = float(np.linalg.norm(ends[0] - ends[1]))
            assert not item.is_closed or gap <= 1.5 * longest, item.name


def kinds(path: Path) -> set[object]:
    """The objects, modes, surfaces and lists that a test of files in general may meet in this one."""
    file, found = decoded(path), set[object]()
    for item in file.objects.values():
        for name, value in vars(item).items():
            if isinstance(value, (bool, Enum)):
                found.add((type(item), name, value))
            elif isinstance(value, (list, dict)) and value:
                found.add((type(item), name))
        if isinstance(item, Joint):
            found.add((item.type, item.mode))
        if isinstance(item, Shape):
            found |= {leaf.primitive for leaf in item.leaves} | {leaf.is_convex for leaf in item.leaves}
    return found | {name for name, value in vars(file).items() if isinstance(value, (list, dict)) and value}


@needs_samples
def test_the_samples_of_each_kind_have_all_that_is_in_any_of_them() -> None:
    some = set[object]().union(*(kinds(path) for path in ALL if path.stem in OF_EACH_KIND))
    assert set[object]().union(*map(kinds, ALL)) - some == set()
