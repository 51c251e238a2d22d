"""``simROS2`` without ROS 2: nothing is published, and nothing is ever received."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

from simx_server.errors import CommandError

from ...interpreter import Constant
from .answers import answer
from .ros import RosPart
from .ros_messages import default_message, supported_messages

_NO_ROS = "the server has no ROS"


def _numbered(*names: str) -> dict[str, int]:
    return {name: number for number, name in enumerate(names)}


class SimRos2(RosPart):
    """The functions of ``simROS2``."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = MappingProxyType(
        {
            "clock_type": _numbered("ros", "system", "steady"),
            "action_result_code": _numbered("succeeded", "aborted", "canceled", "unknown"),
            "goal_response": _numbered("reject", "accept_and_execute", "accept_and_defer"),
            "cancel_response": _numbered("reject", "accept"),
            "qos_history_policy": _numbered("system_default", "keep_last", "keep_all"),
            "qos_reliability_policy": _numbered("system_default", "reliable", "best_effort"),
            "qos_durability_policy": _numbered("system_default", "transient_local", "volatile"),
            "qos_liveliness_policy": _numbered("system_default", "automatic", "manual_by_topic"),
        }
    )

    def createPublisher(self, _topic: str, _kind: str, *_more: Any) -> int:
        """Return the handle of a publisher. Stand-in: what it publishes goes nowhere."""
        return self._new()

    def createSubscription(self, _topic: str, _kind: str, _callback: Any, *_more: Any) -> int:
        """Return the handle of a subscription. Stand-in: it receives nothing."""
        return self._new()

    def createClient(self, _service: str, _kind: str) -> int:
        """Return the handle of a client. Stand-in: no service answers it."""
        return self._new()

    def createService(self, _service: str, _kind: str, _callback: Any) -> int:
        """Return the handle of a service. Stand-in: it is never called."""
        return self._new()

    def createActionClient(self, _action: str, _kind: str, *_callbacks: Any) -> int:
        """Return the handle of a client. Stand-in: no action answers it."""
        return self._new()

    def createActionServer(self, _action: str, _kind: str, *_callbacks: Any) -> int:
        """Return the handle of an action. Stand-in: it is never asked."""
        return self._new()

    def imageTransportCreatePublisher(self, _topic: str, _queue: int = 1) -> int:
        """Return the handle of a publisher. Stand-in: what it publishes goes nowhere."""
        return self._new()

    def imageTransportCreateSubscription(self, _topic: str, _callback: Any, _queue: int = 1) -> int:
        """Return the handle of a subscription. Stand-in: it receives nothing."""
        return self._new()

    def createInterface(self, kind: str) -> dict[str, Any]:
        """Return a message with default values. Stand-in: an unknown type gives an empty table."""
        self._note()
        return default_message(kind) or {}

    def getInterfaceConstants(self, _kind: str) -> dict[str, Any]:
        """Return the constants of a message. Stand-in: none is known."""
        self._note()
        return {}

    def supportedInterfaces(self) -> list[str]:
        """Return the types of messages that createInterface knows. Stand-in: these are the common ones."""
        self._note()
        return supported_messages()

    def getTime(self, _clock: int = 0) -> dict[str, int]:
        """Return the simulated time. Stand-in: the server has no ROS, whose time it would be."""
        self._note()
        return _split(self._sim.time)

    def getSystemTime(self) -> dict[str, int]:
        """Return the simulated time. Stand-in: runs could not be repeated with the time of the system."""
        self._note()
        return _split(self._sim.time)

    def getSimulationTime(self) -> dict[str, int]:
        """Return the simulated time as seconds and nanoseconds."""
        return _split(self._sim.time)

    def timeFromFloat(self, seconds: float) -> dict[str, int]:
        """Return a time as seconds and nanoseconds."""
        return _split(seconds)

    def timeToFloat(self, time: dict[str, Any]) -> float:
        """Return a time of seconds and nanoseconds as a number."""
        sec, nanosec = time.get("sec", 0), time.get("nanosec", 0)
        if not isinstance(sec, int | float) or not isinstance(nanosec, int | float):
            raise CommandError("a time is a table with the numbers sec and nanosec")
        return sec + nanosec * 1e-9

    publish = answer(reason=_NO_ROS)
    spinSome = answer(reason=_NO_ROS)
    waitForService = answer(False, reason="no service answers")
    call = answer(reason="no service answers")
    sendGoal = answer(False, reason="no action answers")
    cancelLastGoal = answer(False, reason="no action answers")
    importInterface = answer(reason=_NO_ROS)
    shutdownPublisher = answer(reason=_NO_ROS)
    shutdownSubscription = answer(reason=_NO_ROS)
    shutdownClient = answer(reason=_NO_ROS)
    shutdownService = answer(reason=_NO_ROS)
    shutdownActionClient = answer(reason=_NO_ROS)
    shutdownActionServer = answer(reason=_NO_ROS)
    publisherTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    subscriptionTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    clientTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    serviceTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    actionClientTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    actionServerTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    actionServerPublishFeedback = answer(reason=_NO_ROS)
    actionServerActionAbort = answer(reason=_NO_ROS)
    actionServerActionSucceed = answer(reason=_NO_ROS)
    actionServerActionCanceled = answer(reason=_NO_ROS)
    actionServerActionExecute = answer(reason=_NO_ROS)
    actionServerActionIsCanceling = answer(False, reason=_NO_ROS)
    actionServerActionIsActive = answer(False, reason=_NO_ROS)
    actionServerActionIsExecuting = answer(False, reason=_NO_ROS)
    imageTransportShutdownSubscription = answer(reason=_NO_ROS)


def _split(seconds: float) -> dict[str, int]:
    whole = int(seconds // 1)
    return {"sec": whole, "nanosec": min(int((seconds - whole) * 1e9), 999_999_999)}
