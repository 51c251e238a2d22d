"""CoppeliaSim's properties of objects, the scene and the server, as scripts use them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from sim_api_calls import SCENE, ScriptWorld, world

from simx_server.files.library import shipped_models, shipped_scenes
from simx_server.sim_api.properties import missing
from simx_server.sim_api.properties.table import kinds_with

__all__ = ["world"]

SENSORS = SCENE.replace(
    '<site name="ray"',
    '<light name="lamp" pos="0 0 3"/><camera name="view" pos="0 -5 1"/>'
    '<site name="cone" pos="1 1 1"/><site name="script" pos="0 0 0"/>'
    '<body name="held" pos="5 0 1"><freejoint/><geom type="box" size="0.1 0.1 0.1"/>'
    '<body name="ball" pos="0 0 0.3"><joint name="socket" type="ball"/><geom type="sphere" size="0.1"/></body></body>'
    '<body name="post" pos="6 0 1"><geom type="box" size="0.1 0.1 0.1"/>'
    '<site name="scales" pos="0 0 0.1"/><body name="load" pos="0 0 0.2"><geom type="box" size="0.1 0.1 0.1"/></body>'
    "</body><site name='ray'",
).replace("</custom>", '<text name="simx:proximity:cone" data="type=cone range=2 angle_deg=30"/></custom>')

NAMES = (
    "robot",
    "mark",
    "hinge",
    "arm",
    "tip",
    "cube",
    "wall",
    "eye",
    "ray",
    "lamp",
    "view",
    "cone",
    "socket",
)


def use_names(world: ScriptWorld) -> None:
    lines = (
        f"{name} = sim.getObject('/{name}', {{noError=true}}) "
        f"if {name} == -1 then {name} = sim.getObjectHandle('{name}@silentError') end"
        for name in NAMES
    )
    world.lua("\n".join(lines))


@pytest.fixture(autouse=True)
def _handles(world: ScriptWorld) -> None:
    use_names(world)


@pytest.fixture
def sensors(tmp_path: Path) -> ScriptWorld:
    found = ScriptWorld(tmp_path, xml=SENSORS)
    use_names(found)
    return found


def kept(world: ScriptWorld, target: str, kind: str, name: str, value: str) -> object:
    """The value that a property has after it was set."""
    world.lua(f"sim.set{kind}Property({target}, '{name}', {value})")
    return world.value(f"sim.get{kind}Property({target}, '{name}')")


@pytest.mark.parametrize(
    ("target", "kind", "name", "value", "expected"),
    [
        ("cube", "String", "alias", "'box'", "box"),
        ("cube", "String", "deprecatedName", "'box'", "box"),
        ("cube", "Bool", "selected", "true", True),
        ("cube", "Int", "layer", "256", 256),
        ("cube", "Bool", "collidable", "false", False),
        ("cube", "Bool", "measurable", "false", False),
        ("cube", "Bool", "detectable", "false", False),
        ("cube", "Bool", "depthInvisible", "true", True),
        ("cube", "Int", "objectPropertyFlags", "0x1020", 0x1020),
        ("cube", "Bool", "modelBase", "true", True),
        ("robot", "Bool", "model.notCollidable", "true", True),
        ("robot", "Bool", "modelNotMeasurable", "true", True),
        ("robot", "Int", "modelPropertyFlags", "3", 3),
        ("cube", "Vector3", "absPosition", "{1, 2, 3}", [1, 2, 3]),
        ("cube", "Quaternion", "quaternion", "{0, 0, 1, 0}", [0, 0, 1, 0]),
        ("cube", "Vector3", "eulerAngles", "{0, 0, 0.5}", pytest.approx([0, 0, 0.5])),
        ("cube", "Pose", "pose", "{1, 2, 3, 0, 0, 0, 1}", [1, 2, 3, 0, 0, 0, 1]),
        ("cube", "Bool", "dynamic", "false", False),
        ("cube", "Bool", "respondable", "false", False),
        ("cube", "Int", "respondableMask", "0xff00", 0xFF00),
        ("cube", "Float", "mass", "2.5", 2.5),
        ("cube", "Vector3", "initLinearVelocity", "{1, 0, 0.5}", [1, 0, 0.5]),
        ("cube", "Vector3", "centerOfMass", "{0.01, 0, 0}", [0.01, 0, 0]),
        ("cube", "FloatArray", "inertia", "{2, 0, 0, 0, 3, 0, 0, 0, 4}", [2, 0, 0, 0, 3, 0, 0, 0, 4]),
        ("cube", "Float", "bullet.friction", "0.25", 0.25),
        ("cube", "FloatArray", "mujoco.friction", "{0.5, 0.1, 0.2}", [0.5, 0.1, 0.2]),
        ("cube", "Int", "mujoco.condim", "4", 4),
        ("hinge", "Float", "jointPosition", "0.5", 0.5),
        ("hinge", "FloatArray", "interval", "{-1, 1.5}", [-1, 1.5]),
        ("hinge", "Bool", "cyclic", "true", True),
        ("hinge", "Float", "targetPos", "0.25", 0.25),
        ("hinge", "Float", "targetVel", "0.75", 0.75),
        ("hinge", "Float", "targetForce", "42", 42),
        ("hinge", "Int", "jointMode", "0", 0),
        ("hinge", "Int", "dynCtrlMode", "4", 4),
        ("hinge", "FloatArray", "maxVelAccelJerk", "{1, 2, 3}", [1, 2, 3]),
        ("hinge", "FloatArray", "springDamperParams", "{5, 6}", [5, 6]),
        ("hinge", "FloatArray", "bullet.posPid", "{0.5, 0.25, 0.125}", [0.5, 0.25, 0.125]),
        ("tip", "Float", "dummySize", "0.25", 0.25),
        ("ray", "Bool", "explicitHandling", "true", True),
        ("ray", "Float", "volume_range", "4.5", 4.5),
        ("ray", "Float", "volume_offset", "0.5", 0.5),
        ("ray", "Float", "closeThreshold", "0.125", 0.125),
        ("ray", "Bool", "backFaceDetection", "false", False),
        ("ray", "Float", "angleThreshold", "0.5", pytest.approx(0.5)),
        ("ray", "Bool", "showVolume", "false", False),
        ("eye", "IntArray2", "resolution", "{16, 8}", [16, 8]),
        ("eye", "Float", "viewAngle", "0.5", 0.5),
        ("eye", "FloatArray", "clippingPlanes", "{0.5, 20}", [0.5, 20]),
        ("eye", "Int", "renderMode", "2", 2),
        ("eye", "Color", "backgroundColor", "{0.25, 0.5, 1}", [0.25, 0.5, 1]),
        ("eye", "Bool", "explicitHandling", "true", True),
        ("eye", "Bool", "omitPacket1", "true", True),
        ("sim.handle_scene", "Bool", "dynamicsEnabled", "false", False),
        ("sim.handle_scene", "Vector3", "gravity", "{0, 0, -1.5}", [0, 0, -1.5]),
        ("sim.handle_scene", "Vector3", "mujoco.wind", "{1, 2, 3}", [1, 2, 3]),
        ("sim.handle_scene", "IntArray", "dynamicsEngine", "{sim.physics_mujoco, 0}", [4, 0]),
        ("sim.handle_scene", "Int", "visibilityLayers", "3", 3),
        ("sim.handle_app", "String", "appArg2", "'text'", "text"),
    ],
)
def test_a_property_has_the_value_that_was_set(
    world: ScriptWorld, target: str, kind: str, name: str, value: str, expected: object
) -> None:
    assert kept(world, target, kind, name, value) == expected
    assert world.value(f"sim.getProperty({target}, '{name}')") == expected


def test_handles_are_integers_too(world: ScriptWorld) -> None:
    robot = world.handle("robot")
    assert world.lua(
        "return sim.getIntProperty(hinge, 'parentHandle'), sim.getHandleProperty(hinge, 'parent')"
    ) == [
        robot,
        robot,
    ]
    world.lua("sim.setHandleProperty(cube, 'parent', robot)")
    assert world.value("sim.getObjectParent(cube)") == robot
    world.lua("sim.setIntProperty(cube, 'parentHandle', -1)")
    children = world.value("sim.getHandleArrayProperty(robot, 'children')")
    assert children == world.value("sim.getIntArrayProperty(robot, 'children')")
    world.lua("sim.setHandleArrayProperty(sim.handle_scene, 'selection', {cube, arm})")
    assert world.value("sim.getObjectSelection()") == [world.handle("cube"), world.handle("arm")]
    assert world.value("sim.getLongProperty(cube, 'objectUid') == sim.getObjectUid(cube)")


def test_properties_that_can_only_be_read(world: ScriptWorld) -> None:
    assert world.value("sim.getStringProperty(eye, 'objectType')") == "visionSensor"
    assert world.value("sim.getIntProperty(hinge, 'jointType') == sim.joint_revolute")
    assert world.value("sim.getVector3Property(cube, 'bbHSize')") == pytest.approx([0.1, 0.1, 0.1])
    assert world.value("sim.getBoolProperty(cube, 'visible')") is True
    assert world.value("sim.getIntProperty(sim.handle_scene, 'simulationState')") == 16
    assert world.value("sim.getStringArrayProperty(sim.handle_app, 'pluginNames')")[0] == "simIK"
    world.fails("sim.setStringProperty(cube, 'objectType', 'joint')", "can only be read")
    world.fails("sim.setVector3Property(cube, 'bbHSize', {1, 1, 1})", "can only be read")


def test_the_server_names_the_folders_of_scenes_and_models(world: ScriptWorld) -> None:
    assert Path(world.value("sim.getStringParam(sim.stringparam_scenedefaultdir)")) == shipped_scenes()
    assert Path(world.value("sim.getStringProperty(sim.handle_app, 'modelPath')")) == shipped_models()


def test_the_time_of_a_run(world: ScriptWorld) -> None:
    world.passes(2)
    assert world.value("sim.getFloatProperty(sim.handle_scene, 'simulationTime')") == pytest.approx(0.1)
    assert world.value("sim.getIntProperty(sim.handle_scene, 'stepCount')") == 2
    world.fails(
        "sim.setFloatProperty(sim.handle_scene, 'timeStep', 0.01)", "only while the simulation is stopped"
    )
    world.fails("sim.setFloatProperty(sim.handle_scene, 'dynamicsStepSize', 0.01)", "stop it first")


def test_time_steps_are_set_while_stopped(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, kind="customization")
    world.call("simxStopSimulation")
    assert kept(world, "sim.handle_scene", "Float", "timeStep", "0.02") == 0.02
    assert kept(world, "sim.handle_scene", "Float", "dynamicsStepSize", "0.004") == pytest.approx(0.004)
    assert world.sim.substeps == 5
    world.fails(
        "sim.setFloatProperty(sim.handle_scene, 'dynamicsStepSize', 0.5)", "up to the simulation step"
    )
    world.fails("sim.setFloatProperty(sim.handle_scene, 'dynamicsStepSize', 1e-9)", "physics steps")


def test_velocities_are_those_of_the_last_step(world: ScriptWorld) -> None:
    world.lua("sim.setVector3Property(cube, 'initLinearVelocity', {1, 0, 0})")
    world.lua("sim.resetDynamicObject(cube)")
    world.passes(2)
    for name in ("calcLinearVelocity", "dynLinearVelocity"):
        assert world.value(f"sim.getVector3Property(cube, '{name}')") == pytest.approx([1, 0, 0], abs=1e-6)
    assert world.value("sim.getFloatProperty(cube, 'calcRotationVelocity')") == pytest.approx(0, abs=1e-6)


def test_colours_can_only_be_set(world: ScriptWorld) -> None:
    world.lua("sim.setColorProperty(cube, 'applyColor.diffuse', {1, 0.5, 0})")
    assert world.lua("return sim.getShapeColor(cube, nil, sim.colorcomponent_diffuse)")[1] == [1, 0.5, 0]
    world.lua("sim.setFloatProperty(cube, 'applyColor.transparency', 0.5)")
    world.fails("sim.getColorProperty(cube, 'applyColor.diffuse')", "can only be set")
    assert world.lua("return sim.getPropertyInfo(cube, 'applyColor.diffuse')")[:2] == [10, 2]


def test_a_shape_is_its_own_mesh(world: ScriptWorld) -> None:
    world.lua("sim.setColorProperty(sim.getIntArrayProperty(cube, 'meshes')[1], 'color.diffuse', {1, 0, 0})")
    assert world.value("sim.getColorProperty(cube, 'color.diffuse')") == [1, 0, 0]
    assert kept(world, "cube", "Float", "color.transparency", "0.5") == 0.5
    points, indices, normals = world.lua("return sim.getShapeMesh(cube)")
    assert world.value("sim.getFloatArrayProperty(cube, 'vertices')") == points
    assert world.value("sim.getIntArrayProperty(cube, 'indices')") == indices
    assert world.value("sim.getFloatArrayProperty(cube, 'normals')") == normals
    world.goes_on("sim.setBoolProperty(cube, 'showEdges', true)", "not available here", 1)


def test_a_proximity_sensor_says_what_it_detects(world: ScriptWorld) -> None:
    assert world.value("sim.getIntProperty(ray, 'detectedObjectHandle')") == -1
    world.passes()
    assert world.value("sim.getIntProperty(ray, 'detectedObjectHandle')") == world.handle("wall")
    assert world.value("sim.getVector3Property(ray, 'detectedPoint')")[2] == pytest.approx(0.95)
    world.lua("sim.setFloatProperty(ray, 'volume_range', 0.5)")
    world.passes()
    assert world.value("sim.getVector3Property(ray, 'detectedPoint')") == [0, 0, 0]


def test_sizes_of_a_volume_belong_to_its_type(sensors: ScriptWorld) -> None:
    assert sensors.value("sim.getFloatArrayProperty(cone, 'volume_angle')") == pytest.approx([math.pi / 6, 0])
    assert kept(sensors, "cone", "FloatArray", "volume_angle", "{math.pi / 4, 0}") == pytest.approx(
        [math.pi / 4, 0]
    )
    assert kept(sensors, "cone", "FloatArray", "volume_radius", "{0.1, 0.1}") == [0.1, 0.1]
    sensors.fails("sim.setFloatArrayProperty(cone, 'volume_radius', {0.1, 0.2})", "one size at both ends")
    sensors.fails("sim.setFloatArrayProperty(ray, 'volume_xSize', {1, 1})", "a ray, which has no size_x")
    sensors.fails("sim.setFloatProperty(cone, 'volume_range', -1)", "a number above 0")
    sensors.fails("sim.setFloatProperty(cone, 'volume_range', 1e300)", "at most 1e\\+09 is possible")
    assert sensors.value("sim.getFloatProperty(cone, 'volume_range')") == 2


def test_settings_of_a_light_stay_when_an_object_is_made(sensors: ScriptWorld) -> None:
    kept(sensors, "lamp", "Float", "spotCutoffAngle", "0.5")
    kept(sensors, "lamp", "Int", "spotExponent", "7")
    kept(sensors, "lamp", "FloatArray", "attenuationFactors", "{1, 0, 0.5}")
    sensors.lua("sim.createDummy(0.1)")
    assert sensors.value("sim.getFloatProperty(lamp, 'spotCutoffAngle')") == pytest.approx(0.5)
    assert sensors.value("sim.getIntProperty(lamp, 'spotExponent')") == 7
    assert sensors.value("sim.getFloatArrayProperty(lamp, 'attenuationFactors')") == [1, 0, 0.5]


def test_lights_cameras_and_spherical_joints(sensors: ScriptWorld) -> None:
    assert kept(sensors, "lamp", "Bool", "enabled", "false") is False
    assert kept(sensors, "lamp", "Float", "spotCutoffAngle", "0.5") == pytest.approx(0.5)
    assert kept(sensors, "lamp", "FloatArray", "attenuationFactors", "{1, 0, 0.5}") == [1, 0, 0.5]
    assert kept(sensors, "lamp", "Color", "color.diffuse", "{1, 0.5, 0}") == [1, 0.5, 0]
    assert sensors.value("sim.getIntProperty(lamp, 'lightType') == sim.light_spot")
    assert kept(sensors, "lamp", "Int", "spotExponent", "500") == 128
    assert sensors.value("sim.getBoolProperty(view, 'perspective')") is True
    assert kept(sensors, "view", "Float", "viewSize", "2.5") == 2.5
    assert sensors.value("sim.getBoolProperty(view, 'perspective')") is True
    assert kept(sensors, "socket", "Quaternion", "jointQuaternion", "{0, 0, 1, 0}") == pytest.approx(
        [0, 0, 1, 0]
    )
    sensors.fails("sim.setQuaternionProperty(socket, 'jointQuaternion', {0, 0, 0, 0})", "is no rotation")


def test_an_unknown_name_is_refused_with_what_there_is(world: ScriptWorld) -> None:
    world.fails(
        "sim.getFloatProperty(cube, 'mas')", "'cube' \\(shape\\) has no property 'mas'; did you mean 'mass'"
    )
    world.fails("sim.getFloatProperty(hinge, 'mass')", "that is one of a shape")
    world.fails("sim.getFloatProperty(cube, 'gravity')", "the scene \\(sim.handle_scene\\)")
    world.fails("sim.setBoolProperty(cube, 'qqqqqq', true)", "it has absEulerAngles, absPose")
    world.goes_on(
        "sim.setFloatProperty(cube, 'bullet.restitution', 1)",
        "'bullet.restitution' is not available here: the engine here is MuJoCo",
        1,
    )
    world.goes_on(
        "sim.getBoolProperty(cube, 'startInDynSleepMode')", "'startInDynSleepMode' is not available here"
    )
    world.fails("sim.getIntProperty(9999, 'layer')", "no object with handle 9999")


def test_a_wrong_type_is_refused_with_the_right_function(world: ScriptWorld) -> None:
    world.fails("sim.getIntProperty(cube, 'mass')", "is of type float, not int; use sim.getFloatProperty")
    world.fails(
        "sim.setFloatProperty(cube, 'respondable', 1)", "is of type bool, not float; use sim.setBoolProperty"
    )
    world.fails("sim.setVector3Property(cube, 'position', {1, 2})", "must be a table of 3 numbers: x, y, z")
    world.fails("sim.setFloatProperty(cube, 'mass', 'heavy')", "the value of 'mass' must be a finite number")
    world.goes_on("sim.setFloatProperty(cube, 'mass', -1)", "must be above 0", 1)
    world.goes_on("sim.setBoolProperty(ray, 'showVolume', true)", "'showVolume' stays false", 1)
    world.fails("sim.getVector3Property(cube, 'quaternion')", "use sim.getQuaternionProperty")


def test_the_option_no_error_gives_nil(world: ScriptWorld) -> None:
    for call in (
        "sim.getFloatProperty(cube, 'mas'",
        "sim.getIntProperty(cube, 'mass'",
        "sim.getProperty(9999, 'mass'",
    ):
        assert world.value(f"{call}, {{noError=true}})") is None
    world.lua("sim.setFloatProperty(cube, 'mass', -1, {noError=true})")
    assert world.value("sim.getFloatProperty(cube, 'mass')") == 0.5
    world.fails("sim.getFloatProperty(cube, 'mas', {noError=false})", "no property")


def test_properties_are_listed(world: ScriptWorld) -> None:
    assert world.lua("return sim.getPropertyInfo(cube, 'mass')") == [2, 0, '{"label": "mass"}']
    assert world.lua("return sim.getPropertyInfo(cube, 'objectType')")[1] == 1
    assert world.lua("return sim.getPropertyInfo(cube, 'mas')") == [None, None, None]
    assert world.value("sim.getPropertyTypeString(sim.propertytype_floatarray)") == "floatarray"
    world.fails("sim.getPropertyTypeString(99)", "no type of properties")
    names = world.value(
        "(function() local all, i = {}, 0; while true do local name, group = sim.getPropertyName(cube, i); "
        "if not name then return all end; all[name] = group; i = i + 1 end end)()"
    )
    assert (names["mass"], names["alias"]) == ("shape", "object")
    assert world.lua("return sim.getPropertyName(cube, 0, {prefix='mass'})") == ["mass", "shape"]
    assert world.lua("return sim.getPropertyName(sim.handle_app, 0)")[1] == "app"
    found = world.value("sim.getProperties(cube, {skipLarge=true})")
    assert found["mass"] == 0.5
    assert found["position"] == [2, 0, 1]
    assert "applyColor.diffuse" not in found


def test_the_properties_of_a_target_are_described(world: ScriptWorld) -> None:
    found = world.value("sim.getPropertiesInfos(cube)")
    assert found["mass"]["type"] == 2
    assert found["mass"]["class"] == "shape"
    assert found["visible"]["flags"]["writable"] is False
    assert found["applyColor.diffuse"]["flags"]["readable"] is False


def test_many_properties_are_set_at_once(world: ScriptWorld) -> None:
    world.lua("sim.setProperties(cube, {mass=3, alias='heavy', ['customData.a']=1})")
    assert world.value("sim.getFloatProperty(cube, 'mass')") == 3
    assert world.lua("return sim.getObjectAlias(cube), sim.getProperty(cube, 'customData.a')") == ["heavy", 1]


def test_the_stop_undoes_what_a_run_has_set(world: ScriptWorld) -> None:
    world.lua(
        "sim.setFloatProperty(cube, 'mass', 9); sim.setStringProperty(cube, 'alias', 'x');"
        "sim.setFloatProperty(ray, 'volume_range', 1); sim.setVector3Property(sim.handle_scene, 'gravity', {0, 0, -5})"
    )
    world.call("simxStopSimulation")
    world.run(0)
    use_names(world)
    assert world.value("sim.getFloatProperty(cube, 'mass')") == 0.5
    assert world.value("sim.getFloatProperty(ray, 'volume_range')") == 10
    assert world.value("sim.getVector3Property(sim.handle_scene, 'gravity')") == [0, 0, 0]


def test_point_clouds_and_octrees(world: ScriptWorld) -> None:
    world.lua(
        "cloud, tree = sim.createPointCloud(0.05, 20, 0), sim.createOctree(0.1, 0)"
        "sim.insertPointsIntoPointCloud(cloud, 0, {1, 2, 3, 4, 5, 6})"
        "sim.insertVoxelsIntoOctree(tree, 0, {0.05, 0.05, 0.05})"
    )
    assert world.value("sim.getFloatArrayProperty(cloud, 'points')") == [1, 2, 3, 4, 5, 6]
    assert kept(world, "cloud", "Float", "cellSize", "0.25") == 0.25
    assert kept(world, "cloud", "Int", "maxPointsInCell", "7") == 7
    assert kept(world, "cloud", "Int", "pointSize", "2") == 2
    assert kept(world, "cloud", "Bool", "ocTreeStruct", "false") is False
    world.fails("sim.setIntProperty(cloud, 'maxPointsInCell', 0)", "at least one point")
    assert world.value("sim.getFloatProperty(tree, 'voxelSize')") == 0.1
    assert world.value("sim.getFloatArrayProperty(tree, 'voxels')") == pytest.approx([0.05] * 3)
    world.goes_on("sim.getBufferProperty(tree, 'colors')", "set, and not read")


def test_no_property_is_both_here_and_missing() -> None:
    assert not [name for name in missing.MISSING if kinds_with(name)]


LINKED = SCENE.replace(
    "</worldbody>",
    '<site name="one"/><site name="two" pos="1 0 0"/><site name="Script" pos="0 0 0"/>'
    '<body name="plate" pos="0 4 1"><freejoint/><geom type="box" size="0.1 0.1 0.1"/>'
    '<site name="scales"/><body name="load" pos="0 0 0.2"><geom type="box" size="0.1 0.1 0.1" mass="1"/></body></body>'
    "</worldbody>",
).replace("<rangefinder", '<force site="scales"/><torque site="scales"/><rangefinder')


def test_dummies_and_force_sensors(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, xml=LINKED)
    world.lua(
        "one, two, scales = sim.getObject('/one'), sim.getObject('/two'), sim.getObjectHandle('scales')"
    )
    assert world.value("sim.getIntProperty(one, 'dummyType') == sim.dummytype_default")
    world.lua("sim.setHandleProperty(one, 'linkedDummy', two)")
    assert world.value("sim.getIntProperty(one, 'dummyType') == sim.dummytype_dynloopclosure")
    assert world.value("sim.getIntProperty(two, 'linkedDummyHandle') == one")
    assert kept(world, "one", "Int", "dummyType", "5") == 5
    assert kept(world, "scales", "Float", "forceThreshold", "50") == 50
    assert world.value("sim.getBoolProperty(scales, 'forceThresholdEnabled')") is True
    assert kept(world, "scales", "Bool", "forceThresholdEnabled", "false") is False
    assert world.value("sim.getFloatProperty(scales, 'forceThreshold')") == 0
    assert kept(world, "scales", "Bool", "torqueThresholdEnabled", "true") is True
    assert world.value("sim.getFloatProperty(scales, 'torqueThreshold')") == 10
    assert kept(world, "scales", "Int", "filterSampleSize", "3") == 3
    assert kept(world, "scales", "Int", "consecutiveViolationsToTrigger", "3") == 3
    assert kept(world, "scales", "Int", "filterType", "1") == 1
    assert world.value("sim.getVector3Property(scales, 'sensorForce')") == [0, 0, 0]
    world.lua("sim.setVector3Property(sim.handle_scene, 'gravity', {0, 0, -10})")
    world.passes(2)
    for name in ("sensorForce", "filteredSensorForce", "sensorTorque"):
        assert len(world.value(f"sim.getVector3Property(scales, '{name}')")) == 3
    world.lua("plate = sim.getObjectHandle('plate')")
    assert kept(world, "plate", "Bool", "dynamic", "false") is False
    assert kept(world, "plate", "Bool", "dynamic", "true") is True
    world.fails("sim.setFloatProperty(scales, 'forceThreshold', 0)", "a number above 0")
    world.fails("sim.setIntProperty(scales, 'filterType', 7)", "0 average or 1 median")
