"""Vector environments for Stable-Baselines3, which has its own interface for them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

_MODULE = "stable_baselines3.common.vec_env"
try:
    # By name: type checkers then need no Stable-Baselines3, which brings PyTorch.
    VecEnv: Any = import_module(_MODULE).VecEnv
except ModuleNotFoundError as missing:
    from simx_client.protocol.cli.installing import extra_line

    raise ModuleNotFoundError(
        f"{__name__} needs {missing.name}; install with: {extra_line('learning')}", name=missing.name
    ) from None


class VecAdapter(VecEnv):  # pyright: ignore[reportUntypedBaseClass]
    """A Gymnasium vector environment as Stable-Baselines3 takes it.

    vector = gymnasium.make_vec("simx/Reach-v0", 8, autoreset_mode="SameStep")
    model = DDPG("MlpPolicy", VecAdapter(vector))
    """

    def __init__(self, environment: Any) -> None:
        """Adapt an environment; closing this closes it.

        Args:
            environment: a ``gymnasium.vector.VectorEnv``.

        Raises:
            ValueError: it does not start the next episode within the step that ends one.
        """
        if environment.metadata.get("autoreset_mode") is not AutoresetMode.SAME_STEP:
            raise ValueError(
                "Stable-Baselines3 needs an environment with autoreset_mode=AutoresetMode.SAME_STEP; "
                f"this one has {environment.metadata.get('autoreset_mode')}"
            )
        self.environment = environment
        self.render_mode = environment.render_mode
        self._actions: Any = None
        super().__init__(  # pyright: ignore[reportUnknownMemberType]
            environment.num_envs, environment.single_observation_space, environment.single_action_space
        )

    def reset(self) -> Any:
        """Start an episode in all simulations, with the seeds of ``seed``."""
        seeds = None if all(seed is None for seed in self._seeds) else list(self._seeds)
        self._reset_seeds()
        return self.environment.reset(seed=seeds)[0]

    def step_async(self, actions: NDArray[Any]) -> None:
        """Store the actions."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Make the step."""
        observations, rewards, terminated, truncated, told = self.environment.step(self._actions)
        done = terminated | truncated
        infos: list[dict[str, Any]] = [_of(told, place) for place in range(self.num_envs)]
        for place in np.flatnonzero(done).tolist():
            infos[place] = _of(told.get("final_info", {}), place)
            infos[place]["terminal_observation"] = told["final_obs"][place]
            infos[place]["TimeLimit.truncated"] = bool(truncated[place] and not terminated[place])
        return observations, rewards.astype(np.float32), done, infos

    def close(self) -> None:
        """Close the environment."""
        self.environment.close()

    def get_images(self) -> list[Any]:
        """Return an image of each simulation."""
        return list(self.environment.render() or [None] * self.num_envs)

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the environment for each simulation."""
        return [getattr(self.environment, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Raise NotImplementedError: all simulations belong to one object."""
        raise NotImplementedError(f"{attr_name} cannot be set: all simulations belong to one environment")

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **more: Any) -> list[Any]:
        """Raise NotImplementedError: all simulations belong to one object."""
        raise NotImplementedError(
            f"{method_name} cannot be called: all simulations belong to one environment"
        )

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        """Return False for each simulation."""
        return [False] * len(list(self._get_indices(indices)))


def _of(told: dict[str, Any], place: int) -> dict[str, Any]:
    """Return the information of one simulation: Gymnasium has arrays, and for each a mask of its simulations."""
    return {
        name: values[place]
        for name, values in told.items()
        if not isinstance(values, dict) and f"_{name}" in told and told[f"_{name}"][place]
    }
