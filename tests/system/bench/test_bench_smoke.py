"""The benchmark's pieces run, and its report says what it should. Nothing here depends on how fast anything is.

Those that start several servers: `bench/checks`.
"""

from __future__ import annotations

import importlib
import importlib.util
import itertools
import os
import subprocess
import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path

import cv2
import pytest

from bench import __main__ as bench
from bench.calls import (
    blocking,
    embedded,
    original,
    stepping,
)
from bench.measuring import baselines, drawing_bars, measure, plot, processes, scheduling
from bench.measuring.bars import Bar, Bars
from bench.measuring.machine import Watch, description
from bench.measuring.measure import (
    Effort,
    Rounds,
    difference,
    in_turn,
    percentile,
    ratio,
    repeated,
    side_by_side,
)
from bench.measuring.report import (
    Findings,
    Grid,
    Panel,
    Plot,
    Ratio,
    Rival,
    Row,
    bars_of,
    compose,
    details,
)
from bench.ros2 import steps
from bench.world import bursts, edits, scenes, sensors, step

pytestmark = [pytest.mark.slow, pytest.mark.system, pytest.mark.gl]

TINY = Effort(sets=1, rounds=1, factor=0.02, least=1)


def rounds(*medians: float) -> Rounds:
    return Rounds(tuple((value,) for value in medians))


def test_percentiles_are_values_that_were_measured() -> None:
    assert percentile([5.0, 1.0, 3.0], 50) == 3.0
    assert percentile(list(range(1000)), 99) == 990


def test_no_values_have_no_percentile() -> None:
    with pytest.raises(ValueError, match="nothing was measured"):
        percentile([], 99)


def test_a_ratio_is_taken_round_by_round_so_that_drift_cancels() -> None:
    assert ratio(rounds(2.0, 20.0, 200.0), rounds(1.0, 10.0, 100.0)) == 2.0
    assert difference(rounds(3.0, 13.0), rounds(1.0, 11.0)).median == 2.0


def test_cases_take_turns_in_alternating_order() -> None:
    order: list[str] = []

    def case(name: str) -> tuple[float, ...]:
        order.append(name)
        return (1.0,)

    in_turn("order", {"a": lambda: case("a"), "b": lambda: case("b")}, rounds=3)
    assert "".join(order) == "abbaab"


def test_warm_up_calls_are_made_but_not_counted() -> None:
    calls = itertools.count()
    taken = side_by_side("count", {"a": lambda: next(calls)}, rounds=2, calls=20)
    assert taken["a"].count == 40
    assert next(calls) == 44


def test_rounds_of_several_process_sets_are_put_together() -> None:
    numbers = itertools.count()

    def one_set(stack: ExitStack) -> dict[str, Rounds]:
        return {"a": rounds(float(next(numbers)))}

    assert repeated(3, one_set)["a"].values == ((0.0,), (1.0,), (2.0,))


FOUND = Findings(
    "Calls, and more",
    "Calls",
    [Ratio("kept", 1.2, target=1.5), Ratio("broken", 1.7, target=1.5), Ratio("told", 3.0)],
    [Row.of("a call", Rounds(((1e-6, 2e-6, 3e-6),)), "us"), Row.of("a start", rounds(0.25), "ms")],
    ["a note"],
    [Grid(("clients", "us"), [("8", [12.5]), ("64", [None])])],
    [Plot("calls", [])],
    [Rival("a read, us", {"simx": 3.0, "the rival": 44.0})],
)


def lines_of(page: str) -> dict[str, str]:
    """The lines of the page's tables by their first cell; the last one of a name."""
    return {line.split("|")[1].strip(): line for line in page.splitlines() if line.startswith("| ")}


def test_the_report_is_a_summary_of_aims_by_topic_beside_the_rivals() -> None:
    other = Findings("Start", "Memory", [Ratio("large", 80.0, "MB", 100.0)])
    report = compose([FOUND, other], conditions=["a run"])
    lines = lines_of(report)
    assert "yes" in lines["kept"]
    assert "**no**" in lines["broken"]
    assert "told" not in lines
    assert "2 of 3 are kept" in report
    assert "1 of 2" in lines["Calls"]
    assert "broken: 1.13" in lines["Calls"]
    assert "1 of 1" in lines["Memory"]
    assert report.index("### Calls") < report.index("| broken") < report.index("### Memory")
    assert "44.0" in lines["the rival"]
    assert "![rivals](plots/rivals.png)" in report
    assert "- a run" in report


