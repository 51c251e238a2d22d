"""The tutorial's reach task as a Gymnasium vector environment: one simulation each, all stepped together.

The hand camera is to come over the ball `Target`, so that the ball is in the middle of its picture, HEIGHT in front
of it. Where the ball lies is drawn anew for each episode.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from simx_client.client import Answer, Calls, Servers

Floats = NDArray[np.float32]

JOINTS = tuple(f"UR5_joint{number}" for number in range(1, 7))
CAMERA, BALL = "kinect_rgb", "Target"

START = np.radians([90.0, -45.0, 90.0, 0.0, -100.0, 0.0])
"""Joint angles from which the camera sees the ball; the tutorial's."""

REACH = 0.9
"""Radians that a joint may leave the start pose by; within them the arm does not meet itself."""

INCREMENT = 0.05
"""Radians per pass of 50 ms that an action of 1 moves a joint's target by."""

HEIGHT = 0.35
"""Metres between camera and ball that are wanted; the gripper's fingers then stay clear of the ball."""

BALL_LOW, BALL_HIGH = (-0.55, -0.15), (-0.35, 0.12)
"""World x and y within which the ball lies, m: reachable, and free of the loose solids."""

BALL_Z = 0.075
EPISODE = 100
"""Passes of an episode: five seconds."""


def distance(observations: NDArray[Any]) -> NDArray[np.float64]:
    """Metres between the ball and where it should be in the camera's frame; one per row."""
    return np.linalg.norm(observations[:, 6:9] - (0.0, 0.0, HEIGHT), axis=1)


class ReachEnv(VectorEnv[Floats, Floats, NDArray[Any]]):
    """Observation: six joint angles (rad), then the ball in the camera's frame (m; z is ahead).

    Action: six numbers from -1 to 1, by which the joints' targets move, times INCREMENT. Reward: minus the distance
    in metres. An episode always has EPISODE passes; then all simulations begin anew, within the same step.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012 - Gymnasium's form

    def __init__(self, servers: Servers) -> None:
        """Use simulations of the tutorial's scene; they are closed with the environment.

        Args:
            servers: ``Worlds("ur5_rg2_kinect", 8)``, or ``Client.many(ports)`` for servers that run already.

        Raises:
            CallsFailed: one of them has another scene.
        """
        self.servers = servers
        self.num_envs = len(servers)
        bounds = np.full(9, np.inf, dtype=np.float32)
        self.single_observation_space = gymnasium.spaces.Box(-bounds, bounds)
        self.single_action_space = gymnasium.spaces.Box(-1.0, 1.0, (6,), dtype=np.float32)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        try:
            self._handles = [
                [answer.value for answer in answers]
                for answers in self.servers.each(
                    lambda calls, _: [calls.simxGetObjectHandle(name) for name in (*JOINTS, CAMERA, BALL)]
                )
            ]
            self._targets = np.tile(START, (self.num_envs, 1))
            self._balls = np.zeros((self.num_envs, 3))
            self._passes = 0
            self.servers.watch(self._read)
        except BaseException:
            self.servers.close()
            raise

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begin an episode everywhere; the seed decides where the balls lie, in this episode and the following."""
        super().reset(seed=seed)
        return self._begin(), {}

    def step(
        self, actions: Floats
    ) -> tuple[Floats, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """One pass everywhere. ``infos["distance"]`` is in metres; at an episode's end ``final_obs`` is what it
        ended with, and the observations are the first of the next one.

        Raises:
            CallsFailed: a simulation has gone, or refused something.
        """
        moved = self._targets + INCREMENT * np.clip(actions, -1.0, 1.0)
        self._targets = np.clip(moved, START - REACH, START + REACH)
        observations = self.servers.step(self._write).astype(np.float32)
        far = distance(observations)
        self._passes += 1
        is_over = self._passes >= EPISODE
        infos: dict[str, Any] = {"distance": far, "_distance": np.ones(self.num_envs, dtype=bool)}
        if is_over:
            infos |= {"final_obs": observations, "_final_obs": np.ones(self.num_envs, dtype=bool)}
            observations = self._begin()
        none = np.zeros(self.num_envs, dtype=bool)
        return observations, -far, none, none | is_over, infos

    def close_extras(self, **_: Any) -> None:
        """What Gymnasium's ``close`` calls: close the simulations, stopped."""
        try:
            self.servers.each(lambda calls, _: calls.simxStopSimulation(), check=False)
        finally:
            self.servers.close()

    def _begin(self) -> Floats:
        """A stop puts everything back to where it was, so equal episodes are equal to the bit. One message each."""
        self._passes = 0
        self._targets[:] = START
        self._balls[:, :2] = self.np_random.uniform(BALL_LOW, BALL_HIGH, (self.num_envs, 2))
        self._balls[:, 2] = BALL_Z
        answers = self.servers.each(self._prepare)
        return np.array([np.hstack([answer.value for answer in row]) for row in answers], dtype=np.float32)

    # --- what is called on each simulation --------------------------------------------------------

    def _prepare(self, calls: Calls, place: int) -> list[Answer[Any]]:
        *joints, _, ball = self._handles[place]
        calls.simxStopSimulation()
        calls.simxSynchronous(True)
        calls.simxStartSimulation()
        for joint, angle in zip(joints, START, strict=True):
            calls.simxSetJointPosition(joint, angle)
            calls.simxSetJointTargetPosition(joint, angle)
        calls.simxSetObjectPosition(ball, -1, self._balls[place])
        return self._read(calls, place)

    def _read(self, calls: Calls, place: int) -> list[Answer[Any]]:
        *joints, camera, ball = self._handles[place]
        return [
            *[calls.simxGetJointPosition(joint) for joint in joints],
            calls.simxGetObjectPosition(ball, camera),
        ]

    def _write(self, calls: Calls, place: int) -> None:
        *joints, _, _ = self._handles[place]
        for joint, target in zip(joints, self._targets[place].tolist(), strict=True):
            calls.simxSetJointTargetPosition(joint, target)
