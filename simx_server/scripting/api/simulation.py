"""The simulation as a whole: its time."""

from __future__ import annotations

from .base import ApiPart


class SimulationFunctions(ApiPart):
    """Seconds."""

    def getSimulationTime(self) -> float:
        """Seconds."""
        return self._sim.time

    def getSimulationTimeStep(self) -> float:
        """Seconds of one pass."""
        return self._sim.time_step
