"""`SimxEnv`: a simulation as a Gymnasium environment."""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any, Self

import gymnasium
import numpy as np
from numpy.typing import NDArray

from simx_client.client.servers import Servers
from simx_client.connection.timeouts import DEFAULT_TIMEOUT
from simx_client.errors import CallsFailed
from simx_client.protocol import constants as c
from simx_client.randomization import Randomize

from .actions import How
from .observations import Observed
from .rendering import MODES, Film, RealTime, check_mode, open_browser
from .running.episodes import Episodes
from .running.opening import check_place, open_addresses, open_alone
from .running.together import Running, Together
from .task import Start, State, Task


class SimxEnv(gymnasium.Env[Any, Any]):
    """One simulation, described by names of the scene.

        env = SimxEnv(
            "cart_pole",
            observations=["action.position", "pole_joint.position"],
            actions={"action.force": (-10, 10)},
            reward=lambda now: 1.0,
            done=lambda now: abs(now["pole_joint.position"]) > 0.2,
        )

    ``docs/gym.md`` lists the quantities. A stop at the start of each episode restores the scene, so episodes of equal
    seeds and actions are equal bit for bit.
    """

    metadata: dict[str, Any] = {"render_modes": list(MODES), "render_fps": 20}  # noqa: RUF012 - Gymnasium's form

    def __init__(
        self,
        scene: str | os.PathLike[str] | None = None,
        *,
        observations: Observed | Mapping[str, Observed],
        actions: Mapping[str, How],
        reward: Callable[[State], float],
        done: Callable[[State], bool] | None = None,
        start: Start | Callable[[np.random.Generator], Start] | None = None,
        measures: Sequence[str] = (),
        info: Callable[[State], dict[str, Any]] | None = None,
        time_step: float | None = None,
        frame_skip: int = 1,
        camera: str | None = None,
        randomize: Randomize | None = None,
        address: str | None = None,
        render_mode: str | None = None,
        timeout: float = DEFAULT_TIMEOUT,
        **settings: object,
    ) -> None:
        """Start a simulation in this process, or connect to a server.

        Args:
            scene: what ``simx-server`` takes: a V-REP, MJCF or URDF file, or the name of a shipped scene.
            observations: a name (numbers or an image), several names (one array of their numbers), or a dictionary of
                these (a dictionary space).
            actions: for each name a range ``(low, high)``, an `Increment` or `Choices`.
            reward: returns the reward of the step that led to a state.
            done: returns whether the episode ends in this state; None: episodes end by a time limit only, such as
                ``gymnasium.wrappers.TimeLimit``.
            start: values that are set at the start of each episode, by name: numbers, `Uniform`, or functions of the
                environment's random generator that return numbers; or one such function that returns them all by name.
            measures: further names that `reward`, `done` and `info` can read.
            info: returns the information dictionary of a state.
            time_step: duration of a simulation step in seconds; default: the scene's.
            frame_skip: number of simulation steps in a step of the environment.
            camera: vision sensor for ``render_mode="rgb_array"``; default: the first one of the scene.
            randomize: properties of the scene that are drawn at the start of each episode.
            address: server to use instead: ``HOST:PORT``, or ``REALM@ROUTER:PORT``. It has its scene already.
            render_mode: "rgb_array", or "human" for the web viewer and steps at real time.
            timeout: time-out of calls in seconds.
            settings: flags of ``simx-server``, with underscores, for the simulation in this process.

        Raises:
            ConnectionFailed: the scene or a setting cannot be used, or the server cannot be reached.
            CallsFailed: an object does not exist.
            ValueError: a name, range or number cannot be used; the text says what is valid.
        """
        if scene is not None and address is not None:
            raise ValueError(f"the server at {address} has its scene already; leave out scene={scene!r}")
        task = Task(
            scene=scene,
            observations=observations,
            actions=actions,
            reward=reward,
            done=done,
            start=start,
            measures=measures,
            info=info,
            time_step=time_step,
            frame_skip=frame_skip,
            camera=camera,
            randomize=randomize,
        )
        self._open(task, address, render_mode, timeout, settings)

    @classmethod
    def of(
        cls,
        task: Task,
        *,
        address: str | None = None,
        render_mode: str | None = None,
        timeout: float = DEFAULT_TIMEOUT,
        **settings: object,
    ) -> Self:
        """Return an environment for a task. A server at `address` must have the objects of the task."""
        self = cls.__new__(cls)
        self._open(task, address, render_mode, timeout, settings)
        return self

    def _open(
        self,
        task: Task,
        address: str | None,
        render_mode: str | None,
        timeout: float,
        settings: Mapping[str, object],
    ) -> None:
        check_mode(render_mode, MODES)
        check_place(address, settings)
        if render_mode == "human":
            if address is not None:
                raise ValueError(
                    f"render_mode='human' shows a simulation of this process; start the server at {address} with --view"
                )
            settings = {"view": 0, **settings}
        self.task, self.render_mode = task, render_mode
        self.view_address = ""
        """Address of the web viewer; empty without one."""

        self._address, self._timeout, self._settings = address, timeout, settings
        self._close: weakref.finalize[..., Any] = weakref.finalize(self, _nothing)
        self._connect()
        self.observation_space = self._episodes.observations.space
        self.action_space = self._episodes.actions.space

    def _connect(self) -> None:
        self._close()
        with ExitStack() as stack:
            if self._address is None:
                servers, self.view_address = open_alone(self.task.scene, self._timeout, self._settings, stack)
            else:
                servers = open_addresses([self._address], self._timeout, stack)
            self._running = Running(Episodes(self.task, servers))
            self._may_join = self._address is None
            self._film = Film(servers, self.task.camera) if self.render_mode == "rgb_array" else None
            seconds = self.task.frame_skip * (self.task.time_step or _time_step(servers))
            self.metadata = {**type(self).metadata, "render_fps": max(1, round(1 / seconds))}
            self._clock = RealTime(seconds) if self.render_mode == "human" else None
            stack.callback(self._running.end)
            self._close = weakref.finalize(self, stack.pop_all().close)
        if self.view_address:
            open_browser(self.view_address)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode. Starts or connects again if the simulation was lost or closed.

        Args:
            seed: of the random values of this and the following episodes.
            options: none are defined.

        Raises:
            CallsFailed: the simulation is gone, or refused a value of the start.
            ConnectionFailed: the simulation was lost, and there is none again.
            ValueError: `options` contains something.
        """
        super().reset(seed=seed)
        if options:
            raise ValueError(f"this environment has no options; got {', '.join(map(str, options))}")
        if not self._close.alive:
            self._connect()
        state = self.np_random.bit_generator.state
        try:
            self._episodes.start({0: self.np_random})
        except CallsFailed:
            if not self._episodes.servers.lost:
                raise
            self._connect()
            self.np_random.bit_generator.state = state  # the lost simulation has used none of it
            self._episodes.start({0: self.np_random})
        if self._may_join:
            self._may_join = False
            self._running.join_if_whole()
        if self._clock is not None:
            self._clock.restart()
        return self._episodes.observation(0), self.task.info_of(self._episodes.state(0))

    @property
    def _episodes(self) -> Episodes | Together:
        return self._running.episodes

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Make one step. Numbers of an action outside of -1..1 count as the nearest of them.

        Raises:
            CallsFailed: the simulation is gone, or refused a call.
            ValueError: the action is not valid.
        """
        episodes = self._running.episodes
        episodes.step(_ONE, (action,))
        if self._clock is not None:
            self._clock.wait()
        now = episodes.state(0)
        reward, is_done = self.task.judge(now)
        return episodes.observations.make(now), reward, is_done, False, self.task.info_of(now)

    def render(self) -> NDArray[np.uint8] | None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Return the image of the camera with ``render_mode="rgb_array"``; otherwise None."""
        if self._film is None:
            return None
        self._episodes.prepare_calls()
        return self._film.images()[0]

    def close(self) -> None:
        """Stop the simulation; end it, or disconnect from its server. Idempotent; ``reset`` opens it again."""
        self._close()


_ONE = (0,)
"""The place of the only simulation."""


def _time_step(servers: Servers) -> float:
    answers = servers.each(
        lambda calls, _: calls.simxGetFloatingParameter(c.sim_floatparam_simulation_time_step)
    )
    return answers[0].value


def _nothing() -> None:
    """Close nothing: the environment is not open yet."""
