"""``simROS`` and the older ``simExtROS_`` without ROS: nothing is published, and nothing is ever received."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING, Any, ClassVar

from .answers import StandIn, answer

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_NO_ROS = "the server has no ROS"


class RosPart(StandIn):
    """Functions that ROS 1 and ROS 2 share: handles, parameters, transformations, images."""

    NOTE: ClassVar[str] = (
        "ROS is not there: what scripts publish goes nowhere, and subscriptions receive nothing"
    )

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._handles = count(1)
        self._parameters: dict[str, Any] = {}

    def _new(self) -> int:
        self._note()
        return next(self._handles)

    def _parameter(self, name: str, kinds: type | tuple[type, ...], default: Any) -> tuple[bool, Any]:
        self._note()
        value = self._parameters.get(name)
        return (True, value) if isinstance(value, kinds) else (False, default)

    def _set_parameter(self, name: str, value: Any) -> None:
        self._note()
        if len(self._parameters) < 1000:
            self._parameters[name] = value

    sendTransform = answer(reason=_NO_ROS)
    sendTransforms = answer(reason=_NO_ROS)
    imageTransportPublish = answer(reason=_NO_ROS)
    imageTransportShutdownPublisher = answer(reason=_NO_ROS)

    def getParamString(self, name: str, default: str = "") -> tuple[bool, str]:
        """Return whether a script has set the parameter, and its value. Stand-in: the server has no ROS."""
        return self._parameter(name, str, default)

    def getParamInt(self, name: str, default: int = 0) -> tuple[bool, int]:
        """Return whether a script has set the parameter, and its value. Stand-in: the server has no ROS."""
        return self._parameter(name, int, default)

    def getParamDouble(self, name: str, default: float = 0.0) -> tuple[bool, float]:
        """Return whether a script has set the parameter, and its value. Stand-in: the server has no ROS."""
        return self._parameter(name, (int, float), default)

    def getParamBool(self, name: str, default: bool = False) -> tuple[bool, bool]:
        """Return whether a script has set the parameter, and its value. Stand-in: the server has no ROS."""
        return self._parameter(name, bool, default)

    def setParamString(self, name: str, value: str) -> None:
        """Keep a parameter for this script. Stand-in: the server has no ROS."""
        self._set_parameter(name, value)

    def setParamInt(self, name: str, value: int) -> None:
        """Keep a parameter for this script. Stand-in: the server has no ROS."""
        self._set_parameter(name, value)

    def setParamDouble(self, name: str, value: float) -> None:
        """Keep a parameter for this script. Stand-in: the server has no ROS."""
        self._set_parameter(name, value)

    def setParamBool(self, name: str, value: bool) -> None:
        """Keep a parameter for this script. Stand-in: the server has no ROS."""
        self._set_parameter(name, value)

    def hasParam(self, name: str) -> bool:
        """Return whether a script has set the parameter. Stand-in: the server has no ROS."""
        self._note()
        return name in self._parameters

    def deleteParam(self, name: str) -> None:
        """Forget a parameter of this script. Stand-in: the server has no ROS."""
        self._note()
        self._parameters.pop(name, None)


class SimRos(RosPart):
    """The functions of ``simROS``."""

    def advertise(self, _topic: str, _kind: str, _queue: int = 1, _latch: bool = False) -> int:
        """Return the handle of a publisher. Stand-in: what it publishes goes nowhere."""
        return self._new()

    def subscribe(self, _topic: str, _kind: str, _callback: Any, _queue: int = 1, _hints: Any = None) -> int:
        """Return the handle of a subscription. Stand-in: it receives nothing."""
        return self._new()

    def advertiseService(self, _service: str, _kind: str, _callback: Any) -> int:
        """Return the handle of a service. Stand-in: it is never called."""
        return self._new()

    def serviceClient(self, _service: str, _kind: str) -> int:
        """Return the handle of a client. Stand-in: no service answers it."""
        return self._new()

    def imageTransportAdvertise(self, _topic: str, _queue: int = 1) -> int:
        """Return the handle of a publisher. Stand-in: what it publishes goes nowhere."""
        return self._new()

    def imageTransportSubscribe(self, _topic: str, _callback: Any, _queue: int = 1) -> int:
        """Return the handle of a subscription. Stand-in: it receives nothing."""
        return self._new()

    def getTime(self, _flags: int = 0) -> float:
        """Return the simulated time in seconds. Stand-in: the server has no ROS, whose time it would be."""
        self._note()
        return self._sim.time

    publish = answer(reason=_NO_ROS)
    call = answer(reason="no service answers")
    shutdownPublisher = answer(reason=_NO_ROS)
    shutdownSubscriber = answer(reason=_NO_ROS)
    shutdownServiceServer = answer(reason=_NO_ROS)
    shutdownServiceClient = answer(reason=_NO_ROS)
    publisherTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    subscriberTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    serviceServerTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    serviceClientTreatUInt8ArrayAsString = answer(reason=_NO_ROS)
    imageTransportShutdownSubscriber = answer(reason=_NO_ROS)


class OldRosFunctions(StandIn):
    """V-REP 3.2's plug-in, such as ``simExtROS_enablePublisher``."""

    NOTE = RosPart.NOTE

    def extROS_enablePublisher(self, topic: str, *_values: Any) -> str:
        """Return the topic. Stand-in: nothing is published."""
        self._note()
        return topic

    extROS_disablePublisher = answer(0, reason=_NO_ROS)
    extROS_wakePublisher = answer(0, reason=_NO_ROS)
    extROS_enableSubscriber = answer(1, reason=_NO_ROS)
    extROS_disableSubscriber = answer(True, reason=_NO_ROS)
