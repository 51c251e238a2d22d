"""The benchmark's pieces run, and its report says what it should. Nothing here depends on how fast anything is."""

from __future__ import annotations

import importlib
import itertools
import os
from contextlib import ExitStack, closing
from pathlib import Path

import cv2
import pytest

from bench import __main__ as bench
from bench.calls import (
    batch,
    blocking,
    embedded,
    one_host,
    original,
    parts,
    stepping,
    streaming,
    values,
    worlds,
)
from bench.images import picture, rendering, sizes
from bench.load import classroom, clients, scale, servers, startup, view
from bench.measuring import baselines, plot, processes
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
from bench.measuring.report import Findings, Grid, Panel, Plot, Ratio, Row, compose
from bench.world import scenes, sensors, vrep_files
from simx_server.viewer.launching import missing

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


def test_the_report_begins_with_the_aims_and_marks_broken_ones() -> None:
    found = Findings(
        "Calls, and more",
        [Ratio("kept", 1.2, target=1.5), Ratio("broken", 1.7, target=1.5), Ratio("told", 3.0)],
        [Row.of("a call", Rounds(((1e-6, 2e-6, 3e-6),)), "us"), Row.of("a start", rounds(0.25), "ms")],
        ["a note"],
        [Grid(("clients", "us"), [("8", [12.5]), ("64", [None])])],
        [Plot("calls", [])],
    )
    report = compose([found], conditions=["a run"])
    lines = {line.split("|")[1].strip(): line for line in report.splitlines() if line.startswith("| ")}
    assert "yes" in lines["kept"]
    assert "**no**" in lines["broken"]
    assert "yes" not in lines["told"]
    assert "2.00" in lines["a call"]
    assert "250" in lines["a start"]
    assert "12.5" in lines["8"]
    assert "1 of 2 are kept" in report
    assert report.index("## Aims") < report.index("broken") < report.index("## Calls") < report.index("told")
    assert "[Calls, and more](#calls-and-more)" in report
    assert "![calls](plots/calls.png)" in report
    assert "- a note" in report
    assert "- a run" in report


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


def test_a_plot_is_a_small_picture_of_its_panels(tmp_path: Path) -> None:
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
    burst = blocking.TARGET_BURST
    bounds = [blocking.TARGET, None, None, blocking.TARGET_P99, burst, burst * blocking.TARGET]
    assert [ratio.target for ratio in found.ratios] == 2 * bounds


@pytest.mark.usefixtures("without_opengl")
def test_streams_are_measured_at_both_speeds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "CLIENTS", 2)
    monkeypatch.setattr(streaming, "VALUES", 5)
    found = streaming.measure(TINY)
    told = {row.what for row in found.rows}
    assert {streaming.READ, streaming.SET, streaming.PUT} <= told
    assert {f"{streaming.AGE}, speed {speed}" for speed in ("1", "max")} <= told
    assert {streaming.SHARE, streaming.SHARE_ALONE} <= told
    assert found.ratios[-1].target == streaming.TARGET_SHARE


@pytest.mark.usefixtures("without_opengl")
def test_steps_are_measured_beside_the_same_physics() -> None:
    found = stepping.measure(TINY)
    told = {row.what for row in found.rows}
    assert {stepping.TARGET, 1 / stepping.SHARE_OF_RATE} <= {ratio.target for ratio in found.ratios}
    assert {stepping.TRIGGER, stepping.LOOP, stepping.STEPS, stepping.PASS} <= told


@pytest.mark.usefixtures("without_opengl")
def test_many_servers_are_measured_beside_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "COUNTS", (1, 2))
    monkeypatch.setattr(batch, "TASKS", batch.TASKS[1:])
    found = batch.measure(TINY)
    task = batch.TASKS[0]
    cases = (batch.BLOCKING, batch.LEGACY, batch.PASS, batch.by_batch(1), batch.by_batch(2))
    assert {f"{task.scene}: {case}" for case in cases} <= {row.what for row in found.rows}
    assert [ratio.target for ratio in found.ratios] == [None, 1 / batch.TARGET, None]
    assert all(ratio.value > 0 for ratio in found.ratios)


