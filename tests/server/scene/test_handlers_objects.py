"""Objects, the tree, poses, group data and object parameters, asked as a client asks them."""

from __future__ import annotations

import math

import pytest
from handler_calls import World

from simx_server.errors import CommandError, UnknownHandle, UnknownName, WrongKind

SCENE = """
<mujoco>
  <worldbody>
    <body name="table" pos="1 2 0.5">
      <geom type="box" size="0.4 0.3 0.05" mass="3"/>
      <body name="lamp" pos="0 0 0.1" euler="0 0 90"><geom type="cylinder" size="0.1 0.2" mass="1"/></body>
      <site name="marker" pos="0.1 0 0"/>
    </body>
    <body name="ball" pos="0 0 1"><freejoint/><geom type="sphere" size="0.05" mass="0.2"/></body>
    <body name="wheel" pos="3 0 1"><joint name="axle"/><geom type="capsule" size="0.1 0.2" mass="1"/></body>
    <body name="drawer" pos="5 0 1"><joint name="rail" type="slide" range="-0.1 0.3" limited="true"/>
      <geom type="ellipsoid" size="0.1 0.2 0.3" mass="1"/></body>
    <body name="hip" pos="7 0 1"><joint name="ball_joint" type="ball"/><geom size="0.1" mass="1"/></body>
    <camera name="eye" pos="0 0 2"/>
  </worldbody>
  <custom><text name="simx:model:table" data="base=yes"/></custom>
</mujoco>
"""


@pytest.fixture
def world() -> World:
    return World(SCENE)


def test_a_name_of_any_length_is_refused_with_a_short_text(world: World) -> None:
    with pytest.raises(UnknownName) as caught:
        world.call("simxGetObjectHandle", "x" * 1_000_000)
    assert len(str(caught.value)) < 300


def test_unknown_name_lists_the_nearest_and_unknown_handle_the_valid_ones(world: World) -> None:
    with pytest.raises(UnknownName, match="did you mean 'table'"):
        world.call("simxGetObjectHandle", "tabel")
    with pytest.raises(UnknownHandle, match=r"handles of this scene are 1\.\."):
        world.call("simxGetObjectPosition", 99, -1)


def test_objects_of_a_type_and_of_all(world: World) -> None:
    everything = world.call("simxGetObjects", -2)
    assert everything == sorted(everything)
    assert len(everything) == len(world.sim.scene.objects)
    assert world.handle("axle") in world.call("simxGetObjects", 1)
    assert world.call("simxGetObjects", 9) == [world.handle("eye")]
    assert world.call("simxGetObjects", 14) == []


def test_parent_and_child_never_fail_but_leave_an_error_text(world: World) -> None:
    table, lamp, marker = (world.handle(name) for name in ("table", "lamp", "marker"))
    assert world.call("simxGetObjectParent", lamp) == table
    assert world.call("simxGetObjectParent", table) == -1
    children = [world.call("simxGetObjectChild", table, index) for index in range(3)]
    assert sorted(children[:2]) == sorted([lamp, marker])
    assert children[2] == -1
    assert not world.client.errors
    assert world.call("simxGetObjectParent", 99) == -1
    assert world.call("simxGetObjectChild", 99, 0) == -1
    assert len(world.client.errors) == 2


def test_poses_go_in_and_out(world: World) -> None:
    ball = world.handle("ball")
    world.call("simxSetObjectPosition", ball, world.handle("table"), [0.0, 0.0, 1.0])
    assert world.call("simxGetObjectPosition", ball, -1) == pytest.approx([1, 2, 1.5])
    world.call("simxSetObjectOrientation", ball, -1, [0.1, 0.2, 0.3])
    assert world.call("simxGetObjectOrientation", ball, -1) == pytest.approx([0.1, 0.2, 0.3])
    world.call("simxSetObjectQuaternion", ball, -1, [0.0, 0.0, 1.0, 1.0])
    assert world.call("simxGetObjectQuaternion", ball, -1) == pytest.approx([0, 0, 0.5**0.5, 0.5**0.5])
    assert world.call("simxGetObjectPosition", world.handle("lamp"), -11) == pytest.approx([0, 0, 0.1])


def test_velocity_is_zero_while_stopped_and_measured_over_the_last_step(world: World) -> None:
    ball = world.handle("ball")
    assert world.call("simxGetObjectVelocity", ball) == ([0, 0, 0], [0, 0, 0])
    world.run(2)
    linear, _ = world.call("simxGetObjectVelocity", ball)
    assert linear[2] == pytest.approx(-9.81 * 0.075, rel=0.05)
    assert world.call("simxGetObjectVelocity", ball + 0x400000)[0] == linear
    assert world.call("simxGetObjectFloatParameter", ball, 13) == pytest.approx(linear[2])


