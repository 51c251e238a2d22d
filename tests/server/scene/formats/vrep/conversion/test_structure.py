"""Which body each object of a V-REP file gets, and what its joints do."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from handler_calls import World

from simx_server.editing import object_flags
from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.conversion.unique_names import UniqueNames
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.objects import (
    Dummy,
    ForceSensor,
    Joint,
    JointType,
    Leaf,
    Primitive,
    Shape,
    VrepFile,
    VrepObject,
)
from simx_server.scene.objects import Scene
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import conjugate

QUARTER = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)


def box(handle: int, name: str, parent: int = -1, **values: Any) -> Shape:
    leaf = Leaf(primitive=Primitive.CUBOID, size=(0.1, 0.1, 0.1), vertices=_CORNERS, triangles=_FACES)
    return Shape(
        handle=handle,
        name=name,
        parent=parent,
        leaves=[leaf],
        mass=1.0,
        inertia=(0.002, 0.002, 0.002),
        **{"is_dynamic": True, **values},
    )


_CORNERS = np.array(
    [[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)], np.float32
)
_FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ],
    np.int32,
)


def at(x: float, y: float, z: float, quat: Any = (1.0, 0.0, 0.0, 0.0)) -> Any:
    return (x, y, z), quat


def file_of(*objects: VrepObject) -> VrepFile:
    return VrepFile(name="f.ttt", serialization=21, program=(3, 6, 0), objects={o.handle: o for o in objects})


def built(*objects: VrepObject) -> tuple[Scene, mujoco.MjModel]:
    spec, _ = convert(file_of(*objects))
    return build(spec, None)


def world_of(*objects: VrepObject) -> World:
    spec, _ = convert(file_of(*objects))
    spec.compile()
    return World(spec.to_xml())


def pose(world: World, name: str) -> tuple[list[float], list[float]]:
    scene = world.sim.scene
    position, quat = frames.get_pose(world.sim, scene.resolve(name))
    return list(position), list(quat)


def parent_of(scene: Scene, name: str) -> str | None:
    above = scene.objects[scene.resolve(name)].parent
    return None if above == -1 else scene.objects[above].name


def test_a_dynamic_shape_below_a_shape_is_free_but_keeps_its_parent() -> None:
    scene, model = built(box(0, "table", is_dynamic=False), box(1, "cup", 0, pose=at(0, 0, 1)))
    assert parent_of(scene, "cup") == "table"
    assert model.body("cup").jntnum[0] == 1
    assert model.body("cup").parentid[0] == 0


def test_a_link_hangs_on_its_joint_and_frames_are_those_of_the_file() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(handle=1, parent=0, name="axis", pose=at(0, 0, 1, QUARTER), position=0.5, is_cyclic=True),
        box(2, "arm", 1, pose=at(0.2, 0, 0)),
    )
    position, quat = pose(world, "axis")
    assert position == pytest.approx([0, 0, 1])
    assert quat == pytest.approx(list(QUARTER), abs=1e-6)
    assert pose(world, "arm")[0] == pytest.approx([0.2 * math.cos(0.5), 0, 1 + 0.2 * math.sin(0.5)])
    assert world.call("simxGetJointPosition", world.sim.scene.resolve("axis")) == pytest.approx(0.5)


def test_a_prismatic_joint_keeps_its_frame_and_position() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(
            handle=1,
            parent=0,
            name="rail",
            type=JointType.PRISMATIC,
            pose=at(1, 0, 0),
            position=0.3,
            range=1.0,
        ),
        box(2, "slide", 1, pose=at(0, 0, 0.1)),
    )
    assert pose(world, "rail")[0] == pytest.approx([1, 0, 0])
    assert pose(world, "slide")[0] == pytest.approx([1, 0, 0.4])


def test_a_spherical_joint_starts_with_the_turn_of_the_file() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(handle=1, parent=0, name="ball", type=JointType.SPHERICAL, turn=QUARTER),
        box(2, "arm", 1, pose=at(0, 1, 0)),
    )
    assert pose(world, "ball")[1] == pytest.approx([1, 0, 0, 0])
    assert pose(world, "arm")[0] == pytest.approx([0, 0, 1], abs=1e-9)


def test_a_force_sensor_holds_a_dynamic_shape() -> None:
    scene, model = built(
        box(0, "base", is_dynamic=False), ForceSensor(handle=1, parent=0, name="cell"), box(2, "load", 1)
    )
    assert parent_of(scene, "load") == "cell"
    assert parent_of(scene, "cell") == "base"
    assert model.nv == 0
    assert "load" in scene.welded_bodies


def test_static_shapes_ride_along_without_weight() -> None:
    scene, model = built(
        box(0, "base"),
        box(1, "cover", 0, is_dynamic=False),
        Dummy(handle=2, parent=0, name="frame"),
        box(3, "plate", 2, is_dynamic=False),
    )
    assert model.body_subtreemass[model.body("base").id] == pytest.approx(1.0)
    assert parent_of(scene, "plate") == "frame"
    assert scene.objects[scene.resolve("frame")].kind.text == "dummy"


@pytest.mark.parametrize("bits", [0, 0x2, 0x1F0, 0x30, 0x1F3])
def test_a_dummy_has_the_special_properties_of_the_file(bits: int) -> None:
    world = world_of(Dummy(handle=0, name="frame", properties=bits), Dummy(handle=1, name="leaf", parent=0))
    assert object_flags.special_flags(world.parts, world.handle("frame")) == bits
    assert object_flags.special_flags(world.parts, world.handle("leaf")) == 0


def test_a_joint_in_force_mode_without_a_dynamic_shape_stays_where_it_is_put() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(handle=1, parent=0, name="axis", pose=at(0, 0, 1, QUARTER), is_cyclic=True),
        box(2, "arm", 1, pose=at(0.2, 0, 0), is_dynamic=False),
    )
    axis = world.sim.scene.resolve("axis")
    world.call("simxSetJointPosition", axis, 0.4)
    world.sim.start()
    for _ in range(20):
        world.parts.step()
    assert world.call("simxGetJointPosition", axis) == pytest.approx(0.4)
    assert world.call("simxGetObjectIntParameter", world.sim.scene.resolve("arm"), 3003) == 1


def test_a_link_becomes_static_and_dynamic_again() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(handle=1, parent=0, name="axis", pose=at(0, 0, 1, QUARTER), is_cyclic=True),
        box(2, "arm", 1, pose=at(0.2, 0, 0)),
    )
    axis, arm = world.sim.scene.resolve("axis"), world.sim.scene.resolve("arm")
    world.call("simxSetObjectIntParameter", arm, 3003, 1)
    assert world.call("simxGetObjectIntParameter", arm, 3003) == 1
    world.sim.start()
    world.parts.step()
    assert world.call("simxGetJointPosition", axis) == 0.0
    world.call("simxSetObjectIntParameter", arm, 3003, 0)
    assert world.call("simxGetObjectIntParameter", arm, 3003) == 0
    for _ in range(4):
        world.parts.step()
    assert abs(world.call("simxGetJointPosition", axis)) > 0.1


def test_a_position_controlled_joint_holds_its_load_and_reaches_its_target() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(
            handle=1, parent=0, name="axis", pose=at(0, 0, 1, QUARTER), is_cyclic=True, motor=True,
            control="position", max_force=100.0, target_position=0.5, upper_velocity=2.0,
        ),
        box(2, "arm", 1, pose=at(0.5, 0, 0)),
    )  # fmt: skip
    world.sim.start()
    for _ in range(40):
        world.parts.step()
    assert world.call("simxGetJointPosition", world.sim.scene.resolve("axis")) == pytest.approx(0.5, abs=2e-3)


def test_two_linked_dummies_close_a_chain() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False, pose=at(0, 0, 1)),
        Dummy(handle=1, parent=0, name="hook", pose=at(0, 0, -0.2), linked=3),
        box(2, "load", pose=at(0, 0, 0.6)),
        Dummy(handle=3, parent=2, name="ring", pose=at(0, 0, 0.2), linked=1),
    )
    world.sim.start()
    for _ in range(20):
        world.parts.step()
    assert pose(world, "load")[0] == pytest.approx([0, 0, 0.6], abs=1e-3)


def test_a_chain_that_ends_on_a_ball_joint_bears_load_at_its_lever() -> None:
    hinge = Joint(handle=1, parent=0, name="hinge", pose=at(0, 0, 0, QUARTER), is_cyclic=True)
    world = world_of(
        box(0, "base", is_dynamic=False, pose=at(0, 0, 1)),
        hinge,
        box(2, "arm", 1, pose=at(0.5, 0, 0)),
        Joint(handle=3, parent=0, name="ball", pose=at(0, 0, -0.1), type=JointType.SPHERICAL),
        Dummy(handle=4, parent=3, name="hook", pose=at(0, 0, 0.1), linked=5),
        Dummy(handle=5, parent=2, name="ring", pose=at(-0.5, 0, 0, conjugate(QUARTER)), linked=4),
    )
    world.sim.start()
    for _ in range(20):
        world.parts.step()
    turned = world.call("simxGetJointPosition", world.sim.scene.resolve("hinge"))
    assert turned == pytest.approx(0, abs=0.03), "5 N m on the lever of 0.1 m between ball and dummy"


def test_a_hinge_with_only_a_linked_dummy_stands_as_the_chain_wants() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False, pose=at(0, 0, 1)),
        Joint(handle=1, parent=0, name="axis", pose=at(0, 0, -0.2), is_cyclic=True),
        Dummy(handle=2, parent=1, name="hook", linked=4),
        box(3, "load", pose=at(0, 0, 0.6)),
        Dummy(handle=4, parent=3, name="ring", pose=at(0, 0, 0.2, (0.0, 0.0, 0.0, 1.0)), linked=2),
    )
    world.sim.start()
    for _ in range(20):
        world.parts.step()
    assert abs(world.call("simxGetJointPosition", world.sim.scene.resolve("axis"))) == pytest.approx(math.pi)
    place, turn = pose(world, "load")
    assert place == pytest.approx([0, 0, 0.6], abs=1e-3)
    assert abs(turn[0]) == pytest.approx(1.0, abs=1e-6), "it has not turned"


def test_a_dependent_joint_follows_its_master() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(handle=1, parent=0, name="lead", mode=0, is_cyclic=True),
        box(2, "a", 1, is_dynamic=False),
        Joint(handle=3, parent=0, name="rest", mode=4, is_cyclic=True, master=1, factor=-2.0, offset=0.1),
        box(4, "b", 3, is_dynamic=False),
    )
    world.call("simxSetJointPosition", world.sim.scene.resolve("lead"), 0.2)
    assert world.call("simxGetJointPosition", world.sim.scene.resolve("rest")) == pytest.approx(-0.3)


def test_a_stored_position_outside_the_limits_widens_them() -> None:
    _, model = built(
        box(0, "base", is_dynamic=False),
        Joint(handle=1, parent=0, name="axis", position=-0.2, minimum=0.0, range=1.0),
        box(2, "arm", 1),
    )
    assert model.joint("axis").range.tolist() == pytest.approx([-0.2, 1.0])


def test_a_model_that_is_not_dynamic_has_no_free_bodies() -> None:
    base = box(0, "base")
    base.is_model_base, base.model_properties = True, 0x20
    _, model = built(base, box(1, "part", 0))
    assert model.nv == 0


def test_names_become_unique_words_and_handles_follow_the_file() -> None:
    scene, _ = built(
        Dummy(handle=7, name="my part"), Dummy(handle=3, name="my_part"), Dummy(handle=5, name="~x/y")
    )
    assert [item.name for item in scene.objects.values()] == ["my_part", "my_part_0", "x_y"]


def test_a_name_that_a_damaged_file_repeats_very_often_takes_no_long_search() -> None:
    unique = UniqueNames("{}_{}", taken=["a_1"])
    assert [unique.take("a") for _ in range(4)] == ["a", "a_0", "a_2", "a_3"]
    assert len({unique.take("b") for _ in range(100_000)}) == 100_000


@pytest.mark.parametrize("force", [2.0, 10.0, 1000.0])
def test_a_light_wheel_with_a_strong_motor_keeps_its_velocity(force: float) -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(
            handle=1, parent=0, name="axle", pose=at(0, 0, 1), is_cyclic=True, motor=True,
            max_force=force, target_velocity=1.5,
        ),
        box(2, "wheel", 1),
    )  # fmt: skip
    axle = world.sim.scene.resolve("axle")
    world.sim.start()
    for _ in range(10):
        world.parts.step()
    before = world.call("simxGetJointPosition", axle)
    dof = int(world.sim.model.jnt_dofadr[world.sim.model.joint("axle").id])
    for _ in range(10):
        world.parts.step()
        assert world.sim.data.qvel[dof] == pytest.approx(1.5, rel=0.02)
    assert world.call("simxGetJointPosition", axle) - before == pytest.approx(0.75, rel=0.02)


def test_an_arm_under_velocity_control_at_0_holds_its_load() -> None:
    world = world_of(
        box(0, "base", is_dynamic=False),
        Joint(
            handle=1,
            parent=0,
            name="axis",
            pose=at(0, 0, 1, QUARTER),
            is_cyclic=True,
            motor=True,
            max_force=100.0,
        ),
        box(2, "arm", 1, pose=at(0.5, 0, 0)),
    )
    world.sim.start()
    for _ in range(40):
        world.parts.step()
    assert world.call("simxGetJointPosition", world.sim.scene.resolve("axis")) == pytest.approx(0, abs=2e-3)
