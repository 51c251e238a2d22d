"""The settings of joints as annotations, from which `state.initial_state` gives the same."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import Annotation, Value
from simx_server.scene.saved import numbers_text

from .state import MODE_WORDS, UPPER_VELOCITY, Binding, JointMode, JointState, Native

if TYPE_CHECKING:
    from simx_server.scene.saved import Saved

_WORDS = {mode: word for word, mode in MODE_WORDS.items()}

_OF_PROFILES = {"upper_acceleration": "acceleration", "upper_jerk": "jerk"}


def save_joints(saved: Saved, joints: Mapping[int, tuple[Binding, JointState]]) -> None:
    """Annotate the saved joints with their present settings."""
    for handle, (binding, state) in joints.items():
        if handle in saved.names:
            saved.drop(handle, "joint")
            saved.put(handle, "joint", **_note(saved, binding, state))


def _note(saved: Saved, binding: Binding, state: JointState) -> Annotation:
    note: dict[str, Value] = {
        "mode": _WORDS[state.mode],
        "control": _control(state),
        "max_force": 0.0 - state.max_force if state.backwards else state.max_force,
        "target_position": state.target_position,
        "target_velocity": state.target_velocity,
        "P": state.p,
        "I": state.i,
        "D": state.d,
        "K": state.k,
        "C": state.c,
        "rigid": state.rigid,
        "ik_weight": state.ik_weight,
        "cyclic": state.cyclic,
    }
    if state.motor_was_set or state.motor != (binding.native in (Native.POSITION, Native.VELOCITY)):
        note["motor"] = state.motor
    if state.upper_velocity != UPPER_VELOCITY.get(binding.kind, 0.0):
        note["upper_velocity"] = state.upper_velocity
    for key, name in _OF_PROFILES.items():
        if getattr(state, name):
            note[key] = getattr(state, name)
    for name in ("lock", "hybrid", "rewind", "fixed"):
        if getattr(state, name):
            note[name] = True
    if state.spring and not state.control_loop:
        note["spring"] = True
    if state.alignment is not None:
        note["alignment"] = numbers_text(state.alignment)
    if not state.annotated:
        note["switches"] = True
    note |= _dependency(saved, binding, state)
    return note


def _control(state: JointState) -> str:
    if state.control_loop:
        return "spring" if state.spring else "script" if state.scripted else "position"
    return "force" if state.pushes else "velocity"


def _dependency(saved: Saved, binding: Binding, state: JointState) -> Annotation:
    """Return the shift of a tendon's position, or what a joint follows."""
    if binding.element == "tendon":
        return {"offset": state.offset} if state.offset else {}
    master = saved.name(state.master)
    if master is None and (state.mode == JointMode.DEPENDENT or (state.factor, state.shift) == (1.0, 0.0)):
        return {}
    numbers: Annotation = {"multiplication": state.factor, "offset": state.shift}
    return numbers if master is None else {"master": master, **numbers}