def test_the_second_page_has_all_figures() -> None:
    page = details([FOUND], conditions=["a run"])
    lines = lines_of(page)
    assert "3.00" in lines["told"]
    assert "2.00" in lines["a call"]
    assert "250" in lines["a start"]
    assert "12.5" in lines["8"]
    assert "[Calls, and more](#calls-and-more)" in page
    assert "![calls](plots/calls.png)" in page
    assert "- a note" in page
    assert "- a run" in page


def test_without_rivals_and_aims_the_report_says_on_what_it_was_made() -> None:
    report = compose([Findings("Nothing")], conditions=["a run"])
    assert "- a run" in report
    assert "Rivals" not in report
    assert bars_of([Findings("Nothing")]) is None


def test_a_bar_chart_has_a_line_for_each_rival(tmp_path: Path) -> None:
    bars = bars_of([FOUND])
    assert bars is not None
    assert bars == Bars("rivals", [("a read, us", [Bar("simx", 3.0, True), Bar("the rival", 44.0, False)])])
    picture = cv2.imread(str(drawing_bars.draw_bars(tmp_path / "plots", bars)))
    assert picture is not None
    assert picture.shape[1] == drawing_bars.WIDTH
    assert picture.shape[0] >= 2 * drawing_bars.LINE


def test_a_disturbed_turn_is_repeated_and_the_quietest_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    shares = iter([0.0, 0.9, 0.1, 0.0])
    watch = scheduling.Disturbance()
    monkeypatch.setattr(measure, "DISTURBANCE", watch)
    monkeypatch.setattr(watch, "share", lambda _: next(shares))
    monkeypatch.setattr(watch, "may_repeat", lambda _: True)
    numbers = itertools.count()
    taken = in_turn("turns", {"a": lambda: (float(next(numbers)),)}, rounds=3)
    assert taken["a"].values == ((0.0,), (2.0,), (3.0,))
    assert (watch.turns, watch.repeated, watch.disturbed) == (3, 1, 0)


def test_repetitions_have_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    watch = scheduling.Disturbance()
    monkeypatch.setattr(measure, "DISTURBANCE", watch)
    monkeypatch.setattr(watch, "share", lambda _: 1.0)
    monkeypatch.setattr(watch, "may_repeat", lambda _: True)
    numbers = itertools.count()
    taken = in_turn("turns", {"a": lambda: (float(next(numbers)),)}, rounds=3)
    assert len(taken["a"].values) == 3
    assert next(numbers) == 6
    assert watch.disturbed == 3


def test_processor_time_of_a_child_is_of_this_run() -> None:
    before = scheduling.own_seconds()
    with subprocess.Popen(
        [sys.executable, "-c", "while sum(__import__('os').times()[:2]) < 0.3: pass\ninput()"],
        stdin=subprocess.PIPE,
        text=True,
    ) as child:
        deadline = time.monotonic() + 60
        while scheduling.own_seconds() < before + 0.2 and time.monotonic() < deadline:
            os.sched_yield()
        assert scheduling.own_seconds() >= before + 0.2
        child.kill()


def test_the_clock_and_the_scheduling_are_told() -> None:
    told = "\n".join(scheduling.scheduling())
    for word in ("clock", "cores used", "governor", "scheduling", "autogroup"):
        assert word in told


def test_the_report_says_on_what_and_beside_what_load_it_was_made() -> None:
    told = "\n".join([*description(), *Watch().lines()])
    for word in (
        "cores",
        "GB of memory",
        "mujoco",
        "eclipse-zenoh",
        "at the beginning",
        "hypervisor",
        "million in a second",
    ):
        assert word in told


def test_a_plot_is_a_small_image_of_its_panels(tmp_path: Path) -> None:
    curve = [(1.0, 3.0), (2.0, 30.0), (64.0, 0.5)]
    panels = [
        Panel("a", "x", {"cost": curve}, {"least": [(1.0, 0.0)]}),
        Panel("b", "x", {"cost": curve}, {}, True),
    ]
    file = plot.draw(tmp_path / "plots", Plot("both", panels))
    picture = cv2.imread(str(file))
    assert picture is not None
    assert picture.shape == (plot.HEIGHT, 2 * plot.WIDTH, 3)
    assert file.stat().st_size < 40_000
    assert plot.steps(7.3) == [0, 1, 2, 3, 4, 5, 6, 7, 8]
    assert plot.decades(3, 400) == [1, 10, 100, 1000]


@pytest.mark.parametrize(
    ("far", "near"),
    [
        (baselines.QUERY, baselines.Query),
        (baselines.PUBLICATIONS, baselines.Publications),
        (baselines.TCP, baselines.Tcp),
    ],
)
def test_a_baseline_answers_small_and_large_and_leaves(far: str, near: type) -> None:
    with processes.baseline(far) as running, closing(near(running.port)) as end:
        for size in (31, 300_000):
            assert len(end.exchange(baselines.request_of(39, size))) == size
    with pytest.raises(ProcessLookupError):
        os.kill(running.process_id, 0)


