"""The simulation as a whole: start, pause, stop, and its clock."""

from __future__ import annotations

from enum import StrEnum

from simx_client.calls.strict import Strict
from simx_client.connection.connection import Connection
from simx_client.errors import SimxError
from simx_client.protocol import constants as c

from .channel import Channel

_NOT_STOPPED, _PAUSED = 1, 2
"""Bits of the simulation state in a message header."""


class State(StrEnum):
    """State of the simulation."""

    STOPPED = "stopped"
    RUNNING = "running"
    PAUSED = "paused"


class Simulation(Strict):
    """Starts, pauses and stops the simulation that all clients of a server share."""

    __slots__ = ("_channel", "_connection")

    def __init__(self, channel: Channel, connection: Connection) -> None:
        self._channel, self._connection = channel, connection

    def __repr__(self) -> str:
        """Return the state of the newest answer; sends nothing."""
        header = self._connection.last_header
        known = "" if header is None else f": {_state_of(header.server_state)} at the newest answer"
        return f"<Simulation {self._channel.state}{known}>"

    def start(self) -> None:
        """Start the simulation, or continue after a pause; no effect while it runs."""
        self._channel.send(lambda calls: calls.simxStartSimulation())

    def pause(self) -> None:
        """Pause the simulation until the next start."""
        self._channel.send(lambda calls: calls.simxPauseSimulation())

    def stop(self) -> None:
        """Stop the simulation and restore the state of the start. Also ends stepped mode."""
        self._channel.send(lambda calls: calls.simxStopSimulation())

    @property
    def state(self) -> State:
        """Request the state from the server."""
        self._request_time_ms()
        header = self._connection.newest_header()
        return _state_of(0 if header is None else header.server_state)

    @property
    def time(self) -> float:
        """Return the simulation time in seconds, in whole milliseconds as messages carry it; 0 while stopped."""
        return self._request_time_ms() / 1000

    @property
    def time_step(self) -> float:
        """Return the duration of a simulation step in simulated seconds. Set it while stopped."""
        seconds = self._channel.request(
            lambda calls: calls.simxGetFloatingParameter(c.sim_floatparam_simulation_time_step)
        )
        return float(f"{seconds:.6g}")  # the server sends single precision: 0.05 instead of 0.0500000007

    @time_step.setter
    def time_step(self, seconds: float) -> None:
        if self.state is not State.STOPPED:  # the server ignores it silently, as V-REP did
            raise SimxError("the time step cannot be changed while a simulation runs; stop it first")
        self._channel.send(
            lambda calls: calls.simxSetFloatingParameter(c.sim_floatparam_simulation_time_step, seconds)
        )

    def _request_time_ms(self) -> int:
        answer = self._channel.gather(
            lambda calls: calls.simxGetIntegerParameter(c.sim_intparam_program_version)
        )
        assert answer.reply is not None
        return answer.reply.time_ms


def _state_of(bits: int) -> State:
    if not bits & _NOT_STOPPED:
        return State.STOPPED
    return State.PAUSED if bits & _PAUSED else State.RUNNING
