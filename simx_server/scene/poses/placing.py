"""World poses of objects, read from and written to the model and the state.

Frames: a body's own; a joint's z is its axis (see `joint_frames`); a camera's is turned by pi about y against MuJoCo's,
so that it points along +z with +x to the left; a light shines along +z (MuJoCo has no roll about it).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np
import numpy.typing as npt

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind, SceneObject

from .joint_chain import body_pose, joint_frames, shift_beyond
from .poses import (
    IDENTITY,
    NO_TURN,
    Pose,
    Quaternion,
    compose,
    inverse,
    multiply,
    normalised,
    rotate,
    turn_z_to,
)

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_HALF_TURN_Y: Quaternion = (0.0, 0.0, 1.0, 0.0)
_TURN_BACK_Y: Quaternion = (0.0, 0.0, -1.0, 0.0)


def object_pose(sim: LiveScene, item: SceneObject) -> Pose:
    """Return the world pose of an object; of a joint its fixed frame. Call `sim.refresh()` before."""
    if item.element == "body":
        return body_pose(sim, item.id)
    if item.element == "joint":
        return joint_frames(sim, item.id)[0]
    if item.element == "tendon":
        return _tendon_pose(sim, item.id)
    return compose(body_pose(sim, item.body), _local_pose(sim, item))


def pose_in_body(sim: LiveScene, item: SceneObject) -> Pose | None:
    """Return the pose of an object in its body's frame; None: it has none that stays the same while bodies move."""
    if item.element in ("site", "geom"):
        return _local_pose(sim, item)
    fixed = mujoco.mjtCamLight.mjCAMLIGHT_FIXED.value
    modes = {"camera": sim.model.cam_mode, "light": sim.model.light_mode}.get(item.element)
    return _local_pose(sim, item) if modes is not None and modes[item.id] == fixed else None


def moving_pose(sim: LiveScene, item: SceneObject) -> Pose:
    """Return the world pose of the frame for an object's children: a joint's moving frame, else its own."""
    if item.element == "joint":
        return joint_frames(sim, item.id)[1]
    if item.element == "tendon":
        pose = _tendon_pose(sim, item.id)
        return compose(pose, ((0.0, 0.0, sim.joints.position(item.handle)), NO_TURN))
    return object_pose(sim, item)


def element_pose(sim: LiveScene, item: SceneObject) -> Pose:
    """Return the world pose of the MuJoCo element itself: it differs for cameras, which point along -z there."""
    pose = object_pose(sim, item)
    return (pose[0], multiply(pose[1], _TURN_BACK_Y)) if item.element == "camera" else pose


def place(
    sim: LiveScene, item: SceneObject, pose: Pose, *, with_joints: bool = False, present: Pose | None = None
) -> None:
    """Give an object a world pose, with everything below it; moving bodies below lose their velocity.

    A link leaves its joint where it is, as in V-REP, unless `with_joints`; the body and later joints that a joint
    carries move along. Objects below in the tree that the body does not carry (a free body under a gripper, a body
    under a dummy) are moved by the same amount. `present`: the object's pose now, if it is known. Raises CommandError
    for a joint on a tendon.
    """
    sim.refresh()
    before = object_pose(sim, item) if present is None else present
    if _followers(sim, item):
        carry_followers(sim, item, lambda: _place_element(sim, item, before, pose, with_joints))
    else:
        _place_element(sim, item, before, pose, with_joints)
        sim.changed()


def carry_followers(sim: LiveScene, item: SceneObject, move: Callable[[], None]) -> None:
    """Move an object or its joint's value with `move`, and all objects below that the model does not carry."""
    sim.refresh()
    before = moving_pose(sim, item)
    followers = [(sim.scene.get(h), object_pose(sim, sim.scene.get(h))) for h in _followers(sim, item)]
    move()
    sim.changed()
    if not followers:
        return
    sim.refresh()
    delta = compose(moving_pose(sim, item), inverse(before))
    for follower, follower_pose in followers:
        sim.refresh()
        place_without_followers(sim, follower, compose(delta, follower_pose))


def rest(sim: LiveScene, item: SceneObject) -> None:
    """Take the velocity of what `place` moves, as that does."""
    had_any = False
    for each in (item, *map(sim.scene.get, _followers(sim, item))):
        if each.element in ("body", "joint") or is_linking_sensor(sim, each):
            had_any = _stop_motion(sim, each.body) or had_any
    if had_any:
        sim.changed()


def place_without_followers(sim: LiveScene, item: SceneObject, pose: Pose) -> None:
    """Give a child of a placed object a world pose: it moves with its joints."""
    _place_element(sim, item, object_pose(sim, item), pose, with_joints=True)
    sim.changed()


