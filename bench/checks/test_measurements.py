"""Measurements that start several servers run, and find what they should. Nothing here depends on how fast anything is.

They take half a minute of processor time, so `make bench` runs them, before it measures.
"""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

from bench.calls import batch, one_host, streaming, worlds
from bench.images import picture, rendering, sizes
from bench.learning import environments
from bench.learning import growth as learning
from bench.load import classroom, clients, scale, servers, startup, view
from bench.measuring import paces
from bench.measuring.measure import Effort
from bench.measuring.report import Findings, Ratio, compose
from bench.world import growth, vrep_files
from simx_server.viewer.launching import missing

TINY = Effort(sets=1, rounds=1, factor=0.02, least=1)


@pytest.fixture
def without_opengl(monkeypatch: pytest.MonkeyPatch) -> None:
    """No server looks for it."""
    monkeypatch.setenv("MUJOCO_GL", "disable")


@pytest.mark.usefixtures("without_opengl")
def test_streams_are_measured_at_both_speeds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "CLIENTS", 2)
    monkeypatch.setattr(streaming, "VALUES", 5)
    found = streaming.measure(TINY)
    told = {row.what for row in found.rows}
    assert {streaming.READ, streaming.SET, streaming.PUT} <= told
    assert {f"{streaming.AGE}, speed {speed}" for speed in ("1", "max")} <= told
    assert {streaming.SPENT, streaming.SPENT_ALONE, streaming.PACKED} <= told
    assert found.ratios[-1].target == streaming.MOST


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


def test_a_file_of_v_rep_is_decoded_and_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vrep_files, "BODY", 400_000)
    monkeypatch.setattr(vrep_files, "SCENE", 200_000)
    found = vrep_files.measure(TINY)
    assert {row.what for row in found.rows} == {vrep_files.DECODE, vrep_files.OPEN}
    assert all(row.median > 0 for row in found.rows)
    assert [ratio.target for ratio in found.ratios] == [vrep_files.DECODE_MOST, 5.0, vrep_files.OPEN_MOST]


@pytest.mark.usefixtures("without_opengl")
def test_starts_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(startup, "FIRST_S", 0.01)
    monkeypatch.setattr(startup, "SETTLES_S", 0.0)
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


@pytest.mark.usefixtures("without_opengl")
def test_cost_is_measured_by_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(growth, "COUNTS", (5, 60))
    monkeypatch.setattr(growth, "STREAMED", 4)
    monkeypatch.setattr(growth, "KINDS", (growth.FREE,))
    monkeypatch.setattr(growth, "SETTLES_S", 0.0)
    found = growth.measure(TINY)
    names = {
        growth.START,
        growth.LOAD,
        growth.GROUP,
        growth.TOLIST,
        growth.TRIGGER,
        growth.STREAMS,
        growth.MEMORY,
    }
    names |= {growth.DUMMY, growth.COPY, growth.COPIES, growth.REMOVE, growth.PARENT, growth.MODEL_FILE}
    [grid] = found.grids
    lines = dict(grid.lines)
    assert names <= set(lines)
    assert all(figure and figure > 0 for name in names for figure in lines[name])
    bounds = [ratio.target for ratio in found.ratios if ratio.target]
    aims = [growth.GROUP_MOST, growth.STREAM_MOST, growth.START_MOST, growth.MEMORY_MOST]
    assert bounds == [*aims, growth.EDIT_MOST, growth.EDIT_MOST]


@pytest.mark.usefixtures("without_opengl")
def test_cost_is_measured_by_servers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(servers, "COUNTS", (1, 2))
    sweep_of(servers.measure(TINY), ["1", "2"])


def test_images_are_told_in_their_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rendering, "CAMERAS", {rendering.TUTORIAL: (rendering.CAMERA,)})
    found = picture.measure(TINY)
    told = {row.what for row in found.rows}
    assert {picture.LIST, picture.ARRAY, picture.RENDER, picture.QUERY, picture.BUILD} <= told
    assert {picture.BOTH, picture.CHANNELS, picture.SHARED, picture.ASKING, rendering.STATE} <= told
    bounds = {ratio.what: ratio.target for ratio in found.ratios}
    slowest = (
        f"{rendering.SLOWEST}: {rendering.by_rays(rendering.TUTORIAL, rendering.CAMERA)} / bare mj_multiRay"
    )
    assert bounds[slowest] == rendering.RAYS_MOST
    assert bounds[f"{picture.FRAME} / {picture.PLAIN_FRAME}"] == picture.FRAME_MOST
    if not found.notes:
        assert {rendering.BOTH, rendering.DEPTH} <= told


