"""The module ``sim-2`` in Lua scripts: objects, properties, methods, values."""

from __future__ import annotations

from pathlib import Path

import pytest
from sim_api_calls import SCENE, ScriptWorld

OBJECTS = "sim2 = require('sim-2'); cube = sim2.scene:getObject('/cube'); hinge = sim2.scene:getObject('/robot/hinge')"


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> ScriptWorld:
    world = ScriptWorld(tmp_path_factory.mktemp("sim-2"))
    world.lua(OBJECTS)
    return world


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("sim2.version", 2),
        ("tostring(sim2.scene)", "sim.Object(-12)"),
        ("cube.type", "shape"),
        ("cube.name", "cube"),
        ("hinge.joint.type", "revolute"),
        ("cube.position:data()", [2.0, 0.0, 1.0]),
        ("cube.position[3]", 1.0),
        ("cube:getPosition():rows()", 3),
        ("cube.pose.t[1]", 2.0),
        ("cube.pose.q.w", 1.0),
        ("#cube.worldQuaternion", 4),
        ("sim2.scene.simulation.time", 0.0),
        ("math.type(sim2.scene.simulation.state)", "integer"),
        ("sim2.simulationState.running", 17),
        ("sim2.jointType.prismatic", 11),
        ("sim2.handle_all", -2),
        ("sim2.getObjectPosition == sim.getObjectPosition", True),
        ("sim2.getNothing == nil", True),
        ("cube.nothing == nil", True),
        ("cube == sim2.scene:getObject('cube')", True),
        ("sim2.Object('/cube') == cube", True),
        ("hinge.parent == sim2.scene:getObject('/robot')", True),
        ("sim2.scene:getObject('/robot').parent == nil", True),
        ("#sim2.scene:getObjects{'joint'}", 1),
        ("sim2.self.type", "detachedScript"),
        ("sim2.self.language", "lua"),
        ("sim2.app.productVersionNb", 41000),
        ("tostring(cube.color.diffuse):sub(1, 7)", "Color(#"),
        ("cube.inertiaMatrix.T:cols()", 3),
        ("require('sim') == sim", True),
        ("require('sim-1') == sim", True),
        ("require('sim-2') == sim2", True),
        ("select('#', cube:getPropertyInfo('bla', {noError = true}))", 3),
    ],
)
def test_members_are_read(shared: ScriptWorld, expression: str, value: object) -> None:
    assert shared.value(expression) == value


def test_members_are_set(shared: ScriptWorld) -> None:
    shared.lua("cube.position = {1, 2, 3}")
    assert shared.value("cube.position:data()") == [1.0, 2.0, 3.0]
    shared.lua("local eigen = require('simEigen'); cube.position = eigen.Vector{4, 5, 6}")
    shared.lua("cube.pose = require('simEigen').Pose({0, 0, 2}, {0, 0, 1, 0})")
    assert shared.value("cube.pose:data()") == [0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0]
    shared.lua("hinge.dynamics.ctrlMode = 'velocity'")
    assert shared.value("hinge.dynamics.ctrlMode") == 4
    shared.lua("cube.color.diffuse = require('Color')('red'); cube.mass = 3")
    assert shared.value("cube.color.diffuse:html()") == "#ff0000"
    assert shared.value("cube.mass") == 3.0
    shared.fails("cube.nothing = 1", "property is unknown")
    shared.fails("cube.position[3] = 0", "frozen")


def test_programs_make_properties_of_every_type(shared: ScriptWorld) -> None:
    for value, kind in (
        ("5", "integer"),
        ("0.5", "float"),
        ("'text'", "string"),
        ("true", "boolean"),
        ("{1, 'a'}", "table"),
    ):
        shared.lua(f"cube.customData.mine = {value}")
        assert shared.value("math.type(cube.customData.mine) or type(cube.customData.mine)") == kind
    shared.lua("cube.customData.mine = require('Buffer')('\\0\\255')")
    assert shared.value("cube:getPropertyInfo('customData.mine')") == 4
    shared.lua("cube.refs.friends = {hinge}")
    assert shared.value("cube.refs.friends[1] == hinge") is True
    shared.lua("cube.customData.mine = nil")
    assert shared.value("cube.customData.mine == nil") is True
    shared.lua("sim2.scene.signal.go = 1; sim2.app.namedParam.x = 'y'")
    assert shared.value("sim.getInt32Signal('go')") == 1


def test_functions_get_objects(shared: ScriptWorld) -> None:
    found = shared.lua("""
        local names = {}
        sim2.scene:getObject('/robot'):visitTree(function(item) names[#names + 1] = item.name end)
        return names""")[0]
    assert found[0] == "robot"
    assert "hinge" in found


def test_objects_are_created(shared: ScriptWorld) -> None:
    shared.lua("""
        new = sim2.scene:createObject{type = 'shape', cuboid = {size = {0.2, 0.2, 0.2}}, name = 'made', dynamic = true}
        marker = sim2.scene:createObject{type = 'marker'}
        ids = marker:addItems(require('simEigen').Matrix(3, 2, {1, 4, 2, 5, 3, 6}))""")
    assert shared.value("new.name") == "made"
    assert shared.value("#ids") == 2
    assert shared.value("marker.points:col(2):data()") == [4.0, 5.0, 6.0]
    shared.lua("new:remove(); marker:remove()")
    assert shared.value("new:isValid()") is False
    shared.fails("return new.name", "target does not exist")


