"""The namespace ``simROS2``, and its actions, which are stand-ins."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

from simx_server.scripting.interpreter import Constant
from simx_server.sim_api.stand_ins.answers import answer

from .interfaces import Ros2InterfaceFunctions
from .part import Ros2Part
from .quality import DURABILITY, RELIABILITY
from .services import Ros2ServiceFunctions
from .topics import Ros2TopicFunctions

_NO_ACTIONS = "the server has no actions"


def _numbered(*names: str) -> dict[str, int]:
    return {name: number for number, name in enumerate(names)}


class Ros2ActionFunctions(Ros2Part):
    """Actions, which no other node sees."""

    def createActionClient(self, _action: str, _kind: str, *_callbacks: Any) -> int:
        """Return the handle of a client. Stand-in: no action answers it."""
        return self._without_actions()

    def createActionServer(self, _action: str, _kind: str, *_callbacks: Any) -> int:
        """Return the handle of an action. Stand-in: it is never asked."""
        return self._without_actions()

    def _without_actions(self) -> int:
        if self._world.ros2_topics.node is not None:
            self._say_once("simROS2: actions of scripts are not connected")
        return self._new()

    sendGoal = answer(False, reason="no action answers")
    cancelLastGoal = answer(False, reason="no action answers")
    shutdownActionClient = answer(reason=_NO_ACTIONS)
    shutdownActionServer = answer(reason=_NO_ACTIONS)
    actionClientTreatUInt8ArrayAsString = answer(reason=_NO_ACTIONS)
    actionServerTreatUInt8ArrayAsString = answer(reason=_NO_ACTIONS)
    actionServerPublishFeedback = answer(reason=_NO_ACTIONS)
    actionServerActionAbort = answer(reason=_NO_ACTIONS)
    actionServerActionSucceed = answer(reason=_NO_ACTIONS)
    actionServerActionCanceled = answer(reason=_NO_ACTIONS)
    actionServerActionExecute = answer(reason=_NO_ACTIONS)
    actionServerActionIsCanceling = answer(False, reason=_NO_ACTIONS)
    actionServerActionIsActive = answer(False, reason=_NO_ACTIONS)
    actionServerActionIsExecuting = answer(False, reason=_NO_ACTIONS)


class SimRos2(Ros2TopicFunctions, Ros2ServiceFunctions, Ros2InterfaceFunctions, Ros2ActionFunctions):
    """The functions of ``simROS2``."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = MappingProxyType(
        {
            "clock_type": _numbered("ros", "system", "steady"),
            "action_result_code": _numbered("succeeded", "aborted", "canceled", "unknown"),
            "goal_response": _numbered("reject", "accept_and_execute", "accept_and_defer"),
            "cancel_response": _numbered("reject", "accept"),
            "qos_history_policy": _numbered("system_default", "keep_last", "keep_all"),
            "qos_reliability_policy": dict(RELIABILITY),
            "qos_durability_policy": dict(DURABILITY),
            "qos_liveliness_policy": _numbered("system_default", "automatic", "manual_by_topic"),
        }
    )

    def spinSome(self) -> None:
        """Do nothing: messages arrive between two simulation steps."""
        self._note()

    importInterface = answer(reason="the types are those that the server knows")
