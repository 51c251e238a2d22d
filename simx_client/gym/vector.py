"""`SimxVectorEnv`: many simulations of one task as a Gymnasium vector environment."""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, iterate
from numpy.typing import NDArray

from simx_client.connection.timeouts import DEFAULT_TIMEOUT
from simx_client.errors import SimxError

from .rendering import Film, check_mode
from .running import placing
from .running.episodes import Episodes
from .running.opening import check_place, open_addresses
from .running.together import Running, Together
from .task import Task

_MODES = ("rgb_array",)


class SimxVectorEnv(VectorEnv[Any, Any, NDArray[Any]]):
    """Simulations that step together, in worker processes, in this process, or in servers.

    Simulation *i* of seed *n* makes the same episodes as one environment of seed *n + i*, bit for bit,
    wherever it runs.
    """

    metadata: dict[str, Any] = {"render_modes": list(_MODES)}  # noqa: RUF012 - Gymnasium's form
    single_observation_space: Space[Any]
    single_action_space: Space[Any]
    observation_space: Space[Any]
    action_space: Space[Any]
    backend: str
    """Where the simulations run, and why."""

    def __init__(
        self,
        task: Task,
        num_envs: int = 1,
        *,
        processes: int | None = None,
        threads: int | None = None,
        addresses: Sequence[str] | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        timeout: float = DEFAULT_TIMEOUT,
        **settings: object,
    ) -> None:
        """Start the simulations, or connect to servers.

        Args:
            task: see `SimxEnv` for its fields.
            num_envs: number of simulations.
            processes: number of worker processes; 0: all in this process; default: the scene and a measurement at the
                start decide.
            threads: number of threads of this process that step the simulations together, 0 for none; default: one per
                processor core, if the scene and the task allow it.
            addresses: servers to use instead, one per simulation.
            max_episode_steps: number of steps after which an episode is truncated.
            autoreset_mode: when a simulation starts its next episode: with the next step (Gymnasium's default), within
                the step that ends the episode (for Stable-Baselines3), or with ``reset(options={"reset_mask": …})``.
            render_mode: "rgb_array" for images of all simulations.
            timeout: time-out in seconds for the answers of all simulations together.
            settings: flags of ``simx-server``, with underscores, for simulations that start here.

        Raises:
            ConnectionFailed: the scene or a setting cannot be used, or a server cannot be reached.
            CallsFailed: an object does not exist.
            ValueError: a name, range or number cannot be used; the text says what is valid.
        """
        check_mode(render_mode, _MODES)
        check_place(addresses, settings)
        if addresses is not None and (
            len(addresses) != num_envs or processes is not None or threads is not None
        ):
            raise ValueError(
                f"num_envs={num_envs} needs as many addresses, not {len(addresses)}, and no number of processes or "
                "threads"
            )
        if max_episode_steps is not None and max_episode_steps < 1:
            raise ValueError(f"max_episode_steps must be at least 1, not {max_episode_steps}")
        self.task, self.num_envs, self.render_mode = task, num_envs, render_mode
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self._place = (placing.Wanted(processes, threads), addresses, timeout, settings)
        self._limit = max_episode_steps
        self._end: weakref.finalize[..., Any] | None = None
        self._connect()
        self.single_observation_space = self._episodes.observations.space
        self.single_action_space = self._episodes.actions.space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.metadata = {**type(self).metadata, "autoreset_mode": self.autoreset_mode}
        self._random = [np.random.default_rng() for _ in range(num_envs)]
        self._steps = np.zeros(num_envs, int)
        self._is_over = np.zeros(num_envs, bool)

    def _connect(self) -> None:
        if self._end is not None:
            self._end()
        wanted, addresses, timeout, settings = self._place
        with ExitStack() as stack:
            if addresses is None:
                servers, self.backend, self._threads = placing.start(
                    self.task, self.num_envs, wanted, timeout, settings, stack
                )
            else:
                servers, self.backend = open_addresses(addresses, timeout, stack), "servers at `addresses`"
                self._threads = 0
            self._running = Running(Episodes(self.task, servers))
            self._film = Film(servers, self.task.camera) if self.render_mode == "rgb_array" else None
            stack.callback(self._running.end)
            self._end = weakref.finalize(self, stack.pop_all().close)

    def reset(
        self,
        *,
        seed: int | np.integer[Any] | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode in all simulations. Starts them again if one was lost.

        Args:
            seed: *n*: simulation *i* gets *n + i*; or a seed per simulation. None continues with the random numbers.
            options: ``{"reset_mask": array}`` restarts only the simulations where the array is True.

        Raises:
            CallsFailed: a simulation is gone, or refused a value of the start.
            ValueError: the seeds or options cannot be used.
        """
        places = self._masked(dict(options or {}))
        if isinstance(seed, (int, np.integer)):
            seeds: Sequence[int | None] | None = [int(seed) + place for place in range(self.num_envs)]
        else:
            seeds = seed
        if seeds is not None and len(seeds) != self.num_envs:
            raise ValueError(f"{self.num_envs} simulations need as many seeds, not {len(seeds)}")
        if self.closed:
            raise SimxError("this environment was closed; make another one")
        if self._episodes.servers.lost:
            if len(places) < self.num_envs:
                raise ValueError("a simulation was lost; reset all of them, without a mask")
            self._connect()
        for place in places:
            if seeds is not None and seeds[place] is not None:
                # Gymnasium's own way from a seed to a generator, so that a lone environment has the same numbers.
                self._random[place] = np.random.Generator(
                    np.random.PCG64(np.random.SeedSequence(seeds[place]))
                )
        self._start(places)
        if self._threads:
            self._running.join(self._threads)
        return self._episodes.observe(), self._infos(places)

    def step(
        self, actions: Any
    ) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Make one step of all simulations.

        Raises:
            CallsFailed: a simulation is gone, or refused a call; `reset` starts all of them again.
            ValueError: an action is not valid, or a simulation has to be reset first.
        """
        everywhere, episodes = range(self.num_envs), self._episodes
        resting = set(np.flatnonzero(self._is_over).tolist())
        if resting and self.autoreset_mode is AutoresetMode.DISABLED:
            raise ValueError(
                f"the episodes of simulations {sorted(resting)} are over; reset them with options={{'reset_mask': …}}"
            )
        is_array = actions.__class__ is np.ndarray
        rows: Sequence[Any] = actions if is_array else list(iterate(self.action_space, actions))
        if len(rows) != self.num_envs:
            raise ValueError(f"{self.num_envs} simulations need as many actions, not {len(rows)}")
        stepped = [place for place in everywhere if place not in resting] if resting else everywhere
        episodes.step(stepped, rows)
        self._steps += ~self._is_over
        rewards, terminated = episodes.judge(stepped)
        if self._limit is None:
            truncated = np.zeros(self.num_envs, bool)
        else:
            truncated = (self._steps >= self._limit) & ~self._is_over
        if resting:
            self._start(sorted(resting))
        self._is_over = terminated | truncated
        infos: dict[str, Any] = {}
        if self.autoreset_mode is AutoresetMode.SAME_STEP and self._is_over.any():
            over = np.flatnonzero(self._is_over).tolist()
            for place in over:
                final_info = self.task.info_of(episodes.state(place))
                final = {"final_obs": episodes.observation(place), "final_info": final_info}
                infos = self._add_info(infos, final, place)
            self._start(over)
        return episodes.observe(), rewards, terminated, truncated, self._infos(everywhere, infos)

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return an image of each simulation with ``render_mode="rgb_array"``; otherwise None."""
        if self._film is None:
            return None
        self._episodes.prepare_calls()
        return tuple(self._film.images())

    def close_extras(self, **_: Any) -> None:
        """End the simulations, or disconnect from their servers; Gymnasium's ``close`` calls this."""
        if self._end is not None:
            self._end()

    @property
    def _episodes(self) -> Episodes | Together:
        return self._running.episodes

    def _start(self, places: Sequence[int]) -> None:
        self._episodes.start({place: self._random[place] for place in places})
        self._steps[places] = 0
        self._is_over[places] = False

    def _masked(self, options: dict[str, Any]) -> list[int]:
        mask = options.pop("reset_mask", None)
        if options:
            raise ValueError(f"the only option is reset_mask; got {', '.join(map(str, options))}")
        if mask is None:
            return list(range(self.num_envs))
        mask = np.asarray(mask)
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(f"reset_mask must be {self.num_envs} bools with at least one True, not {mask!r}")
        return np.flatnonzero(mask).tolist()

    def _infos(self, places: Iterable[int], infos: dict[str, Any] | None = None) -> dict[str, Any]:
        infos = {} if infos is None else infos
        if self.task.info is not None:
            for place in places:
                infos = self._add_info(infos, self.task.info_of(self._episodes.state(place)), place)
        return infos
