"""Poses of bodies from joint values: V-REP's two frames of each joint, and moving a link relative to its joint.

In MuJoCo a joint is a property of the body it moves, given in that body's frame; in V-REP it is an object between two
others. So to move a link relative to its joint means to move the body, and the joint back in the body's frame.
"""

from __future__ import annotations

from contextlib import nullcontext
from typing import TYPE_CHECKING

import mujoco

from simx_server.scene.editing.model_changes import undone_on_failure
from simx_server.scene.editing.recompile import edit

from .poses import (
    IDENTITY,
    NO_TURN,
    Pose,
    Quaternion,
    about,
    add,
    compose,
    conjugate,
    inverse,
    multiply,
    normalised,
    rotate,
    scale,
    subtract,
    turn_z_to,
)

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene, Posed


def body_pose(sim: Posed, body: int) -> Pose:
    """Return the world pose of a body (0: the world)."""
    if body == 0:
        return IDENTITY
    data = sim.data
    return tuple(data.xpos[body].tolist()), tuple(data.xquat[body].tolist())  # type: ignore[return-value]


def body_local(sim: LiveScene, body: int) -> Pose:
    """Return a body's pose in its parent's frame before its own joints moved it; of a mocap body its world pose."""
    mocap = int(sim.model.body_mocapid[body])
    position, quat = (
        (sim.model.body_pos[body], sim.model.body_quat[body])
        if mocap < 0
        else (sim.data.mocap_pos[mocap], sim.data.mocap_quat[mocap])
    )
    return tuple(position.tolist()), tuple(quat.tolist())  # type: ignore[return-value]


def start_pose(sim: LiveScene, body: int) -> Pose:
    """Return the world pose of a body's frame before its own joints moved it."""
    return compose(body_pose(sim, int(sim.model.body_parentid[body])), body_local(sim, body))


def joint_frames(sim: LiveScene, joint: int) -> tuple[Pose, Pose]:
    """Return the world poses of a joint's fixed and moving frame.

    Both lie at the anchor; z is the axis, and where the axis is the body's own z the frame is the body's at value 0
    (else turned by the smallest rotation that takes z to the axis; placing a body relative to its joint does not
    change the joint). Moving = fixed, turned about or shifted along z by the joint value. Several joints of one body
    act one after the other, as in `mj_kinematics`.
    """
    body = int(sim.model.jnt_bodyid[joint])
    return _joint_chain(sim, body, joint)[0]


def joint_separation(sim: LiveScene, body: int) -> Pose:
    """Return a body's pose in the frame given by its joints' values: the identity, unless they were separated."""
    last = int(sim.model.body_jntadr[body] + sim.model.body_jntnum[body]) - 1
    return compose(inverse(_joint_chain(sim, body, last)[1]), body_pose(sim, body))


def _joint_chain(sim: LiveScene, body: int, last: int) -> tuple[tuple[Pose, Pose], Pose]:
    """Return (fixed and moving frame of the joint `last`, the body's pose after it), from the joint values alone."""
    model, data = sim.model, sim.data
    position, quat = start_pose(sim, body)
    fixed = moving = IDENTITY
    for index in range(int(model.body_jntadr[body]), last + 1):
        address = int(model.jnt_qposadr[index])
        offset = model.jnt_pos[index].tolist()
        axis = model.jnt_axis[index].tolist()
        anchor = add(position, rotate(quat, offset))
        kind = model.jnt_type[index]
        if kind == mujoco.mjtJoint.mjJNT_BALL.value:
            turn, value, rest = normalised(data.qpos[address : address + 4].tolist()), 0.0, 0.0
        else:
            value, rest = float(data.qpos[address]), float(model.qpos0[address])
            turn = about(axis, value - rest) if kind == mujoco.mjtJoint.mjJNT_HINGE.value else NO_TURN
        align = _alignment(sim, index)
        if kind == mujoco.mjtJoint.mjJNT_SLIDE.value:
            along = rotate(quat, axis)
            turned = multiply(quat, align)
            fixed = subtract(anchor, scale(along, rest)), turned
            moving = add(anchor, scale(along, value - rest)), turned
            position = add(position, scale(along, value - rest))
        else:
            zero = multiply(quat, about(axis, -rest)) if rest else quat
            after = multiply(quat, turn)
            fixed = anchor, multiply(zero, align)
            moving = anchor, multiply(after, align)
            quat = after
            position = subtract(anchor, rotate(quat, offset))
    return (fixed, moving), (position, quat)


def shift_beyond(sim: LiveScene, body: int, staying: int, delta: Pose) -> None:
    """Move a body, and those of its joints that come after the first `staying` ones, by a motion of the world.

    The first joints stay where they are, with their values. The caller sets velocities.
    """
    model, data = sim.model, sim.data
    first = int(model.body_jntadr[body])
    joints = range(first, first + staying)
    start = start_pose(sim, body)
    # The motion of the staying joints, in the world, which applies to all that comes after them.
    done = compose(_joint_chain(sim, body, first + staying - 1)[1], inverse(start))
    new_start = _unit(compose(compose(inverse(done), compose(delta, done)), start))
    back = _unit(compose(inverse(new_start), start))
    alignments = [normalised(multiply(back[1], _alignment(sim, joint))) for joint in joints]
    parent = body_pose(sim, int(model.body_parentid[body]))
    with undone_on_failure(sim) if staying else nullcontext():
        position, quat = compose(inverse(parent), new_start)
        model.body_pos[body], model.body_quat[body] = position, normalised(quat)
        for joint, alignment in zip(joints, alignments, strict=True):
            model.jnt_pos[joint] = compose(back, (tuple(model.jnt_pos[joint].tolist()), NO_TURN))[0]
            model.jnt_axis[joint] = rotate(back[1], model.jnt_axis[joint].tolist())
            if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL.value:
                address = int(model.jnt_qposadr[joint])
                value: Quaternion = tuple(data.qpos[address : address + 4].tolist())  # type: ignore[assignment]
                data.qpos[address : address + 4] = multiply(multiply(back[1], value), conjugate(back[1]))
            sim.joints.align(joint, alignment)
        if staying:
            sim.joints.masses_changed()
            if model.body_simple[body] and model.body_dofnum[body] > 1:
                _compile_anew(sim, model.body(body).name)
    sim.model_edited()


def _compile_anew(sim: LiveScene, name: str) -> None:
    """Compile a body again so that MuJoCo stores the inertia that couples its axes.

    MuJoCo leaves it out for a body whose joint lay in its centre of mass when it was compiled.
    """

    def surgery(spec: mujoco.MjSpec) -> None:
        spec.body(name).simple = 0

    with sim.interruptions.unasked_edit():
        edit(sim, surgery, set())


def _unit(pose: Pose) -> Pose:
    """Normalise a pose: rounding must not grow from one placing to the next."""
    return pose[0], normalised(pose[1])


def _alignment(sim: LiveScene, joint: int) -> Quaternion:
    """Return the rotation from a body's axes to those of its joint's frame."""
    known = sim.joints.alignment(joint)
    if known is not None:
        return known
    if sim.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL.value:
        return NO_TURN
    return turn_z_to(sim.model.jnt_axis[joint].tolist())
