"""``/diagnostics``: how the simulation runs, about once a second, for ``rqt_robot_monitor`` and aggregators."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping

from simx_server.simulation.simulation import SimulationState

from ..endpoints import Content, Context, Message, Moment, Offer, Published

TYPE = "diagnostic_msgs/msg/DiagnosticArray"

OK, WARN, ERROR = range(3)
"""Levels of ``diagnostic_msgs/DiagnosticStatus``."""

PERIOD = 1.0
"""Simulated seconds between two messages."""

SLOW = 0.9
"""Share of the wanted speed below which the simulation is slow."""


class Diagnostics(Content):
    """Publishes the state of the run and the problems of the server."""

    def __init__(self, context: Context) -> None:
        self._client, self._world = context.client, context.world
        self._simulation = context.world.simulation
        self._failure = ""
        """Why the last run was stopped; empty if someone wanted it."""

        self._last = (0, 0.0)
        """Simulated nanoseconds and the wall clock at the last message."""

    def run_started(self) -> None:
        self._failure = ""

    def run_stopped(self) -> None:
        self._failure = self._simulation.failure

    def offers(self) -> Iterable[Offer]:
        yield Published("/diagnostics", TYPE, self._message, period=PERIOD)

    def _message(self, moment: Moment) -> Message:
        simulation, pace = self._simulation, self._world.parameters.pace
        wanted = pace.speed if pace is not None else math.inf
        speed = self._speed(moment)
        is_slow = speed is not None and math.isfinite(wanted) and speed < SLOW * wanted
        level, text = OK, f"the simulation is {simulation.state.value}"
        if self._failure:
            level, text = ERROR, self._failure
        elif is_slow:
            level, text = WARN, f"the simulation runs at {speed:.2f} of real time, and {wanted:g} is wanted"
        problems = self._client.problems()
        return {
            "header": moment.header(""),
            "status": [
                _status(
                    level,
                    "simx: simulation",
                    text,
                    {
                        "state": simulation.state.value,
                        "scene": simulation.scene.name,
                        "simulation step (s)": f"{simulation.time_step:g}",
                        "steps": str(simulation.step_count),
                        "speed": "" if speed is None else f"{speed:.3f}",
                        "wanted speed": f"{wanted:g}",
                        "objects": str(len(simulation.scene.objects)),
                    },
                ),
                _status(
                    WARN if problems else OK,
                    "simx: server",
                    "; ".join(problems) or "no problems",
                    {str(number): problem for number, problem in enumerate(problems, 1)},
                ),
            ],
        }

    def _speed(self, moment: Moment) -> float | None:
        """Return the simulated seconds per second since the last message; None while no steps are made."""
        (simulated, wall), now = self._last, time.monotonic()
        self._last = moment.nanoseconds, now
        passed = moment.nanoseconds - simulated
        if self._simulation.state is not SimulationState.RUNNING or passed <= 0 or not wall or now <= wall:
            return None
        return passed * 1e-9 / (now - wall)


def _status(level: int, name: str, text: str, values: Mapping[str, str]) -> Message:
    return {
        "level": level,
        "name": name,
        "message": text,
        "hardware_id": "simx",
        "values": [{"key": key, "value": value} for key, value in values.items()],
    }
