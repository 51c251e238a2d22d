"""simxGetObjectGroupData: each data type against the function that asks for one object."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from handler_calls import World

from simx_server.errors import CommandError
from simx_server.scene.naming import paths
from simx_server.scene.objects import Scene

SHAPE, JOINT, DUMMY, PROXIMITY, VISION, FORCE, LIGHT, OBJECTS = 0, 1, 4, 5, 9, 12, 13, 109

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <light name="sun" pos="0 0 3" dir="0 0 -1"/>
    <camera name="eye" pos="0 -2 1" xyaxes="1 0 0 0 0 1"/>
    <body name="base" pos="0.5 0.2 1" euler="0.1 0.2 0.3">
      <geom type="box" size="0.1 0.1 0.1" contype="0"/>
      <body name="link" pos="0 0 0.2" euler="0.3 -0.2 0.1">
        <joint name="turn" axis="0 0 1" range="-1 2" damping="0.1"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1" contype="0"/>
        <site name="tip" pos="0.3 0 0"/>
        <body name="end" pos="0.3 0 0">
          <joint name="slide" type="slide" axis="1 0 0" range="-0.5 0.5"/>
          <geom size="0.02" contype="0"/><site name="cell"/>
          <body name="wrist"><joint name="wrist_ball" type="ball"/><geom size="0.02" contype="0"/></body>
        </body>
      </body>
      <body name="wheel"><joint name="roll" axis="0 1 0"/><geom size="0.05" contype="0"/></body>
      <site name="ahead" pos="0.2 0 0" euler="0 3.14159 0"/>
      <site name="blind" pos="0 0 2"/>
      <site name="asked" pos="0.2 0 0"/>
    </body>
    <body name="Copy#0" pos="1 1 1"><freejoint/><geom size="0.05"/></body>
    <body name="Copy#1" pos="2 1 1"><freejoint/><geom size="0.05"/></body>
  </worldbody>
  <sensor><force site="cell"/><torque site="cell"/></sensor>
  <custom>
    <text name="simx:proximity:ahead" data="range=5"/>
    <text name="simx:proximity:blind" data="range=1"/>
    <text name="simx:proximity:asked" data="explicit=yes"/>
    <text name="simx:joint:roll" data="mode=force motor=on control=velocity target_velocity=1 cyclic=yes"/>
    <text name="simx:collection:some" data="objects=tip,floor tree=end"/>
  </custom>
</mujoco>
"""


@pytest.fixture(scope="module")
def world() -> World:
    world = World(SCENE)
    world.run(3)
    return world


def group(world: World, kind: int, data: int) -> tuple[list[int], list[int], list[float], list[str]]:
    return world.call("simxGetObjectGroupData", kind, data)


def pose(command: str, relative_to: int) -> Callable[[World, int], list[float]]:
    return lambda world, handle: world.call(command, handle, relative_to)


def both(*parts: Callable[[World, int], list[float]]) -> Callable[[World, int], list[float]]:
    return lambda world, handle: [value for part in parts for value in part(world, handle)]


def velocity(*parts: int) -> Callable[[World, int], list[float]]:
    def read(world: World, handle: int) -> list[float]:
        linear_and_angular = world.call("simxGetObjectVelocity", handle)
        return [value for part in parts for value in linear_and_angular[part]]

    return read


POSITION, EULER, QUATERNION = "simxGetObjectPosition", "simxGetObjectOrientation", "simxGetObjectQuaternion"

FLOATS: dict[int, tuple[int, Callable[[World, int], list[float]]]] = {
    3: (3, pose(POSITION, -1)),
    4: (3, pose(POSITION, -11)),
    5: (3, pose(EULER, -1)),
    6: (3, pose(EULER, -11)),
    7: (4, pose(QUATERNION, -1)),
    8: (4, pose(QUATERNION, -11)),
    9: (6, both(pose(POSITION, -1), pose(EULER, -1))),
    10: (6, both(pose(POSITION, -11), pose(EULER, -11))),
    11: (7, both(pose(POSITION, -1), pose(QUATERNION, -1))),
    12: (7, both(pose(POSITION, -11), pose(QUATERNION, -11))),
    17: (3, velocity(0)),
    18: (3, velocity(1)),
    19: (6, velocity(0, 1)),
}


