"""Joints that follow another one: V-REP's dependent mode, position = offset + multiplication * master's position.

The file names the master in the joint's annotation. Loading adds an equality per dependent joint, through which the two
exchange forces; the joints switch it on and write its numbers, so that they can change without another compile.
"""

from __future__ import annotations

import mujoco

from .formats.annotations import Annotation, Annotations, SceneError
from .naming.names import INTERNAL
from .spec_elements import leaves_of

EQUALITY = INTERNAL + "dependency:"
"""Prefix of the names of added equalities; the rest is the dependent joint's name."""

_SOLVER_REFERENCE = (0.004, 1.0)
_SOLVER_IMPEDANCE = (0.99, 0.999, 0.0001)
"""Stiff, like the shipped gripper's couplings: with the default the joint would lag visibly behind a fast master."""

_SINGLE = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


def add_dependencies(spec: mujoco.MjSpec, annotations: Annotations) -> None:
    """Check the masters in the annotations and add an equality, off, for each joint in dependent mode.

    Raises SceneError.
    """
    notes = {name: by_kind["joint"] for name, by_kind in annotations.objects.items() if "joint" in by_kind}
    kinds = {joint.name: joint.type for joint in leaves_of(spec, "joints")} if notes else {}
    for name, note in notes.items():
        _check(name, note, kinds, notes)
        is_there = spec.equality(EQUALITY + name) is not None  # in a saved scene
        if note.get("mode") == "dependent" and kinds.get(name) in _SINGLE and not is_there:
            add_equality(spec, name)


def add_equality(spec: mujoco.MjSpec, joint: str) -> None:
    """Add the equality, off, through which a joint exchanges forces with a master."""
    equality = spec.add_equality(
        name=EQUALITY + joint,
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=joint,
        active=False,
    )
    equality.solref[:2] = _SOLVER_REFERENCE
    equality.solimp[:3] = _SOLVER_IMPEDANCE


def _check(name: str, note: Annotation, kinds: dict[str, object], notes: dict[str, Annotation]) -> None:
    element = f"text 'simx:joint:{name}'"
    master = note.get("master")
    mode = note.get("mode")
    if master is None:
        if mode not in (None, "dependent"):  # a joint keeps what it had in an earlier mode
            return
        if "multiplication" in note:
            raise SceneError(f"{element} has multiplication= without master=, the joint to follow")
        if "offset" in note and name in kinds:
            raise SceneError(
                f"{element} has offset=, valid for a tendon, or with master= for a dependent joint"
            )
        return
    if mode is None or kinds.get(name) not in _SINGLE:
        raise SceneError(f"{element} has master=, valid for a hinge or slide joint with mode=dependent")
    if kinds.get(str(master)) not in _SINGLE:
        raise SceneError(f"{element} has master={master}, which is no hinge or slide joint of the scene")
    seen = {name}
    while isinstance(master, str) and notes.get(master, {}).get("mode") == "dependent":
        if master in seen:
            raise SceneError(f"{element} has master={note['master']}, which follows '{name}' itself")
        seen.add(master)
        master = notes[master].get("master")
