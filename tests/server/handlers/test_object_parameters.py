"""Numbered parameters of objects: layers, velocities, boxes, first velocities, respondable masks, other kinds."""

from __future__ import annotations

import math

import pytest
from handler_calls import World

from simx_server.errors import CommandError, WrongKind

SCENE = """
<mujoco>
  <option integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <light name="sun" pos="0 0 3"/>
    <camera name="eye" pos="0 0 2"/>
    <camera name="view" pos="0 -2 2" fovy="50" resolution="200 100"/>
    <body name="ball" pos="0 0 1" euler="0 0 90"><freejoint/><geom type="sphere" size="0.05" mass="0.2"/></body>
    <body name="box" pos="0 0 2"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/>
      <site name="corner" pos="0.1 0 0"/><site name="mark" type="box" size="0.01 0.02 0.03"/></body>
    <body name="arm" pos="3 0 1"><joint name="hinge" axis="0 1 0"/><geom size="0.1" mass="1"/>
      <body name="hidden" pos="0 0 0.1"><geom size="0.1" mass="0.1" group="3"/><geom size="0.05" pos="0 0 0.1"/></body>
      <body name="shell" pos="0 0 0.2"><geom size="0.1" mass="0.1" group="3"/></body>
      <site name="far" pos="0.2 0 0"/></body>
    <site name="post" pos="2 2 0"/>
  </worldbody>
  <equality><connect name="loop" site1="corner" site2="post" active="false"/></equality>
  <custom><text name="simx:camera:view" data="view=yes"/></custom>
</mujoco>
"""


@pytest.fixture
def world() -> World:
    return World(SCENE)


def read(world: World, name: str, *numbers: int) -> list[float]:
    return [world.call("simxGetObjectFloatParameter", world.handle(name), number) for number in numbers]


def read_int(world: World, name: str, number: int) -> int:
    return world.call("simxGetObjectIntParameter", world.handle(name), number)


def write(world: World, name: str, number: int, value: float) -> None:
    world.call("simxSetObjectFloatParameter", world.handle(name), number, value)


def write_int(world: World, name: str, number: int, value: int) -> None:
    world.call("simxSetObjectIntParameter", world.handle(name), number, value)


def test_velocities_are_those_of_the_last_step(world: World) -> None:
    assert read(world, "ball", 11, 12, 13, 14) == [0, 0, 0, 0]
    world.run(2)
    linear, _ = world.call("simxGetObjectVelocity", world.handle("ball"))
    assert read(world, "ball", 11, 12, 13) == linear
    assert linear[2] == pytest.approx(-9.81 * 0.075, rel=0.03)


def test_layers_say_what_cameras_show_and_come_back_at_stop(world: World) -> None:
    assert [read_int(world, name, 10) for name in ("ball", "eye", "hidden", "shell")] == [1, 1, 1, 256]
    assert [read_int(world, name, 36) for name in ("ball", "shell")] == [1, 0]
    world.run()
    write_int(world, "ball", 10, 512)
    assert (read_int(world, "ball", 10), read_int(world, "ball", 36)) == (512, 0)
    world.call("simxSetIntegerParameter", 11, 512 | 255)
    assert read_int(world, "ball", 36) == 1
    world.call("simxStopSimulation")
    assert read_int(world, "ball", 10) == 1
    with pytest.raises(CommandError, match="16 bits"):
        write_int(world, "ball", 10, 65536)


def test_boxes_are_in_the_objects_own_frame_for_dummies_too(world: World) -> None:
    assert read(world, "ball", *range(15, 21)) == pytest.approx([-0.05] * 3 + [0.05] * 3)
    assert read(world, "mark", *range(15, 21)) == pytest.approx([-0.01, -0.02, -0.03, 0.01, 0.02, 0.03])
    assert read(world, "arm", *range(21, 27)) == pytest.approx([-0.1, -0.1, -0.1, 0.205, 0.1, 0.3])
    before = read(world, "arm", *range(21, 27))
    world.call("simxSetObjectOrientation", world.handle("arm"), -1, [0.3, 0.2, 0.1])
    assert read(world, "arm", *range(21, 27)) == pytest.approx(before)


