"""Every kind of object has a bounding box, and that of a model is around those of its objects, as in V-REP."""

from __future__ import annotations

import math

import pytest
from handler_calls import World
from vrep_samples import decoded, each_sample, needs_samples

from simx_server.editing import object_flags
from simx_server.editing.scaling_objects import scale_object
from simx_server.errors import CommandError
from simx_server.handlers.objects.bounding_box import of_object
from simx_server.scene.editing.editing import dummy_size, set_dummy_size
from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.objects import (
    Camera,
    Dummy,
    ForceSensor,
    Graph,
    Joint,
    JointType,
    Light,
    Path,
    PathPoint,
    ProximitySensor,
    VisionSensor,
    Volume,
    VrepFile,
    VrepObject,
)

HALF = math.sqrt(0.5)


def world_of(*objects: VrepObject) -> World:
    """The world of a V-REP file with these objects."""
    file = VrepFile(name="f.ttt", serialization=21, program=(3, 6, 0), objects={o.handle: o for o in objects})
    world = World()
    world.sim.use(*build(convert(file)[0], None))
    return world


def box(world: World, name: str, first: int = 15) -> list[float]:
    """Least and greatest x, y, z; `first`: the number of the parameter of the least x."""
    return [world.call("simxGetObjectFloatParameter", world.handle(name), first + i) for i in range(6)]


def model_box(world: World, name: str) -> list[float]:
    return box(world, name, 21)


def about(x: float, y: float, z: float) -> object:
    return pytest.approx([-x, -y, -z, x, y, z])


def cylinder(offset: float, reach: float) -> Volume:
    return Volume(type="cylinder", offset=offset, range=reach, radius=0.05, radius_far=0.1)


@pytest.mark.parametrize(
    ("item", "expected"),
    [
        (Dummy(handle=1, name="it", size=0.04), [-0.02, -0.02, -0.02, 0.02, 0.02, 0.02]),
        (Joint(handle=1, name="it", length=0.3, diameter=0.04, position=0.5), [-0.02, -0.02, -0.15, 0.02, 0.02, 0.15]),
        (Joint(handle=1, name="it", type=JointType.SPHERICAL, diameter=0.04), [-0.04] * 3 + [0.04] * 3),
        (Joint(handle=1, name="it", type=JointType.PRISMATIC), [-0.01, -0.01, -0.075, 0.01, 0.01, 0.075]),
        (ForceSensor(handle=1, name="it", size=0.06), [-0.03] * 3 + [0.03] * 3),
        (Camera(handle=1, name="it", size=0.1), [-0.05, -0.05, -0.26, 0.05, 0.22, 0.1]),
        (Light(handle=1, name="it", size=0.2), [-0.1] * 3 + [0.1] * 3),
        (Light(handle=1, name="it", size=0.2, type=1), [-0.1] * 3 + [0.1] * 3),
        (Light(handle=1, name="it", type=2), [-0.08, -0.08, -0.15, 0.08, 0.08, 0.05]),
        (Graph(handle=1, name="it", size=0.3), [-0.15] * 3 + [0.15] * 3),
        (Path(handle=1, name="it", size=0.02, points=[PathPoint(pose=((i, 0, 0), (1, 0, 0, 0))) for i in (0, 1)]),
         [-0.01] * 3 + [0.01] * 3),
        (ProximitySensor(handle=1, name="it", method="cylinder", volume=cylinder(-0.04, 0.2), size=0.01),
         [-0.1, -0.1, -0.04, 0.1, 0.1, 0.16]),
        (ProximitySensor(handle=1, name="it", method="cylinder", volume=cylinder(0.3, 0.2), size=0.04),
         [-0.1, -0.1, -0.02, 0.1, 0.1, 0.5]),
        (ProximitySensor(handle=1, name="it", method="cone",
                         volume=Volume(type="cone", range=0.8, radius=0.2, angle=1)),
         [-math.sin(0.5), -math.sin(0.5), -0.005, math.sin(0.5), math.sin(0.5), 1]),
        (ProximitySensor(handle=1, name="it", method="cone", volume=Volume(type="cone", range=1, angle=2 * math.pi)),
         [-1] * 3 + [1] * 3),
        (ProximitySensor(handle=1, name="it", method="disc", volume=Volume(type="disc", range=1, angle=1, y_size=0.1)),
         [-math.sin(0.5), -0.05, -0.005, math.sin(0.5), 0.05, 1]),
        (ProximitySensor(handle=1, name="it", method="ray", volume=Volume(type="ray", range=2), size=0.0001),
         [-0.001, -0.001, -0.00005, 0.001, 0.001, 2]),
        (ProximitySensor(handle=1, name="it", method="pyramid",
                         volume=Volume(type="pyramid", range=1, x_size=0.2, y_size=0.1, x_size_far=0.1,
                                       y_size_far=0.4)),
         [-0.1, -0.2, -0.005, 0.1, 0.2, 1]),
        (VisionSensor(handle=1, name="it", resolution=(64, 32), angle=math.pi / 2, near=0.1, far=2,
                      body=(0.1, 0.2, 0.3)),
         [-2, -1, -0.3, 2, 1, 2]),
        (VisionSensor(handle=1, name="it", resolution=(32, 64), is_perspective=False, orthographic_size=0.4, far=2),
         [-0.1, -0.2, -0.03, 0.1, 0.2, 2]),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, VrepObject) else "",
)  # fmt: skip
def test_each_kind_of_object_has_its_box(item: VrepObject, expected: list[float]) -> None:
    assert box(world_of(item), "it") == pytest.approx(expected, abs=1e-6)


