"""DDPG learns the tutorial's reach task: ``python examples/reach/train.py``. Needs the extra ``learning``.

The algorithm is Stable-Baselines3's; this file chooses its parameters, and draws how the reward grew.
"""

from __future__ import annotations

import argparse
import logging
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from curve import draw

from simx_client.client import Worlds

try:
    import torch
    from adapter import Adapter
    from environment import EPISODE, ReachEnv, distance
    from stable_baselines3 import DDPG
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.noise import NormalActionNoise, VectorizedActionNoise
    from stable_baselines3.common.vec_env import VecMonitor
except ModuleNotFoundError as missing:
    from simx_client.protocol.cli.installing import extra_line

    sys.exit(f"the package {missing.name} is not installed, which learning needs: {extra_line('learning')}")

logger = logging.getLogger("reach")

SCENE = "ur5_rg2_kinect"
PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "reach_reward.png"
PROGRESS_EVERY_S = 10.0


class Episodes(BaseCallback):
    """Collects the return of every episode, and says now and then how it goes."""

    def __init__(self) -> None:
        super().__init__()
        self.steps: list[int] = []
        self.returns: list[float] = []
        self._began = self._said = time.monotonic()

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if episode := info.get("episode"):
                self.steps.append(self.num_timesteps)
                self.returns.append(float(episode["r"]))
        if self.returns and time.monotonic() - self._said >= PROGRESS_EVERY_S:
            self._said = time.monotonic()
            logger.info(
                "%d steps, %.0f a second, return of the last episodes %.1f",
                self.num_timesteps,
                self.num_timesteps / (self._said - self._began),
                np.mean(self.returns[-20:]),
            )
        return True


def learner(environment: VecMonitor, seed: int, *, warm_up: int = 2_000) -> DDPG:
    """DDPG with small networks: there are nine numbers to look at, and the processor has physics to do too.

    Args:
        warm_up: steps of random actions before learning begins.
    """
    torch.set_num_threads(1)
    noise = NormalActionNoise(np.zeros(6), np.full(6, 0.1))
    return DDPG(
        "MlpPolicy",
        environment,
        learning_rate=lambda left: 1e-3 * left,  # what is learned early is rough, what is learned late stays
        buffer_size=200_000,
        learning_starts=warm_up,
        batch_size=256,
        gamma=0.95,
        train_freq=(1, "step"),
        gradient_steps=4,
        action_noise=VectorizedActionNoise(noise, environment.num_envs),
        policy_kwargs={"net_arch": [128, 128]},
        seed=seed,
        device="cpu",
    )


def evaluate(model: DDPG, environment: ReachEnv, seed: int) -> np.ndarray:
    """Metres between ball and goal at the end of an episode without noise, for each simulation."""
    observations, _ = environment.reset(seed=seed)
    for _ in range(EPISODE):
        actions, _ = model.predict(observations, deterministic=True)
        observations, _, _, _, infos = environment.step(actions)
    return distance(infos["final_obs"])


def train(count: int, steps: int, seed: int, picture: Path | None) -> tuple[float, float]:
    """Learn with so many simulations; returns the median distance at an episode's end before and after, metres."""
    environment = ReachEnv(Worlds(SCENE, count))
    wrapped = VecMonitor(Adapter(environment))
    try:
        model, episodes = learner(wrapped, seed, warm_up=min(2_000, steps // 4)), Episodes()
        before = float(np.median(evaluate(model, environment, seed + 1)))
        began = time.monotonic()
        model.learn(steps, callback=episodes)
        rate = steps / (time.monotonic() - began)
        after = float(np.median([evaluate(model, environment, seed + 1 + turn) for turn in range(3)]))
    finally:
        wrapped.close()
    logger.info(
        "%d steps of %d simulations, %.0f a second with learning; an episode ended %.0f mm from the goal before, "
        "%.0f mm after",
        steps,
        count,
        rate,
        before * 1e3,
        after * 1e3,
    )
    if picture is not None and episodes.returns:
        draw(
            picture,
            episodes.steps,
            episodes.returns,
            f"DDPG, reach task, {count} simulations: return of an episode",
        )
        logger.info("the curve is in %s", picture)
    return before, after


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="DDPG learns to bring the hand camera over the ball.")
    parser.add_argument("--count", type=int, default=8, metavar="N", help="simulations (8)")
    parser.add_argument(
        "--steps", type=int, default=48_000, help="environment steps, of all together (48000)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of balls, networks and noise (1)")
    parser.add_argument("--picture", type=Path, default=PICTURE, help="where the reward curve goes")
    chosen = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    logging.getLogger("simx_client").setLevel(logging.WARNING)
    # As an exception, so that the simulations end with it.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    train(chosen.count, chosen.steps, chosen.seed, chosen.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
