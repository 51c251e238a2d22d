"""The benchmark's pieces run, and its report says what it should. Nothing here depends on how fast anything is."""

from __future__ import annotations

import itertools
import os
from contextlib import ExitStack, closing

import pytest

from bench import __main__ as bench
from bench import (
    baselines,
    batch,
    blocking,
    picture,
    processes,
    rendering,
    scale,
    scenes,
    sensors,
    startup,
    stepping,
    streaming,
)
from bench.measure import Effort, Rounds, difference, in_turn, percentile, ratio, repeated, side_by_side
from bench.report import Findings, Ratio, Row, compose

TINY = Effort(sets=1, rounds=1, factor=0.02)


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


def test_the_report_puts_ratios_first_and_marks_broken_targets() -> None:
    found = Findings(
        "Calls",
        [Ratio("kept", 1.2, target=1.5), Ratio("broken", 1.7, target=1.5), Ratio("told", 3.0)],
        [Row.of("a call", Rounds(((1e-6, 2e-6, 3e-6),)), "us"), Row.of("a start", rounds(0.25), "ms")],
        ["a note"],
    )
    report = compose([found], effort="a run")
    lines = {line.split("|")[1].strip(): line for line in report.splitlines() if line.startswith("| ")}
    assert "yes" in lines["kept"]
    assert "**no**" in lines["broken"]
    assert "yes" not in lines["told"]
    assert "2.00" in lines["a call"]
    assert "250" in lines["a start"]
    assert report.index("Ratios and targets") < report.index("## Calls")
    assert "- a note" in report


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


def test_blocking_reads_are_measured_beside_their_baselines() -> None:
    found = blocking.measure(TINY)
    assert {row.what for row in found.rows} == {
        f"{what}, {state}"
        for what in (blocking.READ, blocking.BURST, blocking.QUERY, blocking.PUBLICATIONS, blocking.TCP)
        for state in (blocking.STOPPED, blocking.RUNNING)
    }
    bounds = [blocking.TARGET, None, None, blocking.TARGET_P99, blocking.TARGET_BURST]
    assert [ratio.target for ratio in found.ratios] == 2 * bounds


def test_streams_are_measured_at_both_speeds() -> None:
    found = streaming.measure(TINY)
    told = {row.what for row in found.rows}
    assert {streaming.READ, streaming.SET, streaming.PUT} <= told
    assert {f"{streaming.AGE}, speed {speed}" for speed in ("1", "max")} <= told
    assert {streaming.SHARE, streaming.SHARE_ALONE} <= told
    assert found.ratios[-1].target == streaming.TARGET_SHARE


def test_steps_are_measured_beside_the_same_physics() -> None:
    found = stepping.measure(TINY)
    told = {row.what for row in found.rows}
    assert {stepping.TARGET, 1 / stepping.SHARE_OF_RATE} <= {ratio.target for ratio in found.ratios}
    assert {stepping.TRIGGER, stepping.LOOP, stepping.STEPS, stepping.PASS} <= told


def test_many_servers_are_measured_beside_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "COUNTS", (1, 2))
    monkeypatch.setattr(batch, "TASKS", batch.TASKS[1:])
    found = batch.measure(TINY)
    (task,) = batch.TASKS
    cases = (batch.BLOCKING, batch.LEGACY, batch.PASS, batch.by_batch(1), batch.by_batch(2))
    assert {f"{task.scene}: {case}" for case in cases} <= {row.what for row in found.rows}
    assert [ratio.target for ratio in found.ratios] == [None, 1 / batch.TARGET, None]
    assert all(ratio.value > 0 for ratio in found.ratios)


def test_a_scene_is_measured_beside_its_physics(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenes, "list_scenes", lambda: ["stock_kinect"])
    found = scenes.measure(TINY)
    assert [ratio.target for ratio in found.ratios] == [scenes.SHARE_OF_REAL_TIME, None]
    assert all(ratio.value > 0 for ratio in found.ratios)


def test_a_ring_of_sensors_is_measured_beside_the_bare_pass() -> None:
    found = sensors.measure(TINY)
    assert {sensors.PASS, sensors.ONE, sensors.RING, sensors.RING_ALONE} <= {row.what for row in found.rows}


def test_starts_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(startup, "FIRST_S", 0.01)
    told = {row.what for row in startup.measure(TINY).rows}
    assert {startup.SERVER, startup.CLIENT, startup.CONNECT, startup.WORST} <= told


def test_servers_and_clients_are_measured_by_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")  # no server looks for OpenGL
    monkeypatch.setattr(scale, "FLEET", 2)
    monkeypatch.setattr(scale, "CLIENTS", (1, 2, 4))
    found = scale.measure(TINY)
    told = {row.what: row.median for row in found.rows}
    assert {scale.READ.format(count) for count in (1, 2, 4)} | {scale.DIRECT, scale.ROUTED} <= set(told)
    assert told["bytes of a blocking read on the wire, question"] > 0
    assert all(ratio.value > 0 for ratio in found.ratios)


def test_pictures_are_told_in_their_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rendering, "CAMERAS", {rendering.TUTORIAL: (rendering.CAMERA,)})
    found = picture.measure(TINY)
    told = {row.what for row in found.rows}
    assert {picture.LIST, picture.ARRAY, picture.RENDER, picture.QUERY, picture.BUILD} <= told
    assert {picture.BOTH, picture.CHANNELS, picture.SHARED, picture.ASKING, rendering.STATE} <= told
    bounds = {ratio.what: ratio.target for ratio in found.ratios}
    assert bounds[rendering.by_rays(rendering.TUTORIAL, rendering.CAMERA)] == rendering.RAYS_TARGET_MS
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
