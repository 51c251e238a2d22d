"""Let a joint that starts to follow another one exchange forces with it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco

from simx_server.joints import JointMode
from simx_server.scene.dependencies import add_equality
from simx_server.scene.editing.recompile import edit
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.world.world import World

_SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


def couple(world: World, handle: int) -> None:
    """Give a joint in dependent mode the equality of `scene/dependencies.py`, if it has none.

    Raises:
        UnknownHandle, WrongKind: the handle is not a joint's.
    """
    sim = world.simulation
    item = sim.scene.get_kind(handle, ObjectKind.JOINT)
    if item.element != "joint" or sim.joints.state(handle).mode != JointMode.DEPENDENT:
        return  # it cannot follow
    if int(sim.model.jnt_type[item.id]) in _SINGLE and not sim.joints.is_coupled(handle):
        edit(sim, lambda spec: add_equality(spec, item.element_name), set())
