"""The names of a scene's objects in ROS 2: joints in JointState, frames in transforms and headers."""

from __future__ import annotations

from simx_server.scene.objects import Scene, SceneObject

from ..wire.names import part_of_name

WORLD = "world"
"""The frame of the world, at the root of all transforms."""


def joint_name(item: SceneObject) -> str:
    """Return the name of a joint in JointState and JointTrajectory."""
    return item.name


def frame_name(item: SceneObject) -> str:
    """Return the frame of an object. Frames have no slash at their start; else every text is one."""
    return item.name.lstrip("/") or f"object_{item.handle}"


def optical_frame(item: SceneObject) -> str:
    """Return the frame of a camera's image: z forward, x right, y down."""
    return f"{frame_name(item)}_optical_frame"


def part_of_topic(scene: Scene, item: SceneObject) -> str:
    """Return an object's name as the part of a topic's name; two objects never have the same.

    `Vision_sensor#0` becomes `Vision_sensor_0`, and if another object has that name or comes to it, a number follows.
    """
    wanted = part_of_name(item.name)
    same = [each.handle for each in scene.objects.values() if part_of_name(each.name) == wanted]
    if len(same) == 1 or item.name == wanted:
        return wanted
    return f"{wanted}__{item.handle}"
