"""Masses of bodies that carry only frames: MuJoCo cannot move a body without mass."""

from __future__ import annotations

from typing import Any

import mujoco

_MASS = 0.01
"""kg; little, so that the joint's armature decides."""

_INERTIA = 1e-5
"""kg m^2 of the same bodies."""

_ARMATURE = 0.05
"""Inertia (kg m^2, kg) of joints that carry only linked dummies: V-REP's physics has no mass there either, and MuJoCo
needs some to hold limits and loops."""


def give_masses(spec: mujoco.MjSpec) -> None:
    """Give each body that has joints, and nothing with mass on it, a small mass."""
    heavy: dict[str, bool] = {}
    for body in reversed(list(spec.bodies)):  # children come after their parents
        if body.name == "world":
            continue
        has_mass = heavy.get(body.name, False) or (body.explicitinertial and body.mass > 0)
        joints = list(body.joints)
        if not joints:
            parent = body.parent.name
            heavy[parent] = heavy.get(parent, False) or has_mass
        elif not has_mass and not _has_weighing_geom(body):
            _make_light(body, joints)


def _has_weighing_geom(body: Any) -> bool:
    return any(geom.mass > 0 for geom in body.geoms)


def _make_light(body: Any, joints: list[Any]) -> None:
    body.explicitinertial = True
    body.mass = _MASS
    body.inertia = [_INERTIA] * 3
    body.ipos, body.iquat = [0, 0, 0], [1, 0, 0, 0]
    for joint in joints:
        if joint.type in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            joint.armature = max(float(joint.armature), _ARMATURE)
