"""The class Path of API 2: points, distances, places along the way, markers and shapes."""

from __future__ import annotations

import math
from typing import Any

import pytest
from model_world import Model, model

from simx_server.errors import CommandError
from simx_server.sim_api.object_model.values import Matrix, Ref

__all__ = ["model"]

SQUARE = Matrix(2, 4, [0, 1, 1, 0, 0, 0, 1, 1])
"""Corners of a square as columns."""


def made(model: Model, points: Any, **options: Any) -> Ref:
    return model.do("app", "Path", points, options)


def numbers(value: Matrix) -> list[float]:
    return value.numbers


def test_a_path_of_lines_is_measured_along_its_points(model: Model) -> None:
    path = made(model, SQUARE, pathPoints={"type": "linear", "samplingDistance": 0.5})
    data = model.do(path, "data")
    assert data["opt"]["types"] == ["lin", "lin"]
    assert data["ctrlPoints"]["points"] == SQUARE
    assert data["ctrlPoints"]["pathLength"] == pytest.approx(3.0)
    assert numbers(data["ctrlPoints"]["distancesAlongPath"]) == pytest.approx([0, 1, 2, 3])
    assert data["pathPoints"]["points"].columns == 8
    assert numbers(model.do(path, "getPoint", 0.5)) == pytest.approx([1.0, 0.5], abs=0.1)
    assert numbers(model.do(path, "getPoint", 2.0)) == [0.0, 1.0]


def test_a_closed_path_leads_back_to_its_start(model: Model) -> None:
    path = made(model, SQUARE, closed=True, closedRepeatsStart=True, onlyCtrlPoints=True)
    data = model.do(path, "data")
    assert data["ctrlPoints"]["pathLength"] == pytest.approx(4.0)
    assert data["ctrlPoints"]["points"].columns == 5
    assert numbers(model.do(path, "getPoint", 0.875)) == pytest.approx([0.0, 0.5])
    point, share = model.do(path, "closest", [-0.2, 0.25])
    assert numbers(point) == pytest.approx([0.0, 0.25], abs=1e-6)
    assert share == pytest.approx(0.9375)


def test_a_curve_rounds_the_corners(model: Model) -> None:
    path = made(model, SQUARE, pathPoints={"samplingDistance": 0.1})
    data = model.do(path, "data")["pathPoints"]
    assert data["opt"]["type"] == "quadraticBezier"
    assert 2.0 < data["pathLength"] < 3.0
    assert max(numbers(data["arcLengths"])) <= 0.1 + 1e-9
    point, _ = model.do(path, "closest", [1.2, -0.2])
    assert math.dist(numbers(point), (1.0, 0.0)) == pytest.approx(0.25 * math.sqrt(2) - 0.0, abs=0.2)
    assert numbers(model.do(path, "getPoint", 1)) == pytest.approx([0.0, 1.0])


def test_points_that_are_nearly_equal_or_in_a_line_are_left_out(model: Model) -> None:
    near = Matrix(1, 5, [0.0, 0.001, 0.5, 0.999, 1.0])
    data = model.do(made(model, near, onlyCtrlPoints=True), "data")
    assert numbers(data["ctrlPoints"]["points"]) == [0.0, 0.5, 1.0]
    line = Matrix(2, 6, [0, 1, 2, 3, 4, 5] + [0.0] * 6)
    straight = model.do(made(model, line, onlyCtrlPoints=True), "data")["ctrlPoints"]["points"]
    assert straight.columns < 6
    kept = made(model, line, onlyCtrlPoints=True, ctrlPoints={"linearityTolerance": 0})
    assert model.do(kept, "data")["ctrlPoints"]["points"] == line


def test_angles_take_the_shorter_way_unless_they_have_bounds(model: Model) -> None:
    cyclic = made(model, None, types=["ang"])
    assert model.do(cyclic, "distance", [3.0], [-3.0]) == pytest.approx(2 * math.pi - 6)
    assert abs(numbers(model.do(cyclic, "interpolate", [3.0], [-3.0], 0.5))[0]) == pytest.approx(math.pi)
    bounded = made(model, None, types=["ang"], bounds=[[-7.0, 7.0]], metric=[2.0])
    assert model.do(bounded, "distance", [3.0], [-3.0]) == pytest.approx(12.0)
    assert sorted(numbers(model.do(bounded, "configs", [3.0]))) == pytest.approx([3 - 2 * math.pi, 3.0])
    assert numbers(model.do(cyclic, "configs", [3.0])) == [3.0]


def test_quaternions_are_turned_by_the_smaller_angle(model: Model) -> None:
    path = made(model, None, types=["quat"] * 4)
    half = [0.0, 0.0, math.sin(0.5), math.cos(0.5)]
    assert model.do(path, "distance", [0, 0, 0, 1], half) == pytest.approx(1.0)
    middle = numbers(model.do(path, "interpolate", [0, 0, 0, -1], half, 0.5))
    assert abs(middle[2]) == pytest.approx(math.sin(0.25))