@pytest.mark.parametrize("data", FLOATS)
def test_poses_and_velocities_are_those_of_each_object(world: World, data: int) -> None:
    count, single = FLOATS[data]
    handles, ints, floats, strings = group(world, OBJECTS, data)
    assert handles == list(world.sim.scene.objects)
    assert (ints, strings) == ([], [])
    assert len(floats) == count * len(handles)
    for index, handle in enumerate(handles):
        assert floats[count * index : count * (index + 1)] == single(world, handle)


def test_euler_angles_near_gimbal_lock_are_those_of_each_object() -> None:
    turned = "".join(
        f'<body name="b{place}" euler="0.3 {angle} -0.4"><geom size="0.1"/><body name="c{place}" euler="1 {angle} 2">'
        '<geom size="0.1"/></body></body>'
        for place, angle in enumerate((math.pi / 2, -math.pi / 2, 1.5677, 1.5676, 0.0, 3.0))
    )
    world = World(f'<mujoco><compiler angle="radian"/><worldbody>{turned}</worldbody></mujoco>')
    for data, relative_to in ((5, -1), (6, -11)):
        handles, _, floats, _ = group(world, SHAPE, data)
        assert floats == [angle for handle in handles for angle in world.call(EULER, handle, relative_to)]


def test_a_group_without_objects_has_no_data() -> None:
    world = World("<mujoco/>")
    for data in range(22):
        assert group(world, SHAPE, data) == ([], [], [], [])


