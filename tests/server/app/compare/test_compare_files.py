"""Recorded runs as files, the alignment of times, tolerances, and the page."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from simx_client.protocol.cli.exit_codes import DIVERGED
from simx_server.app.compare.comparing import exit_code, tolerances_of
from simx_server.app.compare.departures import TOLERANCES, Tolerance, aligned, compare
from simx_server.app.compare.files import read_run, write_run
from simx_server.app.compare.page import page
from simx_server.app.compare.text import Names, lines, record
from simx_server.app.compare.trajectories import Call, Collector, Quantity, Run, Series
from simx_server.errors import CommandError

CUBE = Quantity("Link.001", "position")
HINGE = Quantity("hinge", "joint")
NAMES = Names("original", "here")


def run_of(joint: list[float], *, step: float = 0.05, calls: list[Call] | None = None) -> Run:
    times = np.array([step * (place + 1) for place in range(len(joint))])
    values = np.array(joint)[:, None]
    return Run({HINGE: Series(times, values)}, calls or [], True)


def test_a_run_that_is_written_is_read_again(tmp_path: Path) -> None:
    run = run_of([0.1, 0.2, 0.3], calls=[Call(0.05, "simxSetJointPosition", ["hinge", 0.5], True)])
    run.series[CUBE] = Series(np.array([0.05, 0.15]), np.array([[1.0, 2, 3], [4, 5, 6]]))
    write_run(tmp_path / "run.npz", run)
    again = read_run(tmp_path / "run.npz")
    assert again.series.keys() == run.series.keys()
    assert all(np.array_equal(again.series[each].times, run.series[each].times) for each in run.series)
    assert np.array_equal(again.series[CUBE].values, run.series[CUBE].values)
    assert (again.calls, again.steps) == (run.calls, True)


def test_a_table_of_poses_and_joints_is_a_run(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("time,Link.001.x,Link.001.y,Link.001.z,hinge.joint\n0,1,2,3,0.5\n0.05,4,5,6,\n")
    run = read_run(path)
    assert run.series[CUBE].values.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert run.series[HINGE].times.tolist() == [0], "an empty cell is no value"


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("a,b\n1,2\n", "no column 'time'"),
        ("time,hinge.jont\n0,1\n", "'hinge.jont' names no quantity"),
        ("time,cube.x,cube.y\n0,1,2\n", "has 2 of 3 columns"),
        ("time,hinge.joint\n0,1\n0,2\n", "times of 'hinge.joint' do not rise"),
        ("time,hinge.joint\n0,one\n", "could not convert"),
        ("time,hinge.joint\n0,1,2\n", "other numbers of columns"),
        ("time\n0\n", "has no quantity"),
        ("", "no column 'time'"),
    ],
)
def test_a_bad_table_is_refused_with_what_is_valid(tmp_path: Path, content: str, problem: str) -> None:
    path = tmp_path / "run.csv"
    path.write_text(content)
    with pytest.raises(CommandError, match=problem) as refused:
        read_run(path)
    assert "OBJECT.QUANTITY" in str(refused.value)


def test_arrays_of_objects_are_not_read(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    np.savez(path, **{"time": np.zeros(1), "hinge.joint": np.array([{}], dtype=object)})  # pyright: ignore
    with pytest.raises(CommandError, match="is no recorded run"):
        read_run(path)
    for calls in ("[1]", '{"calls": [[1, 2]]}'):
        np.savez(path, **{"time": np.zeros(1), "hinge.joint": np.zeros(1), "calls": np.array(calls)})  # pyright: ignore
        with pytest.raises(CommandError, match="is no recorded run"):
            read_run(path)
    (tmp_path / "text.npz").write_text("no archive")
    with pytest.raises(CommandError, match="is no recorded run"):
        read_run(tmp_path / "text.npz")
    with pytest.raises(CommandError, match="cannot be read"):
        read_run(tmp_path / "missing.npz")


def test_times_that_the_other_run_lacks_are_interpolated_within_usual_gaps() -> None:
    other = Series(np.array([0.0, 0.1, 0.2, 0.9, 1.0]), np.array([[0.0], [1], [2], [9], [10]]))
    places, values = aligned(np.array([-0.1, 0.0, 0.05, 0.2, 0.5, 0.95, 1.1]), other)
    assert places.tolist() == [1, 2, 3, 5]
    assert values[:, 0] == pytest.approx([0.0, 0.5, 2.0, 9.5])


def test_runs_with_other_steps_are_compared_at_common_times() -> None:
    ramp = [0.1 * number for number in range(1, 41)]
    assert compare(run_of(ramp[:20]), run_of([each / 2 for each in ramp], step=0.025)).is_equal


def test_a_run_that_ends_early_is_not_equal() -> None:
    course = [0.1 * number for number in range(20)]
    found = compare(run_of(course), run_of(course[:9]))
    assert (found.is_equal, exit_code(found), record(found)["ends_early"]) == (False, DIVERGED, True)
    text = "\n".join(lines(found, NAMES))
    assert "ends early: here at 0.450 s, original at 1.000 s" in text
    assert "equal: " not in text
    assert compare(run_of(course[:9]), run_of(course)).is_equal, "a recorded part"
    assert compare(run_of(course), run_of(course[:18])).is_equal, "two steps"
    assert compare(run_of(course), run_of(course[:9]), steps=False).is_equal, "no steps of the program"


def test_the_first_time_above_the_tolerance_counts_and_the_largest_is_told() -> None:
    found = compare(run_of([0.0, 0.0, 0.0, 0.0]), run_of([0.0, 0.004, 0.02, 0.5]))
    (departure,) = found.departures
    assert departure.time == pytest.approx(0.15)
    assert (departure.size, departure.largest) == (pytest.approx(0.02), pytest.approx(0.5))
    assert departure.largest_time == pytest.approx(0.2)
    assert "departs first: hinge joint at 0.150 s, by 0.02 rad or m" in "\n".join(lines(found, NAMES))


def test_a_turn_more_is_the_same_angle_and_a_negated_quaternion_the_same_orientation() -> None:
    assert compare(run_of([math.pi - 0.001]), run_of([-math.pi + 0.001])).is_equal
    turn = Quantity("cube", "orientation")
    one = Run({turn: Series(np.array([0.0]), np.array([[0.6, 0.8, 0, 0]]))})
    other = Run({turn: Series(np.array([0.0]), np.array([[-0.6, -0.8, 0, 0]]))})
    assert compare(one, other).is_equal


def test_nothing_in_common_is_not_equal() -> None:
    found = compare(run_of([1.0]), Run({CUBE: Series(np.array([0.0]), np.zeros((1, 3)))}))
    assert not found.is_equal
    assert (found.only_one, found.only_other) == (["hinge"], ["Link.001"])
    assert "nothing to compare" in "\n".join(lines(found, NAMES))


def test_the_first_call_that_changes_something_else_is_named() -> None:
    def run(target: float, reads: int) -> Run:
        look = Call(0.0, "simxGetJointPosition", ["hinge"], False)
        move = Call(0.1, "simxSetJointTargetPosition", ["hinge", target], True)
        return run_of([0.0], calls=[*[look] * reads, move])

    assert compare(run(0.5, 1), run(0.5, 3)).calls is None, "reads do not count"
    departed = compare(run(0.5, 1), run(0.75, 1)).calls
    assert departed is not None
    assert departed.number == 1
    text = "\n".join(lines(compare(run(0.5, 1), run(0.75, 1)), NAMES))
    assert "here: simxSetJointTargetPosition('hinge', 0.75) at 0.100 s" in text


def test_tolerances_are_chosen_by_name() -> None:
    chosen = tolerances_of(["position=0.5"])
    assert chosen == {**TOLERANCES, "position": Tolerance(0.5)}
    with pytest.raises(CommandError, match=r"no tolerance 'positon'.*valid are position"):
        tolerances_of(["positon=1"])
    with pytest.raises(CommandError, match="not 'far'"):
        tolerances_of(["position=far"])
    loose = tolerances_of(["joint=1"])
    assert compare(run_of([0.0]), run_of([0.5]), loose).is_equal


def test_the_page_has_a_plot_of_what_departs_and_stands_alone() -> None:
    one, other = run_of([0.0, 0.1, 0.2]), run_of([0.0, 0.1, 0.9])
    one.series[Quantity("<b>", "joint")] = other.series[Quantity("<b>", "joint")] = one.series[HINGE]
    text = page("a & b", compare(one, other), (one, other), NAMES)
    assert "<h3>hinge joint, rad or m</h3><svg" in text
    assert text.count("<polyline") == 4
    assert 'class="mark"' in text
    assert "a &amp; b" in text
    assert "<b>" not in text
    assert not any(word in text for word in ("http:", "https:", "src=", "<script"))


def test_programs_get_a_record() -> None:
    told = record(compare(run_of([0.0, 0.0]), run_of([0.0, 0.5])))
    assert told["equal"] is False
    assert told["departures"][0]["object"] == "hinge"
    assert told["departures"][0]["time"] == pytest.approx(0.1)


def test_states_of_a_stopped_simulation_count_before_the_run_only() -> None:
    collector = Collector()
    for time, value in ((0.0, 1.0), (0.05, 2.0), (0.1, 3.0), (0.0, 1.0), (0.05, 5.0)):
        known = collector.at(time)
        if known is not None:
            collector.add(known, [(HINGE, [value])])
    series = collector.run().series[HINGE]
    assert series.times == pytest.approx([0.0, 0.05, 0.1, 0.15])
    assert series.values[:, 0].tolist() == [1, 2, 3, 5]