def test_points_are_appended_and_follow_later(model: Model) -> None:
    path = made(model, None, types=["lin", "lin"], onlyCtrlPoints=True)
    model.do(path, "appendPoints", SQUARE, False)
    assert model.do(path, "data")["ctrlPoints"]["points"] == SQUARE
    model.do(path, "clearPoints")
    with pytest.raises(CommandError, match="empty"):
        model.do(path, "getPoint", 0.5)


def test_a_path_is_taught_by_an_object_and_by_joints(model: Model) -> None:
    taught = model.do("app", "Path.fromObject", model.at("/cube"), {"onlyCtrlPoints": True})
    for place in ([0.0, 0, 1], [1.0, 0, 1], [1.001, 0, 1]):
        model.do("/cube", "setPosition", Matrix.vector(place))
        model.do(taught, "appendFromObject")
    assert model.do(taught, "data")["ctrlPoints"]["points"].columns == 2
    joints = model.do("app", "Path.fromJoints", model.at("/robot/hinge/arm/tip"), model.at("/robot"))
    for angle in (0.0, 1.0):
        model.set("/robot/hinge", "joint.position", angle)
        model.do(joints, "appendFromJoints")
    data = model.do(joints, "data")
    assert data["opt"]["bounds"] == [[-2.0, 2.0]]
    assert numbers(data["ctrlPoints"]["points"]) == [0.0, 1.0]
    markers = model.do(joints, "createMarkers")
    places = model.get(markers["ctrlPointMarkers"]["pointMarker"], "points")
    assert places.numbers[1::2] == pytest.approx([0.4 * math.cos(1), 0.4 * math.sin(1), 1.3], abs=1e-6)
    with pytest.raises(CommandError, match="not above"):
        model.do("app", "Path.fromJoints", model.at("/robot/hinge/arm/tip"), model.at("/wall"))


def test_markers_follow_the_points_and_go_with_the_path(model: Model) -> None:
    path = made(
        model, Matrix(3, 3, [0, 1, 1, 0, 0, 1, 0, 0, 0]), onlyCtrlPoints=True, ctrlPoints={"showAxes": True}
    )
    markers = model.do(path, "createMarkers")["ctrlPointMarkers"]
    assert model.get(markers["pointMarker"], "marker.type") == "cubes"
    assert model.get(markers["lineMarker"], "points").columns == 4
    assert model.get(markers["axesMarker"], "marker.type") == "lines"
    model.do(path, "setPoints", Matrix(3, 2, [0, 1, 0, 0, 0, 0]))
    assert model.get(markers["pointMarker"], "points").columns == 2
    model.do(path, "remove")
    assert not model.do(markers["pointMarker"], "isValid")
    assert not model.do(path, "isValid")


def test_a_shape_is_made_along_the_path(model: Model) -> None:
    path = made(model, Matrix(2, 2, [0, 1, 0, 0]), onlyCtrlPoints=True)
    shape = model.do(path, "createShape", {"section": Matrix(2, 3, [-0.1, 0.1, 0, 0, 0, 0.2])})
    assert model.get(shape, "type") == "shape"
    assert sorted(model.get(shape, "dimension").numbers) == pytest.approx([0.2, 0.2, 1.0], abs=1e-6)
    by_axis = model.do(path, "createShape", {"axis": 2})
    assert model.get(by_axis, "dimension").numbers == pytest.approx([1.0, 0.02, 0.02], abs=1e-6)


def test_a_path_travels_as_bytes(model: Model) -> None:
    path = made(model, SQUARE, closed=True, pathPoints={"samplingDistance": 0.1})
    content, objects = model.do(path, "toBuffer")
    again = model.do("app", "Path.fromBuffer", content, objects)
    assert model.do(again, "data") == model.do(path, "data")
    with pytest.raises(CommandError, match="not those of"):
        model.do("app", "Path.fromBuffer", model.do("app", "pack", [1, 2]))


@pytest.mark.parametrize(
    ("points", "options", "problem"),
    [
        (None, {}, "'types'"),
        (None, {"types": ["quat"] * 3}, "four consecutive"),
        (None, {"types": ["round"]}, "no type of a coordinate"),
        (None, {"types": ["lin"] * 101}, "1 to 100 coordinates"),
        (SQUARE, {"metric": [1.0]}, "item for each"),
        (SQUARE, {"bounds": [[2, 1], []]}, "bounds"),
        (SQUARE, {"pathPoints": {"type": "cubic"}}, "quadraticBezier"),
        (SQUARE, {"pathPoints": {"samplingDistance": 1e-9}}, "at most"),
        (Matrix(7, 1, [0.0] * 7), {}, "length 0"),
        (Matrix(1, 3000, [0.0] * 3000), {}, "at most 2000"),
    ],
)
def test_bad_paths_are_refused(model: Model, points: Any, options: dict[str, Any], problem: str) -> None:
    with pytest.raises(CommandError, match=problem):
        model.do("app", "Path", points, options)
