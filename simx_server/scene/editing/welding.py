"""Fixed connections of bodies: weld a body to another, release it, switch static on and off."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError, Unsupported
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.placing import body_pose, free_joint, is_carried
from simx_server.scene.poses.poses import Pose, compose, conjugate, inverse, rotate

from .recompile import edit
from .transplant import move_body

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene, Posed


def move_body_object(sim: LiveScene, item: SceneObject, parent: int) -> None:
    """Move a body, or the element that represents one, to a new parent physically."""
    body = item.body
    name = sim.model.body(body).name
    target, parents = body_under(sim, parent), {item.handle: parent}
    if target != 0 and is_carried(sim.model, target, body):
        raise CommandError(
            f"'{item.name}' cannot get '{sim.scene.get(parent).name}' as parent, whose body hangs on it"
        )
    links = parent != -1 and _links(sim, sim.scene.get(parent))
    if free_joint(sim.model, body) >= 0:
        if links:
            _weld(sim, body, target, sim.scene.welded_bodies | {name}, weightless=False, parents=parents)
    elif (name in sim.scene.welded_bodies or is_held_link(sim, item)) and not links:
        release(sim, body, parents)
    elif target != int(sim.model.body_parentid[body]):
        was_fixed = name not in sim.scene.welded_bodies and sim.model.body_weldid[body] == 0
        weightless = bool(was_fixed and sim.model.body_weldid[target] != 0)
        _weld(sim, body, target, sim.scene.welded_bodies, weightless=weightless, parents=parents)


def _links(sim: LiveScene, item: SceneObject) -> bool:
    """Return whether this parent holds a free body: force sensors do, and joints with a body without an object."""
    if item.kind == ObjectKind.FORCE_SENSOR:
        return True
    return item.element == "joint" and sim.scene.by_element("body", item.body) is None


def holding_joint(sim: LiveScene, item: SceneObject) -> int | None:
    """Return the handle of the joint that holds a jointless body; None if its body lies in no joint's own body.

    The scenes of V-REP are so: the joint has a body without an object, and all below it lies in that.
    """
    if item.element != "body" or sim.model.body_jntnum[item.id]:
        return None
    above = sim.scene.objects.get(item.parent)
    if above is None or above.element != "joint" or above.body != sim.model.body_parentid[item.id]:
        return None
    return above.handle


def is_held_link(sim: LiveScene, item: SceneObject) -> bool:
    """Return whether a joint's own body holds a shape that is dynamic."""
    return holding_joint(sim, item) is not None and item.element_name not in sim.scene.weightless_bodies


def set_static(sim: LiveScene, handle: int, static: bool) -> None:
    """Make a free body static (it stays with its parent, or where it is) or a jointless body free.

    This is V-REP's `shapeintparam_static`. Physics does not move the joints of a static link.

    Raises:
        Unsupported: a part of the world shall be dynamic, or scripts do not know the joints of a link.
    """
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE, ObjectKind.DUMMY)
    if item.element != "body":
        if not static:
            raise Unsupported(f"'{item.name}' is a part of the world; make it a body to let it move")
        return
    if is_link(sim, item.id):
        joints = joints_of_link(sim, item)
        if not joints:
            raise Unsupported(f"'{item.name}' is a part of a mechanism without joints that scripts know")
        for joint in joints:
            sim.joints.fix(joint, static)
        return
    parent, joint = item.parent, holding_joint(sim, item)
    if joint is not None:
        _set_link_static(sim, item, joint, static)
        return
    if static and free_joint(sim.model, item.id) >= 0:
        target = body_under(sim, parent)
        if is_carried(sim.model, target, item.id):  # a force sensor of the body itself is its parent
            target = int(sim.model.body_parentid[item.id])
        _weld(
            sim, item.id, target, sim.scene.welded_bodies, weightless=bool(sim.model.body_weldid[target] != 0)
        )
    elif not static and free_joint(sim.model, item.id) < 0:
        release(sim, item.id)
    sim.scene.override_parent(handle, parent)


def _set_link_static(sim: LiveScene, item: SceneObject, joint: int, static: bool) -> None:
    """Make a link static, which adds no mass and whose joint physics does not move, or dynamic."""
    names = {item.element_name}
    weightless = sim.scene.weightless_bodies | names if static else sim.scene.weightless_bodies - names
    if weightless != sim.scene.weightless_bodies:
        edit(sim, lambda spec: None, set(), weightless=weightless)
        sim.joints.fix(joint, static)


