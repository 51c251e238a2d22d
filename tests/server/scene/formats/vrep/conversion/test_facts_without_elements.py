"""Parts of a V-REP file beside its objects: data, collections, pairs, groups of inverse kinematics, settings."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from handler_calls import World

from simx_client.protocol import constants as c
from simx_server.kinematics import Calculation, Constraint, Result
from simx_server.kinematics.solver import Method
from simx_server.parts.custom_data import SCENE
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.objects import (
    Collection,
    Dummy,
    Engine,
    Graph,
    GraphCurve,
    GraphStream,
    IkElement,
    IkGroup,
    Joint,
    Pair,
    Settings,
    VrepFile,
    VrepObject,
)
from simx_server.scene.formats.vrep.report import Report
from simx_server.scene.link_constraints import IK
from simx_server.scene.objects import ObjectKind

TIP, TARGET, BASE = 3, 4, 1
OBJECTS: list[VrepObject] = [
    Dummy(
        handle=BASE, name="base", custom_data={"a tag": b"\x00\xff"}, size_factor=0.5, extension="a@b {c d}"
    ),
    Joint(handle=2, name="joint", parent=BASE, mode=2, minimum=-3.0, range=6.0),
    Dummy(
        handle=TIP,
        name="tip",
        parent=2,
        pose=((0.5, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
        linked=TARGET,
        link_type=5,
    ),
    Dummy(
        handle=TARGET, name="target", pose=((0.3, 0.4, 0.0), (1.0, 0.0, 0.0, 0.0)), linked=TIP, link_type=5
    ),
    Dummy(handle=5, name="robot", acknowledgement="Thanks to\nall"),
]


def opened(*more: VrepObject, **values: Any) -> tuple[World, Report]:
    """The world of a file with five objects, and more."""
    given = {"name": "test.ttt", "serialization": 21, "program": (3, 6, 0), **values}
    objects = {item.handle: item for item in (*OBJECTS, *more)}
    spec, report = convert(VrepFile(objects=objects, **given))
    return World(spec.to_xml()), report


def handle(world: World, name: str) -> int:
    found = world.sim.scene.by_name(name)
    assert found is not None
    return found


def test_data_of_objects_and_of_the_scene_are_read_by_scripts() -> None:
    world, report = opened(custom_data={"scene": b"s"}, settings=Settings(acknowledgement="Thanks to all"))
    data = world.parts.custom_data
    assert data.read(handle(world, "base"), "a tag") == b"\x00\xff"
    assert data.read(SCENE, "scene") == b"s"
    assert world.sim.scene.get(handle(world, "base")).annotations["object"]["size_factor"] == 0.5
    assert world.sim.scene.get(handle(world, "base")).annotations["object"]["extension"] == "a@b {c d}"
    assert report.credits == ["Thanks to all"]


def test_entries_of_collections_keep_their_order() -> None:
    first = Collection(id=2_000_000, name="others", entries=[(-1, 5, True), (BASE, 1, False)])
    second = Collection(id=2_000_001, name="robot", entries=[(TIP, 3, True), (BASE, 0, False), (9, 0, True)])
    world, report = opened(collections=[first, second])
    known = world.parts.collections

    def members(name: str) -> set[str]:
        number = known.find(name)
        assert number is not None
        return {world.sim.scene.get(each).name for each in known.members(number)}

    assert members("others") == {"target", "robot"}
    assert members("robot") == {"joint", "tip"}
    assert report.left_out == {"collections have no entries whose object is not in the file": ["robot"]}


def test_pairs_name_objects_and_collections_of_the_same_name() -> None:
    collection = Collection(id=2_000_000, name="robot", entries=[(TIP, 0, True)])
    pairs = [
        Pair(id=1, name="of_collection", entity1=2_000_000, entity2=5),
        Pair(id=2, name="of_all", entity1=5),
        Pair(id=3, name="gone", entity1=99, entity2=5),
    ]
    world, report = opened(collections=[collection], distances=pairs, collisions=pairs[:1])
    registered = world.sim.scene.annotations.registered
    assert registered["distance"]["of_collection"] == {"entity1": "collection:robot", "entity2": "robot"}
    assert registered["distance"]["of_all"] == {"entity1": "robot", "entity2": "all"}
    assert list(registered["collision"]) == ["of_collection"]
    assert report.left_out == {"distance objects without an object to measure": ["gone"]}


def group(**values: Any) -> IkGroup:
    element = IkElement(tip=TIP, constraints=3, precision=(0.001, 0.1), weights=(0.5, 0.2))
    return IkGroup(**{"id": 7, "name": "ik", "elements": [element], "iterations": 50, **values})


def test_a_group_of_inverse_kinematics_moves_the_tip_to_its_linked_dummy() -> None:
    world, _ = opened(ik_groups=[group()])
    world.parts.ik_groups.handle_automatic()
    angle = world.sim.joints.position(handle(world, "joint"))
    assert angle == pytest.approx(math.atan2(0.4, 0.3), abs=0.01)


def test_all_settings_of_a_group_arrive() -> None:
    element = IkElement(tip=TIP, base=BASE, constraints=0b11001, precision=(0.001, 0.1), weights=(0.5, 0.2))
    given = group(
        elements=[element],
        method=1,
        damping=0.3,
        is_explicit=True,
        restore=(True, False),
        is_enabled=False,
        ignores_steps=False,
    )
    world, _ = opened(ik_groups=[given, group(id=8, name="second", after=7)])
    groups = world.parts.ik_groups
    first, second = (groups.get(groups.find(name)) for name in ("ik", "second"))
    assert first.how == Calculation(Method.DAMPED_LEAST_SQUARES, 0.3, 50)
    assert (first.explicit, first.enabled, first.restore) == (True, False, {"position"})
    assert (second.after, second.how.method) == ("ik", Method.PSEUDO_INVERSE)
    assert (first.ignores_steps, second.ignores_steps) == (False, True)
    (found,) = first.elements
    assert found.constraints == Constraint.X | Constraint.ALPHA_BETA | Constraint.GAMMA
    assert (found.precision, found.weights, found.base) == ((0.001, 0.1), (0.5, 0.2), handle(world, "base"))


def test_elements_that_move_nothing_are_left_out() -> None:
    loose = IkElement(tip=99)
    world, report = opened(
        ik_groups=[group(elements=[loose, *group().elements]), group(id=8, name="b", elements=[loose])]
    )
    assert world.parts.ik_groups.names() == ["ik"]
    assert report.left_out["elements of inverse kinematics without a tip"] == ["ik", "b"]
    assert report.left_out["groups of inverse kinematics without a tip"] == ["b"]


def test_a_group_whose_tip_has_no_target_is_there_and_moves_once_a_program_links_one() -> None:
    tip, target = (replace(item, linked=-1) for item in OBJECTS[2:4] if isinstance(item, Dummy))
    world, report = opened(tip, target, ik_groups=[group()])
    groups, joint = world.parts.ik_groups, handle(world, "joint")
    assert not report.left_out
    assert groups.handle(groups.find("ik")) == Result.NOT_PERFORMED
    assert world.parts.dummy_links.type(handle(world, "tip")) == IK, "a link made later is one of kinematics"
    assert groups.retarget(handle(world, "tip"), handle(world, "target"))
    groups.handle_automatic()
    assert world.sim.joints.position(joint) == pytest.approx(math.atan2(0.4, 0.3), abs=0.01)


def test_the_settings_of_the_scene_arrive() -> None:
    settings = Settings(
        time_step=0.02,
        gravity=(0.0, 1.0, -5.0),
        engine=Engine.NEWTON,
        visible_layers=0x1234,
        dynamics=False,
    )
    world, _ = opened(settings=settings)
    sim = world.sim
    assert sim.time_step == 0.02
    assert sim.model.opt.gravity.tolist() == [0.0, 1.0, -5.0]
    assert world.call("simxGetIntegerParameter", c.sim_intparam_dynamic_engine) == 3
    assert world.call("simxGetIntegerParameter", c.sim_intparam_visible_layers) == 0x1234
    assert not world.call("simxGetBooleanParameter", c.sim_boolparam_dynamics_handling_enabled)


@pytest.mark.parametrize("is_custom", [False, True])
def test_whether_programs_set_the_simulation_step_arrives(is_custom: bool) -> None:
    world, _ = opened(settings=Settings(has_custom_step=is_custom))
    assert world.sim.scene.annotations.scene.get("custom_step", True) is is_custom


def test_another_engine_than_the_files_or_mujoco_is_refused() -> None:
    world, _ = opened(settings=Settings(engine=Engine.ODE))
    engine = c.sim_intparam_dynamic_engine
    world.call("simxSetIntegerParameter", engine, 1)
    world.call("simxSetIntegerParameter", engine, 4)
    with pytest.raises(Exception, match="it stays 1"):
        world.call("simxSetIntegerParameter", engine, 0)
    assert world.call("simxGetIntegerParameter", engine) == 1


def test_a_model_brings_no_settings() -> None:
    spec, _ = convert(
        VrepFile(name="m.ttm", serialization=21, program=(3, 6, 0), is_model=True, objects={5: OBJECTS[-1]})
    )
    assert not [text.name for text in spec.texts if text.name.startswith("simx:scene")]


def test_streams_of_graphs_record_what_they_did() -> None:
    streams = [
        GraphStream(name="a, b", id=4, kind=3, object=TARGET, color=(0.0, 1.0, 0.0)),
        GraphStream(name="a; b", id=5, kind=2102, object=2_020_000),
        GraphStream(name="gone", id=6, kind=1, object=99),
        GraphStream(name="other", id=7, kind=77, object=TARGET),
        GraphStream(name="of a script", id=8, kind=-1),
    ]
    curves = [GraphCurve(name="path", streams=(4, 5)), GraphCurve(name="lost", streams=(4, 99))]
    graph = Graph(handle=9, name="plot", streams=streams, curves=curves, is_explicit=True)
    world, report = opened(graph, distances=[Pair(id=2_020_000, name="gap,wide", entity1=5)])
    note = world.sim.scene.get(handle(world, "plot")).annotations["graph"]
    assert note == {
        "explicit": True,
        "streams": "a_ b,z,target,0,1,0;a_ b_0,distance,gap_wide,1,0,0;gone,user,1,0,0;other,user,1,0,0",
        "curves": "path,a_ b,a_ b_0",
    }
    assert world.sim.scene.get(handle(world, "plot")).kind == ObjectKind.GRAPH
    assert report.left_out == {"graphs record no streams of kind 77; scripts can set their values": ["plot"]}


def test_more_streams_than_a_graph_can_have_are_left_out_and_reported() -> None:
    streams = [GraphStream(name="a", id=number, kind=0) for number in range(150)]
    curves = [GraphCurve(name="path", streams=(0, 1))]
    world, report = opened(Graph(handle=9, name="plot", streams=streams, curves=curves))
    assert len(world.parts.graphs.get(handle(world, "plot")).streams) == 100
    assert report.left_out == {"streams and curves of graphs beyond the first 100": ["plot"]}


def test_a_stream_of_a_pair_without_objects_has_no_source() -> None:
    streams = [GraphStream(name="a", id=1, kind=2102, object=2_020_000)]
    graph = Graph(handle=9, name="plot", streams=streams)
    world, _ = opened(graph, distances=[Pair(id=2_020_000, name="gap", entity1=99)])
    assert world.sim.scene.get(handle(world, "plot")).annotations["graph"]["streams"] == "a,user,1,0,0"
