"""The files of examples/ros2 name actions, topics, joints and frames that the server has."""

from __future__ import annotations

import re
from typing import Any

import pytest
from processes import ROOT
from ros2_contents import Contents

from simx_server.gateways.ros2.endpoints import Served

yaml = pytest.importorskip("ruamel.yaml", reason="needs rosbags, of the extra dev")

FOLDER = ROOT / "examples" / "ros2"


def loaded(name: str) -> Any:
    return yaml.YAML(typ="safe").load((FOLDER / name).read_text(encoding="utf-8"))


def test_moveits_controllers_are_actions_of_the_server() -> None:
    manager = loaded("moveit_controllers.yaml")["moveit_simple_controller_manager"]
    contents = Contents(ROOT / "scenes" / "ur5_rg2_kinect.xml")
    services = {each.service: each.type for each in contents.offers() if isinstance(each, Served)}
    for name in manager["controller_names"]:
        given = manager[name]
        kind = services[f"/{name}/{given['action_ns']}/_action/send_goal"]
        assert kind == f"control_msgs/action/{given['type']}_SendGoal"
    states = contents.message("/robot_joint_states")["name"]
    assert manager["UR5_controller"]["joints"] == list(states)
    assert contents.handle(manager["RG2_gripper_controller"]["joints"][0])
    contents.close()


def test_the_block_for_ros2_control_names_topics_and_joints_of_the_server() -> None:
    text = (FOLDER / "ur5.ros2_control.xacro").read_text(encoding="utf-8")
    contents = Contents(ROOT / "scenes" / "ur5.xml")
    for topic in re.findall(r"_topic\">([^<]+)<", text):
        assert topic in contents.topics()
    states = contents.message("/robot_joint_states")["name"]
    assert re.findall(r"position_joint name=\"(\w+)\"/>", text) == list(states)
    contents.close()


def test_nav2_is_given_topics_and_frames_of_the_server() -> None:
    given = loaded("nav2.yaml")
    contents = Contents(ROOT / "scenes" / "pioneer_p3dx.xml")
    assert given["amcl"]["ros__parameters"]["scan_topic"] in contents.topics()
    assert given["bt_navigator"]["ros__parameters"]["odom_topic"] in contents.topics()
    odometry = contents.message("/odom")
    assert odometry["child_frame_id"] == given["amcl"]["ros__parameters"]["base_frame_id"]
    assert (
        odometry["header"]["frame_id"]
        == given["local_costmap"]["local_costmap"]["ros__parameters"]["global_frame"]
    )
    contents.close()


def test_the_launch_file_is_valid_python_and_has_flags_of_the_server() -> None:
    text = (FOLDER / "simulation.launch.py").read_text(encoding="utf-8")
    compile(text, "simulation.launch.py", "exec")
    assert '"--ros2", "--ros2-router", "self", "--start"' in text
