"""A Gymnasium vector environment as Stable-Baselines3 wants one, which has an interface of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv


class Adapter(VecEnv):
    """Any vector environment that begins anew within the step that ends an episode."""

    def __init__(self, environment: VectorEnv[Any, Any, Any]) -> None:
        """Wrap; closing this closes the environment.

        Raises:
            ValueError: it begins anew in another way.
        """
        if environment.metadata.get("autoreset_mode") is not AutoresetMode.SAME_STEP:
            raise ValueError("the environment must begin anew within the same step (AutoresetMode.SAME_STEP)")
        self.environment = environment
        self.render_mode = None
        self._actions: NDArray[Any] = np.zeros(0)
        super().__init__(
            environment.num_envs, environment.single_observation_space, environment.single_action_space
        )

    def reset(self) -> NDArray[Any]:
        seed, self._seeds = self._seeds[0], [None] * self.num_envs
        return self.environment.reset(seed=seed)[0]

    def step_async(self, actions: NDArray[Any]) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], list[dict[str, Any]]]:
        observations, rewards, terminated, truncated, told = self.environment.step(self._actions)
        done = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for place in np.flatnonzero(done):
            infos[place] = {
                "terminal_observation": told["final_obs"][place],
                "TimeLimit.truncated": bool(truncated[place] and not terminated[place]),
            }
        return observations, rewards.astype(np.float32), done, infos

    def close(self) -> None:
        self.environment.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self.environment, attr_name)] * len(self._places(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError(f"{attr_name} cannot be set: all environments are one object")

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **more: Any) -> list[Any]:
        raise NotImplementedError(f"{method_name} cannot be called: all environments are one object")

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        return [False] * len(self._places(indices))

    def _places(self, indices: Any) -> Sequence[int]:
        return list(self._get_indices(indices))
