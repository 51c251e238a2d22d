"""The action ``GripperCommand`` of one gripper: move its driven joints to a position, and tell what it holds.

A joint with a position controller gets the position as its target. Another one is driven by its velocity until it is
there; it keeps pushing when something stops it, as a gripper that holds an object does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from simx_server.errors import CommandError
from simx_server.joints.joints import Joints
from simx_server.simulation.simulation import Simulation, SimulationState

from ..actions import ABORTED, CANCELED, SUCCEEDED, Goal
from ..content.joint_commands import LARGEST
from ..endpoints import Context, Message, Moment
from ..table_call import Call

TOLERANCE = 0.001
"""Distance from the goal, m or rad, at which it is reached, unless a joint moves less in one step."""

SPEED = 0.05
"""Velocity of joints without a position controller, m/s or rad/s."""

STILL = 0.002
"""Velocity below which a joint stands, m/s or rad/s."""

PATIENCE = 0.5
"""Simulated seconds for which joints stand before they count as stalled."""


class GripperHandler:
    """Executes the commands of one gripper, one at a time. Physics thread."""

    def __init__(self, context: Context) -> None:
        self._client = context.client
        self._simulation: Simulation = context.world.simulation
        self.handles: Sequence[int] = ()
        self.has_targets = False
        """See `finding.Arm`."""

        self._goal: Goal | None = None
        self._moved = 0
        """Simulated nanoseconds when a joint moved last."""

    @property
    def _joints(self) -> Joints:
        return self._simulation.joints

    def begin(self, goal: Goal) -> None:
        """Start to move. Raises CommandError: the simulation is stopped, or a number is not valid."""
        command = goal.request["command"]
        if self._simulation.state is SimulationState.STOPPED:
            raise CommandError("the simulation is stopped; start it first")
        if not (abs(command["position"]) <= LARGEST and 0 <= command["max_effort"] <= LARGEST):
            raise CommandError(
                f"the position {command['position']:g} or the effort {command['max_effort']:g} is not valid; "
                f"valid: up to {LARGEST:g}, and an effort of 0 for that of the joint"
            )
        if self._goal is not None:
            self._end(CANCELED)
        self._goal, self._moved = goal, self._now()
        self._client.execute(self._first_calls(command["position"], command["max_effort"]))

    def cancel(self, goal: Goal) -> bool:
        """Hold the joints where they are."""
        if self._goal is not goal:
            return False
        self._end(CANCELED)
        self._client.execute(self._holding_calls())
        return True

    def abort(self, _: str) -> None:
        """Abort the command that is under way; its result has no text."""
        self._end(ABORTED)

    def is_under_way(self) -> bool:
        """Return whether there is a command."""
        return self._goal is not None

    def due(self, moment: Moment) -> Sequence[Call]:
        """Return the calls that stop joints at their goal, and end the command when they are there, or stand."""
        goal = self._goal
        if goal is None:
            return ()
        if any(handle not in self._simulation.scene.objects for handle in self.handles):
            self._end(ABORTED)
            return ()
        wanted = goal.request["command"]["position"]
        goal.feedback(self._state(stalled=False, reached=False))
        if self._is_reached(wanted):
            self._end(SUCCEEDED)
            return [] if self.has_targets else list(self._holding_calls())
        if any(abs(self._joints.velocity(handle)) > STILL for handle in self.handles):
            self._moved = moment.nanoseconds
        elif moment.nanoseconds - self._moved > PATIENCE * 1e9:
            self._end(SUCCEEDED, stalled=True)
        return ()

    def _is_reached(self, wanted: float) -> bool:
        step = 0.0 if self.has_targets else SPEED * self._simulation.time_step
        return all(abs(self._joints.position(handle) - wanted) <= TOLERANCE + step for handle in self.handles)

    def _first_calls(self, position: float, effort: float) -> Iterator[Call]:
        for handle in self.handles:
            if effort:
                yield Call("simxSetJointForce", [handle, effort])
            if self.has_targets:
                yield Call("simxSetJointTargetPosition", [handle, position])
            else:
                way = position - self._joints.position(handle)
                yield Call("simxSetJointTargetVelocity", [handle, math.copysign(SPEED, way)])

    def _holding_calls(self) -> Iterator[Call]:
        for handle in self.handles:
            if self.has_targets:
                yield Call("simxSetJointTargetPosition", [handle, self._joints.position(handle)])
            else:
                yield Call("simxSetJointTargetVelocity", [handle, 0.0])

    def _end(self, status: int, *, stalled: bool = False) -> None:
        goal, self._goal = self._goal, None
        if goal is not None:
            reached = status == SUCCEEDED and not stalled
            goal.end(status, self._state(stalled=stalled, reached=reached))

    def _state(self, *, stalled: bool, reached: bool) -> Message:
        """Return the mean position of the joints, and the sum of their forces."""
        present = [each for each in self.handles if each in self._simulation.scene.objects]
        positions = [self._joints.position(handle) for handle in present]
        return {
            "position": sum(positions) / max(len(positions), 1),
            "effort": -sum(map(self._joints.force, present)),
            "stalled": stalled,
            "reached_goal": reached,
        }

    def _now(self) -> int:
        return Moment.of(self._simulation.step_count, self._simulation.time_step).nanoseconds