def test_dummy_with_objects_below_keeps_its_size() -> None:
    world = world_of(Dummy(handle=0, name="base", size=0.03), Dummy(handle=1, name="leaf", parent=0))
    assert box(world, "base") == about(0.015, 0.015, 0.015)
    base = world.handle("base")
    assert dummy_size(world.sim, base) == pytest.approx(0.03)
    set_dummy_size(world.sim, base, 0.05)
    assert box(world, "base") == about(0.025, 0.025, 0.025)


def test_box_of_a_model_is_around_the_boxes_of_its_objects() -> None:
    turned = (0.0, 0.0, 1.0), (math.cos(math.pi / 8), 0.0, 0.0, math.sin(math.pi / 8))
    world = world_of(
        Dummy(handle=0, name="base"),
        Joint(handle=1, parent=0, name="axis", pose=((0, 0.5, 0), (HALF, 0.0, HALF, 0.0)), length=0.4),
        Dummy(handle=2, parent=1, name="leaf", size=0.02, pose=turned),
    )
    corner = 0.01 * math.sqrt(2)
    assert model_box(world, "leaf") == about(0.01, 0.01, 0.01)
    expected = [-0.2, min(-0.005, 0.5 - corner), -corner, 1.01, 0.5 + corner, corner]
    assert model_box(world, "base") == pytest.approx(expected)
    assert model_box(world, "axis")[2] == pytest.approx(-0.2), "in the joint's own frame"


def test_objects_and_models_that_are_hidden_from_it_do_not_count_for_the_box_of_a_model() -> None:
    far = ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    farther = ((0.0, 3.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    world = world_of(
        Dummy(handle=0, name="base"),
        Dummy(handle=1, parent=0, name="hidden", pose=far, flags=0x120),
        Dummy(handle=2, parent=1, name="below", pose=far),
        Dummy(handle=3, parent=0, name="other", pose=farther, is_model_base=True, model_properties=0x400),
        Dummy(handle=4, parent=3, name="its", pose=far),
    )
    assert model_box(world, "base") == pytest.approx([-0.005, -0.005, -0.005, 2.005, 0.005, 0.005])
    assert model_box(world, "other") == pytest.approx([-0.005, -0.005, -0.005, 1.005, 0.005, 0.005])
    assert model_box(world, "hidden")[3] == pytest.approx(1.005)
    assert object_flags.flags(world.parts, world.handle("hidden")) == 0x120
    object_flags.set_flags(world.parts, world.handle("below"), 0x120)
    assert model_box(world, "base")[3] == pytest.approx(0.005)
    with pytest.raises(CommandError, match="no object of the model 'hidden' counts"):
        model_box(world, "hidden")


def test_newer_properties_leave_out_the_volumes_of_sensors() -> None:
    looks = {"resolution": (64, 32), "angle": 1.0, "near": 0.1, "far": 2.0}
    world = world_of(VisionSensor(handle=0, name="eye", body=(0.1, 0.2, 0.3), **looks))  # type: ignore[arg-type]
    least, greatest = of_object(world.parts, world.handle("eye"), with_volumes=False)
    assert least == pytest.approx([-0.05, -0.1, -0.3])
    assert greatest == pytest.approx([0.05, 0.1, 0.0])


def test_boxes_are_scaled_with_their_objects() -> None:
    volume = Volume(type="cylinder", radius=0.1, radius_far=0.1, range=0.5)
    items = [
        Dummy(handle=0, name="dummy"),
        Joint(handle=1, name="joint", length=0.2, diameter=0.02),
        Camera(handle=2, name="camera"),
        Light(handle=3, name="light"),
        ProximitySensor(handle=4, name="nose", method="cylinder", volume=volume),
        VisionSensor(handle=5, name="eye"),
    ]
    world = world_of(*items)
    before = {item.name: box(world, item.name) for item in items}
    for item in items:
        scale_object(world.parts, world.handle(item.name), (2.0, 2.0, 2.0))
        assert box(world, item.name) == pytest.approx([2 * side for side in before[item.name]], rel=1e-5), (
            item.name
        )


def test_box_of_a_shape_follows_its_changes_and_not_its_pose() -> None:
    world = World(
        """
        <mujoco>
          <worldbody>
            <body name="cup" pos="1 2 3" euler="10 20 30">
              <geom type="box" size="0.1 0.2 0.3" pos="0.5 0 0"/>
              <geom type="box" size="0.1 0.1 0.2" pos="0 0 1" euler="0 90 0"/>
            </body>
          </worldbody>
        </mujoco>"""
    )
    expected = pytest.approx([-0.2, -0.2, -0.3, 0.6, 0.2, 1.1])
    assert box(world, "cup") == expected
    cup = world.handle("cup")
    first = of_object(world.parts, cup)
    world.call("simxSetObjectOrientation", cup, -1, [1.0, 0.5, 0.2])
    assert of_object(world.parts, cup) == first
    scale_object(world.parts, cup, (2.0, 2.0, 2.0))
    assert box(world, "cup") == pytest.approx([-0.4, -0.4, -0.6, 1.2, 0.4, 2.2])


@pytest.mark.slow
@needs_samples
@each_sample
def test_box_of_a_model_is_that_which_vrep_wrote_into_its_file(path) -> None:
    file = decoded(path)
    if not file.is_model or file.program >= (4, 3, 0) or not any(file.bounds):
        pytest.skip("no model with the box of a version that counts volumes")
    world = World(file=path)
    base, *_ = world.sim.scene.children(-1)  # the rest is the ground
    least, greatest = of_object(world.parts, base, whole_model=True)
    size = [high - low for low, high in zip(least, greatest, strict=True)]
    assert size == pytest.approx(list(file.bounds), abs=1e-4)