def place_all(sim: LiveScene, placed: Sequence[tuple[SceneObject, Pose]]) -> None:
    """Place several objects as `place` does, but at less cost; none of them is below another one."""
    sim.refresh()
    moves: list[tuple[SceneObject, Pose, Pose]] = []
    for item, pose in placed:
        before = object_pose(sim, item)
        moves.append((item, before, pose))
        delta = compose(pose, inverse(before))
        for handle in _followers(sim, item):
            follower = sim.scene.get(handle)
            pose_before = object_pose(sim, follower)
            moves.append((follower, pose_before, compose(delta, pose_before)))
    for item, before, pose in moves:
        _place_element(sim, item, before, pose, with_joints=item.element != "joint")
    sim.changed()


def carrier_body(sim: LiveScene, item: SceneObject) -> int:
    """Return the body that an object's world pose is fixed to: for a joint the parent of its body."""
    return int(sim.model.body_parentid[item.body]) if item.element == "joint" else item.body


def is_linking_sensor(sim: LiveScene, item: SceneObject) -> bool:
    """Return whether the object is a force sensor between a body and its parent (not a leaf)."""
    return item.kind == ObjectKind.FORCE_SENSOR and any(
        sim.scene.objects[child].body == item.body and sim.scene.objects[child].element == "body"
        for child in sim.scene.children(item.handle)
    )


def is_carried(model: mujoco.MjModel, body: int, carrier: int) -> bool:
    """Return whether `carrier` is the body itself or an ancestor of it."""
    while body != carrier and body > 0:
        body = int(model.body_parentid[body])
    return body == carrier


def free_joint(model: mujoco.MjModel, body: int) -> int:
    """Return the free joint of a body, or -1."""
    joint = int(model.body_jntadr[body])
    return joint if joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE.value else -1


def _followers(sim: LiveScene, item: SceneObject) -> tuple[int, ...]:
    """Return the objects below that the model carries along with neither the object nor another of them."""
    known = sim.scene.carried_apart.get(item.handle)
    if known is None or known[0] is not sim.model:
        known = sim.scene.carried_apart[item.handle] = sim.model, tuple(_carried_apart(sim, item))
    return known[1]


def _carried_apart(sim: LiveScene, item: SceneObject) -> list[int]:
    carries = item.element in ("body", "joint") or is_linking_sensor(sim, item)
    found: list[int] = []
    pending = sim.scene.children(item.handle)
    while pending:
        child = sim.scene.objects[pending.pop(0)]
        if child.element == "tendon":
            continue
        if carries and is_carried(sim.model, child.body, item.body):
            pending.extend(sim.scene.children(child.handle))
        else:
            found += [child.handle, *_carried_apart(sim, child)]
    return found


def _place_element(sim: LiveScene, item: SceneObject, before: Pose, pose: Pose, with_joints: bool) -> None:
    if item.element == "tendon":
        raise CommandError(
            f"'{item.name}' is driven through a tendon and lies where the tendon's sites are; move those"
        )
    model = sim.model
    if item.element == "joint":
        delta = compose(pose, inverse(before))
        _place_link(sim, item.body, item.id - int(model.body_jntadr[item.body]), delta)
    elif item.element == "body" or is_linking_sensor(sim, item):
        delta = compose(pose, inverse(before))
        if model.body_jntnum[item.body] and free_joint(model, item.body) < 0:
            _place_link(sim, item.body, 0 if with_joints else int(model.body_jntnum[item.body]), delta)
        else:
            _place_body(sim, item.body, compose(delta, body_pose(sim, item.body)))
    else:
        _set_local_pose(sim, item, compose(inverse(body_pose(sim, item.body)), pose))


def _place_body(sim: LiveScene, body: int, pose: Pose) -> None:
    model, data = sim.model, sim.data
    _stop_motion(sim, body)
    joint = free_joint(model, body)
    mocap = int(model.body_mocapid[body])
    if joint >= 0:
        address = int(model.jnt_qposadr[joint])
        data.qpos[address : address + 3] = pose[0]
        data.qpos[address + 3 : address + 7] = pose[1]
    elif mocap >= 0:
        data.mocap_pos[mocap] = pose[0]
        data.mocap_quat[mocap] = pose[1]
    else:
        position, quat = compose(inverse(body_pose(sim, int(model.body_parentid[body]))), pose)
        model.body_pos[body] = position
        model.body_quat[body] = normalised(quat)
        sim.model_edited()


def _place_link(sim: LiveScene, body: int, staying: int, delta: Pose) -> None:
    _stop_motion(sim, body)
    shift_beyond(sim, body, staying, delta)


