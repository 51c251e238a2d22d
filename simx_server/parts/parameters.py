"""The state of the simulator's numbered quantities that no other part has: pace, arguments, random numbers, ...

`handlers/quantities/simulator.py` defines the numbers.
"""

from __future__ import annotations

import logging
import math
import random
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from simx_client.protocol import constants as c
from simx_server.errors import Unsupported
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

PROGRAM_VERSION = 30602
"""V-REP 3.6.2, whose behaviour is the specification, in V-REP's form MMmmpp."""

MAX_ARGUMENTS = 9
"""Most arguments of the command line; string parameters 2 to 10."""

_MAX_SPEED_INDEX = 10
"""Largest speed index: 2**10 times the speed."""

FIRST_PORT = 20000
"""First of V-REP's ports of the remote API for programs that scripts start."""


class Pace(Protocol):
    """Whether simulated time follows the wall clock; implemented by the server's composition."""

    speed: float
    """Simulated seconds per wall second; infinity for as fast as possible."""


class Parameters(Part):
    """All parameters of one simulation."""

    def __init__(self, sim: Simulation, arguments: tuple[str, ...] = ()) -> None:
        self._sim = sim
        self.random = random.Random(0)  # the same numbers in every run of the server
        self.speed_index = 0
        self.next_port = FIRST_PORT
        self.kept: dict[tuple[str, str | int], Any] = {}
        """Quantities without meaning here that were set, by kind and name."""
        self.error_report_mode = c.sim_api_errormessage_report
        """Integer parameter 0, bits: errors go to simxGetLastErrors (1), to the status bar (2); always to the log."""
        self.arguments = arguments
        """Arguments from the server's command line, for programs that read them."""
        self._end: Callable[[], None] | None = None
        self.stop_requests = 0
        """Number of runs that clients or scripts requested to stop, since the server started."""
        self.pace: Pace | None = None
        """Pace of the simulation; without it the caller paces the simulation."""
        self._is_waiting: Callable[[], bool] = lambda: False

    def served_by(
        self, pace: Pace, is_waiting_for_trigger: Callable[[], bool], end: Callable[[], None] | None = None
    ) -> None:
        """Note the server of the simulation.

        Args:
            pace: of its simulation steps.
            is_waiting_for_trigger: returns whether a stepped simulation waits (boolean 45).
            end: ends it; None: it cannot be ended.
        """
        self.pace, self._is_waiting, self._end = pace, is_waiting_for_trigger, end

    def set_error_report_mode(self, mode: int) -> None:
        """Report errors in another way from now on (integer parameter 0)."""
        self.error_report_mode = mode

    def is_waiting_for_trigger(self) -> bool:
        """Return whether a stepped simulation waits (boolean 45)."""
        return self._is_waiting()

    def run_stopping(self) -> None:
        self.stop_requests += 1

    def run_stopped(self) -> None:
        self._change_speed(0)

    @property
    def is_real_time(self) -> bool:
        """Return whether simulated time follows the wall clock."""
        return self.pace is not None and math.isfinite(self.pace.speed)

    def set_real_time(self, value: bool) -> None:
        """Switch real time on or off; while running a success without effect, as in V-REP."""
        if not self._sim.is_running and self.pace is not None and value != self.is_real_time:
            self.pace.speed = 1.0 if value else math.inf

    def set_speed_index(self, value: int) -> None:
        """Set the speed index: each step doubles the pace, each one below 0 halves it, until the run ends.

        While stopped, and without a pace, the call is a success without effect, as in V-REP.
        """
        if self._sim.is_running and self.is_real_time:
            self._change_speed(min(max(value, -_MAX_SPEED_INDEX), _MAX_SPEED_INDEX))

    def _change_speed(self, index: int) -> None:
        if self.pace is not None and math.isfinite(self.pace.speed):
            self.pace.speed *= 2.0 ** (index - self.speed_index)
        self.speed_index = index

    def request_exit(self, value: bool) -> None:
        """Request the end of the server; only while stopped, as in V-REP; False has no effect."""
        if not value:
            return
        if self._sim.is_running:
            raise Unsupported("the server ends only while the simulation is stopped; stop it first")
        if self._end is None:
            raise Unsupported("this simulation has no server that could be ended")
        logger.info("a client asked the server to end")
        self._end()

    def argument(self, index: int) -> str:
        """Return an argument of the command line; '' for a missing one, as in V-REP."""
        return self.arguments[index] if index < len(self.arguments) else ""

    def set_argument(self, index: int, text: str) -> None:
        given = [*self.arguments, *[""] * (index + 1 - len(self.arguments))]
        given[index] = text
        self.arguments = tuple(given)

    def random_euler(self) -> list[float]:
        """Return Euler angles of a uniformly distributed random rotation: sin(beta) is uniform."""
        alpha, gamma = (self.random.uniform(-math.pi, math.pi) for _ in range(2))
        return [alpha, math.asin(self.random.uniform(-1.0, 1.0)), gamma]
