"""Objects of files that the tests' own writer made, in all versions of the format."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import pytest
from vrep_writer import PROGRAMS, VrepWriter

from simx_server.scene.formats.vrep.objects import (
    Dummy,
    Engine,
    ForceSensor,
    Joint,
    JointType,
    Primitive,
    ProximitySensor,
    Shape,
    VisionSensor,
    VrepFile,
    VrepObject,
)
from simx_server.scene.formats.vrep.reading import read_file

VERSIONS = pytest.mark.parametrize("ser", sorted(PROGRAMS))
Kind = TypeVar("Kind", bound=VrepObject)


def read(writer: VrepWriter) -> VrepFile:
    return read_file(writer.bytes(), "test.ttt")


def only(writer: VrepWriter, kind: type[Kind]) -> Kind:
    """Read the file and return its only object of a kind."""
    (item,) = [each for each in read(writer).objects.values() if isinstance(each, kind)]
    return item


@VERSIONS
def test_the_header_tells_version_and_program(ser: int) -> None:
    writer = VrepWriter(ser, is_model=True)
    writer.dummy("base", model_base=True)
    file = read(writer)
    assert (file.serialization, file.program, file.is_model) == (ser, PROGRAMS[ser], True)


@VERSIONS
def test_an_object_keeps_what_all_objects_have(ser: int) -> None:
    writer = VrepWriter(ser)
    base = writer.dummy("base", model_base=True, model_properties=0x20)
    half = 0.5**0.5
    writer.dummy(
        "arm", parent=base, position=(1, 2, 3), quaternion=(half, 0, half, 0), alias="link", layers=0x100,
        properties=0x200, flags=0x1000, order=2, acknowledgement="thanks", custom_data={"a": b"1\0", "b": b""},
    )  # fmt: skip
    first, second = read(writer).objects.values()
    assert (first.is_model_base, second.is_model_base) == (True, False)
    assert (first.model_properties, first.parent, second.parent) == (0x20, -1, base)
    assert second.pose[0] == (1, 2, 3)
    assert second.pose[1] == pytest.approx((half, 0, half, 0))
    assert (second.name, second.layers, second.properties, second.flags) == ("arm", 0x100, 0x200, 0x1000)
    assert second.acknowledgement == "thanks"
    assert second.custom_data == {"a": b"1\0", "b": b""}
    has_alias = PROGRAMS[ser] >= (4, 3, 0)
    assert (second.alias, second.order) == (("link", 2) if has_alias else (None, None))


@VERSIONS
def test_a_shape_has_mesh_mass_and_flags(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.shape(
        "box", cuboid=(0.2, 0.4, 0.6), pose=((0, 0, 1), (1, 0, 0, 0)), mass=2.5, inertia=(0.1, 0.2, 0.3),
        center=(0, 0, 0.1), dynamic=True, respondable=True, mask=0x0F01, velocity=(1, 0, 0, 0, 0, 2), convex=True,
        friction=0.7,
    )  # fmt: skip
    shape = only(writer, Shape)
    assert (shape.mass, shape.mask, shape.is_dynamic, shape.is_respondable) == (2.5, 0x0F01, True, True)
    assert (shape.is_asleep, shape.is_grouped, shape.is_convex) == (False, False, True)
    assert shape.inertia == pytest.approx((0.1, 0.2, 0.3))
    assert shape.inertia_frame[0] == pytest.approx((0, 0, 0.1))
    assert shape.first_velocity == (1, 0, 0, 0, 0, 2)
    assert shape.surface is not None
    assert shape.surface.engines[Engine.BULLET][0][2] == pytest.approx(0.7)
    (leaf,) = shape.leaves
    assert (leaf.primitive, leaf.pose[0], leaf.is_convex) == (Primitive.CUBOID, (0, 0, 1), True)
    assert leaf.size == pytest.approx((0.2, 0.4, 0.6))
    assert np.ptp(leaf.vertices, axis=0) == pytest.approx((0.2, 0.4, 0.6))
    assert leaf.triangles.shape == (12, 3)


@VERSIONS
def test_normals_point_out_of_the_mesh(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.shape("ball", spheroid=(2.0, 2.0, 2.0))
    (leaf,) = only(writer, Shape).leaves
    assert leaf.normals is not None
    middles = leaf.vertices[leaf.triangles].mean(axis=1)
    directions = middles / np.linalg.norm(middles, axis=1, keepdims=True)
    assert np.linalg.norm(leaf.normals, axis=2) == pytest.approx(1.0, abs=1e-5)
    assert np.einsum("ijk,ik->ij", leaf.normals, directions).min() > 0.9


@VERSIONS
def test_colours_come_out_as_they_went_in(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.shape("glass", cuboid=(1, 1, 1), color=(0.9, 0.5, 0.1), opacity=0.25, color_name="Glass")
    (leaf,) = only(writer, Shape).leaves
    assert leaf.material.diffuse == pytest.approx((0.9, 0.5, 0.1), abs=1e-5)
    assert (leaf.material.opacity, leaf.material.name) == (0.25, "Glass")
    assert leaf.material.specular == pytest.approx((0.2, 0.2, 0.2))


@VERSIONS
def test_a_group_has_all_its_leaves(ser: int) -> None:
    writer = VrepWriter(ser)
    triangle = (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    writer.shape(
        "group",
        mass=3.0,
        leaves=[
            {"cylinder": (0.2, 0.2, 0.5), "color": (1, 0, 0)},
            {"mesh": triangle, "pose": ((0, 1, 0), (1, 0, 0, 0)), "culled": True},
            {"plane": (1, 1, 0), "wireframe": True},
        ],
    )
    shape = only(writer, Shape)
    assert (shape.is_grouped, shape.mass) == (True, 3.0)
    first, second, third = shape.leaves
    assert (first.primitive, second.primitive, third.primitive) == (Primitive.CYLINDER, 0, Primitive.PLANE)
    assert second.vertices.tolist() == triangle[0].tolist()
    assert (second.culls_backfaces, second.is_wireframe, third.is_wireframe) == (True, False, True)
    assert second.pose[0] == (0, 1, 0)


@VERSIONS
def test_a_height_field_has_rows_and_columns(ser: int) -> None:
    heights = np.arange(6.0).reshape(2, 3)
    writer = VrepWriter(ser)
    writer.shape("terrain", heightfield=(2.0, 1.0, 5.0), heights=heights)
    (leaf,) = only(writer, Shape).leaves
    assert leaf.heights is not None
    assert leaf.heights.tolist() == heights.tolist()


@VERSIONS
def test_textures_keep_their_pixels(ser: int) -> None:
    pixels = np.arange(4 * 3 * 4).reshape(4, 3, 4)
    writer = VrepWriter(ser)
    texture = writer.texture(pixels)
    writer.shape("floor", plane=(5, 5, 0), texture=texture, texture_scale=(0.5, 2.0))
    file = read(writer)
    assert file.textures[texture].pixels.tolist() == pixels.tolist()
    (shape,) = file.objects.values()
    assert isinstance(shape, Shape)
    use = shape.leaves[0].texture
    assert use is not None
    assert (use.texture, use.mode, use.scale) == (texture, 0, (0.5, 2.0))


@VERSIONS
def test_a_joint_has_position_limits_and_motor(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.joint(
        "slide", kind="prismatic", at=0.25, limits=(-1.0, 2.0), motor=True, lock=True, target_velocity=0.5,
        max_force=-40.0, upper_velocity=3.0, pid=(0.2, 0.01, 0.03),
    )  # fmt: skip
    joint = only(writer, Joint)
    assert (joint.type, joint.position, joint.minimum, joint.range) == (JointType.PRISMATIC, 0.25, -1.0, 3.0)
    assert (joint.motor, joint.control, joint.lock, joint.is_cyclic) == (True, "velocity", True, False)
    assert (joint.mode, joint.target_velocity, joint.max_force) == (5, 0.5, -40.0)
    assert joint.upper_velocity == pytest.approx(3.0)
    assert joint.pid == pytest.approx((0.2, 0.01, 0.03))


@VERSIONS
@pytest.mark.parametrize("control", ["velocity", "position", "spring"])
def test_a_joint_tells_how_its_motor_is_controlled(ser: int, control: str) -> None:
    writer = VrepWriter(ser)
    writer.joint("hinge", motor=True, control=control, target_position=0.5, spring=(7.0, 0.5), limits=None)
    joint = only(writer, Joint)
    assert (joint.control, joint.target_position, joint.spring) == (control, 0.5, (7.0, 0.5))
    assert joint.is_cyclic


@pytest.mark.parametrize(
    ("way", "control"), [(9, "position"), (13, "spring"), (5, "velocity"), (16, "script"), (1, "force")]
)
def test_the_lowest_bit_of_the_way_of_control_means_nothing_beside_others(way: int, control: str) -> None:
    writer = VrepWriter(25)
    writer.joint("hinge", motor=True, extra=b"")
    data = writer.records[0]
    place = data.index(b"Dcm") + 7
    writer.records[0] = data[:place] + bytes([way]) + data[place + 1 :]
    joint = only(writer, Joint)
    assert (joint.control, joint.motor) == (control, True)


@VERSIONS
def test_a_dependent_joint_names_its_master(ser: int) -> None:
    writer = VrepWriter(ser)
    first = writer.joint("first")
    second = writer.joint("second", mode="dependent", master=(first, -2.0, 0.5))
    joint = read(writer).objects[second]
    assert isinstance(joint, Joint)
    assert (joint.mode, joint.master, joint.factor, joint.offset) == (4, first, -2.0, 0.5)


@VERSIONS
def test_a_spherical_joint_has_a_turn(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.joint("ball", kind="spherical", turn=(0, 1, 0, 0))
    joint = only(writer, Joint)
    assert (joint.type, joint.turn) == (JointType.SPHERICAL, (0, 1, 0, 0))


@VERSIONS
def test_linked_dummies_name_each_other(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.dummy("tip", linked=1, link_type=5, size=0.03)
    writer.dummy("target", linked=0, link_type=5)
    tip, target = read(writer).objects.values()
    assert isinstance(tip, Dummy)
    assert isinstance(target, Dummy)
    assert (tip.linked, target.linked, tip.link_type) == (1, 0, 5)
    assert tip.size == pytest.approx(0.03)


@VERSIONS
def test_a_force_sensor_breaks_only_at_thresholds_that_are_on(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.force_sensor("pad", torque=2.5, violations=7, samples=5, median=True)
    sensor = only(writer, ForceSensor)
    assert (sensor.max_force, sensor.max_torque, sensor.violations) == (None, 2.5, 7)
    assert (sensor.samples, sensor.filter) == (5, "median")


@VERSIONS
def test_a_vision_sensor_has_camera_and_filters(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.vision_sensor(
        "eye", resolution=(320, 240), perspective=False, orthographic_size=2.0, near=0.1, far=8.0, explicit=True,
        flags=2 + 16, entity=2000001,
        filters=[{"type": 1}, {"type": 35, "enabled": False, "ints": [4, 5], "reals": [0.5], "data": b"z"}],
    )  # fmt: skip
    sensor = only(writer, VisionSensor)
    assert (sensor.resolution, sensor.is_perspective, sensor.orthographic_size) == ((320, 240), False, 2.0)
    assert (sensor.near, sensor.far) == pytest.approx((0.1, 8.0))
    assert (sensor.is_explicit, sensor.ignores_rgb, sensor.ignores_depth) == (True, True, False)
    assert (sensor.has_no_statistics, sensor.entity) == (True, 2000001)
    if PROGRAMS[ser] >= (4, 0, 0):
        assert sensor.filters is None
    else:
        assert sensor.filters is not None
        first, second = sensor.filters
        assert (first.type, first.enabled, first.reals) == (1, True, [])
        assert (second.type, second.enabled, second.integers) == (35, False, [4, 5])
        assert (second.reals, second.data) == ([0.5], b"z")


@VERSIONS
def test_a_proximity_sensor_has_method_and_volume(ser: int) -> None:
    nan = float("nan")
    writer = VrepWriter(ser)
    writer.proximity_sensor(
        "nose", volume="cone", method="ray", sizes=(0.1, 0.5, nan, nan, nan, nan, 0.02, 0.0, 0.6), gap=0.3,
        minimum=0.05, closest=False, explicit=True, max_angle=1.2, entity=7, faces=(True, False),
    )  # fmt: skip
    sensor = only(writer, ProximitySensor)
    volume = sensor.volume
    assert (sensor.method, volume.type, sensor.entity) == ("ray", "cone", 7)
    assert (volume.offset, volume.range, volume.radius) == pytest.approx((0.1, 0.5, 0.02))
    assert (volume.angle, volume.inside_gap) == pytest.approx((0.6, 0.3))
    assert sensor.minimum_distance == pytest.approx(0.05)
    assert sensor.max_normal_angle == pytest.approx(1.2)
    assert (sensor.finds_closest, sensor.is_explicit) == (False, True)
    assert (sensor.front_faces, sensor.back_faces) == (True, False)


def test_both_forms_of_a_number_are_there_and_the_longer_one_is_taken() -> None:
    writer = VrepWriter(24)
    writer.dummy("third", position=(1 / 3, 0, 0))
    assert only(writer, Dummy).pose[0][0] == 1 / 3
