"""Register the environments with Gymnasium, and make them from the name of their task."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from simx_client.connection.timeouts import DEFAULT_TIMEOUT

from .env import SimxEnv
from .tasks import TASKS, load_task
from .vector import SimxVectorEnv


class RegisteredEnv(SimxEnv):
    """The environment of ``gymnasium.make``."""

    def __init__(self, task: str, **options: Any) -> None:
        """Make the environment of a task.

        Args:
            task: name of a module of ``simx_client.gym.tasks``.
            options: those of `SimxEnv.of`.
        """
        address, render_mode = options.pop("address", None), options.pop("render_mode", None)
        self._open(load_task(task), address, render_mode, options.pop("timeout", DEFAULT_TIMEOUT), options)


class RegisteredVectorEnv(SimxVectorEnv):
    """The environment of ``gymnasium.make_vec``."""

    def __init__(self, task: str, num_envs: int = 1, **options: Any) -> None:
        """Make the environment of a task.

        Args:
            task: name of a module of ``simx_client.gym.tasks``.
            num_envs: number of simulations.
            options: those of `SimxVectorEnv`.
        """
        super().__init__(load_task(task), num_envs, **options)


def register(gymnasium: ModuleType) -> None:
    """Register all tasks, unless they are registered."""
    for name, (environment, steps) in TASKS.items():
        if environment not in gymnasium.registry:
            gymnasium.register(
                environment,
                entry_point=f"{__name__}:RegisteredEnv",
                vector_entry_point=f"{__name__}:RegisteredVectorEnv",
                max_episode_steps=steps,
                kwargs={"task": name},
            )
