"""Keep joints controllable that move very light links: added inertia, and less damping.

A motor is a constraint, whose softness is a share of the joint's inverse inertia if all other joints are free. Where a
link is thousands of times lighter than what hangs on it, as in hands and at ball joints made of three hinges, that is
far softer than the motor of the held robot, and the joint would swing around its target for seconds. The same happens
with a damping that stops the links within a physics step.
"""

from __future__ import annotations

import logging
from typing import Any

import mujoco

from .names import some

logger = logging.getLogger(__name__)

_MOST_RATIO = 1e2
"""Largest ratio of the inertia that a joint moves to that which it moves if all other joints are free."""

_SHORTEST = 0.05
"""Seconds in which damping alone may stop a link: ten physics steps of the default scene."""

_SINGLE = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


def steady_light_links(spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """Add a hundredth of the moved inertia where the ratio is larger than a hundred; limit the damping.

    Args:
        spec: the robot.
        model: the compiled spec.
    """
    damped: list[str] = []
    heavier: list[str] = []
    joints: dict[str, Any] = {joint.name: joint for joint in spec.joints if joint.type in _SINGLE}
    for index in range(model.njnt):
        joint = joints.get(model.joint(index).name)
        dof = int(model.jnt_dofadr[index])
        moved = float(model.dof_M0[dof])
        if joint is None or moved <= 0:
            continue
        if joint.damping[0] > moved / _SHORTEST:
            joint.damping[0] = moved / _SHORTEST
            damped.append(joint.name)
        if moved * float(model.dof_invweight0[dof]) > _MOST_RATIO:
            joint.armature = moved / _MOST_RATIO
            heavier.append(joint.name)
    if damped:
        logger.info(
            "the damping of %s is smaller than in the file: it would stop these joints at once", some(damped)
        )
    if heavier:
        logger.info("%s get inertia, since their links are very light", some(heavier))
