"""A client of an action of ROS 2, by its services and topics, over a plain Zenoh peer."""

from __future__ import annotations

from typing import Any

from ros2_world import Peer

from simx_server.ros2_messages import BY_NAME

EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(2, 7)


class ActionClient:
    """A client of an action, by its services and topics."""

    def __init__(self, peer: Peer, name: str, kind: str) -> None:
        self.peer, self._name, self._kind = peer, name, kind
        feedback, status = BY_NAME[f"{kind}_FeedbackMessage"], BY_NAME["action_msgs/msg/GoalStatusArray"]
        self._feedback_type, self._status_type = feedback, status
        self.feedback_key = f"0/{name}/_action/feedback/{feedback.dds_name}/{feedback.hash}"
        self.status_key = f"0/{name}/_action/status/{status.dds_name}/{status.hash}"
        peer.listen(self.feedback_key)
        peer.listen(self.status_key)

    def send(self, number: int, **goal: Any) -> bool:
        request = {"goal_id": {"uuid": [number] * 16}, "goal": goal}
        return self.peer.call(f"{self._kind}_SendGoal", f"{self._name}/_action/send_goal", request)[
            "accepted"
        ]

    def result(self, number: int) -> dict[str, Any]:
        request = {"goal_id": {"uuid": [number] * 16}}
        return self.peer.call(f"{self._kind}_GetResult", f"{self._name}/_action/get_result", request)

    def cancel(self, number: int, stamp: float = 0.0) -> dict[str, Any]:
        info = {"goal_id": {"uuid": [number] * 16}, "stamp": {"sec": int(stamp), "nanosec": 0}}
        kind = "action_msgs/srv/CancelGoal"
        return self.peer.call(kind, f"{self._name}/_action/cancel_goal", {"goal_info": info})

    def next_feedback(self) -> dict[str, Any]:
        return self._feedback_type.decode(self.peer.next(self.feedback_key).payload)["feedback"]

    def next_status(self, number: int, wanted: int) -> None:
        def has(sent: Any) -> bool:
            each = self._status_type.decode(sent.payload)["status_list"]
            return (number, wanted) in [
                (int(one["goal_info"]["goal_id"]["uuid"][0]), one["status"]) for one in each
            ]

        self.peer.next(self.status_key, has)
