"""DDPG learns simx/Reach-v0 on many simulations: ``python examples/reach/train.py``. Needs the extra ``learning``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from curve import Episodes, draw
from stable_baselines3 import DDPG
from stable_baselines3.common.noise import NormalActionNoise, VectorizedActionNoise
from stable_baselines3.common.vec_env import VecMonitor

from simx_client.gym.stable_baselines3 import VecAdapter

PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "reach_reward.png"


def evaluate(model: DDPG, vector: VecMonitor, seed: int, rounds: int = 3) -> float:
    """Return the median distance in metres between ball and goal at the end of episodes without noise."""
    vector.seed(seed)
    observations, ends = vector.reset(), []
    while len(ends) < rounds * vector.num_envs:
        observations, _, done, infos = vector.step(model.predict(observations, deterministic=True)[0])
        ends += [info["distance"] for info, is_over in zip(infos, done, strict=True) if is_over]
    return float(np.median(ends))


def train(count: int, steps: int, seed: int, picture: Path, **options: Any) -> tuple[float, float]:
    """Learn with several simulations; return the median distance in metres before and after."""
    torch.set_num_threads(1)  # the networks are small, and the processor has physics to do too
    vector = VecMonitor(
        VecAdapter(gymnasium.make_vec("simx/Reach-v0", count, autoreset_mode="SameStep", **options))
    )
    model = DDPG(
        "MlpPolicy",
        vector,
        learning_rate=lambda left: 1e-3 * left,  # early results are rough; late results stay
        buffer_size=200_000,
        learning_starts=min(2_000, steps // 4),
        gamma=0.95,
        train_freq=(1, "step"),
        gradient_steps=4,
        action_noise=VectorizedActionNoise(NormalActionNoise(np.zeros(6), np.full(6, 0.1)), count),
        policy_kwargs={"net_arch": [128, 128]},
        seed=seed,
        device="cpu",
    )
    episodes, before = Episodes(), evaluate(model, vector, seed + 1)
    model.learn(steps, callback=episodes, log_interval=None)
    after = evaluate(model, vector, seed + 1)
    vector.close()
    draw(
        picture,
        episodes.steps,
        episodes.returns,
        f"DDPG, reach task, {count} simulations: return of an episode",
    )
    return before, after


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="DDPG learns to bring the hand camera over the ball.")
    parser.add_argument("--count", type=int, default=8, metavar="N", help="simulations (8)")
    parser.add_argument(
        "--steps", type=int, default=48_000, help="steps, of all simulations together (48000)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of balls, networks and noise (1)")
    parser.add_argument("--picture", type=Path, default=PICTURE, help="file for the reward curve")
    before, after = train(**vars(parser.parse_args()))
    print(
        f"distance to the goal at the end of an episode: {before * 1e3:.0f} mm before, {after * 1e3:.0f} mm after"
    )
