"""Learn simx/CartPole-v0 on a Ray cluster: ``python examples/ray/train.py``. Needs the extras ``gym`` and ``ray``.

Each actor has a simulation in its process. Ray places the actors on the hosts of the cluster, restarts those whose
host is lost, and repeats what they were doing. An episode depends on weights and seed only, so the result does not
depend on the number of actors, or on those that were lost.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

Weights = np.ndarray
Play = Callable[[Sequence[tuple[Weights, int]]], Iterable[float]]
POPULATION, ELITE = 16, 4
FEATURES = 4


class Player:
    """A simulation, and a policy that is linear in what it observes."""

    def __init__(self, steps: int) -> None:
        import gymnasium

        self.environment = gymnasium.make("simx_client.gym:simx/CartPole-v0", max_episode_steps=steps)

    def play(self, weights: Weights, seed: int) -> float:
        """Return the return of an episode."""
        observation, _ = self.environment.reset(seed=seed)
        total, is_over = 0.0, False
        while not is_over:
            action = np.tanh([weights @ observation]).astype(np.float32)
            observation, reward, terminated, truncated, _ = self.environment.step(action)
            total, is_over = total + float(reward), terminated or truncated
        return total


def learn(play: Play, generations: int, seed: int) -> Iterator[tuple[Weights, float]]:
    """Yield mean weights and mean return of each generation: the cross-entropy method."""
    random = np.random.default_rng(seed)
    mean, spread = np.zeros(FEATURES), np.full(FEATURES, 2.0)
    for number in range(generations):
        population = mean + spread * random.normal(size=(POPULATION, FEATURES))
        returns = np.array(list(play([(weights, seed + number) for weights in population])))
        elite = population[np.argsort(-returns, kind="stable")[:ELITE]]
        mean, spread = elite.mean(axis=0), elite.std(axis=0) + 0.1
        yield mean, float(returns.mean())


def on_cluster(ray: Any, players: int, steps: int) -> Play:
    """Return a function that plays episodes on actors of a Ray cluster, in the order of the arguments."""
    actor = ray.remote(Player).options(max_restarts=-1, max_task_retries=-1, scheduling_strategy="SPREAD")
    pool = ray.util.ActorPool([actor.remote(steps) for _ in range(players)])
    return lambda tasks: pool.map(lambda player, task: player.play.remote(*task), tasks)


def main() -> None:
    parser = argparse.ArgumentParser(description="Learn to balance a pole on the hosts of a Ray cluster.")
    parser.add_argument(
        "--ray", default="auto", metavar="ADDRESS", help="HOST:PORT of the cluster's head (auto)"
    )
    parser.add_argument(
        "--players", type=int, default=4, metavar="N", help="actors with a simulation each (4)"
    )
    parser.add_argument("--generations", type=int, default=10, metavar="N", help="generations (10)")
    parser.add_argument("--steps", type=int, default=500, metavar="N", help="steps of an episode (500)")
    chosen = parser.parse_args()
    import ray
    import ray.util

    ray.init(address=chosen.ray, log_to_driver=False)
    for _, mean in learn(on_cluster(ray, chosen.players, chosen.steps), chosen.generations, seed=1):
        print(f"return of a generation: {mean:.0f}", flush=True)


if __name__ == "__main__":
    main()
