"""The solids that collide in place of a mesh that is flat, or not convex."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from vrep_concave import bowl, notched, room
from vrep_shapes import cube, mesh_leaf

from simx_server.scene.formats.vrep.conversion.geometry.colliding import (
    decomposing,
    decomposition,
    part_cache,
    prisms,
    solids,
)
from simx_server.scene.formats.vrep.conversion.geometry.colliding.boxes import box_of
from simx_server.scene.formats.vrep.conversion.geometry.colliding.solids import Form, solids_of
from simx_server.scene.formats.vrep.objects import Leaf


def sheared(amount: float) -> Leaf:
    """The room, leaning towards x."""
    points, faces = room()
    points[:, 0] += np.float32(amount) * points[:, 2]
    return mesh_leaf(points, faces)


def equal(one: Form, other: Form) -> bool:
    return len(one.solids) == len(other.solids) and all(map(np.array_equal, one.solids, other.solids))


needs_library = pytest.mark.skipif(
    not decomposition.is_available(), reason="the extra 'convex' is not installed"
)


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decomposition, "is_available", lambda: False)


def test_unconnected_convex_parts_collide_each_for_itself() -> None:
    points, faces = cube()
    leaf = mesh_leaf(np.concatenate([points, points + 3]), np.concatenate([faces, faces + 8]))
    for moves in (False, True):
        form = solids_of(leaf, moves=moves)
        assert form.is_exact
        assert sorted(float(each.min()) for each in form.solids) == [-0.5, 2.5]
        assert all(len(each) == 8 for each in form.solids)


@pytest.mark.usefixtures("without")
@pytest.mark.parametrize("moves", [False, True])
@pytest.mark.parametrize("is_reversed", [False, True])
def test_body_of_boxes_collides_as_boxes(moves: bool, is_reversed: bool) -> None:
    points, faces = room()
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0].astype(np.float32)
    turn[:, 0] *= np.linalg.det(turn)
    form = solids_of(mesh_leaf(points @ turn.T, faces[:, ::-1] if is_reversed else faces), moves=moves)
    boxes = [box_of(each) for each in form.solids]
    assert form.is_exact
    assert len(boxes) == 5
    volumes = [8 * float(box.half.prod()) for box in boxes if box is not None]
    assert sum(volumes) == pytest.approx(0.8 * (2.2 * 2.2 - 2 * 2 - 0.8 * 0.1), rel=1e-4)


@pytest.mark.usefixtures("without")
def test_outline_with_a_height_collides_as_convex_columns() -> None:
    points, faces = notched()
    points[points[:, 1] > 2, 0] += 1
    form = solids_of(mesh_leaf(points, faces), moves=True)
    assert form.is_exact
    assert len(form.solids) == 2
    assert all(np.ptp(each[:, 2]) == 1 for each in form.solids)


@pytest.mark.usefixtures("without")
def test_moving_part_without_a_simple_form_is_a_hull_without_the_library() -> None:
    points, faces = bowl()
    form = solids_of(mesh_leaf(points, faces), moves=True)
    assert not form.is_exact
    assert [len(each) for each in form.solids] == [len(points)]


@pytest.mark.usefixtures("without")
def test_a_moving_mesh_that_nearly_fills_its_hull_collides_as_the_hull() -> None:
    points, faces = cube()
    for dent, expected in ((0.05, 1), (0.6, 9)):
        dented = points.copy()
        dented[0] += np.float32(dent)
        form = solids_of(mesh_leaf(dented, faces), moves=True)
        assert form.is_exact
        assert len(form.solids) == expected


@pytest.mark.usefixtures("without")
def test_a_moving_mesh_of_too_many_parts_is_one_hull(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solids, "MOST_PARTS", 20)
    points, faces = cube()
    everything = np.concatenate([points + 3 * number for number in range(21)])
    leaf = mesh_leaf(everything, np.concatenate([faces + 8 * number for number in range(21)]))
    form = solids_of(leaf, moves=True)
    assert not form.is_exact
    assert len(form.solids) == 1
    assert len(solids_of(leaf, moves=False).solids) == 21


def test_static_mesh_collides_where_its_surface_is_and_on_no_other_side_of_a_thin_wall() -> None:
    leaf = mesh_leaf(*bowl())
    form = solids_of(leaf, moves=False)
    assert form.is_exact
    assert not form.moved
    assert len(form.solids) < 0.6 * len(leaf.triangles), "neighbours in a plane are joined"
    away = np.linalg.norm(np.concatenate(form.solids), axis=1)
    assert away.min() > 0.49 * np.cos(np.pi / 16) * np.cos(np.pi / 24), "the middle of the inner facets"
    assert away.max() < 0.5 + 1e-6
    corners = {tuple(each) for each in np.concatenate(form.solids).round(5).tolist()}
    assert {tuple(each) for each in leaf.vertices.round(5).tolist()} <= corners


@pytest.mark.parametrize("amount", [0.3, 2.0, -2.0])
def test_solids_behind_sharp_edges_end_at_the_other_side(amount: float) -> None:
    form = solids_of(sheared(amount), moves=False)
    assert len(form.solids) > 5
    points = np.concatenate(form.solids).astype(float)
    points[:, 0] -= amount * points[:, 2]
    away = np.abs(points[:, :2]).max(axis=1)
    assert away.min() > 1 - 1e-4
    assert away.max() < 1.1 + 1e-4
    assert points[:, 2].min() > -1e-4
    assert points[:, 2].max() < 0.8 + 1e-4
    is_in_doorway = (np.abs(points[:, 0]) < 0.4 - 1e-4) & (points[:, 1] < 0)
    assert not is_in_doorway.any()


def test_huge_static_mesh_is_simplified_the_same_way_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solids, "MOST_STATIC", 60)
    leaf = mesh_leaf(*bowl())
    form = solids_of(leaf, moves=False)
    assert 10 < len(form.solids) <= 60
    assert 0 < form.moved < 0.3
    assert equal(form, solids_of(leaf, moves=False))


@pytest.mark.parametrize("is_reversed", [False, True])
def test_flat_mesh_becomes_a_slab_behind_its_surface(is_reversed: bool) -> None:
    points = np.array([[0, 0, 1], [2, 0, 1], [2, 1, 1], [0, 1, 1]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    assert solids.is_flat(points)
    assert not solids.is_flat(cube()[0])
    ((slab,), is_exact, _) = solids_of(
        mesh_leaf(points, faces[:, ::-1] if is_reversed else faces), moves=False
    )
    assert is_exact
    assert sorted({float(z) for z in slab[:, 2]}) == pytest.approx(
        [1.0, 1.0 + prisms.SHEET] if is_reversed else [1.0 - prisms.SHEET, 1.0]
    )


def test_flat_mesh_seen_from_both_sides_collides_once_and_not_in_its_notch() -> None:
    points, faces = notched()
    lid = faces[(points[faces][:, :, 2] == 1).all(axis=1)]
    form = solids_of(mesh_leaf(points, np.concatenate([lid, lid[:, ::-1]])), moves=False)
    assert len(form.solids) == 2
    assert np.ptp(np.concatenate(form.solids)[:, 2]) == pytest.approx(prisms.SHEET, rel=1e-3)
    assert not any((each.max(axis=0)[:2] > 2).all() for each in form.solids)


def open_ell() -> Leaf:
    """An L without its upper lid."""
    points, faces = notched()
    is_lid = (points[faces][:, :, 2] == points[:, 2].max()).all(axis=1)
    return mesh_leaf(points, faces[~is_lid])


@pytest.mark.parametrize("moves", [False, True])
def test_open_mesh_collides_as_slabs_for_each_flat_side(moves: bool) -> None:
    form = solids_of(open_ell(), moves=moves)
    assert form.is_exact
    assert len(form.solids) == 8, "six sides, and two for the bottom, which is not convex"
    assert all(np.ptp(each, axis=0).min() == pytest.approx(prisms.SHEET, rel=1e-3) for each in form.solids)


def test_moving_open_mesh_of_many_flat_sides_collides_as_its_hull(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solids, "MOST_MOVING", 7)
    form = solids_of(open_ell(), moves=True)
    assert not form.is_exact
    assert len(form.solids) == 1


def moving_bowl() -> Form:
    return solids_of(mesh_leaf(*bowl(3, 8)), moves=True)


@pytest.fixture
def cache(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> pytest.MonkeyPatch:
    """A cache of the test's own, in which nothing is yet, as in this process."""
    monkeypatch.delenv("SIMX_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
    monkeypatch.setattr(decomposition, "_known", {})
    return monkeypatch


@needs_library
def test_parts_are_found_once_kept_and_the_same_each_time(
    cache: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    first = moving_bowl()
    assert first.is_exact
    assert len(first.solids) > 3, "the library leaves the bowl open"
    cache.setattr(decomposition, "_PROGRAM", "no_such_program")
    assert equal(first, moving_bowl()), "remembered by the process"
    cache.setattr(decomposition, "_known", {})
    assert equal(first, moving_bowl()), "kept on the disk"
    assert not any("could not be" in each.getMessage() for each in caplog.records)
    (entry,) = part_cache.folder().iterdir()
    for content in (b"", b"\x80\x04pickled", entry.read_bytes()[:-4] + b"\0\0\xc0\x7f"):
        entry.write_bytes(content)
        cache.setattr(decomposition, "_known", {})
        assert not moving_bowl().is_exact, "a damaged entry is ignored"


@needs_library
def test_library_that_crashes_or_takes_too_long_leaves_a_hull_and_a_warning(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    for name, value in (("SECONDS", 0.01), ("_PROGRAM", "no_such_program")):
        with monkeypatch.context() as patch:
            patch.setenv("SIMX_CACHE", "0")
            patch.setattr(decomposition, "_known", {})
            patch.setattr(decomposition, name, value)
            form = moving_bowl()
        assert not form.is_exact
        assert len(form.solids) == 1
    assert sum("could not be decomposed" in each.getMessage() for each in caplog.records) == 2


def test_a_mesh_that_asks_for_too_many_cuts_is_decomposed_more_coarsely(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[str] = []

    def start(command: list[str], **_: Any) -> list[str]:
        asked.append(command[-1])
        return command

    def answer_of(command: list[str], *_: Any) -> bytes:
        if len(asked) < 3:
            raise subprocess.CalledProcessError(decomposing.TOO_MUCH, command)
        answer = io.BytesIO()
        np.savez(answer, cube()[0])
        return answer.getvalue()

    monkeypatch.setattr(decomposition, "is_available", lambda: True)
    monkeypatch.setattr(decomposition, "stored", lambda _key: None)
    monkeypatch.setattr(decomposition, "store", lambda _key, _parts: None)
    monkeypatch.setattr(decomposition, "_known", {})
    monkeypatch.setattr(decomposition, "_rules", lambda thresholds: repr(thresholds).encode())
    monkeypatch.setattr(subprocess, "Popen", start)
    monkeypatch.setattr(decomposition, "answer_of", answer_of)
    parts = decomposition.decompose(*bowl())
    assert parts is not None
    assert len(parts) == 1
    assert asked == [str(each) for each in decomposing.THRESHOLDS]


def test_a_mesh_larger_than_a_pipe_reaches_the_process_that_starts_slowly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = "import sys, numpy as np; np.savez(sys.stdout.buffer, np.array([len(sys.stdin.buffer.read())]))"
    start = subprocess.Popen
    monkeypatch.setattr(
        subprocess, "Popen", lambda _, **options: start([sys.executable, "-c", program], **options)
    )
    monkeypatch.setattr(decomposition, "_GLANCE", 0.001)  # the first look is before the process reads
    monkeypatch.setattr(decomposition, "SECONDS", 30)
    (found,) = decomposition._within_work(bytes(1 << 20), lambda: True, (0.1,))
    assert found.tolist() == [1 << 20]


def test_work_is_counted_in_the_librarys_log(monkeypatch: pytest.MonkeyPatch) -> None:
    ended: list[int] = []
    monkeypatch.setattr(os, "_exit", ended.append)
    most = decomposing.MOST_PIECES
    decomposing.limit_work(
        io.BytesIO(b"[info] iter 0 ---- waiting pool: 1\n[info] waiting pool: %d\n" % most)
    )
    assert not ended
    decomposing.limit_work(io.BytesIO(b"[info] iter 6 ---- waiting pool: %d\n" % (most + 1)))
    assert ended == [decomposing.TOO_MUCH]


def test_meshes_beyond_the_work_of_a_file_are_decomposed_coarsely() -> None:
    budget = decomposition.Budget()
    assert budget.thresholds(decomposition.MOST_IN_FILE) == decomposing.THRESHOLDS
    assert not budget.is_spent
    assert budget.thresholds(1) == decomposing.THRESHOLDS[-1:]
    assert budget.is_spent
