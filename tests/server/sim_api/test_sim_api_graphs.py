"""Values that scripts record in graphs, and read back."""

from __future__ import annotations

import math

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

G = "local g = sim.getObjectHandle('mark')\n"


def test_user_data_are_recorded_once_in_each_pass_in_which_they_were_set(world: ScriptWorld) -> None:
    for value in (1, 2):
        assert world.lua(G + f"return sim.setGraphUserData(g, 'height', {value})") == [1]
        world.passes()
    world.passes()
    label, _, color, times, values, limits, number, _ = world.lua(G + "return sim.getGraphCurve(g, 0, 0)")
    assert (label, color, number) == ("height", [1, 0, 0], 0)
    assert times == pytest.approx([0.05, 0.1])
    assert (values, limits) == ([1, 2], pytest.approx([0.05, 0.1, 1, 2]))
    assert world.lua(G + "return sim.getGraphCurve(g, 0, 1)") in ([], [None])


def test_streams_are_transformed(world: ScriptWorld) -> None:
    world.lua(G + "s = sim.addGraphStream(g, 'speed', 'm/s', 0, {0, 1, 0})\n"
              "for i, v in ipairs({1, 3, 7}) do\n"
              "sim.setGraphStreamValue(g, s, v) sim.handleGraph(g, i) end")  # fmt: skip
    curve = "local _, _, _, t, v = sim.getGraphCurve(g, 0, 0) return t, v"
    transform = G + "sim.setGraphStreamTransformation(g, s, sim.stream_transf_{}) "
    assert world.lua(G + curve) == [[1, 2, 3], [1, 3, 7]]
    assert world.lua(transform.format("derivative") + curve) == [[2, 3], [2, 4]]
    assert world.lua(transform.format("integral") + curve) == [[1, 2, 3], [0, 2, 7]]
    assert world.lua(transform.format("cumulative, 2, 1, 1") + curve) == [[1, 2, 3], [3, 9, 23]]
    assert world.lua(transform.format("raw, 1, 0, 2") + curve) == [[1, 2, 3], [1, 2, 5]]
    world.fails(G + "sim.setGraphStreamTransformation(g, s, 7)", "no transformation; those are 0 raw")
    world.fails(G + "sim.setGraphStreamValue(g, 99, 1)", "no stream 99; its streams are 0 'speed'")


def test_cyclic_values_change_the_short_way_round(world: ScriptWorld) -> None:
    world.lua(
        G
        + """s = sim.addGraphStream(g, 'angle', 'deg', 0, nil, 360)
        for i, v in ipairs({170, -170, -150}) do sim.setGraphStreamValue(g, s, v) sim.handleGraph(g, i) end"""
    )
    curve = "local _, _, _, t, v = sim.getGraphCurve(g, 0, 0) return v"
    transform = G + "sim.setGraphStreamTransformation(g, s, sim.stream_transf_{}) "
    assert world.lua(transform.format("derivative") + curve) == [[20, 20]]
    assert world.lua(transform.format("raw, 1, 0, 2") + curve) == [[170, -180, -160]]
    assert world.lua(transform.format("raw, 0.5, 0, 2") + curve) == [[85, -90, -80]]
    world.fails(G + "sim.addGraphStream(g, 'other', '', 0, nil, -1)", "not below 0")
    world.lua(
        G
        + "for i, v in ipairs({-1.7e308, 1.7e308}) do sim.setGraphStreamValue(g, s, v) sim.handleGraph(g, 3 + i) end"
    )
    assert float(world.lua(transform.format("derivative") + curve)[0][-1]) == math.inf


def test_streams_and_curves_of_a_name_are_changed(world: ScriptWorld) -> None:
    world.lua(
        G + "s = sim.addGraphStream(g, 'x', 'm', 1) sim.setGraphStreamValue(g, s, 4) sim.handleGraph(g, 0)"
    )
    assert world.lua(G + "return sim.addGraphStream(g, 'x', 'mm', 4, {0, 0, 1}) == s") == [True]
    label, options, color, _, values, _, _, _ = world.lua(G + "return sim.getGraphCurve(g, 0, 0)")
    assert (label, options, color, values) == ("x", 4, [0, 0, 1], [4])
    world.lua(G + "c = sim.addGraphCurve(g, 'c', 2, {s, s}, nil, 'm', 2)")
    assert world.lua(G + "return sim.addGraphCurve(g, 'c', 2, {s, -1}, {0, 7}, 'm', 4) == c") == [True]
    _, options, _, xs, ys, *_ = world.lua(G + "return sim.getGraphCurve(g, 1, 0)")
    assert (options, xs, ys) == (4, [4], [7])


def test_curves_put_streams_against_each_other(world: ScriptWorld) -> None:
    world.lua(G + "x, y = sim.addGraphStream(g, 'x'), sim.addGraphStream(g, 'y') "
              "c = sim.addGraphCurve(g, 'path', 2, {x, y}, {0, 0}, 'm') "
              "d = sim.addGraphCurve(g, 'space', 3, {x, y, -1}, {0, 0, 5}) "
              "for i = 1, 2 do sim.setGraphStreamValue(g, x, i) sim.setGraphStreamValue(g, y, i * i) "
              "sim.handleGraph(sim.handle_all, i) end")  # fmt: skip
    label, _, color, xs, ys, limits, _, width = world.lua(G + "return sim.getGraphCurve(g, 1, 0)")
    assert (label, color, xs, ys, limits, width) == ("path", [1, 1, 0], [1, 2], [1, 4], [1, 2, 1, 4], 2)
    assert world.lua(G + "return sim.getGraphCurve(g, 2, 0)")[3:6] == [[1, 2], [1, 4], [5, 5]]
    world.lua(G + "sim.duplicateGraphCurveToStatic(g, c, 'before') sim.resetGraph(g)")
    empty = world.lua(G + "return sim.getGraphCurve(g, 1, 0)")
    assert (empty[3], empty[5]) == ([], None)
    assert world.lua(G + "return sim.getGraphCurve(g, 1, 1)")[3] == [1, 2]
    world.lua(G + "sim.destroyGraphCurve(g, c)")
    assert world.lua(G + "return sim.getGraphCurve(g, 1, 0)")[0] == "before"
    world.fails(G + "sim.addGraphCurve(g, 'bad', 4, {x}, nil)", "2 or 3 dimensions")


def test_a_new_run_begins_with_empty_graphs(world: ScriptWorld) -> None:
    world.lua(G + "sim.setGraphUserData(g, 'height', 1) sim.handleGraph(g, 1)")
    handle = world.handle("mark")
    world.call("simxStopSimulation")
    assert len(world.parts.graphs.get(handle).streams) == 1
    world.run()
    assert world.parts.graphs.get(handle).streams == {}