@pytest.mark.skipif(missing() is not None, reason="needs the extra viewer")
def test_the_page_is_told_beside_a_server_without_one() -> None:
    found = view.measure(TINY)
    told = {row.what for row in found.rows}
    assert told == {view.LOOK, view.SURVEY, view.PASS}
    assert [ratio.target for ratio in found.ratios] == 2 * [view.MOST]
    (grid,) = found.grids
    assert [name for name, _ in grid.lines] == [view.NO_PAGE, *view.LOOKERS]


def test_reads_on_one_host_are_measured_beside_the_rivals_that_are_installed() -> None:
    found = one_host.measure(TINY)
    told = {row.what: row.median for row in found.rows}
    states = (one_host.IDLE, one_host.BUSY, one_host.ONE_CORE)
    expected = [one_host.EMBEDDED, one_host.LOCAL, one_host.ZENOH, one_host.TCP, one_host.QUERY]
    has_zmq = importlib.util.find_spec("coppeliasim_zmqremoteapi_client") is not None
    if has_zmq:
        expected.append(one_host.ZMQ)
    assert all(told[f"{case}, {state}"] > 0 for case in expected for state in states)
    assert [rival.task for rival in found.rivals] == [f"blocking read, us, {state}" for state in states]
    aims = [ratio.target for ratio in found.ratios if ratio.target]
    assert aims == (6 * [one_host.TARGET] if has_zmq else []) + [one_host.MOST_SWITCHES]
    assert any("ZeroMQ" in note for note in found.notes) is not has_zmq


def test_worlds_for_learning_are_counted_here_and_in_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without Ray, which would start a cluster."""
    monkeypatch.setattr(learning, "COUNTS", (1, 2))
    monkeypatch.setattr(learning, "ENVIRONMENT", "simx/CartPole-v0")
    monkeypatch.setattr(learning, "ACTIONS", 1)
    monkeypatch.setattr(learning, "has_ray", lambda: False)
    (grid,) = learning.measure(TINY).grids
    assert [name for name, _ in grid.lines] == ["1", "2"]
    assert all(value and value > 0 for _, values in grid.lines for value in values)


def test_environments_are_measured_beside_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(environments, "COUNTS", (2,))
    monkeypatch.setattr(environments, "ARMS", 2)
    found = environments.measure(TINY)
    names = {row.what for row in found.rows}
    assert names >= {environments.ALONE, environments.PENDULUM, environments.RESET, environments.carts(2, 1)}
    assert names >= {environments.arms(what, 1) for what in ("simx/Reach-v0", "rollout", "batch")}
    assert all(row.median > 0 for row in found.rows)


@pytest.mark.usefixtures("without_opengl")
def test_cost_is_measured_by_image_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes, "SIZES", ((16, 12), (32, 24)))
    sweep_of(sizes.measure(TINY), ["16 x 12", "32 x 24"])


def test_figures_of_another_pace_are_a_column_of_the_report(tmp_path: Path) -> None:
    file = tmp_path / "paces.json"
    found = Findings("Reads", ratios=[Ratio("read / stub", 2.0, target=1.0), Ratio("read / queue", 3.0)])
    assert paces.load(file) == []
    paces.store(file, paces.ONE_CORE, "a full run of 1 s", [found])
    paces.store(file, paces.BUSY, "a full run of 2 s", [found])
    paces.store(
        file,
        paces.BUSY,
        "a full run of 3 s",
        [Findings("", ratios=[Ratio("read / stub", 1.234, target=1.0)])],
    )
    busy, one_core = paces.load(file)
    assert (busy.pace, busy.found, one_core.found) == (
        paces.BUSY,
        {"read / stub": 1.23},
        {"read / stub": 2.0},
    )
    assert busy.condition.endswith("a full run of 3 s")
    page = compose([found], conditions=[], others={each.pace: each.found for each in (busy, one_core)})
    assert re.search(r"\| read / stub \| +2.00 x \| +1.00 x \| +\*\*no\*\* \| +1.23 x \| +2.00 x \|", page)
