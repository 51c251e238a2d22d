"""One group of inverse kinematics: its elements, and how their tips are to reach their targets."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import field, replace

import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass

from .chain import Element, Joints
from .solver import Calculation, Result, Solution

_DEFAULT = Calculation()


@dataclass
class Group:
    """One group; scripts may change everything but its name until the simulation stops."""

    name: str
    elements: list[Element]
    how: Calculation = _DEFAULT
    explicit: bool = False
    """The group is handled only when a script requests it."""
    enabled: bool = True
    """Only an enabled group moves joints."""
    restore: frozenset[str] = frozenset()
    """Of position and orientation: the joints stay where they are when the tips do not reach this part."""
    after: str = ""
    """Name of another group: this one is handled only when that one has failed."""
    ignores_steps: bool = False
    """One iteration may move a joint as far as it likes."""
    margins: tuple[float, float] = (0.0, 0.0)
    """How far slides (m) and hinges (rad) stay away from their limits."""
    result: Result = field(default=Result.NOT_PERFORMED)
    """The result of the last handling."""
    checked: tuple[int, ...] | None = None
    """The joints of the last check, which the Jacobian is for; None after a handling: those in IK mode."""


def as_asked(group: Group, joints: Joints) -> Joints:
    """Return the joints with the steps and the limits that a group asks for."""
    if group.ignores_steps:
        joints = replace(joints, max_step=np.full(len(joints.max_step), math.inf))
    if any(group.margins):
        slide, hinge = group.margins
        margins = np.where(joints.is_hinge, hinge, slide)
        margins = np.minimum(margins, (joints.high - joints.low) / 2)
        joints = replace(joints, low=joints.low + margins, high=joints.high - margins)
    return joints


def must_stay(elements: Sequence[Element], restore: Collection[str], solution: Solution) -> bool:
    """Return whether the joints keep their positions, since the tips do not reach what they must reach.

    Args:
        elements: those of the group.
        restore: what must be reached, of position and orientation.
        solution: the result of the group.
    """
    linear = max(element.precision[0] for element in elements)
    angular = max(element.precision[1] for element in elements)
    misses = {"position": solution.distance > linear, "orientation": solution.angle > angular}
    return solution.result != Result.SUCCESS and any(misses[part] for part in restore)
