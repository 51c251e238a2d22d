"""The constraints by which physics holds linked dummies together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco

from .naming.names import INTERNAL

if TYPE_CHECKING:
    from .objects import SceneObject

PHYSICS, IK = 0, 5
"""`sim_dummy_linktype_dynamics_loop_closure` and `sim_dummy_linktype_ik_tip_target`."""

EQUALITY = INTERNAL + "link:"
"""Prefix of the names of the constraints; the rest is the name of a dummy's site or body."""

CLOSED = (0.005, 1.0)
"""Time constant (s) and damping ratio: V-REP closes a loop within one of its dynamics steps of 5 ms."""

RIGID = (0.9999, 0.9999, 0.0001)
"""Impedance of a loop. MuJoCo measures softness by the lightest body in it, often one with next to no inertia that
carries only a dummy: at 0.97 a tie rod turned a wheel with 30 N m by half a radian.
"""

SOFT = (0.97, 0.97, 0.0001)
"""The same of a loop with a motor at its end: loops of light links are a little soft in V-REP's engines, and a gripper
with two motors in one loop needs that, since each of them works against the other.
"""


def site_name(body: str) -> str:
    """Return the name of the site that marks the place of a dummy that is a body."""
    prefix, sign, name = body.rpartition("/")
    return f"{prefix}{sign}{INTERNAL}site:{name}"


def site_of(spec: mujoco.MjSpec, item: SceneObject) -> str:
    """Return the name of a dummy's site; a dummy that is a body gets one."""
    if item.element == "site":
        return item.element_name
    name = site_name(item.element_name)
    if spec.site(name) is None:
        spec.body(item.element_name).add_site(name=name, group=4)
    return name


def add_weld(
    spec: Any,
    name: str,
    first: str,
    second: str,
    *,
    reference: tuple[float, float] = CLOSED,
    impedance: tuple[float, float, float] = RIGID,
) -> None:
    """Add a constraint that holds two sites together in place and orientation."""
    weld = spec.add_equality(
        name=name, type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_SITE, name1=first, name2=second
    )
    weld.solref[:2] = reference
    weld.solimp[:3] = impedance
    weld.data[10] = 1.0  # orientations count like positions