def test_quaternions_and_poses_calculate(shared: ScriptWorld) -> None:
    shared.lua("eigen = require('simEigen'); q = eigen.Quaternion.fromeuler({0, 0, math.pi / 2})")
    assert shared.value("(q * eigen.Vector{1, 0, 0}):data()") == pytest.approx([0, 1, 0])
    assert shared.value("(q * q:inv()):data()") == pytest.approx([0, 0, 0, 1])
    shared.lua("p = eigen.Pose({1, 0, 0}, q)")
    assert shared.value("(p * p:inv()):data()") == pytest.approx([0, 0, 0, 0, 0, 0, 1])
    assert shared.value("(p * eigen.Vector{1, 0, 0}):data()") == pytest.approx([1, 1, 0])
    assert shared.value("eigen.Pose(p:tomatrix()) == p or #p") in (True, 7)


MAIN = """
sim = require('sim-2')
function sysCall_init() started = true end
function sysCall_actuation()
    sim.scene:handleSimulationScripts(sim.syscb_actuation)
    sim.scene:handleCustomizationScripts(sim.syscb_actuation)
    sim.app:handleAddOnScripts(sim.syscb_actuation)
    sim.app:handleSandboxScript(sim.syscb_actuation)
    sim.scene:stepKinematicJoints()
    sim.scene.dynamics:step()
end
function sysCall_sensing()
    for _, sensor in ipairs(sim.scene:getObjects{'proximitySensor'}) do
        if not sensor.explicitHandling then sensor:handleSensor() end
    end
    sim.scene:handleSimulationScripts(sim.syscb_sensing)
    sim.scene.signal.seen = (sim.scene.signal.seen or 0) + 1
end
"""


CHILD = """
sim = require('sim-2')
function sysCall_actuation() sim.scene.signal.child = (sim.scene.signal.child or 0) + 1 end
"""
NOTES = """
<text name="simx:script:main" data="file=main.lua type=main"/>
<text name="simx:script:cube" data="file=child.lua"/>
"""


def test_a_main_script_of_4_11_runs_the_scene(tmp_path: Path) -> None:
    (tmp_path / "main.lua").write_text(MAIN)
    (tmp_path / "child.lua").write_text(CHILD)
    scene = SCENE.replace("<custom>", f"<custom>{NOTES}")
    world = ScriptWorld(tmp_path, scene)
    world.passes(3)
    assert world.parts.signals.get_integer("child") == 3
    assert world.parts.signals.get_integer("seen") == 3


def test_motions_reach_their_goals(shared: ScriptWorld) -> None:
    found = shared.lua("""
        local Motion = require('Motion')
        local motion = Motion.RuckigPosition{pos = {0}, targetPos = {0.1}, maxVel = {1}, maxAccel = {2}, maxJerk = {9}}
        local steps = 0
        while motion:step() == 0 do steps = steps + 1 end
        local data = motion:data()
        motion:remove()
        local speed = Motion.RuckigVelocity{pos = {0}, targetVel = {1}, maxAccel = {2}, maxJerk = {9}}
        while speed:step() == 0 do end
        return steps, data.pos[1], speed:data().vel[1]""")
    assert found[0] > 3
    assert found[1:] == pytest.approx([0.1, 1.0])


def test_the_classes_of_motions_have_the_methods_of_the_model(shared: ScriptWorld) -> None:
    text = (Path(__file__).parents[3] / "support" / "manual" / "api2_methods.txt").read_text()
    shared.lua("Motion = require('Motion')")
    found = 0
    for kind in ("RuckigPosition", "RuckigVelocity", "MoveToConfig", "MoveToPose", "TimeOptimalTrajectory"):
        for name in text.partition(f"[{kind}]")[2].partition("[")[0].split():
            member = (
                f"getmetatable(Motion.{kind}).__call" if name == "Constructor" else f"Motion.{kind}.{name}"
            )
            assert shared.value(f"type({member})") == "function", f"{kind}.{name}"
            found += 1
    assert found == 21


JOINT = """
sim = require('sim-2')
function sysCall_joint(inData)
    sim.scene.signal.name = inData.joint.name
    return {pos = inData.pos + 0.01, vel = 0.2}
end
"""


def test_a_call_back_of_a_joint_gets_an_object(tmp_path: Path) -> None:
    (tmp_path / "joint.lua").write_text(JOINT)
    note = '<text name="simx:script:hinge" data="file=joint.lua"/>'
    world = ScriptWorld(
        tmp_path,
        SCENE.replace("control=position", "mode=passive control=position").replace(
            "<custom>", f"<custom>{note}"
        ),
    )
    world.lua("hinge = sim.getObject('/robot/hinge')")
    world.lua("sim.setJointMode(hinge, 0, 0); sim.setJointTargetPosition(hinge, 1)")
    world.passes(2)
    assert world.value("sim.getStringSignal('name')") == "hinge"


def test_a_method_is_called_without_the_module(shared: ScriptWorld) -> None:
    shared.lua("sim.setMatrixProperty(sim.handle_scene, 'customData.grid', {{1, 2}, {3, 4}})")
    assert shared.value("sim.getMatrixProperty(sim.handle_scene, 'customData.grid')") == [
        [1.0, 2.0],
        [3.0, 4.0],
    ]
    found = shared.value("sim.callMethod(sim.handle_scene, 'getProperty', 'customData.grid')")
    assert found == {"@": "matrix", "value": [2, 2, [1.0, 2.0, 3.0, 4.0]]}
    assert shared.value("sim2.scene.customData.grid:item(2, 1)") == 3.0