def test_a_process_that_fails_is_told_with_its_last_words() -> None:
    with pytest.raises(processes.NotReady, match="not a port"), processes.server("--port", "not a port"):
        pass


@pytest.fixture
def without_opengl(monkeypatch: pytest.MonkeyPatch) -> None:
    """No server looks for it."""
    monkeypatch.setenv("MUJOCO_GL", "disable")


@pytest.mark.usefixtures("without_opengl")
def test_blocking_reads_are_measured_beside_their_baselines() -> None:
    found = blocking.measure(TINY)
    assert {row.what for row in found.rows} == {
        f"{what}, {state}"
        for what in (blocking.READ, blocking.BURST, blocking.QUERY, blocking.PUBLICATIONS, blocking.TCP)
        for state in (blocking.STOPPED, blocking.RUNNING)
    }
    bounds = [blocking.TARGET, None, None, blocking.TARGET_P99, blocking.TARGET_BURST, None]
    assert [ratio.target for ratio in found.ratios] == 2 * bounds


@pytest.mark.usefixtures("without_opengl")
def test_steps_are_measured_beside_the_same_physics() -> None:
    found = stepping.measure(TINY)
    told = {row.what for row in found.rows}
    assert {stepping.TARGET, 1 / stepping.SHARE_OF_RATE} <= {ratio.target for ratio in found.ratios}
    assert {stepping.TRIGGER, stepping.LOOP, stepping.STEPS, stepping.PASS} <= told


def test_a_scene_is_measured_beside_its_physics(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenes, "list_scenes", lambda: ["stock_kinect"])
    found = scenes.measure(TINY)
    assert [ratio.target for ratio in found.ratios] == [scenes.MOST, None]
    [(name, figures)] = found.grids[0].lines
    assert name == "stock_kinect"
    assert all(figure and figure > 0 for figure in figures)


def test_a_ring_of_sensors_is_measured_beside_the_bare_step() -> None:
    found = sensors.measure(TINY)
    assert {sensors.PASS, sensors.ONE, sensors.RING, sensors.RING_ALONE} <= {row.what for row in found.rows}


def test_embedded_calls_are_measured_beside_bare_physics() -> None:
    found = embedded.measure(TINY)
    assert {embedded.READ, embedded.RESET} <= {row.what for row in found.rows}
    assert all(one.value > 0 for one in found.ratios)
    assert len(found.ratios) >= len(embedded.SHARES)


def test_the_dearest_edit_of_each_scene_is_an_aim(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(edits, "SIZES", ((60, 0), (60, 0), (60, 0), (60, 10)))
    found = edits.measure(TINY)
    assert [ratio.target for ratio in found.ratios if ratio.target] == 3 * [edits.MOST]


def test_bursts_of_edits_are_measured_with_their_compiles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bursts, "BODIES", 60)
    monkeypatch.setattr(bursts, "BURST", 10)
    found = bursts.measure(TINY)
    counts = [values[0] for what, values in found.grids[0].lines if what.endswith("compiles")]
    assert counts == len(bursts.BURSTS) * [1, bursts.BURST]
    assert {ratio.target for ratio in found.ratios} == {bursts.MOST}


def test_the_parts_of_a_step_beyond_mujoco_are_measured() -> None:
    found = step.measure(TINY)
    assert [ratio.target for ratio in found.ratios] == [step.FIXED, step.EACH, step.ARM, None]
    assert all(row.median > 0 for row in found.rows if row.what.endswith(" ms"))


def test_an_unknown_measurement_is_a_usage_error_that_lists_them(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        bench.main(["blokking"])
    assert left.value.code == 2
    message = capsys.readouterr().err
    assert all(name in message for name in bench.MEASUREMENTS)


def test_an_original_client_is_told_beside_the_limit_of_its_protocol() -> None:
    found = original.measure(TINY)
    assert [row.what for row in found.rows] == [original.PACED, original.LIMIT, original.BARE, original.TCP]
    assert [each.target for each in found.ratios if each.target] == [original.TARGET]


@pytest.mark.parametrize("module", bench.MEASUREMENTS.values())
def test_every_measurement_has_its_function(module: str) -> None:
    assert callable(importlib.import_module(module).measure)


def test_a_node_of_ros_2_is_measured_with_and_without_a_listener() -> None:
    found = steps.measure(TINY)
    told = {row.what: row.median for row in found.rows}
    assert all(told[case] > 0 for case in (steps.STEP, steps.SILENT, steps.HEARD))
    assert [each.target for each in found.ratios] == [steps.TARGET_US, None]
