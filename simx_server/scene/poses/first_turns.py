"""The turns that spherical joints start with: MuJoCo's models do not store them."""

from __future__ import annotations

from collections.abc import Collection

import mujoco

from simx_server.scene.formats.annotations import numbers_of
from simx_server.scene.objects import Scene, SceneObject

from .poses import normalised


def has_turn(item: SceneObject) -> bool:
    """Return whether an object's annotation has a turn."""
    return "turn" in item.annotations.get("joint", {})


def set_turns(
    scene: Scene, model: mujoco.MjModel, data: mujoco.MjData, handles: Collection[int] | None = None
) -> None:
    """Write the turns of the annotations into the state; `handles`: only of these joints."""
    for item in scene.objects.values() if handles is None else [scene.objects[handle] for handle in handles]:
        turn = item.annotations.get("joint", {}).get("turn")
        if (
            turn is not None
            and item.element == "joint"
            and model.jnt_type[item.id] == mujoco.mjtJoint.mjJNT_BALL.value
        ):
            address = int(model.jnt_qposadr[item.id])
            data.qpos[address : address + 4] = normalised(numbers_of(turn))
