"""`SimxVectorEnv`: many simulations of a task, in processes, in this process and in servers."""

from __future__ import annotations

import os
import signal
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from processes import server
from world_processes import NotingSubprocess

from simx_client.client.worlds import worker
from simx_client.errors import CallsFailed, SimxError
from simx_client.gym import SimxVectorEnv, load_task

pytestmark = [pytest.mark.slow, pytest.mark.gl]

COUNT = 3
CART_POLE = load_task("cart_pole")


def vector(count: int = COUNT, **options: Any) -> SimxVectorEnv:
    chosen: dict[str, Any] = {"processes": 0} | options
    return SimxVectorEnv(CART_POLE, count, **chosen)


def pushes(count: int, steps: int) -> np.ndarray:
    return np.random.default_rng(4).uniform(-1, 1, (steps, count, 1)).astype(np.float32)


def trajectory(environment: SimxVectorEnv, steps: int = 15) -> np.ndarray:
    rows = [environment.reset(seed=3)[0]]
    rows += [environment.step(actions)[0] for actions in pushes(environment.num_envs, steps)]
    environment.close()
    return np.array(rows)


def test_results_do_not_depend_on_where_the_simulations_run() -> None:
    here, in_processes = trajectory(vector()), trajectory(vector(processes=2))
    assert here.shape == (16, COUNT, 4)
    assert np.array_equal(here, in_processes)
    assert np.array_equal(here, trajectory(vector(processes=None)))
    with server("cart_pole") as one, server("cart_pole") as two:
        addresses = [f"127.0.0.1:{each.port}" for each in (one, two)]
        remote = trajectory(SimxVectorEnv(CART_POLE, 2, addresses=addresses), 0)
    assert np.array_equal(remote[0], here[0, :2])


def test_each_simulation_makes_the_episodes_of_a_lone_environment() -> None:
    together = trajectory(vector())
    for place in range(COUNT):
        alone = gymnasium.make("simx/CartPole-v0")
        rows = [alone.reset(seed=3 + place)[0]]
        rows += [alone.step(actions[place])[0] for actions in pushes(COUNT, 15)]
        alone.close()
        assert np.array_equal(rows, together[:, place])


def test_make_vec_uses_this_vectorisation_with_the_registered_length() -> None:
    environment = gymnasium.make_vec("simx/CartPole-v0", 2, processes=0, max_episode_steps=2)
    assert isinstance(environment, SimxVectorEnv)
    assert environment.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    environment.reset(seed=1)
    none = np.zeros((2, 1), np.float32)
    assert not environment.step(none)[3].any()
    assert environment.step(none)[3].all()
    environment.close()


def fall(environment: SimxVectorEnv) -> tuple[Any, ...]:
    """Push the first cart only, until its pole has fallen; the last step."""
    actions = np.zeros((environment.num_envs, 1), np.float32)
    actions[0] = 1.0
    for _ in range(100):
        found = environment.step(actions)
        if found[2].any():
            assert found[2].tolist() == [True, False, False]
            return found
    raise AssertionError("the pole has not fallen")


def test_next_step_autoreset_starts_one_simulation_with_the_step_after_its_end() -> None:
    environment = vector()
    environment.reset(seed=1)
    last = fall(environment)
    assert abs(last[0][0, 2]) > 0.2
    observations, rewards, terminated, truncated, _ = environment.step(np.zeros((COUNT, 1), np.float32))
    assert abs(observations[0, 2]) <= 0.05
    assert observations[0, 1] == observations[0, 3] == 0.0
    assert rewards.tolist() == [0.0, 1.0, 1.0]
    assert not terminated.any()
    assert not truncated.any()
    environment.close()


def test_same_step_autoreset_returns_the_last_observation_as_information() -> None:
    environment = vector(autoreset_mode="SameStep")
    environment.reset(seed=1)
    observations, _, _, _, infos = fall(environment)
    assert abs(observations[0, 2]) <= 0.05
    assert infos["_final_obs"].tolist() == [True, False, False]
    assert abs(infos["final_obs"][0][2]) > 0.2
    environment.close()


def test_without_autoreset_a_mask_resets_the_episodes_that_are_over() -> None:
    environment = vector(autoreset_mode=AutoresetMode.DISABLED)
    environment.reset(seed=1)
    last = fall(environment)
    none = np.zeros((COUNT, 1), np.float32)
    with pytest.raises(ValueError, match=r"simulations \[0\] are over"):
        environment.step(none)
    observations, _ = environment.reset(options={"reset_mask": last[2]})
    assert abs(observations[0, 2]) <= 0.05
    assert np.array_equal(observations[1:], last[0][1:])
    environment.step(none)
    environment.close()


def test_a_lost_process_is_reported_and_reset_starts_all_again(monkeypatch: pytest.MonkeyPatch) -> None:
    processes = NotingSubprocess()
    monkeypatch.setattr(worker, "subprocess", processes)
    environment = vector(processes=2)
    expected, _ = environment.reset(seed=3)
    os.kill(processes.started[0].pid, signal.SIGKILL)
    none = np.zeros((COUNT, 1), np.float32)
    with pytest.raises(CallsFailed, match="ended by SIGKILL"):
        environment.step(none)
    again, _ = environment.reset(seed=3)
    assert np.array_equal(again, expected)
    environment.step(none)
    environment.close()
    assert len(processes.started) == 4
    assert processes.have_ended()


def test_render_returns_an_image_of_each_simulation() -> None:
    environment = vector(2, render_mode="rgb_array")
    environment.reset(seed=1)
    images = environment.render()
    assert images is not None
    assert [image.shape for image in images] == [(96, 128, 3)] * 2
    assert not np.array_equal(images[0], images[1])
    environment.close()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"addresses": ["127.0.0.1:1"], "processes": None}, "num_envs=3 needs as many addresses, not 1"),
        ({"max_episode_steps": 0}, "max_episode_steps must be at least 1, not 0"),
        ({"autoreset_mode": "sometimes"}, "sometimes"),
        ({"render_mode": "human"}, "render_mode must be 'rgb_array' or None, not 'human'"),
        ({"addresses": ["127.0.0.1:1"] * 3, "speed": 2}, "has its own settings; leave out speed"),
    ],
)
def test_options_that_cannot_be_used_say_what_is_valid(options: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        vector(**options)


def test_a_seed_of_numpy_is_a_seed() -> None:
    environment = vector()
    expected, _ = environment.reset(seed=3)
    assert np.array_equal(environment.reset(seed=np.int64(3))[0], expected)
    environment.close()


def test_wrong_seeds_masks_and_actions_are_refused() -> None:
    environment = vector()
    with pytest.raises(ValueError, match="3 simulations need as many seeds, not 2"):
        environment.reset(seed=[1, 2])
    with pytest.raises(ValueError, match="reset_mask must be 3 bools"):
        environment.reset(options={"reset_mask": [1, 0, 0]})
    with pytest.raises(ValueError, match="the only option is reset_mask; got speed"):
        environment.reset(options={"speed": 1})
    environment.reset(seed=1)
    with pytest.raises(ValueError, match="3 simulations need as many actions, not 2"):
        environment.step(np.zeros((2, 1), np.float32))
    environment.close()
    with pytest.raises(SimxError, match="this environment was closed"):
        environment.reset()
