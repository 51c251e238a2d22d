"""Scale the lengths and forces of a joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .joints import Joints

_SLIDE, _BALL = 11, 12


def scale_joint(joints: Joints, handle: int, factor: float) -> None:
    """Scale a joint alike along all axes: its force and springs, of a prismatic joint also lengths and speeds.

    Raises:
        UnknownHandle, WrongKind: the handle is not a joint's.
    """
    kind = joints.joint_type(handle)
    if kind == _BALL:
        return
    state = joints.state(handle)
    is_slide = kind == _SLIDE
    force = factor ** (3 if is_slide else 4)
    stiffness = factor ** (2 if is_slide else 4)
    position = joints.position(handle)
    if state.max_force < 1e9:
        joints.set_max_force(handle, state.max_force * force)
    joints.change(handle, k=state.k * stiffness, c=state.c * stiffness)
    if not is_slide:
        return
    cyclic, least, extent = joints.interval(handle)
    if extent < 1e9:
        joints.set_interval(handle, cyclic, least * factor, extent * factor)
    joints.change(
        handle,
        target_position=state.target_position * factor,
        target_velocity=state.target_velocity * factor,
        upper_velocity=state.upper_velocity * factor,
    )
    if joints.state(handle).master < 0:
        joints.set_position(handle, position * factor)
