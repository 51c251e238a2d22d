"""The simulation as a whole: start, pause, stop, and its clock."""

from __future__ import annotations

from enum import StrEnum

from simx_client.connection.connection import Connection
from simx_client.connection.strict import Strict
from simx_client.errors import SimxError
from simx_client.protocol import constants as c

from .channel import Channel

_NOT_STOPPED, _PAUSED = 1, 2
"""Bits of the state in the header of a message."""


class State(StrEnum):
    """What the simulation does."""

    STOPPED = "stopped"
    RUNNING = "running"
    PAUSED = "paused"


class Simulation(Strict):
    """Runs, pauses and ends the simulation that all clients of a server share."""

    __slots__ = ("_channel", "_connection")

    def __init__(self, channel: Channel, connection: Connection) -> None:
        self._channel, self._connection = channel, connection

    def __repr__(self) -> str:
        """With the state that the newest answer told; nothing is asked for."""
        header = self._connection.last_header
        known = "" if header is None else f": {_state_of(header.server_state)} at the newest answer"
        return f"<Simulation {self._channel.state}{known}>"

    def start(self) -> None:
        """Start, or go on after a pause; nothing when it runs."""
        self._channel.tell(lambda calls: calls.simxStartSimulation())

    def pause(self) -> None:
        """Stand still until the next start."""
        self._channel.tell(lambda calls: calls.simxPauseSimulation())

    def stop(self) -> None:
        """End the run: everything is again as it was at the start. Ends stepped mode, too."""
        self._channel.tell(lambda calls: calls.simxStopSimulation())

    @property
    def state(self) -> State:
        """Asks the server."""
        self._ask_time_ms()
        header = self._connection.newest_header()
        return _state_of(0 if header is None else header.server_state)

    @property
    def time(self) -> float:
        """Simulated seconds since the start, in whole milliseconds as messages carry them; 0 while stopped."""
        return self._ask_time_ms() / 1000

    @property
    def time_step(self) -> float:
        """Simulated seconds of one pass. To be set while stopped."""
        seconds = self._channel.ask(
            lambda calls: calls.simxGetFloatingParameter(c.sim_floatparam_simulation_time_step)
        )
        return float(f"{seconds:.6g}")  # it came in single precision; 0.05 is not 0.0500000007

    @time_step.setter
    def time_step(self, seconds: float) -> None:
        if self.state is not State.STOPPED:  # the server would pass over it without a word, as V-REP did
            raise SimxError("the time step cannot be changed while a simulation runs; stop it first")
        self._channel.tell(
            lambda calls: calls.simxSetFloatingParameter(c.sim_floatparam_simulation_time_step, seconds)
        )

    def _ask_time_ms(self) -> int:
        answer = self._channel.gather(
            lambda calls: calls.simxGetIntegerParameter(c.sim_intparam_program_version)
        )
        assert answer.reply is not None
        return answer.reply.time_ms


def _state_of(bits: int) -> State:
    if not bits & _NOT_STOPPED:
        return State.STOPPED
    return State.PAUSED if bits & _PAUSED else State.RUNNING