def body_under(sim: LiveScene, parent: int) -> int:
    """Return the body that children of an object are physically attached to."""
    return 0 if parent == -1 else sim.scene.get(parent).body


def body_name(sim: LiveScene, body: int) -> str:
    return "world" if body == 0 else sim.model.body(body).name


def is_link(sim: Posed, body: int) -> bool:
    return bool(sim.model.body_jntnum[body]) and free_joint(sim.model, body) < 0


def joints_of_link(sim: LiveScene, item: SceneObject) -> list[int]:
    """Return the handles of the joints in a body."""
    return [
        each.handle for each in sim.scene.objects.values() if each.element == "joint" and each.body == item.id
    ]


def _weld(
    sim: LiveScene,
    body: int,
    target: int,
    welded: set[str],
    *,
    weightless: bool,
    parents: dict[int, int] | None = None,
) -> None:
    """Fix a body to another in its present pose. `weightless`: it adds no mass (else it has its own)."""
    model = sim.model
    sim.refresh()
    name, target_name = model.body(body).name, body_name(sim, target)
    local = compose(inverse(body_pose(sim, target)), start_pose(sim, body))
    free = False if free_joint(model, body) >= 0 else None
    whole = rigid_bodies(sim, body)
    weights = sim.scene.weightless_bodies - whole | (whole if weightless else set[str]())
    edit(
        sim,
        lambda spec: move_body(spec, name, target_name, local, free=free),
        {("body_", name)},
        welded=welded,
        weightless=weights,
        parents=parents,
    )


def release(sim: LiveScene, body: int, parents: dict[int, int] | None = None) -> None:
    """Give a body a free joint, its present velocity, and its weight."""
    name = sim.model.body(body).name
    sim.refresh()
    pose, motion = body_pose(sim, body), velocity(sim, body)
    edit(
        sim,
        lambda spec: move_body(spec, name, "world", pose, free=True),
        {("body_", name)},
        welded=sim.scene.welded_bodies - {name},
        weightless=sim.scene.weightless_bodies - rigid_bodies(sim, body),
        parents=parents,
    )
    set_free(sim, name, pose, motion)


def set_free(sim: LiveScene, name: str, pose: Pose, motion: list[float]) -> None:
    """Set pose and velocity (as `velocity` returns it) of a body that has got a free joint."""
    joint = int(sim.model.body_jntadr[sim.model.body(name).id])
    position, dof = int(sim.model.jnt_qposadr[joint]), int(sim.model.jnt_dofadr[joint])
    sim.data.qpos[position : position + 7] = (*pose[0], *pose[1])
    sim.data.qvel[dof : dof + 6] = motion
    sim.changed()


def rigid_bodies(sim: LiveScene, body: int) -> set[str]:
    """Return the names of a body and of those below that are fixed to it."""
    model = sim.model
    # The bodies below one follow it in the model, up to the first whose parent is before it.
    behind = np.flatnonzero(model.body_parentid[body + 1 :] < body)
    end = body + 1 + int(behind[0]) if len(behind) else model.nbody
    fixed = np.flatnonzero(model.body_weldid[body:end] == model.body_weldid[body]) + body
    return {model.body(i).name for i in fixed.tolist()}


def start_pose(sim: Posed, body: int) -> Pose:
    """Return the world pose of a body's frame before its hinges and slides moved it: the pose in the MJCF file."""
    if not is_link(sim, body):
        return body_pose(sim, body)
    model = sim.model
    local: Pose = tuple(model.body_pos[body].tolist()), tuple(model.body_quat[body].tolist())  # type: ignore[assignment]
    return compose(body_pose(sim, int(model.body_parentid[body])), local)


def velocity(sim: LiveScene, body: int) -> list[float]:
    """Return a body's velocity as a free joint's: linear in the world frame, angular in the body's."""
    mujoco.mj_comVel(sim.model, sim.data)
    motion = np.empty(6)
    mujoco.mj_objectVelocity(sim.model, sim.data, mujoco.mjtObj.mjOBJ_XBODY, body, motion, 0)
    turn = conjugate(body_pose(sim, body)[1])
    return [*motion[3:].tolist(), *rotate(turn, motion[:3].tolist())]