def test_first_velocity_is_given_at_the_start_and_is_there_again_after_the_stop(world: World) -> None:
    for number, value in ((3000, 0.5), (3001, -0.25), (3020, 2.0)):
        write(world, "ball", number, value)
    assert not world.sim.data.qvel.any()
    world.run(1)
    linear, euler_rates = world.call("simxGetObjectVelocity", world.handle("ball"))
    assert linear[:2] == pytest.approx([0.5, -0.25])
    assert euler_rates == pytest.approx([2, 0, 0], abs=1e-6)
    assert read(world, "ball", 3000, 3020) == [0, 0]
    world.call("simxStopSimulation")
    assert read(world, "ball", 3000, 3001, 3002, 3020, 3021, 3022) == pytest.approx([0.5, -0.25, 0, 2, 0, 0])
    assert not world.sim.data.qvel.any()
    world.run(1)
    assert world.call("simxGetObjectVelocity", world.handle("ball"))[0][0] == pytest.approx(0.5)


def test_in_a_run_the_first_velocity_waits_for_the_next_placing(world: World) -> None:
    """How scripts throw: V-REP adds a shape that was placed to its physics again."""
    world.run(1)
    write(world, "ball", 3002, 3.0)
    world.parts.step()
    assert read(world, "ball", 13)[0] < 0
    world.call("simxSetObjectPosition", world.handle("ball"), -1, [1.0, 1.0, 1.0])
    world.parts.step()
    world.parts.step()
    assert read(world, "ball", 13) == pytest.approx([3 - 9.81 * 0.075], rel=0.01)
    world.call("simxSetObjectPosition", world.handle("ball"), -1, [1.0, 1.0, 1.0])
    world.parts.step()
    world.parts.step()
    assert read(world, "ball", 13)[0] < 0
    with pytest.raises(CommandError, match="part of a mechanism or of the world"):
        write(world, "arm", 3000, 1.0)


def test_masks_decide_who_meets_whom(world: World) -> None:
    """The box falls past the ball's place: between trees the high bytes count, within one the low ones."""
    assert read_int(world, "ball", 3019) == 0xFFFF
    write_int(world, "ball", 3019, 0x0FFF)
    write_int(world, "box", 3019, 0xF0FF)
    pairs = {tuple(sorted((e.bodyname1, e.bodyname2))) for e in world.sim.scene.spec.excludes}
    assert pairs == {("ball", "box")}
    world.call("simxSetObjectParent", world.handle("box"), world.handle("ball"), True)
    assert not world.sim.scene.spec.excludes
    write_int(world, "box", 3019, 0xF0F0)
    write_int(world, "ball", 3019, 0x0F0F)
    assert len(world.sim.scene.spec.excludes) == 1
    write_int(world, "ball", 3019, 0xFFFF)
    assert not world.sim.scene.spec.excludes
    with pytest.raises(CommandError, match="make it a body"):
        write_int(world, "floor", 3019, 1)
    with pytest.raises(CommandError, match="16 bits"):
        write_int(world, "ball", 3019, -1)


def test_masks_act_by_their_other_byte_when_what_held_two_trees_together_is_removed() -> None:
    world = World(
        """
        <mujoco><worldbody>
          <site name="top"/>
          <body name="a"><freejoint/><geom size="0.1"/></body>
          <body name="b" pos="0 0 1"><freejoint/><geom size="0.1"/></body>
        </worldbody></mujoco>
        """
    )
    a, b, top = (world.handle(name) for name in ("a", "b", "top"))
    for handle in (a, b):
        world.call("simxSetObjectParent", handle, top, True)
    write_int(world, "a", 3019, 0x00FF)
    assert not world.sim.scene.spec.excludes
    world.call("simxRemoveObject", top)
    assert len(world.sim.scene.spec.excludes) == 1


def test_shape_that_meets_nothing_falls_through_the_floor_until_the_stop(world: World) -> None:
    world.run(1)
    write_int(world, "ball", 3019, 0x00FF)
    for _ in range(14):
        world.parts.step()
    assert world.call("simxGetObjectPosition", world.handle("ball"), -1)[2] < -0.5
    assert world.call("simxGetObjectPosition", world.handle("box"), -1)[2] > 0.05
    world.call("simxStopSimulation")
    assert read_int(world, "ball", 3019) == 0xFFFF
    world.run(20)
    assert world.call("simxGetObjectPosition", world.handle("ball"), -1)[2] > 0.04


def test_mass_of_a_body_whose_motor_is_off_leaves_compensation_possible() -> None:
    """MuJoCo forgets gravity compensation altogether when no body has it at the moment a mass changes."""
    world = World("""<mujoco><option integrator="implicitfast"/><worldbody>
      <body name="lift" gravcomp="1"><joint name="rail" type="slide" axis="0 0 1"/><geom size="0.1" mass="1"/></body>
      </worldbody><custom><text name="simx:joint:rail" data="motor=off"/></custom></mujoco>""")
    write(world, "lift", 3005, 2.0)
    write_int(world, "rail", 2000, 1)
    world.run(10)
    assert world.call("simxGetJointPosition", world.handle("rail")) == pytest.approx(0, abs=1e-6)


