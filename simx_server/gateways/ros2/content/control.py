"""Services that control the run: the node's own Triggers, and the standard ones of ``simulation_interfaces``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from simx_client.protocol.constants import sim_boolparam_exit_request
from simx_server.errors import CommandError
from simx_server.sensors.vision.futures import then
from simx_server.simulation.simulation import SimulationState

from ..endpoints import Content, Context, Message, Offer, Served
from ..standard.results import INCORRECT_STATE, OK, UNSUPPORTED, failed, result
from ..table_call import Call
from .run import WrongState

TRIGGER = "std_srvs/srv/Trigger"

STOPPED, PLAYING, PAUSED, QUITTING, NO_WORLD, LOADING_WORLD = range(6)
"""States of ``simulation_interfaces/SimulationState``."""

_STATES = {
    SimulationState.STOPPED: STOPPED,
    SimulationState.RUNNING: PLAYING,
    SimulationState.PAUSED: PAUSED,
}

ALREADY_IN_TARGET_STATE, TRANSITION_ERROR, INCORRECT_TRANSITION = 101, 102, 103
"""Results of ``simulation_interfaces/SetSimulationState``."""

SCOPE_DEFAULT, SCOPE_TIME, SCOPE_STATE, SCOPE_SPAWNED, SCOPE_ALL = 0, 1, 2, 4, 255
"""Scopes of ``simulation_interfaces/ResetSimulation``."""

_EVERYTHING = (SCOPE_DEFAULT, SCOPE_TIME | SCOPE_STATE | SCOPE_SPAWNED, SCOPE_ALL)


class Control(Content):
    """Serves ``~/start``, ``~/stop``, ``~/pause``, ``~/reset``, ``~/step``, and four services of the standard."""

    def __init__(self, context: Context) -> None:
        self._context, self._run = context, context.run

    def step_finished(self) -> None:
        self._run.step_finished()

    def run_paused(self) -> None:
        self._run.run_paused()

    def run_stopped(self) -> None:
        self._run.run_stopped()

    def offers(self) -> Iterable[Offer]:
        run = self._run
        for name, action in (
            ("start", run.start),
            ("stop", run.stop),
            ("pause", run.pause),
            ("reset", run.reset),
        ):
            stops = _always if name in ("stop", "reset") else _never
            yield Served(f"~/{name}", TRIGGER, partial(_trigger, action), _not_triggered, stops)
        yield Served("~/step", TRIGGER, self._step_once, _not_triggered)
        package = "simulation_interfaces/srv"
        yield Served("/get_simulation_state", f"{package}/GetSimulationState", self._get, _no_state)
        for name, kind, answer, stops in (
            ("/set_simulation_state", "SetSimulationState", self._set, _is_to_end),
            ("/reset_simulation", "ResetSimulation", self._reset, _always),
            ("/step_simulation", "StepSimulation", self._step, _never),
        ):
            yield Served(name, f"{package}/{kind}", answer, failed, stops)

    def _step_once(self, _: Mapping[str, Any]) -> Future[Message]:
        return then(self._run.step(1), lambda _: {"success": True, "message": "one step is made"})

    def _get(self, _: Mapping[str, Any]) -> Message:
        return {"state": {"state": self._state()}, **result(OK)}

    def _state(self) -> int:
        if self._run.world.is_loading:
            return LOADING_WORLD
        if self._run.world.is_unloaded and self._run.state is SimulationState.STOPPED:
            return NO_WORLD
        return _STATES[self._run.state]

    def _set(self, request: Mapping[str, Any]) -> Message:
        wanted, present = request["state"]["state"], self._state()
        if wanted == QUITTING:
            return self._quit()
        if wanted not in (STOPPED, PLAYING, PAUSED):
            return result(
                UNSUPPORTED,
                f"no state {wanted} can be set; valid: 0 stopped, 1 playing, 2 paused, 3 quitting",
            )
        if present in (NO_WORLD, LOADING_WORLD):
            return result(TRANSITION_ERROR, "there is no world, or it is being loaded; load one first")
        if wanted == present:
            return result(ALREADY_IN_TARGET_STATE, "the simulation is in this state already")
        try:
            {STOPPED: self._run.stop, PLAYING: self._run.start, PAUSED: self._run.pause}[wanted]()
        except WrongState as problem:
            return result(INCORRECT_TRANSITION, str(problem))
        except CommandError as problem:
            return result(TRANSITION_ERROR, str(problem))
        return result(OK)

    def _quit(self) -> Message:
        """Stop, and have the server end; the answer leaves before."""
        self._run.stop()
        try:
            self._context.client.ask(Call("simxSetBooleanParameter", [sim_boolparam_exit_request, True]))
        except CommandError as problem:
            return result(TRANSITION_ERROR, str(problem))
        return result(OK)

    def _reset(self, request: Mapping[str, Any]) -> Message | Future[Message]:
        scope = request["scope"]
        if scope in _EVERYTHING:
            self._run.reset_all()
        elif scope == SCOPE_TIME | SCOPE_STATE:
            return then(self._run.reset_but_spawned(), lambda _: result(OK))
        elif scope == SCOPE_SPAWNED:
            self._run.spawned.delete_spawned()
        else:
            return result(
                UNSUPPORTED,
                "time and state are reset together; valid: SCOPE_DEFAULT (0), SCOPE_TIME | SCOPE_STATE (3), "
                "SCOPE_SPAWNED (4) and SCOPE_ALL (255)",
            )
        return result(OK)

    def _step(self, request: Mapping[str, Any]) -> Message | Future[Message]:
        try:
            return then(self._run.step(request["steps"]), lambda _: result(OK))
        except WrongState as problem:
            return result(INCORRECT_STATE, str(problem))


def _always(_: Mapping[str, Any]) -> bool:
    return True


def _never(_: Mapping[str, Any]) -> bool:
    return False


def _is_to_end(request: Mapping[str, Any]) -> bool:
    return request["state"]["state"] in (STOPPED, QUITTING)


def _trigger(action: Callable[[], str], _: Mapping[str, Any]) -> Message:
    return {"success": True, "message": action()}


def _not_triggered(why: str) -> Message:
    return {"success": False, "message": why}


def _no_state(why: str) -> Message:
    return {"state": {"state": STOPPED}, **failed(why)}
