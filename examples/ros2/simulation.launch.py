# pyright: reportMissingImports=false, reportUnknownVariableType=false
"""Start a simulation as a node of ROS 2 that is the router too; argument: scene.

Set RMW_IMPLEMENTATION=rmw_zenoh_cpp for all other nodes, and use_sim_time.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration


def generate_launch_description() -> LaunchDescription:
    """Return the server with the scene of the argument."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("scene", default_value="ur5_rg2_kinect"),
            ExecuteProcess(
                cmd=[
                    "simx-server", LaunchConfiguration("scene"), "--ros2", "--ros2-router", "self", "--start",
                ],
                output="screen",
            ),
        ]
    )  # fmt: skip
