"""Ways of mobile robots that PyRep's add-on plans, and the direction in which a robot faces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scenes_for_tests import world_of

from simx_server.errors import CommandError
from simx_server.scene.poses.frames import pose_from_matrix12, quat_from_euler, set_pose
from simx_server.world.world import World

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="robot" pos="-1 0 .1"><freejoint/><geom type="box" size=".1 .06 .05"/>
      <body name="head" pos="0 0 .1"><geom size=".05" mass=".1"/></body></body>
    <body name="wall" pos="0 0 .1"><geom type="box" size=".02 .8 .1"/></body>
    <body name="fence" pos="{fence} .1"><geom type="box" size=".02 3 .1"/></body>
    <site name="target" pos="1 0 .3" euler="0 0 90"/>
  </worldbody>
  <custom><text name="simx:collection:base" data="tree=robot"/></custom>
</mujoco>
"""
"""A wall is between the robot and the target; a fence beyond it may close the way."""

RADIUS = 0.1


def place(fence: str = "5 0") -> World:
    return world_of(SCENE.format(fence=fence))


def plan(world: World, bound: float = 2.0, points: int = 200, ignores: int = 0) -> np.ndarray:
    scene = world.simulation.scene
    robot, target = scene.resolve("robot"), scene.resolve("target")
    ints: list[Any] = [robot, target, world.collections.find("base"), ignores, points]
    return np.array(call(world, "getNonlinearPathMobile", ints, [bound], ["RRTConnect"])).reshape(-1, 3)


def call(
    world: World,
    name: str,
    ints: list[int],
    floats: list[float] | None = None,
    texts: list[str] | None = None,
) -> list[float]:
    found = world.scripts.add_ons["PyRep"].call(name, ints, floats or [], texts or [], b"")
    assert (found[0], found[2], found[3]) == ([], [], b"")
    return found[1]


def meets_wall(world: World, state: np.ndarray) -> bool:
    sim = world.simulation
    x, y, yaw = state.tolist()
    set_pose(sim, sim.scene.resolve("robot"), -1, ((x, y, 0.1), quat_from_euler([0.0, 0.0, yaw])))
    base = world.collections.find("base")
    assert base is not None
    return bool(world.meters.collisions.check(base, sim.scene.resolve("wall")))


def test_a_robot_drives_around_a_wall_and_ends_as_the_target_stands() -> None:
    world = place()
    before = world.simulation.data.qpos.copy()
    path = plan(world)
    assert np.array_equal(world.simulation.data.qpos, before), "nothing moves"
    assert len(path) == 200
    assert path[0] == pytest.approx([-1.0, 0.0, 0.0])
    assert path[-1] == pytest.approx([1.0, 0.0, math.pi / 2])
    assert np.abs(path[:, :2]).max() <= 2.0
    assert meets_wall(world, np.zeros(3))
    assert not any(meets_wall(world, state) for state in path)


def test_it_turns_no_sharper_than_with_a_radius_of_a_tenth_of_a_metre_and_never_sideways() -> None:
    path = plan(place(), points=1000)
    steps = np.diff(path, axis=0)
    lengths = np.linalg.norm(steps[:, :2], axis=1)
    turns = np.remainder(steps[:, 2] + np.pi, 2 * np.pi) - np.pi
    assert np.all(np.abs(turns) <= lengths / RADIUS * 1.02 + 1e-9), "an arc is longer than its chord"
    middle = path[:-1, 2] + turns / 2
    sideways = -np.sin(middle) * steps[:, 0] + np.cos(middle) * steps[:, 1]
    assert np.abs(sideways).max() < 1e-4


def test_ignored_collisions_give_the_shortest_way() -> None:
    path = plan(place(), ignores=1)
    lengths = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1)
    assert 2.0 < lengths.sum() < 2.4


def test_a_closed_way_or_an_end_beyond_the_bound_gives_nothing() -> None:
    assert len(plan(place(fence="-.5 0"))) == 0
    assert len(plan(place(), bound=0.9)) == 0


def test_equal_programs_get_equal_ways() -> None:
    assert np.array_equal(plan(place()), plan(place()))


def test_wrong_bounds_and_numbers_of_states_are_explained() -> None:
    for bound in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(CommandError, match="a bound is above 0"):
            plan(place(), bound=bound)
    with pytest.raises(CommandError, match="up to 10000 states"):
        plan(place(), points=10**9)
    assert len(plan(place(), points=-5)) >= 2


@pytest.mark.parametrize(
    ("turn", "yaw"),
    [((0.0, 0.0, 0.3), 0.3), ((0.0, 0.0, 2.5), 2.5 - math.pi), ((0.0, 0.0, -1.2), -1.2 + math.pi / 2)],
)
def test_a_robot_faces_along_the_axis_of_the_target_that_looks_away_from_it(
    turn: tuple[float, float, float], yaw: float
) -> None:
    world = place()
    sim = world.simulation
    robot, target = sim.scene.resolve("robot"), sim.scene.resolve("target")
    set_pose(sim, target, -1, ((1.0, 0.1, 0.3), quat_from_euler(list(turn))))
    *matrix, angle = call(world, "getBoxAdjustedMatrixAndFacingAngle", [robot, target])
    assert angle == pytest.approx(yaw - math.pi / 2)
    assert len(matrix) == 12
    where, how = pose_from_matrix12(matrix)
    assert where == pytest.approx((1.0, 0.1, 0.3))
    assert how == pytest.approx(quat_from_euler([0.0, 0.0, yaw]))


def test_there_is_no_direction_between_objects_at_the_same_place() -> None:
    world = place()
    robot = world.simulation.scene.resolve("robot")
    with pytest.raises(CommandError, match="at the same place"):
        call(world, "getBoxAdjustedMatrixAndFacingAngle", [robot, robot])
