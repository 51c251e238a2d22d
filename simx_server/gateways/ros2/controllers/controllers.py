"""The controllers of a scene: one for each arm and each gripper, with MoveIt's usual names."""

from __future__ import annotations

from collections.abc import Iterable

from simx_server.scene.objects import Scene, SceneObject

from ..actions import Action
from ..annotated.joint_groups import Group, group_of
from ..annotated.notes import Names, annotated
from ..content.naming import part_of_topic
from ..endpoints import Content, Context, Followed, Moment, Offer
from ..wire.names import Distribution
from .finding import Arm, find_arms
from .gripper import GripperHandler
from .trajectory import TrajectoryHandler

TRAJECTORY, GRIPPER = "control_msgs/action/FollowJointTrajectory", "control_msgs/action/GripperCommand"


class Controllers(Content):
    """Serves ``/ROBOT_controller/follow_joint_trajectory`` and ``/GRIPPER_gripper_controller/gripper_cmd``."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._simulation = context.world.simulation
        self._trajectories: dict[str, tuple[Action, TrajectoryHandler]] = {}
        self._grippers: dict[str, tuple[Action, GripperHandler]] = {}
        """By name; each goes on when the offers are listed again."""

    def run_stopped(self) -> None:
        for _, handler in (*self._trajectories.values(), *self._grippers.values()):
            handler.abort("the simulation was stopped")

    def offers(self) -> Iterable[Offer]:
        scene, joints = self._simulation.scene, self._simulation.joints
        names = Names(scene, self._context.robots)
        groups = [
            group_of(scene, joints, names, item, note)
            for item, note in annotated(scene, self._context.robots, "command")
        ]
        trajectories, self._trajectories = self._trajectories, {}
        grippers, self._grippers = self._grippers, {}
        for arm in find_arms(scene, joints):
            topic = f"{_topic(scene, names, arm)}_controller/follow_joint_trajectory"
            action, handler = self._trajectories[topic] = trajectories.get(topic) or self._trajectory(topic)
            handler.group = _group(scene, names, arm, groups)
            yield from action.offers()
            yield Followed(topic, handler.due, handler.is_under_way)
            if not arm.gripper:
                continue
            holder = scene.objects[arm.gripper[0]]
            topic = f"{names.own_topic(names.robot(holder))}_gripper_controller/gripper_cmd"
            if topic in self._grippers:
                continue
            gripper, moving = self._grippers[topic] = grippers.get(topic) or self._gripper(topic)
            moving.handles, moving.has_targets = arm.gripper, arm.has_targets
            yield from gripper.offers()
            yield Followed(topic, moving.due, moving.is_under_way)
        for topic, (_, gone) in (*trajectories.items(), *grippers.items()):
            if topic not in self._trajectories and topic not in self._grippers:
                gone.abort("its joints have gone")

    def _now(self) -> Moment:
        return Moment.of(self._simulation.step_count, self._simulation.time_step)

    def _trajectory(self, topic: str) -> tuple[Action, TrajectoryHandler]:
        handler = TrajectoryHandler(self._context)
        # Humble has the older feedback only.
        older_lacks = () if self._context.distribution is Distribution.HUMBLE else ("index",)
        return Action(topic, TRAJECTORY, handler, lambda: self._now().stamp, older_lacks=older_lacks), handler

    def _gripper(self, topic: str) -> tuple[Action, GripperHandler]:
        handler = GripperHandler(self._context)
        return Action(topic, GRIPPER, handler, lambda: self._now().stamp), handler


def _topic(scene: Scene, names: Names, arm: Arm) -> str:
    """Return the name of an arm: that of its robot, with that of its first joint if there are several."""
    root = names.own_topic(arm.robot)
    return root if arm.is_alone else f"{root}_{part_of_topic(scene, scene.objects[arm.joints[0]])}"


def _group(scene: Scene, names: Names, arm: Arm, groups: Iterable[Group]) -> Group:
    """Return the joints of an arm, with the names and offsets of an annotated group that has all of them."""
    for group in groups:
        if set(arm.joints) <= set(group.handles):
            places = [group.handles.index(handle) for handle in arm.joints]
            return Group(
                tuple(group.names[place] for place in places),
                tuple(arm.joints),
                tuple(group.offsets[place] for place in places),
            )
    items: list[SceneObject] = [scene.objects[handle] for handle in arm.joints]
    return Group(tuple(map(names.joint, items)), tuple(arm.joints), (0.0,) * len(items))
