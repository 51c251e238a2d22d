"""The action ``SimulateSteps``: make simulation steps of a paused simulation, with feedback after each of them."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Future

from simx_server.errors import CommandError

from ..actions import ABORTED, CANCELED, SUCCEEDED, Action, Goal
from ..content.run import Steps
from ..endpoints import Content, Context, Moment, Offer
from .results import FAILED, OK, result


class SimulateSteps(Content):
    """Serves ``/simulate_steps``."""

    def __init__(self, context: Context) -> None:
        self._run, simulation = context.run, context.world.simulation
        self._steps: dict[bytes, Steps] = {}
        kind = "simulation_interfaces/action/SimulateSteps"
        self._action = Action(
            "/simulate_steps",
            kind,
            self,
            lambda: Moment.of(simulation.step_count, simulation.time_step).stamp,
        )

    def offers(self) -> Iterable[Offer]:
        yield from self._action.offers()

    def begin(self, goal: Goal) -> None:
        """Ask for the steps. A goal that cannot be executed now is aborted, so that its client learns why."""

        def made(count: int) -> None:
            goal.feedback({"completed_steps": count, "remaining_steps": wanted - count})

        wanted = goal.request["steps"]
        try:
            steps = self._run.request(wanted, made)
        except CommandError as problem:
            goal.end(ABORTED, result(FAILED, str(problem)))
            return
        self._steps[goal.number] = steps
        steps.done.add_done_callback(lambda done: self._end(goal, done))

    def _end(self, goal: Goal, done: Future[None]) -> None:
        del self._steps[goal.number]
        if (problem := done.exception()) is not None:
            goal.end(ABORTED, result(FAILED, str(problem)))
        else:
            goal.end(SUCCEEDED, result(OK))

    def cancel(self, goal: Goal) -> bool:
        """Pause after the step that is being made."""
        goal.end(CANCELED, result(FAILED, "the goal was canceled before all steps were made"))
        if (steps := self._steps.get(goal.number)) is not None:
            self._run.give_up(steps)
        return True