def test_removed_object_is_unknown_until_stop(world: World) -> None:
    ball = world.handle("ball")
    world.run()
    world.call("simxRemoveObject", ball)
    with pytest.raises(UnknownHandle):
        world.call("simxGetObjectPosition", ball, -1)
    world.call("simxStopSimulation")
    assert world.call("simxGetObjectPosition", ball, -1) == pytest.approx([0, 0, 1])


def test_everything_is_removed_and_a_new_dummy_gets_a_higher_handle(world: World) -> None:
    highest = max(world.call("simxGetObjects", -2))
    world.run()
    dummy = world.call("simxCreateDummy", 0.1, None)
    assert dummy > highest
    assert dummy in world.call("simxGetObjects", 4)
    world.call("simxRemoveObject", -2)
    assert world.call("simxGetObjects", -2) == []
    world.call("simxStopSimulation")
    assert max(world.call("simxGetObjects", -2)) == highest


def test_parent_changes_in_place(world: World) -> None:
    ball, table = world.handle("ball"), world.handle("table")
    world.call("simxSetObjectParent", ball, table, True)
    assert world.call("simxGetObjectParent", ball) == table
    assert world.call("simxGetObjectPosition", ball, -1) == pytest.approx([0, 0, 1])
    with pytest.raises(CommandError, match="assembly"):
        world.call("simxSetObjectParent", ball + 0x400000, table, False)


def test_selection_keeps_existing_handles_only(world: World) -> None:
    ball, table = world.handle("ball"), world.handle("table")
    world.call("simxSetObjectSelection", [ball, 99, table, ball])
    assert world.call("simxGetObjectSelection") == [ball, table]
    world.run()
    world.call("simxRemoveObject", ball)
    assert world.call("simxGetObjectSelection") == [table]


def test_model_property_tells_bases_from_others(world: World) -> None:
    assert world.call("simxGetModelProperty", world.handle("table")) == 0
    assert world.call("simxGetModelProperty", world.handle("ball")) == 0xF000


@pytest.mark.parametrize(
    ("data_type", "ints", "floats", "strings"),
    [
        (0, 0, 0, 1), (1, 1, 0, 0), (2, 1, 0, 0), (3, 0, 3, 0), (4, 0, 3, 0), (5, 0, 3, 0), (6, 0, 3, 0),
        (7, 0, 4, 0), (8, 0, 4, 0), (9, 0, 6, 0), (10, 0, 6, 0), (11, 0, 7, 0), (12, 0, 7, 0), (13, 2, 6, 0),
        (14, 1, 6, 0), (15, 0, 2, 0), (16, 2, 2, 0), (17, 0, 3, 0), (18, 0, 3, 0), (19, 0, 6, 0), (20, 0, 0, 1),
        (21, 0, 0, 1), (22, 0, 0, 0), (-1, 0, 0, 0),
    ],
)  # fmt: skip
def test_group_data_has_a_constant_stride(
    world: World, data_type: int, ints: int, floats: int, strings: int
) -> None:
    handles, *lists = world.call("simxGetObjectGroupData", 109, data_type)
    assert handles == world.call("simxGetObjects", -2)
    assert [len(values) for values in lists] == [len(handles) * n for n in (ints, floats, strings)]


def test_group_data_says_what_single_calls_say(world: World) -> None:
    handles, _, _, names = world.call("simxGetObjectGroupData", 0, 0)
    assert [world.handle(name) for name in names] == handles
    _, _, values, _ = world.call("simxGetObjectGroupData", 0, 9)
    for index, handle in enumerate(handles):
        row = values[6 * index : 6 * index + 6]
        assert row[:3] == world.call("simxGetObjectPosition", handle, -1)
        assert row[3:] == world.call("simxGetObjectOrientation", handle, -1)
    joints, kinds, ranges, _ = world.call("simxGetObjectGroupData", 1, 16)
    by_name = dict(zip([world.sim.scene.get(h).name for h in joints], range(len(joints)), strict=True))
    rail, axle, hip = by_name["rail"], by_name["axle"], by_name["ball_joint"]
    assert kinds[2 * rail] == 11
    assert ranges[2 * rail : 2 * rail + 2] == pytest.approx([-0.1, 0.4])
    assert kinds[2 * axle] == 10
    assert ranges[2 * axle + 1] == -1.0
    assert kinds[2 * hip] == 12


def test_group_data_of_no_object_type_is_an_error(world: World) -> None:
    assert world.call("simxGetObjectGroupData", 14, 0) == ([], [], [], [])
    for wrong in (-2, 108, 110):
        with pytest.raises(CommandError, match="no object type"):
            world.call("simxGetObjectGroupData", wrong, 0)


