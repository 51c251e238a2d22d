"""Closed chains: pairs of linked dummies that V-REP's physics holds together, as equality constraints."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from simx_server.scene.formats.vrep.objects import Dummy, Joint, JointType, VrepFile, VrepObject
from simx_server.scene.link_constraints import CLOSED, EQUALITY, IK, PHYSICS, RIGID, SOFT, add_weld, site_name
from simx_server.scene.poses.poses import conjugate, multiply

from .context import Conversion
from .structure import Structure, children_of, world_poses

_OPEN = (0.05, 1.0)
"""Time constant (s) and damping ratio of loops that stand open in the file: they must close without a jerk."""

_GAP = 1e-3
"""Distance in metres from which a loop counts as open."""


def turn_bare_joints(file: VrepFile) -> VrepFile:
    """Return the file with joints turned that carry only a linked dummy, if they stand more than 90 degrees wrong.

    V-REP's engines turn them within a few steps, since they have no mass on them. MuJoCo's constraint, which is
    measured by the sine of half of the angle, gets weaker from there on, and ends at 180 degrees.
    """
    objects, poses, children = dict(file.objects), world_poses(file), children_of(file)
    for item in file.objects.values():
        joint, partner = _bare_joint(file, item, children), file.objects.get(getattr(item, "linked", -1))
        if joint is None or not isinstance(partner, Dummy) or not joint.is_cyclic:
            continue
        if objects.get(partner.parent) is not file.objects.get(partner.parent):
            continue  # the hinge at the other end has been turned
        frame, own, other = (poses[each.handle][1] for each in (joint, item, partner))
        w, _, _, z = multiply(conjugate(frame), multiply(multiply(other, conjugate(own)), frame))
        angle = math.remainder(2.0 * math.atan2(z, w), 2.0 * math.pi)
        if abs(angle) > math.pi / 2:
            objects[joint.handle] = replace(joint, position=joint.position + angle)
    return replace(file, objects=objects)


def _bare_joint(
    file: VrepFile, item: VrepObject, children: Mapping[int, Sequence[VrepObject]]
) -> Joint | None:
    """Return the hinge that carries nothing but this dummy, whose link closes a loop."""
    if not isinstance(item, Dummy) or item.link_type != PHYSICS:
        return None
    joint = file.objects.get(item.parent)
    if not isinstance(joint, Joint) or joint.type != JointType.REVOLUTE or joint.motor:
        return None
    return joint if len(children[joint.handle]) == 1 else None


def add_loops(conversion: Conversion, structure: Structure) -> None:
    """Add a constraint for each pair of linked dummies on different bodies."""
    for item in conversion.file.objects.values():
        partner = structure.loop_partner(item)
        if partner is None or not isinstance(item, Dummy) or partner.handle < item.handle:
            continue
        first, second = (structure.riding[each.handle][0] for each in (item, partner))
        if first.name == second.name or not (_moves(first) or _moves(second)):
            continue
        gap = math.dist(*(structure.world_poses[each.handle][0] for each in (item, partner)))
        sites = [_site_of(conversion, structure, each) for each in (item, partner)]
        is_soft = any(_is_driven(conversion.file, each) for each in (item, partner))
        add_weld(
            conversion.spec,
            EQUALITY + sites[0],
            *sites,
            reference=_OPEN if gap > _GAP else CLOSED,
            impedance=SOFT if is_soft else RIGID,
        )


def _is_driven(file: VrepFile, dummy: Dummy) -> bool:
    """Return whether the joint that carries the dummy has a motor, so that the loop may have two of them."""
    joint = file.objects.get(dummy.parent)
    return isinstance(joint, Joint) and joint.motor


def add_links(conversion: Conversion) -> None:
    """Annotate the links of dummies, and the type of those that a script may link later."""
    for item in conversion.file.objects.values():
        if not isinstance(item, Dummy):
            continue
        partner = conversion.file.objects.get(item.linked)
        linked = conversion.name(partner) if isinstance(partner, Dummy) and partner is not item else None
        link = "ik" if item.link_type == IK else None
        if linked is not None or link is not None:
            conversion.annotate("dummy", conversion.name(item), linked=linked, link=link)


def _moves(body: Any) -> bool:
    """Return whether anything moves a body of the spec."""
    while body.name != "world":
        if list(body.joints):
            return True
        body = body.parent
    return False


def _site_of(conversion: Conversion, structure: Structure, dummy: Dummy) -> str:
    """Return the name of the dummy's site; a dummy with children is a body, and gets one."""
    name = conversion.name(dummy)
    if conversion.spec.site(name) is not None:
        return name
    body, at = structure.riding[dummy.handle]
    site = site_name(name)
    body.add_site(name=site, pos=at[0], quat=at[1], group=5)
    return site
