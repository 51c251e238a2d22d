"""Messages to fill in, and times, of ``simROS2``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError

from .messages import constants, default_message, supported_messages
from .part import Ros2Part
from .topics import split

if TYPE_CHECKING:
    from simx_server.ros2_messages import KnownTypes


class Ros2InterfaceFunctions(Ros2Part, effect="changes"):
    """Messages and times."""

    @property
    def _types(self) -> KnownTypes:
        return self._world.ros2_topics.types

    def createInterface(self, kind: str) -> dict[str, Any]:
        """Return a message with default values. Partly: an unknown type gives an empty table."""
        self._note()
        return default_message(self._types, kind) or {}

    def getInterfaceConstants(self, kind: str) -> dict[str, Any]:
        """Return the constants of a message. Partly: an unknown type gives an empty table."""
        self._note()
        return constants(self._types, kind)

    def supportedInterfaces(self) -> list[str]:
        """Return the types that the server knows."""
        self._note()
        return supported_messages(self._types)

    def getTime(self, _clock: int = 0) -> dict[str, int]:
        """Return the simulated time, which is that of ROS 2 with use_sim_time."""
        self._note()
        return split(self._sim.time)

    def getSystemTime(self) -> dict[str, int]:
        """Return the simulated time. Stand-in: runs could not be repeated with the time of the system."""
        self._note()
        return split(self._sim.time)

    def getSimulationTime(self) -> dict[str, int]:
        """Return the simulated time as seconds and nanoseconds."""
        return split(self._sim.time)

    def timeFromFloat(self, seconds: float) -> dict[str, int]:
        """Return a time as seconds and nanoseconds."""
        return split(seconds)

    def timeToFloat(self, time: dict[str, Any]) -> float:
        """Return a time of seconds and nanoseconds as a number."""
        sec, nanosec = time.get("sec", 0), time.get("nanosec", 0)
        if not isinstance(sec, int | float) or not isinstance(nanosec, int | float):
            raise CommandError("a time is a table with the numbers sec and nanosec")
        return sec + nanosec * 1e-9
