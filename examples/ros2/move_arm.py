"""Move an arm as MoveIt does: send a trajectory to the action FollowJointTrajectory, and wait for the result.

    simx-server ur5_rg2_kinect --ros2 --ros2-router self --start
    python move_arm.py UR5_controller shoulder_pan_joint=-1.2 elbow_joint=0.3 --seconds 2

It prints the result's code (0: the arm is there) and its text. An action is made of services; the SDK takes their types
as definitions and hashes.
"""

from __future__ import annotations

import argparse
import sys
import uuid
from typing import Any

import numpy as np
from zenoh_ros2_sdk import ROS2ServiceClient, get_message_class, load_message_type  # pyright: ignore[reportMissingImports]

ACTION = "control_msgs/action/FollowJointTrajectory"
GOAL = """\
unique_identifier_msgs/UUID goal_id
trajectory_msgs/JointTrajectory trajectory
trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory
control_msgs/JointTolerance[] path_tolerance
control_msgs/JointComponentTolerance[] component_path_tolerance
control_msgs/JointTolerance[] goal_tolerance
control_msgs/JointComponentTolerance[] component_goal_tolerance
builtin_interfaces/Duration goal_time_tolerance
"""
ACCEPTED = "bool accepted\nbuiltin_interfaces/Time stamp\n"
WHICH = "unique_identifier_msgs/UUID goal_id\n"
RESULT = "int8 status\nint32 error_code\nstring error_string\n"
SEND_HASH = "RIHS01_b13789dddc325a7a962825c45e28c77d37237ec129dd0c34dc5994562938c57f"
RESULT_HASH = "RIHS01_e3ceb38e3e1867c8dc0f46014df26e90eb93422f27e9e97f936e07f94be4bc8b"

NEEDED = (
    *("builtin_interfaces/msg/Duration", "unique_identifier_msgs/msg/UUID"),
    *("trajectory_msgs/msg/JointTrajectory", "trajectory_msgs/msg/MultiDOFJointTrajectory"),
    *("control_msgs/msg/JointTolerance", "control_msgs/msg/JointComponentTolerance"),
)


def made(kind: str, **fields: Any) -> Any:
    """Return a message."""
    return get_message_class(kind)(**fields)  # pyright: ignore[reportOptionalCall]


def move(controller: str, goals: dict[str, float], seconds: float, port: int) -> tuple[int, str]:
    """Move joints, and return the code and the text of the result."""
    for kind in NEEDED:
        load_message_type(kind)
    action = f"/{controller}/follow_joint_trajectory/_action"
    send = ROS2ServiceClient(
        f"{action}/send_goal", f"{ACTION}_SendGoal", GOAL, ACCEPTED, type_hash=SEND_HASH, router_port=port
    )
    result = ROS2ServiceClient(
        f"{action}/get_result",
        f"{ACTION}_GetResult",
        WHICH,
        RESULT,
        type_hash=RESULT_HASH,
        router_port=port,
        timeout=seconds * 10 + 60,
    )
    goal_id = made("unique_identifier_msgs/msg/UUID", uuid=np.frombuffer(uuid.uuid4().bytes, np.uint8))
    now = made("builtin_interfaces/msg/Time", sec=0, nanosec=0)
    header = made("std_msgs/msg/Header", stamp=now, frame_id="")
    nothing = np.array([], np.float64)
    duration = "builtin_interfaces/msg/Duration"
    point = made(
        "trajectory_msgs/msg/JointTrajectoryPoint",
        positions=np.array([*goals.values()], np.float64),
        velocities=nothing,
        accelerations=nothing,
        effort=nothing,
        time_from_start=made(duration, sec=int(seconds), nanosec=int(seconds % 1 * 1e9)),
    )
    several = "trajectory_msgs/msg/MultiDOFJointTrajectory"
    answer = send.call(
        goal_id=goal_id,
        trajectory=made(
            "trajectory_msgs/msg/JointTrajectory", header=header, joint_names=[*goals], points=[point]
        ),
        multi_dof_trajectory=made(several, header=header, joint_names=[], points=[]),
        path_tolerance=[],
        component_path_tolerance=[],
        goal_tolerance=[],
        component_goal_tolerance=[],
        goal_time_tolerance=made(duration, sec=0, nanosec=0),
    )
    if answer is None or not answer.accepted:
        return 1, "the goal was not accepted"
    done = result.call(goal_id=goal_id)
    return (1, "no result came") if done is None else (int(done.error_code), str(done.error_string))


def main() -> int:
    """Move the arm."""
    parser = argparse.ArgumentParser(description="Move an arm along a trajectory.")
    parser.add_argument("controller", help="such as UR5_controller")
    parser.add_argument("goals", nargs="+", metavar="JOINT=ANGLE", help="in rad")
    parser.add_argument("--seconds", type=float, default=2.0, help="of simulated time")
    parser.add_argument("--port", type=int, default=7447, help="of the router")
    options = parser.parse_args()
    goals = {name: float(angle) for name, _, angle in (each.partition("=") for each in options.goals)}
    code, text = move(options.controller, goals, options.seconds, options.port)
    print(f"result {code} {text}", flush=True)
    return 0 if code == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
