"""The gripper of an arm: a script that obeys a signal, as the RG2's does, or joints with motors behind the last one.

A script belongs to a gripper NAME if it reads the integer signal `NAME_open`: 1 opens, 0 closes. Without such a script,
fingers with motors move to their upper limits to open, and to their lower limits to close.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.joints.servo import Rule
from simx_server.scene.objects import ObjectKind

from .arms import BY_VELOCITY, Arm, command

if TYPE_CHECKING:
    from simx_server.parts.communication.signals import Signals
    from simx_server.scripting.scripts import Scripts
    from simx_server.simulation.simulation import Simulation

_FINGER_SPEED = 0.05
"""m/s or rad/s of fingers whose motors keep a velocity."""


@dataclass(frozen=True)
class Gripper:
    """One gripper: a signal, or else joints."""

    signal: str = ""
    joints: tuple[int, ...] = ()

    def name(self, sim: Simulation) -> str:
        """Return the signal or the first joint; empty: the arm has none."""
        return self.signal or next((sim.scene.get(joint).name for joint in self.joints), "")

    def is_open(self, sim: Simulation, signals: Signals) -> bool:
        """Return whether it was told to open, or not told anything."""
        if self.signal:
            return signals.get_integer(self.signal) != 0
        for joint in self.joints:
            if sim.joints.rule(joint) in BY_VELOCITY:
                return sim.joints.target_velocity(joint) >= 0
            _, least, extent = sim.joints.interval(joint)
            return sim.joints.target_position(joint) > least + extent / 2
        return True

    def move(self, sim: Simulation, signals: Signals, *, is_open: bool) -> None:
        """Open or close it. Raises CommandError: the arm has none."""
        if self.signal:
            signals.set_integer(self.signal, int(is_open))
            return
        if not self.joints:
            raise CommandError(
                "the arm has no gripper that is known: a script that reads the signal NAME_open, or joints with motors "
                "behind the arm's last joint"
            )
        for joint in self.joints:
            if sim.joints.rule(joint) in BY_VELOCITY:
                sim.joints.set_target_velocity(joint, _FINGER_SPEED if is_open else -_FINGER_SPEED)
            else:
                _, least, extent = sim.joints.interval(joint)
                command(sim, joint, least + extent if is_open else least)


def gripper_of(sim: Simulation, scripts: Scripts, arm: Arm) -> Gripper:
    """Return the gripper behind an arm's last joint, which may be none."""
    below = sim.scene.descendants(arm.joints.handles[-1])
    for script in scripts.all():
        if script.owner in below:
            signal = f"{sim.scene.get(script.owner).name.partition('#')[0]}_open"
            if signal.encode() in script.source(sim):
                return Gripper(signal)
    moved = (Rule.POSITION, Rule.SPRING, Rule.STIFF_SPRING, *BY_VELOCITY)
    fingers = [
        handle
        for handle in below
        if sim.scene.get(handle).kind == ObjectKind.JOINT and sim.joints.rule(handle) in moved
    ]
    return Gripper(joints=tuple(fingers))
