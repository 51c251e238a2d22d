"""What collides in place of a mesh that is flat, or not convex."""

from __future__ import annotations

import numpy as np
import pytest
from vrep_shapes import cube, mesh_leaf

from simx_server.scene.formats.vrep.conversion.geometry import decomposition, solids
from simx_server.scene.formats.vrep.objects import Leaf


def notched() -> tuple[np.ndarray, np.ndarray]:
    """A bar bent to an L: two boxes joined to one surface, of 12 points."""
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], float)
    points = np.concatenate([np.insert(outline, 2, z, axis=1) for z in (0.0, 1.0)])
    ring = [(i, (i + 1) % 6) for i in range(6)]
    sides = [f for a, b in ring for f in ((a, b, b + 6), (a, b + 6, a + 6))]
    lids = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = sides + [(a + 6, b + 6, c + 6) for a, b, c in lids] + [(c, b, a) for a, b, c in lids]
    return points.astype(np.float32), np.array(faces, np.int32)


def ell() -> Leaf:
    return mesh_leaf(*notched())


needs_library = pytest.mark.skipif(
    not decomposition.is_available(), reason="the extra 'convex' is not installed"
)


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decomposition, "is_available", lambda: False)


@pytest.mark.usefixtures("without")
def test_unconnected_convex_parts_collide_each_for_itself() -> None:
    points, faces = cube()
    leaf = mesh_leaf(np.concatenate([points, points + 3]), np.concatenate([faces, faces + 8]))
    found, is_exact = solids.solids_of(leaf)
    assert is_exact
    assert sorted(float(each.min()) for each in found) == [-0.5, 2.5]
    assert all(len(each) == 8 for each in found)


@pytest.mark.usefixtures("without")
def test_part_that_is_not_convex_is_a_hull_without_the_library() -> None:
    found, is_exact = solids.solids_of(ell())
    assert not is_exact
    assert len(found) == 1
    assert len(found[0]) == 12


@pytest.mark.usefixtures("without")
def test_a_mesh_that_nearly_fills_its_hull_collides_as_the_hull() -> None:
    points, faces = cube()
    for dent, expected in ((0.05, True), (0.6, False)):
        dented = points.copy()
        dented[0] += np.float32(dent)
        found, is_exact = solids.solids_of(mesh_leaf(dented, faces))
        assert is_exact is expected
        assert len(found) == 1


@pytest.mark.usefixtures("without")
def test_a_mesh_of_too_many_parts_is_one_hull() -> None:
    points, faces = cube()
    count = solids.MOST_PARTS + 1
    everything = np.concatenate([points + 3 * number for number in range(count)])
    leaf = mesh_leaf(everything, np.concatenate([faces + 8 * number for number in range(count)]))
    found, is_exact = solids.solids_of(leaf)
    assert not is_exact
    assert len(found) == 1


def test_flat_mesh_becomes_a_slab_behind_its_surface() -> None:
    points = np.array([[0, 0, 1], [2, 0, 1], [2, 1, 1], [0, 1, 1]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    assert solids.is_flat(points)
    up = solids.slab(points, faces)
    assert up[:, 2].max() == pytest.approx(1.0)
    assert up[:, 2].min() == pytest.approx(1.0 - solids.SLAB)
    assert solids.slab(points, faces[:, ::-1])[:, 2].max() == pytest.approx(1.0 + solids.SLAB)
    assert not solids.is_flat(cube()[0])


def open_ell() -> Leaf:
    """An L without its upper lid."""
    points, faces = notched()
    is_lid = (points[faces][:, :, 2] == points[:, 2].max()).all(axis=1)
    return mesh_leaf(points, faces[~is_lid])


def test_open_mesh_collides_as_a_slab_for_each_flat_side() -> None:
    found, is_exact = solids.solids_of(open_ell())
    assert is_exact
    assert len(found) == 7
    assert all(np.ptp(each, axis=0).min() == pytest.approx(solids.SLAB, rel=1e-3) for each in found)


def test_open_mesh_of_many_flat_sides_collides_as_its_hull(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solids, "MOST_SLABS", 6)
    found, is_exact = solids.solids_of(open_ell())
    assert not is_exact
    assert len(found) == 1


@needs_library
def test_mesh_is_decomposed_once_and_the_same_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    first, _ = solids.solids_of(ell())
    monkeypatch.setattr(decomposition, "_PROGRAM", "no_such_program")
    again, is_exact = solids.solids_of(ell())
    assert is_exact
    assert all(map(np.array_equal, first, again))


@needs_library
def test_library_that_crashes_or_takes_too_long_leaves_a_hull_and_a_warning(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    for name, value in (("SECONDS", 0.01), ("_PROGRAM", "no_such_program")):
        with monkeypatch.context() as patch:
            patch.setattr(decomposition, "_known", {})
            patch.setattr(decomposition, name, value)
            found, is_exact = solids.solids_of(ell())
        assert not is_exact
        assert len(found) == 1
    assert sum("could not be decomposed" in each.getMessage() for each in caplog.records) == 2


@needs_library
def test_real_library_leaves_the_notch_free() -> None:
    found, is_exact = solids.solids_of(ell())
    assert is_exact
    assert len(found) >= 2
    for part in found:  # the middle of the notch lies in no part's box
        low, high = part.min(axis=0), part.max(axis=0)
        assert not ((low < [2, 2, 0.5]) & (high > [2, 2, 0.5])).all()
