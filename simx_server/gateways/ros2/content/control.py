"""Services that control the run: the node's own Triggers, and the standard ones of ``simulation_interfaces``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from simx_server.sensors.vision.futures import then
from simx_server.simulation.simulation import SimulationState

from ..endpoints import Content, Context, Message, Offer, Served
from .run import Run, WrongState

TRIGGER = "std_srvs/srv/Trigger"

STOPPED, PLAYING, PAUSED, QUITTING = range(4)
"""States of ``simulation_interfaces/SimulationState``."""

_STATES = {
    SimulationState.STOPPED: STOPPED,
    SimulationState.RUNNING: PLAYING,
    SimulationState.PAUSED: PAUSED,
}

UNSUPPORTED, OK, _, INCORRECT_STATE, FAILED = range(5)
"""Results of ``simulation_interfaces/Result``."""

ALREADY_IN_TARGET_STATE, INCORRECT_TRANSITION = 101, 103
"""Results of ``simulation_interfaces/SetSimulationState``."""

SCOPE_DEFAULT, SCOPE_TIME, SCOPE_STATE, SCOPE_SPAWNED, SCOPE_ALL = 0, 1, 2, 4, 255
"""Scopes of ``simulation_interfaces/ResetSimulation``."""

_EVERYTHING = (SCOPE_DEFAULT, SCOPE_TIME | SCOPE_STATE | SCOPE_SPAWNED, SCOPE_ALL)


class Control(Content):
    """Serves ``~/start``, ``~/stop``, ``~/pause``, ``~/reset``, ``~/step``, and four services of the standard."""

    def __init__(self, context: Context) -> None:
        self._run = Run(context)

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
            ("/set_simulation_state", "SetSimulationState", self._set, _is_to_stopped),
            ("/reset_simulation", "ResetSimulation", self._reset, _always),
            ("/step_simulation", "StepSimulation", self._step, _never),
        ):
            yield Served(name, f"{package}/{kind}", answer, _failed, stops)

    def _step_once(self, _: Mapping[str, Any]) -> Future[Message]:
        return then(self._run.step(1), lambda _: {"success": True, "message": "one step is made"})

    def _get(self, _: Mapping[str, Any]) -> Message:
        return {"state": {"state": _STATES[self._run.state]}, **_result(OK)}

    def _set(self, request: Mapping[str, Any]) -> Message:
        wanted, present = request["state"]["state"], _STATES[self._run.state]
        if wanted == QUITTING:
            return _result(UNSUPPORTED, "this server ends with its process, not by a service")
        if wanted not in (STOPPED, PLAYING, PAUSED):
            return _result(UNSUPPORTED, f"there is no state {wanted}; valid: 0 stopped, 1 playing, 2 paused")
        if wanted == present:
            return _result(ALREADY_IN_TARGET_STATE, "the simulation is in this state already")
        try:
            {STOPPED: self._run.stop, PLAYING: self._run.start, PAUSED: self._run.pause}[wanted]()
        except WrongState as problem:
            return _result(INCORRECT_TRANSITION, str(problem))
        return _result(OK)

    def _reset(self, request: Mapping[str, Any]) -> Message:
        if request["scope"] not in _EVERYTHING:
            return _result(
                UNSUPPORTED,
                "time, state and spawned objects are reset together; valid: SCOPE_DEFAULT (0) or SCOPE_ALL (255)",
            )
        self._run.reset()
        return _result(OK)

    def _step(self, request: Mapping[str, Any]) -> Message | Future[Message]:
        try:
            return then(self._run.step(request["steps"]), lambda _: _result(OK))
        except WrongState as problem:
            return _result(INCORRECT_STATE, str(problem))


def _always(_: Mapping[str, Any]) -> bool:
    return True


def _never(_: Mapping[str, Any]) -> bool:
    return False


def _is_to_stopped(request: Mapping[str, Any]) -> bool:
    return request["state"]["state"] == STOPPED


def _trigger(action: Callable[[], str], _: Mapping[str, Any]) -> Message:
    return {"success": True, "message": action()}


def _not_triggered(why: str) -> Message:
    return {"success": False, "message": why}


def _result(code: int, text: str = "") -> Message:
    return {"result": {"result": code, "error_message": text}}


def _failed(why: str) -> Message:
    return _result(FAILED, why)


def _no_state(why: str) -> Message:
    return {"state": {"state": STOPPED}, **_failed(why)}
