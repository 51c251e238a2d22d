"""Paths of V-REP's files: control points, what follows them, their visible forms; V-REP's conveyor belt."""

from __future__ import annotations

import math

import mujoco
import pytest
from handler_calls import World
from vrep_samples import decoded, sample, world_of
from vrep_writer import VrepWriter

from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.objects import Dummy
from simx_server.scene.formats.vrep.opening import open_vrep
from simx_server.scene.poses.frames import get_pose

SERIALIZATIONS = (18, 21, 23)


def world_with(writer: VrepWriter) -> World:
    spec, _, _ = open_vrep(writer.bytes(), "made.ttt")
    world = World()
    world.sim.use(*build(spec, None))
    return world


def place(world: World, name: str) -> list[float]:
    return world.call("simxGetObjectPosition", world.handle(name), -1)


@pytest.mark.parametrize("ser", SERIALIZATIONS)
def test_a_path_has_the_points_and_settings_of_the_file(ser: int) -> None:
    writer = VrepWriter(ser)
    points = [(0, 0, 0), (1, 0, 0), (1, 2, 0)]
    writer.path("rail", points, pauses=(0, 0.5, 0), along=0.25, velocity=0.1, method=0, position=(0, 0, 1))
    writer.path("ring", points, closed=True)
    world = world_with(writer)
    rail, ring = world.handle("rail"), world.handle("ring")
    assert world.call("simxGetObjects", 8) == [rail, ring]
    paths = world.parts.paths
    # The virtual distance rises by 0.5 on the first way, and falls by it on the second one.
    assert paths.get(rail).curve.length == pytest.approx(3 + 2 * 0.5)
    assert paths.pose_at(rail, 0.75)[0] == pytest.approx((0.5, 0, 1))
    assert paths.pose_at(rail, 1.5 + 1.25)[0] == pytest.approx((1, 1, 1))
    assert paths.get(ring).curve.length == pytest.approx(3 + math.sqrt(5))
    world.run(2)
    assert paths.get(rail).position == pytest.approx(0.26)
    if ser >= 20:
        assert paths.get(rail).curve.at(4.0).flags == 2
        assert paths.get(rail).curve.at(4.0).channels == (0, 0, 0, 2)


@pytest.mark.parametrize("ser", SERIALIZATIONS)
def test_dummies_follow_their_path_with_what_is_below_them(ser: int) -> None:
    writer = VrepWriter(ser)
    rail = writer.path("rail", [(0, 0, 0), (2, 0, 0)], position=(0, 0, 1))
    wagon = writer.dummy("wagon", parent=rail, path_offset=0.5, position=(0.5, 0, 0))
    writer.shape("load", parent=wagon, cuboid=(0.1, 0.1, 0.1), position=(0, 0, 0.2))
    writer.dummy("bystander", parent=rail, position=(0.5, 0, 0))
    world = world_with(writer)
    world.parts.paths.set_position(world.handle("rail"), 1)
    assert place(world, "wagon") == pytest.approx([1.5, 0, 1])
    assert place(world, "load") == pytest.approx([1.5, 0, 1.2])
    assert place(world, "bystander") == pytest.approx([0.5, 0, 1])


def test_the_form_of_a_path_is_seen_but_nothing_else_of_it() -> None:
    writer = VrepWriter(21)
    along_x = (0.5, 0.5, 0.5, 0.5)  # z along the path, x across it
    points = [(-1, 0, 0, *along_x), (1, 0, 0, *along_x)]
    writer.path("line", points, section=[(0.05, 0), (-0.05, 0)], scale=2, color=(0, 0, 0), properties=0x200)
    writer.path("unseen", points, section=[(0.05, 0), (-0.05, 0)], scale=2, position=(0, 1, 0), properties=0)
    writer.proximity_sensor("ray", position=(0, 0, 0.5), quaternion=(0, 1, 0, 0))
    world = world_with(writer)
    model, scene = world.sim.model, world.sim.scene
    line, unseen = (scene.objects[world.handle(name)] for name in ("line", "unseen"))
    geoms = [model.geom(geom) for geom in range(model.ngeom)]
    (geom,) = [each for each in geoms if each.bodyid[0] == line.id]
    size = model.mesh_vert[model.mesh_vertadr[geom.dataid[0]] :][: model.mesh_vertnum[geom.dataid[0]]]
    assert sorted((size.max(axis=0) - size.min(axis=0)).tolist()) == pytest.approx([0.002, 0.2, 2], abs=1e-5)
    assert (geom.contype[0], geom.conaffinity[0]) == (0, 0)
    (other,) = [each for each in geoms if each.bodyid[0] == unseen.id]
    assert geom.group[0] < 3 <= other.group[0]
    world.run(1)
    detected = world.call("simxReadProximitySensor", world.handle("ray"))
    assert not detected[0], "sensors do not detect paths"


def test_the_curve_places_v_reps_dummies_where_v_rep_did() -> None:
    path = sample("short conveyor belt.ttm")
    file, world = decoded(path), world_of(path)
    rail = world.handle("ShortConveyorBeltPath")
    offsets = {
        item.name: item.path_offset
        for item in file.objects.values()
        if isinstance(item, Dummy) and item.path_offset is not None
    }
    assert len(offsets) == 26
    for name, offset in offsets.items():
        here = get_pose(world.sim, world.handle(name))
        there = world.parts.paths.pose_at(rail, offset)
        assert there[0] == pytest.approx(here[0], abs=1e-6), name
        assert abs(sum(a * b for a, b in zip(here[1], there[1], strict=True))) == pytest.approx(
            1, abs=1e-6
        ), name


