"""Graphs of a scene's file: streams that measure, curves, what stays from run to run."""

from __future__ import annotations

import pytest
from handler_calls import World
from scripted_world import evaluate, scripted

from simx_server.editing.copying import copy_objects
from simx_server.parts.graphs import Graph
from simx_server.scene.formats.annotations import SceneError

BODIES = """
<body name="ball" pos="0 0 2"><freejoint/><geom size="0.1" mass="1"/></body>
<body name="plot"><site name="mark"/></body>
<body name="wall" pos="0 0 0"><geom type="box" size="1 1 0.1"/></body>
<site name="nose" pos="0.5 0 1" zaxis="0 0 -1"/>
"""
NOTES = (
    '<text name="simx:object:plot" data="type=graph"/><text name="simx:model:plot" data="base=yes"/>'
    '<text name="simx:distance:gap" data="entity1=ball entity2=wall"/>'
)


def world_with(graph: str, scripts: dict[str, str] | None = None) -> World:
    custom = f'{NOTES}<text name="simx:graph:plot" data="{graph}"/>'
    return scripted(scripts or {}, BODIES, custom)


def graph_of(world: World, name: str = "plot") -> Graph:
    handle = world.sim.scene.by_name(name)
    assert handle is not None
    return world.parts.graphs.get(handle)


def samples(world: World, stream: str) -> list[tuple[float, float]]:
    return list(graph_of(world).named(stream).samples)


def test_streams_measure_in_each_simulation_step() -> None:
    world = world_with("streams=height,z,ball,0,0,1;reach,distance,gap;set,user")
    world.call("simxStartSimulation")
    for _ in range(3):
        world.parts.step()
    heights = samples(world, "height")
    assert [time for time, _ in heights] == pytest.approx([0.05, 0.1, 0.15])
    assert [value for _, value in heights] == pytest.approx([2.0] * 3)
    assert [value for _, value in samples(world, "reach")][-1] == pytest.approx(1.8)
    assert samples(world, "set") == []
    assert graph_of(world).named("height").color == (0.0, 0.0, 1.0)


def test_a_stream_of_detected_points_records_only_detections() -> None:
    sensor = '<text name="simx:object:nose" data="order=9"/>'
    world = World(
        f"<mujoco><worldbody>{BODIES}</worldbody><sensor><rangefinder site='nose'/></sensor><custom>{NOTES}{sensor}"
        '<text name="simx:graph:plot" data="streams=x,detected_x,nose;z,detected_z,nose curves=hits,x,z"/>'
        "</custom></mujoco>"
    )
    world.call("simxStartSimulation")
    world.parts.step()
    (found,) = samples(world, "z")
    assert found[1] == pytest.approx(0.1, abs=1e-6)
    graph = graph_of(world)
    (curve,) = graph.curves.values()
    assert [list(axis) for axis in graph.points(curve)] == [[pytest.approx(0.5)], [pytest.approx(0.1)]]


def test_a_value_that_a_script_sets_comes_first() -> None:
    pytest.importorskip("lupa")
    source = "function sysCall_actuation() sim.setGraphUserData(sim.getObjectHandle('plot'), 'height', 7) end"
    world = world_with("streams=height,z,ball", {"lua:ball": source})
    world.call("simxStartSimulation")
    world.parts.step()
    assert [value for _, value in samples(world, "height")] == [7.0]


def test_an_explicit_graph_waits_for_a_script() -> None:
    pytest.importorskip("lupa")
    world = world_with("explicit=yes streams=height,z,ball", {"lua:customization:ball": "x = 1"})
    world.call("simxStartSimulation")
    world.parts.step()
    assert samples(world, "height") == []
    evaluate(world, "sim.handleGraph(sim.getObjectHandle('plot'), 5)", on="ball", kind=6)
    assert samples(world, "height") == [(5.0, pytest.approx(2.0))]


def test_the_next_run_starts_with_the_streams_of_the_file_and_no_samples() -> None:
    pytest.importorskip("lupa")
    child = "function sysCall_init() s = sim.addGraphStream(sim.getObjectHandle('plot'), 'of the run') end"
    lasting = (
        "function sysCall_init() s = sim.addGraphStream(sim.getObjectHandle('plot'), 'of the scene') end"
    )
    world = world_with("streams=height,z,ball", {"lua:ball": child, "lua:customization:ball": lasting})
    for _ in range(2):
        world.call("simxStartSimulation")
        assert [each.name for each in graph_of(world).streams.values()] == [
            "height",
            "of the scene",
            "of the run",
        ]
        assert samples(world, "height") == []
        world.parts.step()
        assert len(samples(world, "height")) == 1
        world.call("simxStopSimulation")
        world.parts.step()


def test_a_stream_that_a_script_adds_when_it_starts_can_be_set() -> None:
    pytest.importorskip("lupa")
    source = (
        "function sysCall_init() g = sim.getObjectHandle('plot') s = sim.addGraphStream(g, 'speed') end "
        "function sysCall_sensing() sim.setGraphStreamValue(g, s, 3) end"
    )
    world = world_with("explicit=no", {"lua:ball": source})
    world.call("simxStartSimulation")
    world.parts.step()
    assert [value for _, value in samples(world, "speed")] == [3.0]


def test_a_copy_measures_the_copies() -> None:
    notes = '<text name="simx:graph:robot" data="streams=height,z,hand"/>'
    notes += '<text name="simx:model:robot" data="base=yes"/>'
    body = (
        '<body name="robot"><geom size="0.1"/><body name="hand" pos="0 0 1"><geom size="0.1"/></body></body>'
    )
    world = scripted({}, body, notes)
    robot = world.sim.scene.by_name("robot")
    assert robot is not None
    copy_objects(world.parts, [robot])
    copied = world.sim.scene.get(world.sim.scene.resolve("robot#0"))
    assert str(copied.annotations["graph"]["streams"]).startswith("height,z,hand#0")


@pytest.mark.parametrize(
    ("graph", "problem"),
    [
        ("streams=height,z,nobody", "streams=nobody, which is no object"),
        ("streams=height,distance,ball", "streams=ball, which is no distance object"),
        ("streams=height,z,ball curves=path,height,other", "curves=other, which is no stream"),
        ("streams=height,what,ball", "valid for streams"),
        ("streams=height", "valid for streams"),
        ("streams=height,z", "valid for streams"),
        ("streams=height,z,ball,red,0,0", "valid for streams"),
        ("streams=a,user;a,user", "valid for streams"),
        ("curves=path,a", "valid for curves"),
        ("streams=" + ";".join(f"s{n},user" for n in range(101)), "101 streams and 0 curves; valid are 100"),
    ],
)
def test_wrong_streams_are_refused(graph: str, problem: str) -> None:
    with pytest.raises(SceneError, match=problem):
        world_with(graph)