def test_joint_commands_reach_the_joint(world: World) -> None:
    axle, rail, hip = (world.handle(name) for name in ("axle", "rail", "ball_joint"))
    world.call("simxSetJointPosition", rail, 7.0)
    assert world.call("simxGetJointPosition", rail) == pytest.approx(0.3)
    world.call("simxSetJointPosition", axle, 0.5)
    assert world.call("simxGetJointMatrix", axle)[:2] == pytest.approx([math.cos(0.5), -math.sin(0.5)])
    world.call("simxSetJointMaxForce", axle, 5.0)
    assert world.call("simxGetJointMaxForce", axle) == 5.0
    world.call("simxSetJointTargetVelocity", axle, 1.0)
    assert world.call("simxJointGetForce", axle) == 0.0
    world.run(4)
    assert world.call("simxGetObjectFloatParameter", axle, 2012) == pytest.approx(1.0, abs=0.05)
    turn = [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0]
    world.call("simxSetSphericalJointMatrix", hip, [float(value) for value in turn])
    assert world.call("simxGetJointMatrix", hip) == pytest.approx(turn, abs=1e-9)
    for wrong in ("simxGetJointPosition", "simxGetJointForce"):
        with pytest.raises(CommandError):
            world.call(wrong, hip)
        with pytest.raises(WrongKind, match="needs a joint"):
            world.call(wrong, world.handle("table"))


def test_bounding_box_is_that_of_the_shapes_in_the_objects_frame(world: World) -> None:
    def box(name: str, first: int = 15) -> list[float]:
        handle = world.handle(name)
        return [world.call("simxGetObjectFloatParameter", handle, first + i) for i in range(6)]

    assert box("table") == pytest.approx([-0.4, -0.3, -0.05, 0.4, 0.3, 0.05])
    assert box("lamp") == pytest.approx([-0.1, -0.1, -0.2, 0.1, 0.1, 0.2])
    assert box("wheel") == pytest.approx([-0.1, -0.1, -0.3, 0.1, 0.1, 0.3])
    assert box("drawer") == pytest.approx([-0.1, -0.2, -0.3, 0.1, 0.2, 0.3])
    assert box("table", 21) == pytest.approx([-0.4, -0.3, -0.1, 0.4, 0.3, 0.3])
    assert box("axle") == pytest.approx([-0.01, -0.01, -0.075, 0.01, 0.01, 0.075])


def test_parameters_of_an_object_know_their_kind_and_number(world: World) -> None:
    axle, ball = world.handle("axle"), world.handle("ball")
    world.call("simxSetObjectIntParameter", axle, 2000, 1)
    world.call("simxSetObjectIntParameter", axle, 2001, 0)
    assert world.call("simxGetObjectIntParameter", axle, 2000) == 1
    world.call("simxSetObjectFloatParameter", axle, 2017, 2.5)
    assert world.call("simxGetObjectFloatParameter", axle, 2017) == 2.5
    with pytest.raises(CommandError, match="use the Int command"):
        world.call("simxGetObjectFloatParameter", axle, 2000)
    with pytest.raises(CommandError, match="cannot be set"):
        world.call("simxSetObjectFloatParameter", axle, 2012, 1.0)
    with pytest.raises(CommandError, match="3005 shapefloatparam_mass"):
        world.call("simxGetObjectFloatParameter", ball, 4711)


def test_mass_and_collision_of_a_shape_change_and_come_back_at_stop(world: World) -> None:
    ball, table = world.handle("ball"), world.handle("table")
    assert world.call("simxGetObjectIntParameter", table, 3003) == 1
    assert world.call("simxGetObjectIntParameter", ball, 3003) == 0
    world.run()
    world.call("simxSetObjectIntParameter", ball, 3003, 1)
    assert world.call("simxGetObjectIntParameter", ball, 3003) == 1
    world.call("simxSetObjectIntParameter", ball, 3003, 0)
    wheel = world.handle("wheel")
    world.call("simxSetObjectIntParameter", wheel, 3003, 1)
    assert world.call("simxGetObjectIntParameter", wheel, 3003) == 1
    world.call("simxSetObjectFloatParameter", ball, 3005, 0.4)
    world.call("simxSetObjectIntParameter", ball, 3004, 0)
    assert world.call("simxGetObjectFloatParameter", ball, 3005) == pytest.approx(0.4)
    assert world.call("simxGetObjectIntParameter", ball, 3004) == 0
    world.call("simxSetObjectIntParameter", ball, 3004, 1)
    assert world.call("simxGetObjectIntParameter", ball, 3004) == 1
    with pytest.raises(CommandError, match="above 0"):
        world.call("simxSetObjectFloatParameter", ball, 3005, 0.0)
    world.call("simxStopSimulation")
    assert world.call("simxGetObjectFloatParameter", ball, 3005) == pytest.approx(0.2)
