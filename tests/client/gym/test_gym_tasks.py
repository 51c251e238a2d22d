"""The registered tasks: what an action does, what is rewarded, and that each can be solved."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import gymnasium
import numpy as np
import pytest

from simx_client.gym.tasks import line_follower, reach

pytestmark = pytest.mark.gl

COUNT = 2


@pytest.fixture
def arms() -> Iterator[Any]:
    environment = gymnasium.make_vec("simx/Reach-v0", COUNT, processes=0, autoreset_mode="SameStep")
    yield environment
    environment.close()


def test_reach_balls_lie_elsewhere_in_every_simulation_and_episode(arms: Any) -> None:
    first, _ = arms.reset(seed=3)
    second, _ = arms.reset()
    again, _ = arms.reset(seed=3)
    assert np.array_equal(first, again)
    assert np.allclose(first[:, :6], reach.START, atol=1e-6)
    balls = np.vstack([first, second])[:, 6:]
    assert len({tuple(ball) for ball in balls}) == 4


def test_reach_an_action_turns_its_joint_that_way_and_the_reward_is_the_distance(arms: Any) -> None:
    before, _ = arms.reset(seed=3)
    actions = np.zeros((COUNT, 6), np.float32)
    actions[0, 0], actions[1, 2] = 1.0, -1.0
    for _ in range(4):
        after, rewards, terminated, truncated, infos = arms.step(actions)
        assert not terminated.any()
        assert not truncated.any()
    moved = after[:, :6] - before[:, :6]
    assert moved[0, 0] > 2 * reach.INCREMENT
    assert moved[1, 2] < -2 * reach.INCREMENT
    assert np.abs(np.delete(moved[0], 0)).max() < 0.01
    assert np.abs(np.delete(moved[1], 2)).max() < 0.01
    assert np.array_equal(rewards, -infos["distance"])
    assert np.allclose(rewards, [-reach.distance(row[6:]) for row in after], atol=1e-6)


def test_reach_episodes_end_by_their_length() -> None:
    environment = gymnasium.make_vec(
        "simx/Reach-v0", COUNT, processes=0, autoreset_mode="SameStep", max_episode_steps=3
    )
    environment.reset(seed=3)
    actions = np.ones((COUNT, 6), np.float32)
    for _ in range(2):
        *_, truncated, infos = environment.step(actions)
        assert not truncated.any()
        assert "final_obs" not in infos
    observations, rewards, _, truncated, infos = environment.step(actions)
    assert truncated.all()
    assert np.allclose([reach.distance(row[6:]) for row in infos["final_obs"]], -rewards, atol=1e-6)
    assert np.allclose(observations[:, :6], reach.START, atol=1e-6)
    environment.close()


def total(environment: Any, policy: Any, seed: int = 1) -> tuple[float, int, bool]:
    """The return of an episode, its number of steps, and whether it ended before its time."""
    observation, _ = environment.reset(seed=seed)
    collected, steps, is_over = 0.0, 0, False
    while not is_over:
        observation, reward, terminated, truncated, _ = environment.step(policy(observation))
        collected, steps, is_over = collected + float(reward), steps + 1, terminated or truncated
    environment.close()
    return collected, steps, terminated


def test_cart_pole_stays_up_with_a_controller_and_falls_without() -> None:
    gains = np.array([-0.1, -0.25, -3.0, -0.6])  # state feedback: the force follows the lean of the pole

    def balance(observation: np.ndarray) -> np.ndarray:
        return np.array([-(gains @ observation)], np.float32)

    assert total(gymnasium.make("simx/CartPole-v0"), balance) == (500.0, 500, False)
    collected, steps, fell = total(gymnasium.make("simx/CartPole-v0"), lambda _: np.ones(1, np.float32))
    assert fell
    assert collected == steps < 100


def test_line_follower_drives_on_along_the_line_by_its_outer_sensors() -> None:
    def steer(brightness: np.ndarray) -> np.ndarray:
        left, _, right = brightness
        turn = 0.6 * np.sign(right - left) if abs(right - left) > 0.2 else 0.0  # towards the dark side
        return np.array([0.5 - turn, 0.5 + turn], np.float32)

    way, steps, left_it = total(gymnasium.make("simx/LineFollower-v0"), steer)
    assert (steps, left_it) == (400, False)
    assert way > 1.2
    _, _, left_it = total(gymnasium.make("simx/LineFollower-v0"), lambda _: np.array([0.5, 0.4], np.float32))
    assert left_it


def test_line_follower_progress_is_the_way_along_the_line() -> None:
    points = [
        (
            line_follower.MIDDLE[0] + line_follower.radius(bearing) * np.cos(bearing),
            line_follower.MIDDLE[1] + line_follower.radius(bearing) * np.sin(bearing),
        )
        for bearing in np.linspace(0.0, 2 * np.pi, 2001)
    ]
    way = sum(line_follower.progress(*pair) for pair in pairwise(points))
    length = sum(float(np.hypot(*np.subtract(a, b))) for a, b in pairwise(points))
    assert abs(way - length) < 1e-3
    assert max(map(line_follower.offset, points)) < 1e-9


def test_pick_place_a_plan_of_waypoints_puts_the_cube_on_its_mark() -> None:
    environment = gymnasium.make("simx/PickPlace-v0")
    observation, _ = environment.reset(seed=2)
    target, cube, mark = (observation[part : part + 3].astype(float) for part in (0, 3, 6))
    above, low = np.array([0.0, 0.0, 0.12]), np.array([0.0, 0.0, 0.03])
    opened, closed = 1.0, -1.0
    plan = [  # where to, gripper, steps there
        (cube + above, opened, 4),
        (cube, opened, 4),
        (cube, closed, 27),
        (cube + above, closed, 1),
        (mark + above, closed, 4),
        (mark + low, closed, 4),
        (mark + low, opened, 7),
        (mark + above, opened, 10),
    ]
    is_done, info = False, {}
    for goal, gripper, rest in plan:
        while rest and not is_done:
            change = np.clip((goal - target) / 0.02, -1, 1)
            rest -= not change.any()
            target = target + 0.02 * change
            action = np.append(change, gripper).astype(np.float32)
            _, reward, is_done, _, info = environment.step(action)
    assert is_done
    assert info["is_success"]
    assert float(reward) > 9.0
    environment.close()
