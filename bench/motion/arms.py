"""Arms under position control: lag, force and overshoot, beside V-REP's law and the inverse dynamics."""

from __future__ import annotations

import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from bench.motion.opened import Array, Running, running
from simx_server.joints.servo import Rule
from simx_server.joints.state import VREP_DYNAMICS_STEP

_SPEED = 0.05
"""rad/s or m/s at which all joints move."""


@dataclass(frozen=True)
class Arm:
    """How an arm follows."""

    joints: int
    lag: float
    """Greatest difference of the steady lag behind moving targets from V-REP's, rad or m."""
    force: float
    """Greatest difference of the reported force from the inverse dynamics while all joints move, as a part of the
    greatest force of the joint, or of 0.1 N m.
    """
    peak: float
    """Greatest force in free motion, as a part of the joint's maximum force."""
    overshoot: float
    """Greatest overshoot of a step of one degree, as a part of it."""
    share: float


def arm(model: str) -> Arm:
    """Move all position controlled joints of a shipped model evenly, then one after the other by a degree."""
    with running("", model) as one:
        joints = one.world.simulation.joints
        moved = _driven(one)
        step = one.world.simulation.time_step
        start = np.array([joints.position(handle) for handle in moved])
        signs = np.array([(-1.0) ** number for number in range(len(moved))])
        _aim(one, moved, start)
        one.step(20)
        errors: list[Array] = []
        reported: list[Array] = []
        for number in range(round(1.5 / step)):
            _aim(one, moved, start + signs * _SPEED * step * (number + 1))
            wanted = _inverse(one, moved)
            reported.append(np.array([-joints.force(handle) for handle in moved]))
            errors.append(wanted - reported[-1])
        behind = np.array([abs(joints.target_position(h) - joints.position(h)) for h in moved])
        by_law = np.array([_lag(one, handle) * _SPEED * step for handle in moved])
        largest = np.abs(reported).max(axis=0)
        most = np.array([joints.max_force(handle) for handle in moved])
        overshoot = max(_overshoot(one, moved, number) for number in range(len(moved)))
        return Arm(
            joints=len(moved),
            lag=float(np.abs(behind - by_law).max()),
            force=float((np.abs(errors[3:]).max(axis=0) / np.maximum(largest, 0.1)).max()),
            peak=float((largest / most).max()),
            overshoot=overshoot,
            share=one.share,
        )


def _driven(one: Running) -> list[int]:
    """Return the position controlled joints that turn freely in both directions."""
    joints, scene = one.world.simulation.joints, one.world.simulation.scene
    found: list[int] = []
    for handle, item in scene.objects.items():
        if item.element != "joint" or joints.rule(handle) != Rule.POSITION:
            continue
        _, low, extent = joints.interval(handle)
        if low + 0.7 < joints.position(handle) < low + extent - 0.7:
            found.append(handle)
    return found


def _aim(one: Running, handles: list[int], targets: Array) -> None:
    for handle, target in zip(handles, targets, strict=True):
        one.world.simulation.joints.set_target_position(handle, float(target))


def _lag(one: Running, handle: int) -> float:
    """Return V-REP's steady lag behind an even motion, in the ways of the target per simulation step."""
    left = (1 - min(one.world.simulation.joints.state(handle).p, 1.0)) ** (
        one.world.simulation.time_step / VREP_DYNAMICS_STEP
    )
    return left / (1 - left)


def _inverse(one: Running, handles: list[int]) -> Array:
    """Make a simulation step; return the mean force that its motion needs at each joint, by the inverse dynamics."""
    bare = copy.copy(one.model)
    bare.dof_frictionloss[:] = 0  # motors are MuJoCo's friction loss
    scratch = mujoco.MjData(bare)
    dofs = [
        int(bare.joint(one.world.simulation.scene.get(handle).element_name).dofadr[0]) for handle in handles
    ]
    forces: list[Array] = []

    def compare(_index: int, _count: int, is_over: bool) -> None:
        if is_over:
            scratch.qacc[:] = one.data.qacc
            mujoco.mj_inverse(bare, scratch)
            forces.append(scratch.qfrc_inverse[dofs].copy())
        else:
            scratch.qpos[:], scratch.qvel[:] = one.data.qpos, one.data.qvel

    one.world.simulation.joints.controllers.accompany(compare)
    one.step(1)
    one.world.simulation.joints.controllers.accompany(None)
    return np.mean(forces, axis=0)


def _overshoot(one: Running, handles: list[int], number: int) -> float:
    """Return how far beyond a step of one degree a joint moves, as a part of the step."""
    joints, degree = one.world.simulation.joints, float(np.radians(1.0))
    _aim(one, handles, np.array([joints.position(handle) for handle in handles]))
    one.step(20)
    start = joints.position(handles[number])
    joints.set_target_position(handles[number], start + degree)
    farthest = 0.0
    for _ in range(8):
        one.step(1)
        farthest = max(farthest, joints.position(handles[number]) - start)
    return max(0.0, farthest / degree - 1)
