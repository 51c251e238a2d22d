"""Break a force sensor: separate the objects that it holds from the object that carries it, for the rest of the run.

The sensor stays in place, on the near side, and the tree of objects does not change, as in V-REP; the far side becomes
a free body with its present velocity. The stop undoes edits, and with them the break.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco

from .editing.least_mass import make_light
from .editing.recompile import edit
from .editing.transplant import find_body, move_body, move_joint, move_leaf
from .editing.welding import body_name, is_link, release, rigid_bodies, set_free, velocity
from .naming.names import INTERNAL
from .objects import SceneObject
from .poses.placing import body_pose, free_joint, is_linking_sensor
from .poses.poses import Pose

if TYPE_CHECKING:
    from .live import LiveScene

_STUMP = INTERNAL + "broken:"
"""Prefix of the name of the body that keeps a broken sensor in its place."""


def break_sensor(sim: LiveScene, item: SceneObject) -> None:
    """Release all objects that this force sensor holds. Raises CommandError when the scene cannot be cut there."""
    if is_linking_sensor(sim, item):
        _cut_off(sim, item)
        return
    for child in sim.scene.children(item.handle):
        held = sim.scene.get(child)
        if held.element == "body" and free_joint(sim.model, held.id) < 0 and not is_link(sim, held.id):
            sim.scene.override_parent(child, item.handle)
            release(sim, held.id)


def _cut_off(sim: LiveScene, item: SceneObject) -> None:
    """Free the body in front of the sensor; its joints and the sensor stay behind, on a stump."""
    model, body = sim.model, item.body
    sim.refresh()
    name = model.body(body).name
    near = body_name(sim, int(model.body_parentid[body]))
    pose, motion = body_pose(sim, body), velocity(sim, body)
    start: Pose = tuple(model.body_pos[body].tolist()), tuple(model.body_quat[body].tolist())  # type: ignore[assignment]
    local: Pose = tuple(model.site_pos[item.id].tolist()), tuple(model.site_quat[item.id].tolist())  # type: ignore[assignment]
    size = model.site_size[item.id].copy()
    joints = _joint_names(model, body)
    stump_name = _STUMP + item.element_name

    def surgery(spec: mujoco.MjSpec) -> None:
        stump = find_body(spec, near).add_body(name=stump_name, pos=start[0], quat=start[1])
        if joints:
            make_light(stump)
        for joint in joints:
            move_joint(spec, joint, stump_name)
        move_leaf(spec, "site", item.element_name, stump_name, local, size)
        move_body(spec, name, "world", pose, free=True)

    whole = rigid_bodies(sim, body)
    edit(
        sim,
        surgery,
        {("body_", name), ("site_", item.element_name)},
        parents=dict.fromkeys(sim.scene.children(item.handle), item.handle),
        welded=sim.scene.welded_bodies - {name},
        weightless=sim.scene.weightless_bodies - whole,
    )
    set_free(sim, name, pose, motion)


def _joint_names(model: mujoco.MjModel, body: int) -> list[str]:
    first = int(model.body_jntadr[body])
    return [model.joint(j).name for j in range(first, first + int(model.body_jntnum[body]))]