def test_compound_and_static_shapes_are_told(world: World) -> None:
    assert [read_int(world, name, 3016) for name in ("ball", "hidden")] == [0, 1]
    assert [read_int(world, name, 3003) for name in ("ball", "floor")] == [0, 1]


def test_cameras_lights_and_linked_dummies_have_their_own(world: World) -> None:
    assert read(world, "view", 9001) == pytest.approx([2 * math.atan(2 * math.tan(math.radians(25)))])
    write(world, "view", 9001, 1.0)
    assert read(world, "view", 9001) == [1.0]
    assert read(world, "view", 9002) == [2.0]
    write_int(world, "view", 9010, 0)
    assert read_int(world, "view", 9010) == 0
    assert world.parts.vision.settings(world.handle("view")).orthographic_size == 2.0
    assert read_int(world, "sun", 8000) == 1
    write_int(world, "sun", 8000, 0)
    assert read_int(world, "sun", 8000) == 0
    assert not world.sim.model.light_castshadow[0]
    assert read_int(world, "corner", 10000) == 0
    assert read_int(world, "post", 10000) == 0
    with pytest.raises(CommandError, match="'far' is linked to no other dummy"):
        read_int(world, "far", 10000)


@pytest.mark.parametrize(
    ("name", "kind", "number", "value"),
    [("ball", "Int", 32, -1), ("ball", "Float", 28, 0.0)],
)
def test_what_can_have_one_value_only_says_so(
    world: World, name: str, kind: str, number: int, value: float
) -> None:
    handle = world.handle(name)
    assert world.call(f"simxGetObject{kind}Parameter", handle, number) == value
    world.call(f"simxSetObject{kind}Parameter", handle, number, value)
    with pytest.raises(CommandError, match="it stays"):
        world.call(f"simxSetObject{kind}Parameter", handle, number, value + 1)


def test_what_has_no_effect_keeps_its_value_until_the_stop_and_is_told_once(world: World) -> None:
    """Such as the manipulation with the mouse, and the place of a texture."""
    ball = world.handle("ball")
    world.sim.start()
    for value in (1.5, 2.5):
        world.call("simxSetObjectIntParameter", ball, 31, 3)
        world.call("simxSetObjectFloatParameter", ball, 3007, value)
    assert read_int(world, "ball", 31) == 3
    assert world.call("simxGetObjectFloatParameter", ball, 3007) == 2.5
    told = [text for text in world.parts.status_bar.messages if "has no effect" in text]
    assert ["3007" in text for text in told] == [False, True]
    world.sim.stop()
    assert world.call("simxGetObjectFloatParameter", ball, 3007) == 0.0


def test_unknown_numbers_list_the_known_ones_of_the_kind(world: World) -> None:
    for name, known in (
        ("ball", "3019 shapeintparam_respondable_mask"),
        ("hinge", "2030 jointintparam_velocity_lock"),
        ("hinge", "2039 jointintparam_dynctrlmode"),
        ("sun", "8000 lightintparam_pov_casts_shadows"),
        ("post", "10000 dummyintparam_link_type"),
        ("eye", "1002 visionintparam_resolution_x"),
    ):
        with pytest.raises(CommandError, match=known):
            read_int(world, name, 4711)
    with pytest.raises(CommandError, match="cannot be set"):
        write(world, "ball", 11, 1.0)
    with pytest.raises(CommandError, match="use the Float command"):
        read_int(world, "ball", 3005)
    with pytest.raises(WrongKind):
        world.parts.object_settings.mask(world.handle("eye"))


def test_shape_the_file_keeps_from_colliding_lands_when_it_is_made_respondable() -> None:
    world = World("""<mujoco><worldbody><geom type="plane" size="5 5 1"/>
      <body name="ball" pos="0 0 0.1"><freejoint/><geom size="0.05" mass="1" contype="0" conaffinity="0"/></body>
      </worldbody></mujoco>""")
    write_int(world, "ball", 3004, 1)
    write(world, "ball", 3005, 2.0)
    world.run(20)
    assert world.call("simxGetObjectPosition", world.handle("ball"), -1)[2] == pytest.approx(0.05, abs=1e-3)
