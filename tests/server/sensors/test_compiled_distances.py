"""The compiled search for the distance of two surfaces and the one in Python give the same numbers, bit for bit."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes_for_tests import world_of
from seeds import many, seeds

from simx_server.scene.geometry.triangles import Array
from simx_server.sensors.distance.box_tree import BoxTree, Placed
from simx_server.sensors.distance.meeting import GeomPairs, geoms_meet
from simx_server.sensors.distance.native import loading
from simx_server.sensors.distance.triangle_pairs import Found, come_within, least_gap

if loading.form().module is None:
    pytest.skip(f"distances are not compiled: {loading.form().reason}", allow_module_level=True)

from simx_server.sensors.distance.native import _triangle_pairs as compiled

Random = np.random.Generator


def turn(random: Random) -> Array:
    return np.linalg.qr(random.normal(size=(3, 3)))[0]


def blob(random: Random) -> Array:
    """A ball with dents, of some hundred to some thousand triangles."""
    rings = int(random.integers(8, 40))
    a, b = np.meshgrid(np.linspace(0, math.pi, rings + 1), np.linspace(0, 2 * math.pi, 2 * rings + 1))
    radius = 1 + random.uniform(0, 0.4) * np.sin(5 * b) * np.sin(a)
    points = np.stack([radius * np.sin(a) * np.cos(b), radius * np.sin(a) * np.sin(b), np.cos(a)], axis=-1)
    return grid(points)


def grid(points: Array) -> Array:
    """The triangles between points (n, m, 3); those at the poles of a ball are degenerate."""
    p, q, r, s = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate(
        [np.stack([p, q, r], 2).reshape(-1, 3, 3), np.stack([p, r, s], 2).reshape(-1, 3, 3)]
    )


def sheet(random: Random) -> Array:
    """A flat sheet: many of its triangles are equally far from another one."""
    across = int(random.integers(2, 30))
    x, y = np.meshgrid(np.linspace(-1, 1, across), np.linspace(-1, 1, across))
    return grid(np.stack([x, y, np.zeros_like(x)], axis=-1))


def soup(random: Random) -> Array:
    """Triangles of all sizes, which lie anywhere."""
    count = int(random.integers(1, 400))
    return random.normal(size=(count, 1, 3)) + random.normal(size=(count, 3, 3)) * random.uniform(
        0, 1, (count, 1, 1)
    )


SHAPES: tuple[Callable[[Random], Array], ...] = (blob, sheet, soup)


def numbers(found: Found) -> tuple[object, ...]:
    gap = found.gap
    return gap.distance, gap.first.tobytes(), gap.second.tobytes(), found.pair


def in_both_forms(
    monkeypatch: pytest.MonkeyPatch,
    first: Placed,
    second: Placed,
    limit: float,
    guess: tuple[int, int] | None = None,
) -> Found:
    """Return what both forms find."""
    found: list[Found] = []
    for form in ("python", ""):
        monkeypatch.setenv(loading.VARIABLE, form)
        found.append(least_gap(first, second, limit, guess))
    in_python, in_c = found
    assert numbers(in_c) == numbers(in_python)
    return in_c


@pytest.mark.parametrize("seed", seeds(10))
def test_both_forms_find_the_same_distance_points_and_triangles(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    random = np.random.default_rng(seed)
    one, other = (SHAPES[int(random.integers(len(SHAPES)))](random) for _ in range(2))
    scale = 10.0 ** random.integers(-3, 3)
    trees = BoxTree(one * scale), BoxTree(other * scale)
    guess: tuple[int, int] | None = None
    place = random.normal(size=3) * scale * random.uniform(0.5, 4)
    first = Placed(trees[0], turn(random), random.normal(size=3) * scale)
    second = Placed(trees[1], turn(random), place)
    for _ in range(4):
        found = in_both_forms(monkeypatch, first, second, 1e6, guess)
        in_both_forms(monkeypatch, first, second, found.gap.distance * random.uniform(0.5, 2), guess)
        guess = found.pair
        second = second._replace(place=second.place + random.normal(size=3) * 0.02 * scale)


def test_both_forms_take_surfaces_without_triangles_and_triangles_without_an_area(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    none, point = BoxTree(np.zeros((0, 3, 3))), BoxTree(np.ones((3, 3, 3)))
    sheets = BoxTree(sheet(np.random.default_rng(0)))
    placed = [Placed(tree, np.eye(3), np.zeros(3)) for tree in (none, point, sheets)]
    for first in placed:
        for second in placed:
            in_both_forms(monkeypatch, first, second, 9.0)
    assert in_both_forms(monkeypatch, placed[2], placed[2], 9.0).gap.distance == 0.0


def test_both_forms_find_the_same_point_of_surfaces_that_meet(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(5)
    for _ in range(many(8)):
        first, second = (
            Placed(BoxTree(blob(random)), turn(random), random.normal(size=3) * 0.3) for _ in range(2)
        )
        guess = (int(random.integers(100)), int(random.integers(100)))
        assert in_both_forms(monkeypatch, first, second, 9.0, guess).gap.distance == 0.0


@pytest.mark.parametrize("seed", seeds(7))
def test_both_forms_agree_whether_surfaces_come_within_a_margin(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    random = np.random.default_rng(seed)
    one, other = (SHAPES[int(random.integers(len(SHAPES)))](random) for _ in range(2))
    scale = 10.0 ** random.integers(-3, 3)
    first = Placed(BoxTree(one * scale), turn(random), random.normal(size=3) * scale)
    second = Placed(BoxTree(other * scale), turn(random), random.normal(size=3) * scale * 2)
    for _ in range(4):
        distance = float(least_gap(first, second, 1e6).gap.distance)
        for margin in (0.0, 0.5 * distance, math.nextafter(distance, 0.0), distance, 1.5 * distance):
            for form in ("python", ""):
                monkeypatch.setenv(loading.VARIABLE, form)
                assert come_within(first, second, margin) is (distance <= margin)
        second = second._replace(place=second.place + random.normal(size=3) * 0.3 * scale)


def test_both_forms_agree_that_surfaces_meet_which_only_touch(monkeypatch: pytest.MonkeyPatch) -> None:
    sheets, none = BoxTree(sheet(np.random.default_rng(0))), BoxTree(np.zeros((0, 3, 3)))
    first = Placed(sheets, np.eye(3), np.zeros(3))
    for form in ("python", ""):
        monkeypatch.setenv(loading.VARIABLE, form)
        assert come_within(first, first._replace(place=np.array([2.0, 0.0, 0.0])), 0.0)
        assert not come_within(first, first._replace(place=np.array([0.0, 0.0, 1e-6])), 0.0)
        assert not come_within(first, Placed(none, np.eye(3), np.zeros(3)), 9.0)


def shapes(random: Random) -> str:
    """A scene of many shapes near each other, and planes that some of them touch."""
    bodies: list[str] = []
    for number in range(24):
        kind = random.choice(["box", "sphere", "capsule", "cylinder", "ellipsoid", "plane"])
        x, y, z = random.uniform(-1, 1, 3)
        a, b, c = random.uniform(-180, 180, 3)
        size = " ".join(str(each) for each in random.uniform(0.05, 0.4, 3))
        pose = f'pos="{x} {y} {z}" euler="{a} {b} {c}"'
        bodies.append(f'<body name="b{number}" {pose}><geom type="{kind}" size="{size}"/></body>')
    return f"<mujoco><worldbody>{''.join(bodies)}</worldbody></mujoco>"


@pytest.mark.parametrize("seed", seeds(5))
def test_both_forms_leave_out_the_same_pairs_and_none_that_meet(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "shapes.xml"
    file.write_text(shapes(np.random.default_rng(seed)), encoding="utf-8")
    instant = world_of(file).instants.now()
    first, second = np.triu_indices(instant.model.ngeom, 1)
    pairs = GeomPairs(instant, first, second)
    for margin in (0.0, 0.05):
        found: list[list[int]] = []
        for form in ("python", ""):
            monkeypatch.setenv(loading.VARIABLE, form)
            found.append(pairs.possible(instant, margin))
        assert found[0] == found[1]
        assert 0 < len(found[0]) < len(pairs)
        for pair in set(range(len(pairs))) - set(found[0]):
            geoms = pairs.geoms(pair)
            assert not geoms_meet(instant, *geoms, margin)


def test_pairs_of_geoms_that_do_not_fit_are_refused() -> None:
    one, other = np.array([0, 1]), np.array([1, 2])
    fits: list[Any] = [
        one,
        other,
        np.ones(2),
        np.zeros((3, 3)),
        np.zeros((3, 9)),
        np.ones((3, 6)),
        np.zeros(3, bool),
    ]
    possible: Any = compiled.possible_pairs
    assert possible(*fits, 0.0) == [0, 1]
    for number, wrong in (
        *((place, each[:-1]) for place, each in enumerate(fits)),
        *((place, each.astype(np.float32)) for place, each in enumerate(fits)),
        *((0, np.array(each)) for each in ([0, 3], [-1, 0])),
    ):
        with pytest.raises(ValueError, match="do not fit"):
            possible(*fits[:number], wrong, *fits[number + 1 :], 0.0)


def test_arrays_that_do_not_fit_are_refused() -> None:
    tree = BoxTree(sheet(np.random.default_rng(0)))
    fits = tree.corners, tree.boxes, np.eye(3), np.zeros(3)
    assert compiled.least_gap(*fits, *fits, 1.0, -1, -1)[0] == 0.0
    wrong = (
        (ValueError, (tree.corners, tree.boxes[:-1], np.eye(3), np.zeros(3))),
        (ValueError, (tree.corners[:-1], tree.boxes, np.eye(3), np.zeros(3))),
        (ValueError, (tree.corners, tree.boxes, np.eye(2), np.zeros(3))),
        (ValueError, (tree.corners, tree.boxes, np.eye(3), np.zeros(2))),
        (TypeError, (tree.corners, tree.boxes, np.eye(3, dtype=int), np.zeros(3))),
        (BufferError, (tree.corners, tree.boxes, np.ones((3, 6))[:, ::2], np.zeros(3))),
    )
    for error, arrays in wrong:
        with pytest.raises((error, ValueError)):
            compiled.least_gap(*fits, *arrays, 1.0, -1, -1)
        with pytest.raises((error, ValueError)):
            compiled.come_within(*fits, *arrays, 1.0)
    for pair in ((0, -1), (len(tree.corners), 0), (-2, 0)):
        with pytest.raises(IndexError):
            compiled.least_gap(*fits, *fits, 1.0, *pair)


def test_a_variable_leaves_the_compiled_form_unused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert loading.form().reason == "compiled"
    monkeypatch.setenv(loading.VARIABLE, "python")
    assert loading.form() == (None, "SIMX_TRIANGLE_PAIRS is python")
