"""Motions along a path in the shortest time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sim_api_calls import ScriptWorld, world

from simx_server.parts.paths.splines import BOUNDARIES, cubic_spline
from simx_server.parts.paths.time_optimal import Limits, time_optimal

__all__ = ["world"]

KNOTS = np.array([0.0, 0.5, 1.2, 2.0, 2.4])
VALUES = np.array([[0.0, 1.0], [0.4, 0.2], [0.1, 0.9], [-0.5, 0.3], [0.0, 1.0]])


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("count", [3, 4, 5])
def test_splines_pass_their_points_smoothly_and_end_as_asked(boundary: str, count: int) -> None:
    values = VALUES[:count].copy()
    if boundary == "periodic":
        values[-1] = values[0]
    spline = cubic_spline(KNOTS[:count], values, boundary)
    value, first, second = spline.at(KNOTS[:count])
    assert value == pytest.approx(values)
    before, after = spline.at(KNOTS[1 : count - 1] - 1e-9), spline.at(KNOTS[1 : count - 1] + 1e-9)
    assert before[1] == pytest.approx(after[1], abs=1e-6)
    assert before[2] == pytest.approx(after[2], abs=1e-5)
    ends = spline.at(np.array([KNOTS[0], KNOTS[count - 1] - 1e-12]))
    if boundary == "clamped":
        assert ends[1] == pytest.approx(np.zeros((2, 2)), abs=1e-6)
    if boundary == "natural":
        assert ends[2] == pytest.approx(np.zeros((2, 2)), abs=1e-6)
    if boundary == "periodic":
        assert first[0] == pytest.approx(ends[1][1], abs=1e-6)
        assert second[0] == pytest.approx(ends[2][1], abs=1e-6)


def test_a_spline_through_points_of_a_cubic_is_that_cubic() -> None:
    spline = cubic_spline(KNOTS, KNOTS[:, None] ** 3 - KNOTS[:, None], "not-a-knot")
    at = np.linspace(0.0, 2.4, 30)
    assert spline.at(at)[0][:, 0] == pytest.approx(at**3 - at)


def test_a_line_takes_as_long_as_acceleration_and_velocity_allow() -> None:
    """2 m at most 1 m/s, 2 m/s² up and 1 m/s² down: 0.5 s and 1 s of it, 1.25 s between them."""
    spline = cubic_spline(np.array([0.0, 2.0]), np.array([[0.0], [2.0]]), "not-a-knot")
    points, times = time_optimal(
        spline, Limits(np.array([-9.0]), np.array([1.0])), Limits(np.array([-1.0]), np.array([2.0])), 500
    )
    assert times[-1] == pytest.approx(0.5 + 1.0 + 1.25, rel=1e-3)
    assert points[0] == pytest.approx([0.0])
    assert points[-1] == pytest.approx([2.0])


@pytest.mark.parametrize("seed", range(4))
def test_no_motion_exceeds_its_limits_and_one_limit_always_acts(seed: int) -> None:
    random = np.random.default_rng(seed)
    values = np.cumsum(random.normal(size=(7, 3)) * 0.3, axis=0)
    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(values, axis=0), axis=1))])
    fastest, strongest = Limits(-np.full(3, 1.0), np.full(3, 1.2)), Limits(-np.full(3, 3.0), np.full(3, 2.5))
    points, times = time_optimal(cubic_spline(knots, values, "not-a-knot"), fastest, strongest, 2000)
    velocity = np.diff(points, axis=0) / times[1]
    acceleration = np.diff(velocity, axis=0) / times[1]
    shares = np.max(
        [
            velocity[:-1] / fastest.upper,
            velocity[:-1] / fastest.lower,
            acceleration / strongest.upper,
            acceleration / strongest.lower,
        ],
        axis=(0, 2),
    )
    assert shares.max() < 1.02
    assert np.mean(shares > 0.9) > 0.9


def test_scripts_get_the_fastest_motion(world: ScriptWorld) -> None:
    world.lua("path = {0, 0,  1, 1,  2, 0} lengths = sim.getPathLengths(path, 2)")
    world.lua(
        "points, times, helper = sim.generateTimeOptimalTrajectory(path, lengths, {-1, 1, -1, 1}, {-2, 2, -2, 2}, 50)"
    )
    assert world.lua("return #points, #times, helper") == [100, 50, -1]
    assert world.value("times[50]") > 2.0
    assert world.value("points[99]") == pytest.approx(2.0)
    for limits, text in (
        ("{-1, 1}, {-1, 1, -1, 1}", "velocities are 4 finite numbers"),
        ("{0, 1, -1, 1}, {-1, 1, -1, 1}", "the least of the velocities are below 0"),
        ("{-1, 1, -1, 1}, {-1, 1, -1, 1}, 1", "samples are 2 to"),
        ("{-1, 1, -1, 1}, {-1, 1, -1, 1}, 9, 'odd'", "a boundary condition is not-a-knot, clamped"),
        ("{-1, 1, -1, 1}, {-1, 1, -1, 1}, 9, 'periodic'", "a periodic path has three points or more"),
    ):
        world.fails(f"sim.generateTimeOptimalTrajectory(path, lengths, {limits})", text)
    world.fails(
        "sim.generateTimeOptimalTrajectory(path, {0, 1, 1}, {-1, 1, -1, 1}, {-1, 1, -1, 1})",
        "lengths of the points of a path increase",
    )


def test_a_path_is_closed(world: ScriptWorld) -> None:
    path, times = world.lua("return sim.closePath({0, 0, 0,  3, 0, 0,  3, 4, 0}, {0, 3, 7})")
    assert path == [0, 0, 0, 3, 0, 0, 3, 4, 0, 0, 0, 0]
    assert times == pytest.approx([0, 3, 7, 7 + math.hypot(3, 4)])