def test_a_scene_is_measured_beside_its_physics(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenes, "list_scenes", lambda: ["stock_kinect"])
    found = scenes.measure(TINY)
    assert [ratio.target for ratio in found.ratios] == [scenes.SHARE_OF_REAL_TIME]
    [(name, figures)] = found.grids[0].lines
    assert name == "stock_kinect"
    assert all(figure and figure > 0 for figure in figures)


def test_a_ring_of_sensors_is_measured_beside_the_bare_pass() -> None:
    found = sensors.measure(TINY)
    assert {sensors.PASS, sensors.ONE, sensors.RING, sensors.RING_ALONE} <= {row.what for row in found.rows}


def test_a_file_of_v_rep_is_decoded_and_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vrep_files, "BODY", 400_000)
    monkeypatch.setattr(vrep_files, "SCENE", 200_000)
    found = vrep_files.measure(TINY)
    assert {row.what for row in found.rows} == {vrep_files.DECODE, vrep_files.OPEN}
    assert all(row.median > 0 for row in found.rows)
    assert [ratio.target for ratio in found.ratios] == [1.5, None, 5.0, 2.0]


@pytest.mark.usefixtures("without_opengl")
def test_starts_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(startup, "FIRST_S", 0.01)
    told = {row.what for row in startup.measure(TINY).rows}
    assert {startup.SERVER, startup.CLIENT, startup.CONNECT, startup.WORST} <= told


def sweep_of(found: Findings, names: list[str]) -> None:
    """A line for each size, figures above zero in all of them, and a plot that can be drawn of every one."""
    [grid] = found.grids
    assert [name for name, _ in grid.lines] == names
    assert all(len(figures) == len(grid.head) - 1 for _, figures in grid.lines)
    assert all(figure and figure > 0 for _, figures in grid.lines for figure in figures)
    [drawn] = found.plots
    curves = [
        curve for panel in drawn.panels for curve in (*panel.curves.values(), *panel.baselines.values())
    ]
    assert all(len(curve) == len(names) for curve in curves)


def test_many_worlds_are_measured_beside_rollout() -> None:
    found = worlds.measure(TINY)
    assert {row.what for row in found.rows} >= {worlds.TOGETHER, worlds.ALONE, worlds.ROLLOUT}
    assert [each.target is not None for each in found.ratios] == [True, True, False]


def test_embedded_calls_are_measured_beside_bare_physics() -> None:
    found = embedded.measure(TINY)
    assert {embedded.READ, embedded.RESET} <= {row.what for row in found.rows}
    assert all(one.value > 0 for one in found.ratios)
    assert len(found.ratios) >= len(embedded.SHARES)


@pytest.mark.usefixtures("without_opengl")
def test_a_fleet_and_a_router_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scale, "FLEET", 2)
    found = scale.measure(TINY)
    told = {row.what: row.median for row in found.rows}
    assert {scale.DIRECT, scale.ROUTED} <= set(told)
    assert told["bytes of a blocking read on the wire, question"] > 0
    assert all(ratio.value > 0 for ratio in found.ratios)


@pytest.mark.usefixtures("without_opengl")
def test_a_class_is_measured_before_and_while_it_is_looked_at() -> None:
    found = classroom.measure(TINY, seats=(2,))
    ((seats, figures),) = found.grids[0].lines
    assert seats == "2"
    assert len(figures) == len(found.grids[0].head) - 1
    assert all(figure is not None and figure >= 0 for figure in figures)


@pytest.mark.usefixtures("without_opengl")
def test_cost_is_measured_by_clients(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clients, "COUNTS", (1, 3))
    sweep_of(clients.measure(TINY), ["1", "3"])


