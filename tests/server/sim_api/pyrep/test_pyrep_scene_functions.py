"""Functions of PyRep's add-on that read and change the scene: arms that follow a path, control points, images."""

from __future__ import annotations

import numpy as np
import pytest
from scenes_for_tests import world_of

from simx_server.errors import CommandError
from simx_server.scene.poses.frames import get_pose, get_position
from simx_server.world.world import World

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base">
      <body name="upper"><joint name="shoulder" axis="0 0 1" range="-3 3"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/>
        <body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 0 1" range="-3 3"/>
          <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/><site name="tip" pos=".4 0 0"/>
        </body>
      </body>
    </body>
    <site name="curve" pos=".5 -.3 0"/>
    <site name="target" pos=".1 .2 .3" euler=".1 .2 .3"/>
  </worldbody>
  <custom>
    <text name="simx:joint:shoulder" data="mode=ik"/>
    <text name="simx:joint:elbow" data="mode=ik"/>
    <text name="simx:ik:arm" data="tip=tip target=target base=base constraints=x,y handling=explicit"/>
    <text name="simx:object:curve" data="type=path"/>
    <text name="simx:path:curve" data="{points}"/>
  </custom>
</mujoco>
"""

NEAR, FAR = (f"points=0,0,0,1,0,0,0;0,.3,0,1,0,0,0;{end},.6,0,1,0,0,0" for end in ("-.1", "1"))
"""The arm reaches all of the first path, from (0.5, -0.3) to (0.4, 0.3), and not the end of the second one."""


def place(points: str = NEAR) -> World:
    world = world_of(SCENE.format(points=points))
    put(world, [-1.2, 1.4])
    return world


def put(world: World, values: list[float]) -> None:
    for name, value in zip(("shoulder", "elbow"), values, strict=True):
        world.simulation.joints.set_position(world.simulation.scene.resolve(name), value)


def call(world: World, name: str, ints: list[int], floats: list[float] | None = None) -> list[float]:
    found = world.scripts.add_ons["PyRep"].call(name, ints, floats or [], [], b"")
    assert (found[0], found[2], found[3]) == ([], [], b"")
    return found[1]


def follow(world: World) -> np.ndarray:
    scene = world.simulation.scene
    ints = [scene.resolve("curve"), world.ik_groups.find("arm"), scene.resolve("target")]
    joints = [scene.resolve("shoulder"), scene.resolve("elbow")]
    return np.array(call(world, "getPathFromCartesianPath", [*ints, *joints])).reshape(-1, 2)


def test_an_arm_follows_a_path_in_400_states_and_stays_where_it_is() -> None:
    world = place()
    sim = world.simulation
    target, tip, curve = (sim.scene.resolve(name) for name in ("target", "tip", "curve"))
    before, rest = sim.data.qpos.copy(), get_pose(sim, target)
    path = follow(world)
    assert np.array_equal(sim.data.qpos, before)
    assert get_pose(sim, target) == (pytest.approx(rest[0]), pytest.approx(rest[1]))
    assert path.shape == (400, 2)
    assert path[0] == pytest.approx([-1.2, 1.4], abs=1e-3)
    length = world.paths.get(curve).curve.length
    for number in range(1, 21):
        put(world, path[20 * number - 1].tolist())
        wanted, _ = world.paths.pose_at(curve, number / 20 * length)
        assert get_position(sim, tip)[:2] == pytest.approx(wanted[:2], abs=1e-3)
    assert np.abs(np.diff(path, axis=0)).max() < 0.2


def test_a_path_that_leaves_the_reach_gives_nothing_and_all_is_as_before() -> None:
    world = place(FAR)
    target = world.simulation.scene.resolve("target")
    before, rest = world.simulation.data.qpos.copy(), get_pose(world.simulation, target)
    assert len(follow(world)) == 0
    assert np.array_equal(world.simulation.data.qpos, before)
    assert get_pose(world.simulation, target)[0] == pytest.approx(rest[0])


def test_control_points_come_to_the_start_of_a_path_with_20_bezier_points() -> None:
    world = place()
    curve = world.simulation.scene.resolve("curve")
    before = world.paths.get(curve).curve.control
    numbers = [-0.3, 0.1, 0.2, 0.0, 0.0, 0.5, -0.2, 0.1, 0.0, 0.1, 0.0, 0.0]
    assert call(world, "insertPathControlPoint", [curve, 2], numbers) == []
    now = world.paths.get(curve).curve.control
    assert len(now) == len(before) + 2
    assert list(now[2:]) == list(before)
    assert now[0].pose[0] == pytest.approx((-0.3, 0.1, 0.2))
    assert now[1].pose[0] == pytest.approx((-0.2, 0.1, 0.0))
    with pytest.raises(CommandError, match="3 control points are 18 numbers, not 12"):
        call(world, "insertPathControlPoint", [curve, 3], numbers)
    with pytest.raises(CommandError, match="control points are"):
        call(world, "insertPathControlPoint", [curve, -1], numbers)


def test_missing_integers_are_explained() -> None:
    world = place()
    with pytest.raises(CommandError, match="takes a path, an IK group, its target and joints"):
        call(world, "getPathFromCartesianPath", [1, 2, 3])
    with pytest.raises(CommandError, match="takes 8 integers and 0 floats, not 2 and 0"):
        call(world, "handleSpherical", [1, 2])
    with pytest.raises(CommandError, match="takes 2 integers and any number of floats, not 1 and 0"):
        call(world, "insertPathControlPoint", [1])
