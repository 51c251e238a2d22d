"""Actions: goals that take simulated time, with feedback, results and an end before their time.

An action is three services and two topics below ``NAME/_action``. Its handler accepts goals, follows them from one
simulation step to the next, and ends each once.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from concurrent.futures import Future
from typing import Any, Protocol

from simx_server.errors import CommandError

from .endpoints import Message, Offer, Sender, Sent, Served
from .wire.qos import LATCHED

UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(7)
"""States of ``action_msgs/GoalStatus``."""

MOST_ACTIVE = 20
"""Goals of one action that are under way."""

MOST_KEPT = 50
"""Goals of one action that have ended, and whose results are kept."""

MOST_ASKING = 20
"""Requests that wait for the result of one goal."""

NO_ERROR, REJECTED, UNKNOWN_GOAL, TERMINATED = range(4)
"""Codes of ``action_msgs/srv/CancelGoal``."""

_NO_ID = bytes(16)


class Goal:
    """One goal, which ends with a result."""

    def __init__(self, number: bytes, request: Mapping[str, Any], stamp: Mapping[str, int]) -> None:
        """Make a goal that was accepted.

        Args:
            number: its UUID.
            request: the wish of the client; forgotten at the end.
            stamp: when it was accepted.
        """
        self.number, self.stamp = number, stamp
        self.request: Mapping[str, Any] = request
        self.status = EXECUTING
        self.feedback: Callable[[Message], object] = lambda _: None
        """Sends feedback to the clients."""

        self.changed: Callable[[], object] = lambda: None
        self.result: Message = {}
        self.asking: list[Future[Message]] = []

    @property
    def is_active(self) -> bool:
        """Return whether it has not ended."""
        return self.status < SUCCEEDED

    def end(self, status: int, result: Message) -> None:
        """End it with its result: SUCCEEDED, CANCELED or ABORTED. A second end has no effect."""
        if not self.is_active:
            return
        self.status, self.result, self.request = status, result, {}  # a trajectory may be large
        asking, self.asking = self.asking, []
        for each in asking:
            each.set_result(self._answer())
        self.changed()

    def answer(self) -> Message | Future[Message]:
        """Return the response to a request for the result, later while it is under way."""
        if not self.is_active:
            return self._answer()
        if len(self.asking) >= MOST_ASKING:
            raise CommandError(f"{MOST_ASKING} requests wait for the result of this goal already")
        self.asking.append(Future())
        return self.asking[-1]

    def _answer(self) -> Message:
        return {"status": self.status, "result": self.result}

    def info(self) -> Message:
        """Return its ``GoalInfo``."""
        return {"goal_id": {"uuid": self.number}, "stamp": self.stamp}


class Handler(Protocol):
    """Executes the goals of one action. Physics thread."""

    def begin(self, goal: Goal) -> None:
        """Start to execute a goal. Raises CommandError: it is rejected."""
        ...

    def cancel(self, goal: Goal) -> bool:
        """End a goal as its client wants, with CANCELED; return whether that is accepted."""
        ...


class Action:
    """The server of one action. Physics thread."""

    def __init__(
        self,
        name: str,
        kind: str,
        handler: Handler,
        now: Callable[[], Mapping[str, int]],
        *,
        older_lacks: Collection[str] = (),
    ) -> None:
        """Make an action without goals.

        Args:
            name: with a slash in front.
            kind: such as `simulation_interfaces/action/SimulateSteps`.
            handler: executes its goals.
            now: returns the simulated time.
            older_lacks: fields that the feedback lacks in an earlier release of its package; empty: it is the same.
        """
        self._name, self._kind, self._handler, self._now = name, kind, handler, now
        self._goals: dict[bytes, Goal] = {}
        self._status = Sender()
        self._feedbacks = [Sender() for _ in range(2 if older_lacks else 1)]
        self._older_lacks = older_lacks

    def offers(self) -> Iterable[Offer]:
        """Yield its services and topics."""
        root = f"{self._name}/_action"
        yield Served(f"{root}/send_goal", f"{self._kind}_SendGoal", self._send_goal, _rejected)
        yield Served(f"{root}/cancel_goal", "action_msgs/srv/CancelGoal", self._cancel, _not_canceled)
        yield Served(f"{root}/get_result", f"{self._kind}_GetResult", self._get_result, _no_result)
        yield Sent(f"{root}/status", "action_msgs/msg/GoalStatusArray", self._status, LATCHED)
        for number, sender in enumerate(self._feedbacks):
            yield Sent(f"{root}/feedback", f"{self._kind}_FeedbackMessage", sender, is_older=bool(number))

    def active(self) -> list[Goal]:
        """Return the goals that are under way."""
        return [goal for goal in self._goals.values() if goal.is_active]

    def _send_goal(self, request: Mapping[str, Any]) -> Message:
        number = bytes(request["goal_id"]["uuid"])
        if number in self._goals or number == _NO_ID:
            raise CommandError("a goal with this id is known already; each goal has a new one")
        if len(self.active()) >= MOST_ACTIVE:
            raise CommandError(
                f"{MOST_ACTIVE} goals of {self._name} are under way already; wait for their ends"
            )
        goal = Goal(number, request["goal"], self._now())
        goal.feedback = lambda message: self._send_feedback(goal, message)
        self._goals[number] = goal
        try:
            self._handler.begin(goal)
        except CommandError:
            del self._goals[number]
            raise
        goal.changed = self._changed
        self._changed()
        return {"accepted": True, "stamp": goal.stamp}

    def _send_feedback(self, goal: Goal, message: Message) -> None:
        for number, sender in enumerate(self._feedbacks):
            if sender.is_wanted:
                lacks = self._older_lacks if number else ()
                kept = {name: value for name, value in message.items() if name not in lacks}
                sender.send({"goal_id": {"uuid": goal.number}, "feedback": kept})

    def _get_result(self, request: Mapping[str, Any]) -> Message | Future[Message]:
        goal = self._goals.get(bytes(request["goal_id"]["uuid"]))
        return {"status": UNKNOWN} if goal is None else goal.answer()

    def _cancel(self, request: Mapping[str, Any]) -> Message:
        """Cancel one goal, those accepted until a time, both, or all, as the standard of actions has it."""
        number, stamp = (
            bytes(request["goal_info"]["goal_id"]["uuid"]),
            _seconds(request["goal_info"]["stamp"]),
        )
        meant = self._goals.get(number)
        if number != _NO_ID and meant is None:
            return {"return_code": UNKNOWN_GOAL}
        if meant is not None and not meant.is_active and not stamp:
            return {"return_code": TERMINATED}
        has_all = number == _NO_ID and not stamp
        wanted = [each for each in self.active() if has_all or each is meant or _seconds(each.stamp) <= stamp]
        if number != _NO_ID and not stamp:
            wanted = [each for each in wanted if each is meant]
        canceled: list[Message] = []
        for goal in wanted:
            goal.status = CANCELING
            if self._handler.cancel(goal):
                canceled.append(goal.info())
            elif goal.is_active:
                goal.status = EXECUTING
        is_refused = wanted and not canceled
        return {"return_code": REJECTED if is_refused else NO_ERROR, "goals_canceling": canceled}

    def _changed(self) -> None:
        ended = [goal for goal in self._goals.values() if not goal.is_active]
        for goal in ended[: max(len(ended) - MOST_KEPT, 0)]:
            del self._goals[goal.number]
        self._status.send(
            {
                "status_list": [
                    {"goal_info": goal.info(), "status": goal.status} for goal in self._goals.values()
                ]
            }
        )


def _seconds(stamp: Mapping[str, int]) -> float:
    return stamp["sec"] + stamp["nanosec"] * 1e-9


def _rejected(_: str) -> Message:
    return {"accepted": False}


def _not_canceled(_: str) -> Message:
    return {"return_code": REJECTED}


def _no_result(_: str) -> Message:
    return {"status": UNKNOWN}