def test_paths_of_many_siblings_count_them_once(monkeypatch: pytest.MonkeyPatch) -> None:
    bodies = "".join(f'<body name="part#{place}"><geom size="0.1"/></body>' for place in range(50))
    world = World(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    counted: list[int] = []
    count = paths.path_parts

    def counting(scene: Scene, parent: int) -> dict[int, str]:
        counted.append(parent)
        return count(scene, parent)

    monkeypatch.setattr(paths, "path_parts", counting)
    assert group(world, SHAPE, 21)[3] == [f"/part[{place}]" for place in range(50)]
    assert counted == [-1]


def test_something_moves_so_that_velocities_say_something(world: World) -> None:
    assert any(abs(value) > 0.1 for value in group(world, SHAPE, 17)[2])
    assert any(abs(value) > 0.1 for value in group(world, SHAPE, 18)[2])


STRINGS: dict[int, Callable[[World, int], str]] = {
    0: lambda world, handle: world.sim.scene.get(handle).name,
    20: lambda world, handle: world.sim.scene.get(handle).name.removesuffix("#0").removesuffix("#1"),
}


@pytest.mark.parametrize("data", STRINGS)
def test_names_and_aliases(world: World, data: int) -> None:
    handles, ints, floats, strings = group(world, OBJECTS, data)
    assert (ints, floats) == ([], [])
    assert strings == [STRINGS[data](world, handle) for handle in handles]


def test_paths_lead_back_to_their_objects(world: World) -> None:
    handles, _, _, paths = group(world, OBJECTS, 21)
    assert "/base/turn/link/slide/cell/end/wrist_ball/wrist" in paths
    assert {"/Copy[0]", "/Copy[1]"} <= set(paths)
    assert [world.handle(path) for path in paths] == handles


def test_types_and_parents(world: World) -> None:
    handles, types, floats, strings = group(world, OBJECTS, 1)
    assert (floats, strings) == ([], [])
    assert types == [int(world.sim.scene.get(handle).kind) for handle in handles]
    assert set(types) == {SHAPE, JOINT, DUMMY, PROXIMITY, VISION, FORCE, LIGHT}
    handles, parents, floats, strings = group(world, OBJECTS, 2)
    assert (floats, strings) == ([], [])
    assert parents == [world.call("simxGetObjectParent", handle) for handle in handles]
    assert -1 in parents


def row_of(world: World, name: str, data: int, kind: int = OBJECTS) -> tuple[list[int], list[float]]:
    """The ints and floats of one object."""
    handles, ints, floats, _ = group(world, kind, data)
    index, count = handles.index(world.handle(name)), len(handles)
    int_stride, float_stride = len(ints) // count, len(floats) // count
    return (
        ints[int_stride * index : int_stride * (index + 1)],
        floats[float_stride * index : float_stride * (index + 1)],
    )


def test_proximity_state_and_object_then_point_and_normal(world: World) -> None:
    ints, floats = row_of(world, "ahead", 13)
    detected, point, handle, normal = world.call("simxReadProximitySensor", world.handle("ahead"))
    assert detected
    assert ints == [1, handle]
    assert handle == world.handle("floor")
    assert floats == [*point, *normal]
    assert row_of(world, "blind", 13) == ([0, -1], [0.0] * 6)
    assert row_of(world, "asked", 13) == ([-1, -1], [0.0] * 6)


def test_force_state_then_force_and_torque(world: World) -> None:
    state, force, torque = world.call("simxReadForceSensor", world.handle("cell"))
    assert row_of(world, "cell", 14) == ([state], [*force, *torque])
    assert state == 1
    assert any(force)


def test_joint_position_and_force(world: World) -> None:
    for name in ("turn", "slide", "roll"):
        ints, floats = row_of(world, name, 15)
        handle = world.handle(name)
        assert ints == []
        assert floats == [world.call("simxGetJointPosition", handle), world.call("simxGetJointForce", handle)]
    assert row_of(world, "roll", 15)[1][0] != 0.0
    assert row_of(world, "wrist_ball", 15) == ([], [0.0, 0.0])


def test_joint_type_and_mode_then_interval_as_a_range(world: World) -> None:
    assert row_of(world, "turn", 16) == ([10, 5], [-1.0, 3.0])
    assert row_of(world, "slide", 16) == ([11, 5], [-0.5, 1.0])
    ints, floats = row_of(world, "roll", 16)
    assert ints == [10, 5]
    assert floats[1] == -1.0
    assert row_of(world, "wrist_ball", 16)[0][0] == 12


def test_hybrid_operation_adds_65536() -> None:
    world = World(SCENE.replace("simx:joint:roll", "simx:joint:turn").replace(
        "mode=force motor=on control=velocity target_velocity=1 cyclic=yes", "mode=ik hybrid=on"))  # fmt: skip
    assert row_of(world, "turn", 16)[0] == [10, 2 + 65536]


WRONG_KIND: dict[int, tuple[list[int], list[float]]] = {
    13: ([-1, -1], [0.0] * 6),
    14: ([-1], [0.0] * 6),
    15: ([], [0.0] * 2),
    16: ([-1, -1], [0.0] * 2),
}


@pytest.mark.parametrize("data", WRONG_KIND)
def test_objects_of_another_kind_keep_the_stride(world: World, data: int) -> None:
    own = {13: PROXIMITY, 14: FORCE, 15: JOINT, 16: JOINT}[data]
    for kind in {SHAPE, JOINT, DUMMY, PROXIMITY, VISION, FORCE, LIGHT} - {own}:
        handles, ints, floats, strings = group(world, kind, data)
        expected_ints, expected_floats = WRONG_KIND[data]
        assert handles
        assert ints == expected_ints * len(handles)
        assert floats == expected_floats * len(handles)
        assert strings == []


def test_stopped_simulation_has_no_sensor_values() -> None:
    world = World(SCENE)
    assert row_of(world, "ahead", 13) == ([-1, -1], [0.0] * 6)
    assert row_of(world, "cell", 14) == ([0], [0.0] * 6)


def test_collection_gives_its_members(world: World) -> None:
    some = world.call("simxGetCollectionHandle", "some")
    handles, _, _, names = group(world, some, 0)
    assert set(names) == {"tip", "floor", "end", "wrist_ball", "wrist"}
    assert group(world, some, 3)[2] == [
        value for handle in handles for value in world.call(POSITION, handle, -1)
    ]


def test_kind_without_objects_is_empty(world: World) -> None:
    assert group(world, 8, 0) == ([], [], [], [])


def test_unknown_data_gives_the_handles_alone(world: World) -> None:
    for data in (-1, 22, 99):
        assert group(world, VISION, data) == ([world.handle("eye")], [], [], [])


@pytest.mark.parametrize("kind", [-2, -1, 108, 110, 2_000_050])
def test_anything_else_is_an_error(world: World, kind: int) -> None:
    with pytest.raises(CommandError, match="is no object type"):
        group(world, kind, 0)


def test_all_lists_are_plain_numbers_and_texts(world: World) -> None:
    for data in range(22):
        handles, ints, floats, strings = group(world, OBJECTS, data)
        values: list[Any] = [*handles, *ints]
        assert {type(value) for value in values} == {int}
        assert all(type(value) is float and math.isfinite(value) for value in floats)
        assert all(type(value) is str for value in strings)
