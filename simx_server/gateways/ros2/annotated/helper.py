"""The topics of V-REP's ROS interface helper, a model or add-on in many scenes: `helper=yes` of the scene.

Programs start, pause, stop and step the simulation with std_msgs/Bool, and are told its state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

from simx_server.simulation.simulation import SimulationState

from ..content.run import PAUSE, START, STOP
from ..endpoints import Commanded, Content, Context, Message, Moment, Offer, Published
from ..table_call import Call

BOOL, INT, FLOAT = (f"std_msgs/msg/{name}" for name in ("Bool", "Int32", "Float32"))

TRIGGER, SET_STEPPING = "/triggerNextStep", "/enableSyncMode"
"""Topics of programs that step the simulation."""

STATES = {SimulationState.STOPPED: 0, SimulationState.RUNNING: 1, SimulationState.PAUSED: 2}
"""Numbers of `/simulationState`."""


class Helper(Content):
    """Takes the commands of the helper and publishes its topics, if the scene asks for it."""

    def __init__(self, context: Context) -> None:
        self._simulation = context.world.simulation

    def offers(self) -> Iterable[Offer]:
        if not self._simulation.scene.annotations.ros2.get("helper", False):
            return
        for name, call in (("start", START), ("pause", PAUSE), ("stop", STOP)):
            yield Commanded(f"/{name}Simulation", BOOL, partial(_if_true, call))
        yield Commanded(TRIGGER, BOOL, partial(_if_true, Call("simxSynchronousTrigger", [])))
        yield Commanded(SET_STEPPING, BOOL, _set_stepping)
        published: tuple[tuple[str, str, Callable[[Moment], Message]], ...] = (
            ("/simulationTime", FLOAT, lambda moment: {"data": moment.nanoseconds / 1e9}),
            ("/simulationState", INT, lambda _: {"data": STATES[self._simulation.state]}),
        )
        for topic, kind, make in published:
            yield Published(topic, kind, make)
        yield Published("/simulationStepDone", BOOL, self._step_done, repeats=False)

    def _step_done(self, _: Moment) -> Message | None:
        """Return the message after a simulation step; none while the simulation does not run."""
        return {"data": True} if self._simulation.state is SimulationState.RUNNING else None


def _if_true(call: Call, message: Mapping[str, Any]) -> Sequence[Call]:
    return [call] if message["data"] else []


def _set_stepping(message: Mapping[str, Any]) -> Sequence[Call]:
    return [Call("simxSynchronous", [bool(message["data"])])]