def test_cost_is_measured_by_streamed_values(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(values, "COUNTS", (1, 20))
    found = values.measure(TINY)
    sweep_of(found, ["1", "20"])
    assert values.message_size(20) > 20 * values.NUMBER_BYTES


@pytest.mark.usefixtures("without_opengl")
def test_cost_is_measured_by_picture_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes, "SIZES", ((16, 12), (32, 24)))
    sweep_of(sizes.measure(TINY), ["16 x 12", "32 x 24"])


@pytest.mark.usefixtures("without_opengl")
def test_cost_is_measured_by_servers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(servers, "COUNTS", (1, 2))
    sweep_of(servers.measure(TINY), ["1", "2"])


@pytest.mark.usefixtures("without_opengl")
def test_a_read_and_a_turn_of_the_loop_are_told_in_their_parts() -> None:
    found = parts.measure(TINY)
    for grid, names in zip(found.grids, (parts.READ_PARTS, parts.LOOP_PARTS), strict=True):
        assert [name for name, _ in grid.lines] == [*names, parts.BETWEEN, parts.WHOLE]
        shares = [figures[1] for _, figures in grid.lines]
        assert sum(share or 0.0 for share in shares[:-1]) == pytest.approx(100.0)


def test_pictures_are_told_in_their_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rendering, "CAMERAS", {rendering.TUTORIAL: (rendering.CAMERA,)})
    found = picture.measure(TINY)
    told = {row.what for row in found.rows}
    assert {picture.LIST, picture.ARRAY, picture.RENDER, picture.QUERY, picture.BUILD} <= told
    assert {picture.BOTH, picture.CHANNELS, picture.SHARED, picture.ASKING, rendering.STATE} <= told
    bounds = {ratio.what: ratio.target for ratio in found.ratios}
    slowest = f"{rendering.SLOWEST}: {rendering.by_rays(rendering.TUTORIAL, rendering.CAMERA)}"
    assert bounds[slowest] == rendering.RAYS_TARGET_MS
    if not found.notes:
        assert {rendering.BOTH, rendering.DEPTH} <= told
        for size, target in rendering.TARGETS_MS.items():
            assert bounds[rendering.colours(rendering.TUTORIAL, rendering.CAMERA, size)] == target


def test_an_unknown_measurement_is_a_usage_error_that_lists_them(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        bench.main(["blokking"])
    assert left.value.code == 2
    message = capsys.readouterr().err
    assert all(name in message for name in bench.MEASUREMENTS)


@pytest.mark.skipif(missing() is not None, reason="needs the extra viewer")
def test_the_page_is_told_beside_a_server_without_one() -> None:
    found = view.measure(TINY)
    told = {row.what for row in found.rows}
    assert told == {view.LOOK, view.SURVEY}
    assert {ratio.what for ratio in found.ratios if ratio.target} == {view.LOOK, view.SURVEY}
    (grid,) = found.grids
    assert [name for name, _ in grid.lines] == [view.NO_PAGE, *view.LOOKERS]


def test_an_original_client_is_told_beside_the_limit_of_its_protocol() -> None:
    found = original.measure(TINY)
    assert [row.what for row in found.rows] == [original.PACED, original.LIMIT, original.BARE, original.TCP]
    assert [each.target for each in found.ratios if each.target] == [original.TARGET]


@pytest.mark.parametrize("module", bench.MEASUREMENTS.values())
def test_every_measurement_has_its_function(module: str) -> None:
    assert callable(importlib.import_module(module).measure)


def test_the_local_way_is_measured_beside_a_client_of_zeromq() -> None:
    pytest.importorskip("coppeliasim_zmqremoteapi_client")
    found = one_host.measure(TINY)
    assert len(found.ratios) == 11
    told = {row.what: row.median for row in found.rows}
    assert all(
        told[f"{case}, {state}"] > 0
        for case in (one_host.LOCAL, one_host.ZENOH, one_host.ZMQ)
        for state in (one_host.IDLE, one_host.BUSY, one_host.ONE_CORE)
    )
