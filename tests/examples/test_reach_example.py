"""The reach example: its environment keeps Gymnasium's rules, and the learning runs where its library is there."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from example_modules import import_from
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import simx_client as v
from simx_client.client import Worlds

FOLDER = Path(__file__).parents[2] / "examples" / "reach"
SCENE, COUNT = "ur5_rg2_kinect", 2
example = partial(import_from, FOLDER)


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> Any:
    return example("environment", monkeypatch)


@pytest.fixture
def environment(module: Any) -> Iterator[Any]:
    environment = module.ReachEnv(Worlds(SCENE, COUNT, processes=0))
    yield environment
    environment.close()
    assert v.simxGetConnectionId(0) == -1


class Alone(gymnasium.Env[Any, Any]):
    """One environment of the vector, as Gymnasium's checker wants it."""

    metadata = {"render_modes": []}  # noqa: RUF012 - Gymnasium's form

    def __init__(self, vector: Any) -> None:
        self._vector = vector
        self.observation_space, self.action_space = (
            vector.single_observation_space,
            vector.single_action_space,
        )

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        super().reset(seed=seed)
        observations, infos = self._vector.reset(seed=seed, options=options)
        return observations[0], infos

    def step(self, action: Any) -> Any:
        observations, rewards, terminated, truncated, infos = self._vector.step(action[np.newaxis])
        told = {"distance": float(infos["distance"][0])}
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), told

    def close(self) -> None:
        self._vector.close()


@pytest.mark.filterwarnings("ignore:.*Box observation space (minimum|maximum) value is:UserWarning")
@pytest.mark.filterwarnings("ignore:.*environment is not registered:UserWarning")
@pytest.mark.filterwarnings("ignore:.*not use a reset with seed:UserWarning")
def test_one_environment_passes_gymnasiums_checker(module: Any) -> None:
    """Equal seeds and actions give equal observations, among other things."""
    alone = Alone(module.ReachEnv(Worlds(SCENE, 1)))
    try:
        check_env(alone, skip_render_check=True, skip_close_check=True)
    finally:
        alone.close()


def test_the_vector_has_the_shapes_it_promises(environment: Any) -> None:
    observations, infos = environment.reset(seed=3)
    assert environment.observation_space.contains(observations)
    assert infos == {}
    environment.action_space.seed(3)
    observations, rewards, terminated, truncated, infos = environment.step(environment.action_space.sample())
    assert environment.observation_space.contains(observations)
    assert rewards.shape == terminated.shape == truncated.shape == (COUNT,)
    assert np.array_equal(rewards, -infos["distance"])
    assert np.all(rewards < 0)
    assert environment.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP


def test_balls_lie_elsewhere_in_every_environment_and_episode(environment: Any, module: Any) -> None:
    first, _ = environment.reset(seed=3)
    second, _ = environment.reset()
    again, _ = environment.reset(seed=3)
    assert np.array_equal(first, again)
    assert np.allclose(first[:, :6], module.START, atol=1e-6)
    balls = np.vstack([first, second])[:, 6:]
    assert len({tuple(ball) for ball in balls}) == 4


def test_an_action_turns_the_joint_it_says_that_way(environment: Any, module: Any) -> None:
    before, _ = environment.reset(seed=3)
    actions = np.zeros((COUNT, 6), dtype=np.float32)
    actions[0, 0], actions[1, 2] = 1.0, -1.0
    for _ in range(4):
        after, *_ = environment.step(actions)
    moved = after[:, :6] - before[:, :6]
    assert moved[0, 0] > 2 * module.INCREMENT
    assert moved[1, 2] < -2 * module.INCREMENT
    assert np.abs(np.delete(moved[0], 0)).max() < 0.01
    assert np.abs(np.delete(moved[1], 2)).max() < 0.01


def test_an_episode_ends_by_its_length_and_the_next_begins_in_the_same_step(
    environment: Any, module: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "EPISODE", 3)
    environment.reset(seed=3)
    actions = np.ones((COUNT, 6), dtype=np.float32)
    for _ in range(2):
        _, _, _, truncated, infos = environment.step(actions)
        assert not truncated.any()
        assert "final_obs" not in infos
    observations, rewards, terminated, truncated, infos = environment.step(actions)
    assert truncated.all()
    assert not terminated.any()
    assert infos["_final_obs"].all()
    assert np.allclose(module.distance(infos["final_obs"]), -rewards, atol=1e-6)
    assert np.allclose(observations[:, :6], module.START, atol=1e-6)
    assert not environment.step(actions)[3].any()


def test_the_curve_is_a_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    curve = example("curve", monkeypatch)
    target = tmp_path / "new folder" / "curve.png"
    curve.draw(target, [100, 200, 300], [-50.0, -20.0, -10.0], "three episodes")
    picture = curve.cv2.imread(str(target))
    assert picture.shape == (curve.HEIGHT, curve.WIDTH, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 3


@pytest.mark.skipif(
    importlib.util.find_spec("stable_baselines3") is None,
    reason="needs the extra learning: Stable-Baselines3 is not installed",
)
def test_a_few_hundred_steps_of_training_run_and_are_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    train = example("train", monkeypatch)
    monkeypatch.setattr(sys.modules["environment"], "EPISODE", 20)
    monkeypatch.setattr(train, "EPISODE", 20)
    before, after = train.train(COUNT, 400, 1, tmp_path / "curve.png")
    assert 0 < before < 2
    assert 0 < after < 2
    assert (tmp_path / "curve.png").is_file()
