"""Shapes, joints and sensors that scripts make, and questions about shapes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from sim_api_calls import ScriptWorld

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 -10" timestep="0.005"/>
  <asset><material name="paint" rgba="0 0 1 0.5"/></asset>
  <worldbody>
    <body name="floor"><geom type="box" size="9 9 0.1" pos="0 0 -0.1" rgba="1 0 0 1"/></body>
    <body name="painted" pos="0 5 1"><geom size="0.1" material="paint"/></body>
    <light name="lamp" pos="0 0 5" diffuse="1 0 0"/>
    <body name="pair" pos="0 6 1"><geom size="0.1"/><geom size="0.1" pos="0 0 1"/></body>
    <body name="sheet" pos="0 7 1"><geom type="plane" size="1 1 0.1" contype="0" conaffinity="0"/></body>
  </worldbody>
</mujoco>
"""

H = "local h = sim.getObjectHandle\n"

TETRAHEDRON = """
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    world = ScriptWorld(tmp_path, SCENE, owner="floor")
    (tmp_path / "tetra.obj").write_text(TETRAHEDRON, encoding="utf-8")
    return world


def name(world: ScriptWorld, handle: int) -> str:
    return world.sim.scene.get(handle).name


@pytest.mark.parametrize(
    ("kind", "stem", "pure_type"), [(0, "Cuboid", 3), (1, "Spheroid", 4), (2, "Cylinder", 5), (3, "Cone", 0)]
)
def test_a_pure_shape_falls_on_the_floor(world: ScriptWorld, kind: int, stem: str, pure_type: int) -> None:
    (handle,) = world.lua(
        f"s = sim.createPureShape({kind}, 8, {{0.2, 0.2, 0.2}}, 0.5) "
        "sim.setObjectPosition(s, -1, {1, 1, 0.15}) return s"
    )
    assert name(world, handle) == stem
    assert world.lua("return sim.getShapeMass(s)") == [pytest.approx(0.5)]
    bits, pure, sizes = world.lua("return sim.getShapeGeomInfo(s)")
    assert (pure, bits & 1, bits & 4) == (pure_type, 0, 4)
    assert sizes == (pytest.approx([0.2, 0.2, 0.2, 0]) if pure else [0, 0, 0, 0])
    world.passes(20)
    assert world.lua("return sim.getObjectPosition(s, -1)")[0][2] == pytest.approx(0.1, abs=2e-3)
    world.call("simxStopSimulation")
    assert handle not in world.sim.scene.objects


def test_a_pure_shape_is_not_collidable_measurable_or_detectable_until_a_program_says_so(
    world: ScriptWorld,
) -> None:
    asked = "return sim.getObjectSpecialProperty(h)"
    renderable = 512
    assert world.lua("h = sim.createPureShape(0, 8, {0.2, 0.2, 0.2}, 1) " + asked) == [renderable]
    world.lua("sim.setObjectSpecialProperty(h, sim.objectspecialproperty_collidable)")
    (bits,) = world.lua(asked)
    assert bits & 1
    (bits,) = world.lua("h = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.2, 0.2, 0.2}) " + asked)
    assert bits & 1
    assert bits & 2
    (bits,) = world.lua("h = sim.createHeightfieldShape(0, 0, 2, 2, 1, {0, 0, 0, 0}) " + asked)
    assert bits & 3 == 0
    assert bits > renderable, "detectable"


def test_a_static_shape_stays_and_a_second_one_has_a_number(world: ScriptWorld) -> None:
    first, second = world.lua(
        "local one = sim.createPureShape(0, 16, {1, 2, 3}, 1) return one, sim.createPureShape(0, 16, {1, 2, 3}, 1)"
    )
    world.passes(3)
    assert (name(world, first), name(world, second)) == ("Cuboid", "Cuboid0")
    assert world.lua(H + "return sim.getObjectPosition(h'Cuboid0', -1)") == [pytest.approx([0, 0, 0])]
    world.fails("sim.createPureShape(4, 0, {1, 1, 1}, 1)", "0 cuboid, 1 sphere")
    assert world.value("sim.getShapeMass(sim.createPureShape(0, 8, {-1, 1, 1}, 0))") == pytest.approx(1e-6)
    world.fails("sim.createPureShape(0, 0, {1, 1}, 1)", "three sizes")


def test_primitive_shapes_of_the_new_kind(world: ScriptWorld) -> None:
    for kind in ("plane", "disc", "cuboid", "spheroid", "cylinder", "cone", "capsule"):
        (handle,) = world.lua(
            f"return sim.createPrimitiveShape(sim.primitiveshape_{kind}, {{0.2, 0.2, 0.6}}, 0)"
        )
        assert name(world, handle) == kind.capitalize()
    assert world.lua(H + "return sim.getShapeGeomInfo(h'Capsule')") == [
        6,
        8,
        pytest.approx([0.2, 0.2, 0.6, 0]),
    ]
    assert world.lua(H + "return sim.getShapeGeomInfo(h'Spheroid')") == [
        6,
        4,
        pytest.approx([0.2, 0.2, 0.6, 0]),
    ]
    world.fails("sim.createPrimitiveShape(7, {1, 1, 1})", "no primitive shape; those are 1 plane")


def test_a_mesh_is_made_from_points_and_read_back(world: ScriptWorld) -> None:
    (handle,) = world.lua(
        "m = sim.createMeshShape(0, 0, {1,0,0, 3,0,0, 3,2,0, 1,2,0}, {0,1,2, 0,2,3}) return m"
    )
    assert name(world, handle) == "Shape"
    assert world.lua("return sim.getObjectPosition(m, -1)") == [pytest.approx([2, 1, 0])]
    points, indices, normals = world.lua("return sim.getShapeMesh(m)")
    corners = np.array(points).reshape(-1, 3)[np.array(indices).reshape(-1, 3)]
    assert corners.shape == (2, 3, 3)
    assert sorted(map(tuple, np.array(points).reshape(-1, 3).round(6).tolist())) == [
        (-1, -1, 0), (-1, 1, 0), (1, -1, 0), (1, 1, 0)]  # fmt: skip
    assert normals == pytest.approx([0, 0, 1] * 6)
    assert world.lua("return sim.getShapeGeomInfo(m)")[:2] == [0, 0]
    world.fails("sim.createMeshShape(0, 0, {0,0,0, 1,0,0, 0,1,0}, {0,1,3})", "indices from 0 to 2")
    (other,) = world.lua("return sim.createShape(0, 0, {0,0,0, 1,0,0, 0,1,0}, {0,1,2}, {}, {}, '', {0, 0})")
    assert name(world, other) == "Shape0"


def test_the_mesh_of_a_primitive_is_in_the_shapes_frame(world: ScriptWorld) -> None:
    points, indices, normals = world.lua(H + "return sim.getShapeMesh(h'floor')")
    assert np.array(points).reshape(-1, 3).min(axis=0).tolist() == pytest.approx([-9, -9, -0.2])
    assert (len(points), len(indices), len(normals)) == (24, 36, 108)
    world.fails(H + "sim.getShapeMesh(h'sheet')", "is a plane")


def test_a_height_field_carries_what_falls_on_it(world: ScriptWorld) -> None:
    world.lua("f = sim.createHeightfieldShape(0, 0, 3, 2, 4, {1, 1, 1, 1, 1, 2})")
    assert world.lua("return sim.getObjectPosition(f, -1)") == [pytest.approx([0, 0, 1.5])]
    low, high = np.array(world.lua("return sim.getShapeMesh(f)")[0]).reshape(-1, 3)[[0, -1]]
    assert (low.tolist(), high.tolist()) == (pytest.approx([-2, -1, -0.5]), pytest.approx([2, 1, 0.5]))
    world.lua("b = sim.createPureShape(1, 8, {0.2, 0.2, 0.2}, 1) sim.setObjectPosition(b, -1, {-1, 0, 1.2})")
    world.passes(10)
    assert world.lua("return sim.getObjectPosition(b, -1)")[0][2] == pytest.approx(1.1, abs=0.02)
    world.fails("sim.createHeightfieldShape(0, 0, 3, 3, 4, {1, 2})", "need 9 heights")


def test_mesh_files_of_the_workspace_are_imported(world: ScriptWorld) -> None:
    points, indices = world.lua("return sim.importMesh(0, 'tetra.obj', 0, 0.0001, 2)")
    assert len(points) == len(indices) == 1
    assert (max(points[0]), len(indices[0])) == (pytest.approx(2), 12)
    (handle,) = world.lua("s = sim.importShape(0, 'tetra.obj', 0, 0.0001, 1) return s")
    assert name(world, handle) == "Shape"
    assert world.lua("return sim.getObjectPosition(s, -1)") == [pytest.approx([0.5, 0.5, 0.5])]
    world.fails("sim.importShape(0, 'scene.xml', 0, 0, 1)", "is no mesh file")
    world.fails("sim.importShape(0, '/etc/passwd', 0, 0, 1)", "workspace|no mesh file|no file")


def test_a_joint_is_made_and_turns_what_hangs_on_it(world: ScriptWorld) -> None:
    (handle,) = world.lua(
        "j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_passive, 0) "
        "s = sim.createPureShape(0, 16, {1, 1, 1}, 1) sim.setObjectPosition(s, -1, {1, 0, 2}) "
        "sim.setObjectParent(s, j, true) sim.setJointPosition(j, math.pi / 2) return j"
    )
    assert name(world, handle) == "Revolute_joint"
    assert world.lua("return sim.getObjectPosition(s, -1)") == [pytest.approx([0, 1, 2], abs=1e-9)]
    assert world.lua("return sim.getJointType(j), sim.getJointMode(j)") == [10, 0, False]
    world.passes(3)
    slide = "local j = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_force, 0) "
    assert world.lua(slide + "return sim.getJointInterval(j)") == [False, [-0.5, 1]]
    assert world.lua("return sim.getJointType(sim.createJoint(12, 5, 0))") == [12]
    world.fails("sim.createJoint(9, 5, 0)", "10 revolute, 11 prismatic")
    world.fails("sim.createJoint(10, 9, 0)", "mode is one of")


def test_sizes_of_joints_and_sensors_are_kept_copied_and_scaled(world: ScriptWorld) -> None:
    made = world.lua("""
    j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_passive, 0, {0.5, 0.1})
    f = sim.createForceSensor(0, {0, 1, 1, 0, 0}, {0.3, 1, 1, 0, 0})
    v = sim.createVisionSensor(2, {8, 8, 0, 0}, {0.1, 2, 1, 0.2, 0, 0, 0, 0, 0, 0, 0})
    p = sim.createProximitySensor(sim.proximitysensor_ray_subtype, 16, 0, {0, 0, 0, 0, 0, 0, 0, 0},
        {0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.4, 0, 0})
    plain = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_passive, 0)
    local get = sim.getFloatProperty
    return get(j, 'jointLength'), get(j, 'jointDiameter'), get(f, 'sensorSize'), get(v, 'sensorSize'),
        get(p, 'sensorPointSize'), get(plain, 'jointLength')
    """)
    assert made == [0.5, 0.1, 0.3, 0.2, 0.4, 0.15]
    copied, scaled = world.lua("""
    local copy = sim.copyPasteObjects({j}, 0)[1]
    sim.scaleObjects({copy}, 2, false)
    return sim.getFloatProperty(j, 'jointLength'), sim.getFloatProperty(copy, 'jointLength')
    """)
    assert (copied, scaled) == (0.5, 1.0)
    world.fails("sim.setFloatProperty(j, 'jointLength', 0)", "a length in metres above 0")
    world.fails("sim.createJoint(10, 0, 0, {1})", "its length and its diameter, not 1")


def test_a_motor_drives_a_joint_that_was_made(world: ScriptWorld) -> None:
    world.lua(
        "j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_force, 0) "
        "sim.setObjectIntParameter(j, 2000, 1) sim.setJointTargetVelocity(j, 1)"
    )
    world.passes(20)
    assert world.lua("return sim.getJointPosition(j)") == [pytest.approx(1, abs=0.02)]


def test_a_joint_that_was_made_links_a_dynamic_shape_and_lets_it_go(world: ScriptWorld) -> None:
    world.lua(
        H + "j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_force, 0) "
        "sim.setObjectPosition(j, -1, {0, 0, 3}) sim.setObjectOrientation(j, -1, {math.pi / 2, 0, 0}) "
        "s = sim.createPureShape(0, 8, {0.1, 0.1, 0.1}, 1) sim.setObjectPosition(s, -1, {1, 0, 3}) "
        "sim.setObjectParent(s, j, true) sim.setObjectParent(j, h'pair', true)"
    )
    world.passes(10)
    x, _, z = world.value("sim.getObjectPosition(s, -1)")
    assert (x**2 + (z - 3) ** 2, x < 0.9) == (pytest.approx(1, abs=1e-6), True)  # a pendulum
    assert world.value("sim.getJointPosition(j)") != 0
    world.lua("sim.setObjectParent(s, -1, true)")
    world.passes(5)
    x, _, z = world.value("sim.getObjectPosition(s, -1)")
    assert x**2 + (z - 3) ** 2 > 1.01


def test_two_bodies_are_glued_by_a_force_sensor(world: ScriptWorld) -> None:
    world.lua(
        "a = sim.createPureShape(0, 8, {0.2, 0.2, 0.2}, 1) sim.setObjectPosition(a, -1, {2, 0, 2}) "
        "b = sim.createPureShape(0, 8, {0.2, 0.2, 0.2}, 3) sim.setObjectPosition(b, -1, {2.5, 0, 2}) "
        "s = sim.createForceSensor(0, {0, 1, 1, 0, 0}, {0.001, 1, 1, 0, 0}) sim.setObjectPosition(s, a, {0, 0, 0}) "
        "sim.setObjectParent(a, s, true) sim.setObjectParent(s, b, true)"
    )
    world.passes(3)
    one, other = world.lua("return sim.getObjectPosition(a, -1), sim.getObjectPosition(b, -1)")
    assert one[2] == pytest.approx(other[2], abs=1e-6) != pytest.approx(2, abs=0.05)  # both fall
    assert other[0] - one[0] == pytest.approx(0.5, abs=1e-6)
    assert world.value("sim.getShapeMass(a)") == pytest.approx(1)


def test_a_proximity_sensor_is_made_with_random_rays_or_for_one_kind_of_detection(world: ScriptWorld) -> None:
    sizes = "{0, 3, 0, 0, 0, 0, 0, 0.1, 0, 0.5, 0, 0, 0, 0, 0}"
    source = (
        "return sim.createProximitySensor(sim.proximitysensor_%s_subtype, %s, %s, {0, 0, 0, 0, %s, 0, 0}, %s)"
    )
    (rays,) = world.lua(source % ("ray", 16, 512, "20, 3", sizes))
    note = world.sim.scene.get(rays).annotations["proximity"]
    assert (note["type"], note["rays"], note["rays_needed"]) == ("random_rays", 20, 3)
    assert "detects" not in note
    assert world.value(f"sim.getBoolProperty({rays}, 'randomizedDetection')")
    (laser,) = world.lua(source % ("cone", "sim.objectspecialproperty_detectable_laser", 0, "0, 0", sizes))
    assert world.sim.scene.get(laser).annotations["proximity"]["detects"] == "laser"
    world.fails(source % ("cone", 16, 512, "20, 3", sizes), "only sensors of the type ray")
    world.fails(source % ("ray", 16, 512, "2, 3", sizes), "random rays are 1 to 10000")


SIZES = "{0, 3, 0.2, 0.2, 0.4, 0.4, 0, 0.1, 0.2, 0.5, 0, 0, 0, 0, 0}"


@pytest.mark.parametrize("kind", ["pyramid", "cylinder", "disc", "cone", "ray"])
def test_a_proximity_sensor_is_made_and_detects(world: ScriptWorld, kind: str) -> None:
    source = f"p = sim.createProximitySensor(sim.proximitysensor_{kind}_subtype, 16, 1, {{0,0,0,0,0,0,0,0}}, {SIZES}) "
    (handle,) = world.lua(source + "sim.setObjectPosition(p, -1, {3, 3, -2}) return p")
    assert name(world, handle) == "Proximity_sensor"
    assert world.call("simxGetObjectIntParameter", handle, 4001) in range(30, 35)
    assert world.lua("return sim.readProximitySensor(p)") == [-1]
    result, distance, *_ = world.lua("return sim.handleProximitySensor(p)")
    if kind != "disc":  # a flat one does not reach the floor
        assert (result, distance) == (1, pytest.approx(1.8, abs=0.05))
    world.fails(f"sim.createProximitySensor(9, 16, 1, {{}}, {SIZES})", "30 pyramid")
    world.fails("sim.createProximitySensor(34, 16, 1, {}, {1, 2})", "15 numbers, not 2")
    behind = SIZES.replace("{0", "{-0.5")
    world.lua(f"return sim.createProximitySensor(sim.proximitysensor_{kind}_subtype, 16, 1, {{}}, {behind})")
    world.fails(
        f"sim.createProximitySensor(34, 16, 1, {{}}, {SIZES.replace(', 3,', ', -3,')})", "range is above 0"
    )


def test_a_vision_sensor_is_made(world: ScriptWorld) -> None:
    (handle,) = world.lua(
        "v = sim.createVisionSensor(1 + 2, {32, 16, 0, 0}, {0.1, 5, 1, 0.1, 0.1, 0.1, 0, 0, 0, 0, 0}) return v"
    )
    settings = world.parts.vision.settings(handle)
    assert (settings.near, settings.far, settings.angle) == (0.1, 5, pytest.approx(1))
    assert (settings.explicit, settings.orthographic_size) == (True, None)
    assert world.lua("return sim.getVisionSensorResolution(v), sim.getObjectOrientation(v, -1)") == [
        [32, 16],
        pytest.approx([0, 0, 0], abs=1e-9),
    ]
    (flat,) = world.lua(
        "return sim.createVisionSensor(0, {32, 16, 0, 0}, {0.1, 5, 1, 0, 0, 0, 0, 0, 0, 0, 0})"
    )
    assert world.parts.vision.settings(flat).orthographic_size == pytest.approx(1)
    (red,) = world.lua(
        "return sim.createVisionSensor(128, {32, 16, 0, 0}, {0.1, 5, 1, 0, 0, 0, 0.5, 0.25, 2, 0, 0})"
    )
    assert world.parts.vision.settings(red).background == (0.5, 0.25, 1)
    world.fails("sim.createVisionSensor(2, {0, 16, 0, 0}, {0.1, 5, 1})", "1 to 4096 pixels")


def test_a_force_sensor_is_made_and_weighs(world: ScriptWorld) -> None:
    world.lua(
        "f = sim.createForceSensor(0, {0, 1, 1, 0, 0}, {0.01, 100, 10, 0, 0}) sim.setObjectPosition(f, -1, {4, 4, 2}) "
        "s = sim.createPureShape(0, 8, {0.1, 0.1, 0.1}, 2) sim.setObjectPosition(s, -1, {4, 4, 1.8}) "
        "sim.setObjectParent(s, f, true)"
    )
    world.passes(5)
    state, force, _ = world.lua("return sim.readForceSensor(f)")
    assert (state, force[2]) == (1, pytest.approx(-20, abs=0.2))
    world.fails("sim.createForceSensor(1, {0, 1, 1, 0, 0}, {0.01, 0, 10, 0, 0})", "threshold is above 0")


def test_a_light_is_read_switched_and_coloured(world: ScriptWorld) -> None:
    get = H + "return sim.getLightParameters(h'lamp')"
    assert world.lua(get)[:3] == [1, [0, 0, 0], [1, 0, 0]]
    assert world.lua(H + "return sim.setLightParameters(h'lamp', 0, nil, {0, 0, 2}, {0.5, 0, 0})") == [1]
    assert world.lua(get) == [0, [0, 0, 0], [0, 0, 1], [0.5, 0, 0]]
    world.fails(H + "sim.setLightParameters(h'floor', 0)", "needs a light")


def test_a_compound_is_told_from_a_single_shape(world: ScriptWorld) -> None:
    assert world.lua(H + "return sim.getShapeGeomInfo(h'pair')") == [5, 0, [0, 0, 0, 0]]
    assert world.lua(H + "return sim.getShapeGeomInfo(h'floor')") == [6, 3, pytest.approx([18, 18, 0.2, 0])]


def test_the_mass_of_a_shape_is_set(world: ScriptWorld) -> None:
    source = (
        "local s = sim.createPureShape(0, 8, {1, 1, 1}, 2) sim.setShapeMass(s, 3) return sim.getShapeMass(s)"
    )
    assert world.lua(source) == [pytest.approx(3)]
    assert math.isfinite(world.sim.time)


def test_a_material_is_accepted_and_the_log_says_where_friction_is_set(world: ScriptWorld) -> None:
    world.goes_on("sim.setShapeMaterial(1, 2)", "attributes of geoms", 1)
