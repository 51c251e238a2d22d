"""Replay the key poses of RLBench's demonstrations: ``python tests/pyrep/key_poses.py PATH TASK ...``.

PATH is a checkout of RLBench, with PyRep installed or on PYTHONPATH. Policies such as PerAct, RVT and 3D Diffuser Actor
predict the next pose of the gripper, to which RLBench plans a path. Here a demonstration gives these poses: those where
the gripper opens or closes, or the arm rests. The task is put back to the demonstration's start, and each pose is
reached by planning, with collision checks where such a path exists. Point clouds and a film camera are read as well. A
line of JSON tells for each task how many replays succeed.
"""

# pyright: reportMissingImports=false, reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false, reportPrivateUsage=false
from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from run_rlbench import with_base_scene

import simx_client.pyrep

STILL = 0.1
"""Velocity of joints in rad/s below which the arm rests."""

PAUSE = 4
"""Steps after a pose at rest in which no other one is found."""


def key_poses(demonstration: Any) -> list[int]:
    """Return the indices of the observations after which the gripper changes or the arm rests, and the last one."""
    found: list[int] = []
    pause, opened = 0, demonstration[0].gripper_open
    for index in range(1, len(demonstration)):
        present = demonstration[index]
        around = [demonstration[max(min(index + by, len(demonstration) - 1), 0)] for by in (-2, -1, 1)]
        is_still = (
            pause <= 0
            and index < len(demonstration) - 2
            and np.allclose(present.joint_velocities, 0, atol=STILL)
            and all(each.gripper_open == present.gripper_open for each in around)
        )
        pause = PAUSE if is_still else pause - 1
        if is_still or present.gripper_open != opened or index == len(demonstration) - 1:
            found.append(index)
        opened = present.gripper_open
    return found


class Replays:
    """An environment in which the gripper's pose is reached by planning."""

    def __init__(self) -> None:
        from pyrep.const import RenderMode
        from pyrep.objects import Dummy, VisionSensor
        from rlbench.action_modes.action_mode import MoveArmThenGripper
        from rlbench.action_modes.arm_action_modes import EndEffectorPoseViaPlanning
        from rlbench.action_modes.gripper_action_modes import Discrete
        from rlbench.environment import Environment
        from rlbench.observation_config import ObservationConfig

        observed = ObservationConfig()
        observed.set_all_high_dim(False)
        for camera in (observed.left_shoulder_camera, observed.front_camera, observed.wrist_camera):
            camera.rgb = camera.depth = camera.point_cloud = True
        self._arm = EndEffectorPoseViaPlanning()
        self.environment = Environment(MoveArmThenGripper(self._arm, Discrete()), "", observed, headless=True)
        self.environment.launch()
        self._film = VisionSensor.create([320, 180])
        self._film.set_explicit_handling(True)
        self._film.set_pose(Dummy("cam_cinematic_placeholder").get_pose())
        self._film.set_render_mode(RenderMode.OPENGL)

    def run(self, name: str, episodes: int) -> dict[str, Any]:
        """Demonstrate and replay a task; return what came of it."""
        from rlbench.utils import name_to_task_class

        outcome: dict[str, Any] = {"task": name, "succeeded": 0, "of": episodes, "errors": []}
        try:
            task = self.environment.get_task(name_to_task_class(name))
            for _ in range(episodes):
                task.sample_variation()
                (demonstration,) = task.get_demos(1, live_demos=True, max_attempts=5)
                _, observation = task.reset_to_demo(demonstration)
                self._look(observation)
                outcome["succeeded"] += self._replay(task, demonstration)
        except Exception as problem:  # one task must not end the others
            outcome["errors"].append(f"{type(problem).__name__}: {problem}"[:200])
        return outcome

    def _look(self, observation: Any) -> None:
        """Check that clouds have points, and that the film shows something."""
        assert np.isfinite(observation.front_point_cloud).all(), "a point is nowhere"
        self._film.handle_explicitly()
        assert self._film.capture_rgb().std() > 0.02, "the film has one colour"

    def _replay(self, task: Any, demonstration: Any) -> bool:
        from rlbench.backend.exceptions import InvalidActionError

        for index in key_poses(demonstration):
            wanted = demonstration[index]
            action = np.concatenate([wanted.gripper_pose, [wanted.gripper_open]])
            self._arm._collision_checking = True
            try:
                _, reward, _ = task.step(action)
            except InvalidActionError:
                self._arm._collision_checking = False
                _, reward, _ = task.step(action)
            if reward >= 1:
                return True
        return False


def main() -> int:
    """Replay the tasks and print what came of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("checkout", metavar="PATH", type=Path)
    parser.add_argument("tasks", metavar="TASK", nargs="+")
    parser.add_argument("--episodes", type=int, default=3)
    options = parser.parse_intermixed_args()
    simx_client.pyrep.activate()
    sys.path.insert(0, str(options.checkout.resolve()))
    with_base_scene(options.checkout.resolve() / "rlbench")
    replays = Replays()
    try:
        outcomes = []
        for name in options.tasks:
            outcomes.append(replays.run(name, options.episodes))
            print(json.dumps(outcomes[-1]), flush=True)
    finally:
        replays.environment.shutdown()
    succeeded = sum(outcome["succeeded"] for outcome in outcomes)
    print(f"{succeeded} of {sum(outcome['of'] for outcome in outcomes)} replays succeed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
