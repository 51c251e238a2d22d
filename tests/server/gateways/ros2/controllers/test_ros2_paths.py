"""Paths through the points of trajectories: ends, derivatives, and points that are not valid."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from simx_server.errors import CommandError
from simx_server.gateways.ros2.controllers import paths
from simx_server.gateways.ros2.controllers.paths import read_path

START = np.array([0.0, 0.0])


def point(seconds: float, positions: Any, velocities: Any = (), accelerations: Any = ()) -> dict[str, Any]:
    time = {"sec": int(seconds), "nanosec": round(seconds % 1 * 1e9)}
    return {
        "positions": np.array(positions),
        "velocities": np.array(velocities),
        "accelerations": np.array(accelerations),
        "time_from_start": time,
    }


def made(*points: dict[str, Any]) -> paths.Path:
    return read_path({"joint_names": ["a", "b"], "points": points}, START)


CASES = {
    "straight": [point(1, [1, 2]), point(3, [2, 0])],
    "cubic": [point(1, [1, 2], [0.5, 0]), point(3, [2, 0], [0, -1])],
    "quintic": [point(1, [1, 2], [0.5, 0], [1, 0]), point(3, [2, 0], [0, -1], [0, 2])],
}


@pytest.mark.parametrize("kind", CASES)
def test_a_path_goes_through_its_points_and_its_derivatives_belong_together(kind: str) -> None:
    path, small = made(*CASES[kind]), 1e-6
    for each in CASES[kind]:
        time = each["time_from_start"]["sec"]
        assert path.at(time - 1e-12).position == pytest.approx(each["positions"], abs=1e-9)
        if len(each["velocities"]):
            assert path.at(time - 1e-12).velocity == pytest.approx(each["velocities"], abs=1e-6)
        if len(each["accelerations"]):
            assert path.at(time - 1e-10).acceleration == pytest.approx(each["accelerations"], abs=1e-5)
    for time in (0.3, 1.7, 2.9):
        here, after = path.at(time), path.at(time + small)
        assert (after.position - here.position) / small == pytest.approx(here.velocity, abs=1e-4)
        assert (after.velocity - here.velocity) / small == pytest.approx(here.acceleration, abs=1e-4)
    assert [path.at(time).point for time in (0.5, 2, 9)] == [0, 0, 1]
    assert path.at(-5).position == pytest.approx(START)
    assert path.at(99).position == pytest.approx(path.goal)
    assert path.duration == 3


def test_a_first_point_at_the_start_is_where_the_path_starts() -> None:
    path = made(point(0, [5, 5]), point(2, [7, 5]))
    assert path.at(1).position == pytest.approx([6, 5])


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([], "no points"),
        ([point(1, [1])], "1 positions for 2 joints"),
        ([point(1, [])], "0 positions"),
        ([point(1, [1, 2], [3])], "1 velocities"),
        ([point(1, [1, float("nan")])], "not finite"),
        ([point(1, [1, 1e9])], "beyond"),
        ([point(2, [1, 2]), point(2, [1, 2])], "increase"),
        ([point(-1, [1, 2])], "not negative"),
        ([point(1, [1, 2])] * 10_001, "10001 points"),
    ],
)
def test_points_that_are_not_valid_are_refused(points: list[dict[str, Any]], said: str) -> None:
    with pytest.raises(CommandError, match=said):
        made(*points)
