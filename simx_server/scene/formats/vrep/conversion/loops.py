"""Closed chains: pairs of linked dummies that V-REP's physics holds together, as equality constraints."""

from __future__ import annotations

import math
from typing import Any

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.structure import Structure
from simx_server.scene.formats.vrep.objects import Dummy
from simx_server.scene.link_constraints import CLOSED, EQUALITY, IK, add_weld, site_name

_OPEN = (0.05, 1.0)
"""Time constant (s) and damping ratio of loops that stand open in the file: they must close without a jerk."""

_GAP = 1e-3
"""Distance in metres from which a loop counts as open."""


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
        add_weld(conversion.spec, EQUALITY + sites[0], sites[0], sites[1], _OPEN if gap > _GAP else CLOSED)


def add_links(conversion: Conversion) -> None:
    """Annotate the links of dummies."""
    for item in conversion.file.objects.values():
        partner = conversion.file.objects.get(item.linked) if isinstance(item, Dummy) else None
        if isinstance(item, Dummy) and isinstance(partner, Dummy) and partner is not item:
            link = "ik" if item.link_type == IK else None
            conversion.annotate("dummy", conversion.name(item), linked=conversion.name(partner), link=link)


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