def _stop_motion(sim: LiveScene, body: int) -> bool:
    """Set the velocity to zero for all degrees of freedom of a body and the bodies below it; return if it was not."""
    known = sim.scene.dofs_below.get(body)
    if known is None or known[0] is not sim.model:
        known = sim.scene.dofs_below[body] = sim.model, _dofs_below(sim.model, body)
    velocities = sim.data.qvel[known[1]]
    if not velocities.any():
        return False
    velocities[:] = 0.0
    return True


def _dofs_below(model: mujoco.MjModel, body: int) -> slice:
    """Return the degrees of freedom of a body and the bodies below it."""
    end = body + 1  # MuJoCo numbers the bodies below a body, and their degrees of freedom, directly behind it
    while end < model.nbody and model.body_parentid[end] >= body:
        end += 1
    return slice(*(int(each) for each in np.searchsorted(model.dof_bodyid, (body, end))))


def _local_pose(sim: LiveScene, item: SceneObject) -> Pose:
    """Return the pose of a site, camera, light or geom in its body's frame."""
    model, data = sim.model, sim.data
    if item.element in ("site", "geom"):
        positions, quats = (
            (model.site_pos, model.site_quat) if item.element == "site" else (model.geom_pos, model.geom_quat)
        )
        return tuple(positions[item.id].tolist()), tuple(quats[item.id].tolist())  # type: ignore[return-value]
    if item.element == "camera":
        if model.cam_mode[item.id] == mujoco.mjtCamLight.mjCAMLIGHT_FIXED.value:
            position, quat = model.cam_pos[item.id].tolist(), model.cam_quat[item.id].tolist()
            return tuple(position), multiply(tuple(quat), _HALF_TURN_Y)  # type: ignore[return-value]
        world = _from_matrix(data.cam_xpos[item.id], data.cam_xmat[item.id])
        world = world[0], multiply(world[1], _HALF_TURN_Y)
    else:
        if model.light_mode[item.id] == mujoco.mjtCamLight.mjCAMLIGHT_FIXED.value:
            return tuple(model.light_pos[item.id].tolist()), turn_z_to(model.light_dir[item.id].tolist())  # type: ignore[return-value]
        world = tuple(data.light_xpos[item.id].tolist()), turn_z_to(data.light_xdir[item.id].tolist())  # type: ignore[assignment]
    return compose(inverse(body_pose(sim, item.body)), world)


def _set_local_pose(sim: LiveScene, item: SceneObject, local: Pose) -> None:
    model, index = sim.model, item.id
    position, quat = local[0], normalised(local[1])
    if item.element == "site":
        # MuJoCo skips the local pose of an element whose frame coincided with the body's at compile time.
        model.site_sameframe[index] = mujoco.mjtSameFrame.mjSAMEFRAME_NONE
        model.site_pos[index], model.site_quat[index] = position, quat
    elif item.element == "geom":
        model.geom_sameframe[index] = mujoco.mjtSameFrame.mjSAMEFRAME_NONE
        model.geom_pos[index], model.geom_quat[index] = position, quat
    elif item.element == "camera":
        model.cam_mode[index] = mujoco.mjtCamLight.mjCAMLIGHT_FIXED
        model.cam_pos[index], model.cam_quat[index] = position, multiply(quat, _TURN_BACK_Y)
    else:
        model.light_mode[index] = mujoco.mjtCamLight.mjCAMLIGHT_FIXED
        model.light_pos[index], model.light_dir[index] = position, rotate(quat, (0.0, 0.0, 1.0))
    sim.model_edited()


def _tendon_pose(sim: LiveScene, tendon: int) -> Pose:
    """Return the frame of the tendon's first site; of a tendon over joints, the fixed frame of its first joint."""
    model = sim.model
    for wrap in range(
        int(model.tendon_adr[tendon]), int(model.tendon_adr[tendon] + model.tendon_num[tendon])
    ):
        target = int(model.wrap_objid[wrap])
        if model.wrap_type[wrap] == mujoco.mjtWrap.mjWRAP_SITE.value:
            local = tuple(model.site_pos[target].tolist()), tuple(model.site_quat[target].tolist())
            return compose(body_pose(sim, int(model.site_bodyid[target])), local)  # type: ignore[arg-type]
        if model.wrap_type[wrap] == mujoco.mjtWrap.mjWRAP_JOINT.value:
            return joint_frames(sim, target)[0]
    return IDENTITY


def _from_matrix(position: npt.NDArray[np.float64], flat: npt.NDArray[np.float64]) -> Pose:
    """Return a pose from MuJoCo's position and row-major 3 x 3 matrix."""
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, flat)
    return tuple(position.tolist()), normalised(quat.tolist())  # type: ignore[return-value]
