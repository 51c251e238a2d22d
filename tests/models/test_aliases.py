"""The names that CoppeliaSim 4 gives the parts of its models: programs for it name them in paths."""

from __future__ import annotations

import pytest
from real_world import Open

PATHS = {
    "pioneer_p3dx": {
        "/PioneerP3DX": "Pioneer_p3dx",
        "/PioneerP3DX/leftMotor": "Pioneer_p3dx_leftMotor",
        "/rightMotor": "Pioneer_p3dx_rightMotor",
        "/PioneerP3DX/ultrasonicSensor[0]": "Pioneer_p3dx_ultrasonicSensor1",
        "/PioneerP3DX/ultrasonicSensor[15]": "Pioneer_p3dx_ultrasonicSensor16",
        "/Floor": "ResizableFloor_5_25",
    },
    "ur5_rg2_kinect": {
        "/UR5/joint": "UR5_joint1",
        "/UR5/joint{5}": "UR5_joint6",
        "/UR5/joint/link/joint": "UR5_joint2",
        "/UR5/joint/joint": "UR5_joint2",
        "/UR5/connection": "UR5_connection",
        "/RG2/openCloseJoint": "RG2_openCloseJoint",
    },
    "stock_kinect": {
        "/kinect/rgb": "kinect_rgb",
        "/kinect/depth": "kinect_depth",
        "/kinect/joint": "kinect_joint",
    },
    "quadricopter": {
        "/Quadcopter": "Quadricopter",
        "/Quadcopter/base": "Quadricopter_base",
        "/target": "Quadricopter_target",
        "/Quadcopter/propeller[0]/respondable": "Quadricopter_propeller_respondable1",
    },
    "lbr_iiwa_7_r800": {"/LBRiiwa7R800/joint{6}": "LBR_iiwa_7_R800_joint7"},
    "bubblerob_tutorial": {"/bubbleRob/leftMotor": "bubbleRob_leftMotor"},
    "e_puck": {"/ePuck/leftJoint": "ePuck_leftJoint", "/ePuck/proxSensor[7]": "ePuck_proxSensor8"},
    "jaco": {"/Jaco/joint{5}": "Jaco_joint6"},
}


@pytest.mark.parametrize("scene", PATHS)
def test_paths_of_coppeliasim_lead_to_the_parts(world: Open, scene: str) -> None:
    opened, _ = world(scene)
    names = opened.simulation.scene
    for path, name in PATHS[scene].items():
        assert names.objects[names.resolve(path)].name == name, path
        assert names.resolve(name) == names.resolve(path), "the old name stays"


def test_brackets_count_the_children_of_one_object(world: Open) -> None:
    opened, _ = world("ur5")
    scene = opened.simulation.scene
    first = scene.resolve("/UR5/joint")
    scene.objects[scene.resolve("/Cylinder" if scene.by_name("Cylinder") else "/Camera")].alias = "joint"
    assert scene.resolve("/joint") != first, "the nearer to the top comes first"
    assert scene.resolve("/UR5/joint") == first