def test_v_reps_conveyor_belt_moves_a_box() -> None:
    spec, _ = convert(decoded(sample("short conveyor belt.ttm")))
    box = spec.worldbody.add_body(name="box", pos=[-0.1, 0, 0.6])
    box.add_freejoint()
    box.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.04] * 3, mass=0.5)
    world = World()
    world.sim.use(*build(spec, None))
    world.run(10)
    start = place(world, "box")
    world.run(40)  # the script of the belt moves it with 0.08 m/s
    end = place(world, "box")
    assert end[0] - start[0] == pytest.approx(0.08 * 2, abs=0.005)
    assert end[1:] == pytest.approx(start[1:], abs=3e-3)


@pytest.mark.parametrize("ser", SERIALIZATIONS)
def test_a_path_planning_task_is_registered(ser: int) -> None:
    writer = VrepWriter(ser)
    base = writer.shape("base", cuboid=(0.1, 0.1, 0.1))
    way, goal = writer.path("way", [(0, 0, 0), (1, 0, 0)]), writer.dummy("goal", position=(0.5, 0.5, 0))
    robot = writer.collection("robot", [(base, 0, True)], overrides=True)
    writer.planning("find", path=way, start=base, goal=goal, robot=robot, kind=3, low=(-1, -2, -3))
    writer.planning("fly", path=way, start=base, goal=goal, robot=base, kind=2, obstacles=robot)
    writer.planning("turn", path=way, start=base, goal=goal, robot=base, kind=5)
    writer.planning("lost", path=base, start=base, goal=goal, robot=base)
    spec, report, _ = open_vrep(writer.bytes(), "made.ttt")
    notes = {text.name: text.data for text in spec.texts if text.name.startswith("simx:planning:")}
    assert set(notes) == {"simx:planning:find", "simx:planning:fly"}
    assert notes["simx:planning:find"].split() == [
        *("path=way", "start=base", "goal=goal", "robot=collection:robot", "obstacles=all"),
        *("type=xyg", "low=-1,-2,-3", "high=1,0,-1", "seconds=2.5"),
    ]
    assert "overrides=yes" in next(text.data for text in spec.texts if text.name == "simx:collection:robot")
    assert [names for kind, names in report.left_out.items() if "planning" in kind] == [["turn"], ["lost"]]
    world = World()
    world.sim.use(*build(spec, None))
    plannings = world.parts.path_plannings
    assert plannings.search(world.parts, plannings.find("find"), 5)
    assert world.parts.paths.get(world.handle("way")).curve.length == pytest.approx(math.sqrt(0.5), rel=1e-3)


@pytest.mark.parametrize("ser", SERIALIZATIONS)
def test_a_motion_planning_task_is_registered(ser: int) -> None:
    writer = VrepWriter(ser)
    base = writer.shape("base", cuboid=(0.1, 0.1, 0.1))
    joint = writer.joint("j1", mode="ik", parent=base)
    link = writer.shape("link", cuboid=(0.1, 0.1, 0.1), parent=joint)
    target = writer.dummy("target")
    tip = writer.dummy("tip", position=(0.2, 0, 0), parent=link, linked=target)
    robot = writer.collection("robot", [(base, 1, True)])
    group = writer.ik_group("reach", [{"tip": tip, "base": base, "constraints": 1}])
    task = {"joints": [joint], "group": group, "weights": [0.5]}
    writer.motion_planning("plan", robot=robot, own=(link, base), clearances=(0, 0.02), **task)
    writer.motion_planning("lost", joints=[joint], group=5, weights=[1])
    spec, report, _ = open_vrep(writer.bytes(), "made.ttt")
    notes = {text.name: text.data for text in spec.texts if text.name.startswith("simx:motion_planning:")}
    assert list(notes) == ["simx:motion_planning:plan"]
    assert notes["simx:motion_planning:plan"].split() == [
        *("joints=j1", "ik=reach", "robot=collection:robot", "obstacles=all", "own=link", "own_others=base"),
        *("own_clearance=0.02", "tip_weights=1,1,1,0.25", "weights=0.5"),
    ]
    assert [names for kind, names in report.left_out.items() if "motion planning" in kind] == [["lost"]]
    world = World()
    world.sim.use(*build(spec, None))
    plannings = world.parts.motion_plannings
    assert plannings.chain(world.parts, plannings.find("plan"), 16).handles == [world.handle("j1")]


def test_bill_plans_his_way_around_a_hedge() -> None:
    path = sample("path planning Bill.ttm")
    spec, _ = convert(decoded(path))
    hedge = spec.worldbody.add_body(name="hedge", pos=[1.5, 0, 0.5])
    hedge.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.8, 0.5])
    world = World()
    world.sim.use(*build(spec, path))
    world.run()
    sides = []
    for _ in range(400):
        world.parts.step()
        x, y, _ = place(world, "Bill")
        if abs(x - 1.5) < 0.1:
            sides.append(abs(y))
    world.parts.scripts.close()
    assert sides
    assert min(sides) > 0.9
    assert math.dist(place(world, "Bill"), place(world, "Bill_goalDummy")) < 0.2
