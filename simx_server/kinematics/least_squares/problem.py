"""The problem of a solver as plain arrays: frames that move, tips, axes, and limits of joints.

Frames that no joint of the solver moves against each other are one frame: between two of its joints lies one fixed
pose, however many bodies MuJoCo has there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.kinematics.chain import Arm, Joints
from simx_server.kinematics.scratch import Array
from simx_server.scene.poses.poses import Pose, Quaternion, compose, conjugate, multiply, normalised
from simx_server.simulation.sleepers import kinematics


class LinkKind(IntEnum):
    """How a link moves against the one before it."""

    HINGE = 0
    """About z of its frame."""
    SLIDE = 1
    """Along z of its frame."""
    BALL = 2


_KINDS = {
    int(mujoco.mjtJoint.mjJNT_HINGE): LinkKind.HINGE,
    int(mujoco.mjtJoint.mjJNT_SLIDE): LinkKind.SLIDE,
    int(mujoco.mjtJoint.mjJNT_BALL): LinkKind.BALL,
}


class Problem(NamedTuple):
    """l links, each moved by one joint, b of them by a spherical one, and e elements; m columns, see `Joints`."""

    links: NDArray[np.int32]
    """(l, 3) the link before it (-1: the world), its `LinkKind`, its first column. Links before others come first."""
    present: Array
    """(l, 8) where it is: the joint's anchor and axis in the world, its value, and the value with which the anchor is
    that. The last four numbers are 0 for a spherical joint."""
    balls: Array
    """(b, 8) world orientations of what spherical joints carry: as it is, and with the joint at 0."""
    ends: NDArray[np.int32]
    """(e, 3) the link that carries the tip (-1: the world), that of the axes for coordinates, and the constraints."""
    poses: Array
    """(e, 18) world poses of tip and axes, weights and precisions of position and orientation."""
    used: NDArray[np.bool_]
    """(e, m) which columns belong to joints between base and tip."""
    bounds: Array
    """(4, m) lower and upper limits, the longest step, and the square root of how readily a joint moves."""


def problem_of(model: mujoco.MjModel, data: mujoco.MjData, joints: Joints, arms: Sequence[Arm]) -> Problem:
    """Return the problem of moving joints while everything else stays where a state has it.

    Raises:
        NoRotation: a spherical joint has no value, as after physics that has diverged.
    """
    kinematics(model, data)
    columns: dict[int, int] = {}
    for column, joint in enumerate(model.dof_jntid[joints.dofs].tolist()):
        columns.setdefault(joint, column)
    ids = sorted(columns)
    kinds, bodies = model.jnt_type[ids].tolist(), model.jnt_bodyid[ids].tolist()
    carrier = _carriers(model, bodies)
    links = [
        (carrier(body, number), _KINDS[kind], columns[joint])
        for number, (joint, kind, body) in enumerate(zip(ids, kinds, bodies, strict=True))
    ]
    present = np.zeros((len(ids), 8))
    present[:, :3], present[:, 3:6] = data.xanchor[ids], data.xaxis[ids]
    addresses = model.jnt_qposadr[ids]
    present[:, 6], present[:, 7] = data.qpos[addresses], model.qpos0[addresses]
    balls: list[Quaternion] = []
    for number, (_, kind, _) in enumerate(links):
        if kind == LinkKind.BALL:  # MuJoCo allows no turn after it in the same body
            present[number, 3:] = 0.0
            address = addresses[number]
            value = normalised(data.qpos[address : address + 4].tolist())
            turn = pose_of_body(data, bodies[number])[1]
            balls += [turn, multiply(turn, conjugate(value))]
    ends = [
        (carrier(arm.body, len(ids)), carrier(arm.base_body, len(ids)), int(arm.element.constraints))
        for arm in arms
    ]
    poses: list[tuple[float, ...]] = []
    for arm in arms:
        tip = compose(pose_of_body(data, arm.body), arm.tip)
        base = compose(pose_of_body(data, arm.base_body), arm.base)
        element = arm.element
        poses.append((*tip[0], *tip[1], *base[0], *base[1], *element.weights, *element.precision))
    return Problem(
        np.array(links, dtype=np.int32).reshape(-1, 3),
        present,
        np.array(balls, dtype=float).reshape(-1, 8),
        np.array(ends, dtype=np.int32).reshape(-1, 3),
        np.array(poses, dtype=float).reshape(-1, 18),
        np.array([arm.used for arm in arms], dtype=bool).reshape(len(arms), -1),
        np.array([joints.low, joints.high, joints.max_step, np.sqrt(joints.weights)], dtype=float),
    )


def pose_of_body(data: mujoco.MjData, body: int) -> Pose:
    """Return a body's world pose in a scratch state."""
    return tuple(data.xpos[body].tolist()), tuple(data.xquat[body].tolist())  # type: ignore[return-value]


def _carriers(model: mujoco.MjModel, bodies: Sequence[int]) -> Callable[[int, int], int]:
    """Return a function that returns which of the first links carries a body, -1 for none.

    `bodies` are those that the links move. The joints of a body act in the order of the links, after those of the
    bodies above it.
    """
    of_body: dict[int, list[int]] = {}
    for number, body in enumerate(bodies):
        of_body.setdefault(body, []).append(number)
    parents = model.body_parentid

    def carrier(body: int, count: int) -> int:
        while True:
            found = [number for number in of_body.get(body, ()) if number < count]
            if found or body == 0:
                return found[-1] if found else -1
            body = int(parents[body])

    return carrier
