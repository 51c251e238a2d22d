"""Collections, collision and distance objects, groups of inverse kinematics, old user interfaces."""

from __future__ import annotations

import math
import struct

from simx_server.scene.formats.vrep.chunks import Chunks
from simx_server.scene.formats.vrep.objects import (
    Button,
    Collection,
    Color,
    IkElement,
    IkGroup,
    MotionPlanning,
    OldUI,
    Pair,
    PathPlanning,
)

RESTORES_POSITION, RESTORES_ORIENTATION, LIMITS_STEPS, EXPLICIT = 2, 4, 0x20, 0x40
"""Bits of a group of inverse kinematics."""


def collection_of(chunks: Chunks) -> Collection:
    """Return a collection. Raises SceneError."""
    (number,) = chunks.ints("Gix")
    found = Collection(id=number, name=chunks.text("Grn"))
    (flags,) = chunks.ints("Par", 0)
    found.overrides = bool(flags & 1)
    for each in chunks.each("Asg"):
        item, _ = each.ints("Obj")
        (kind,) = each.ints("Gty", 0)
        (flags,) = each.ints("Var", 1)
        found.entries.append((item, kind, bool(flags & 1)))
    return found


def pair_of(chunks: Chunks) -> Pair:
    """Return a collision or distance object. Raises SceneError."""
    first, second, number = chunks.ints("Inx")
    pair = Pair(id=number, name=chunks.text("Nme"), entity1=first, entity2=second)
    if chunks.name == "DST":
        (pair.threshold,) = chunks.reals("Trh", 0.0)
    return pair


def ik_group_of(chunks: Chunks) -> IkGroup:
    """Return a group of inverse kinematics. Raises SceneError."""
    (number,) = chunks.ints("Oid")
    group = IkGroup(id=number, name=chunks.text("Nme"))
    (group.iterations,) = chunks.ints("Mit", group.iterations)
    (group.damping,) = chunks.reals("Dpg", group.damping)
    (group.method,) = chunks.ints("Cmt", group.method)
    (flags,) = chunks.ints("Var", 1)
    group.is_enabled = bool(flags & 1)
    group.restore = bool(flags & RESTORES_POSITION), bool(flags & RESTORES_ORIENTATION)
    group.is_explicit = bool(flags & EXPLICIT)
    group.ignores_steps = not flags & LIMITS_STEPS
    (group.after,) = chunks.ints("Doo", -1)
    for each in chunks.each("Ike"):
        tip, base = each.ints("Ik2")
        element = IkElement(tip=tip, base=base)
        (element.constraints,) = each.ints("Ctr", element.constraints)
        angular, linear = each.reals("Pr2", *reversed(element.precision))
        element.precision = linear, angular
        linear, angular = each.reals("Wgt", *element.weights)
        element.weights = linear, angular
        (flags,) = each.ints("Var", 1)
        element.enabled = bool(flags & 1)
        group.elements.append(element)
    return group


def path_planning_of(chunks: Chunks) -> PathPlanning:
    """Return a path planning task. Raises SceneError."""
    (number,) = chunks.ints("Oid")
    path, robot, obstacles = chunks.ints("Idx")
    (start,) = chunks.ints("Pod")
    (goal,) = chunks.ints("Gid")
    planning = PathPlanning(
        id=number,
        name=chunks.text("Nme"),
        path=path,
        start=start,
        goal=goal,
        robot=robot,
        obstacles=obstacles,
    )
    (planning.type,) = chunks.ints("Ttp", planning.type)
    (planning.seconds,) = chunks.reals("Mxt", planning.seconds)
    ranges = chunks.reals("Rn2", *(-5.0, 10.0) * 3, 0.0, 0.0)
    planning.low = ranges[0:6:2]
    planning.high = tuple(low + extent for low, extent in zip(ranges[0:6:2], ranges[1:6:2], strict=True))
    return planning


def motion_planning_of(chunks: Chunks) -> MotionPlanning:
    """Return a motion planning task. Raises SceneError."""
    (number,), (group,) = chunks.ints("Oid"), chunks.ints("Ikg")
    count, *joints = chunks.ints("Jhn")
    robot, obstacles, first, second = chunks.ints("Ety", -1, -1, -1, -1)
    far, near = chunks.reals("Cdt", 0.0, 0.0)
    return MotionPlanning(
        id=number,
        name=chunks.text("Nme"),
        joints=tuple(joints[:count]),
        group=group,
        robot=robot,
        obstacles=obstacles,
        own=(first, second),
        clearances=(far, near),
        tip_weights=chunks.reals("Tmc", 1.0, 1.0, 1.0, 0.1),
        joint_weights=chunks.reals("Jmc", *[1.0] * len(joints))[: len(joints[:count])],
    )


def old_ui_of(chunks: Chunks) -> OldUI:
    """Return an old user interface. Raises SceneError."""
    (handle,) = chunks.ints("Bkh")
    columns, rows = chunks.ints("Bks", 1, 1)
    (attributes,) = chunks.ints("Att", 0)
    (item,) = chunks.ints("Aoi", -1)
    found = OldUI(
        handle=handle, name=chunks.text("Bkn"), object=item, size=(columns, rows), attributes=attributes
    )
    for each in chunks.each("Btn"):
        found.buttons.append(_button_of(each))
    return found


def _button_of(chunks: Chunks) -> Button:
    is_double = "_va" in chunks.places  # since CoppeliaSim 4.5
    tag, bits, real = ("_va", "q", "d") if is_double else ("Bva", "i", "f")
    place, end = chunks.places.get(tag, (0, 0))
    attributes, handle, width, height, x, y = chunks.whole(tag, place, end, "6i")
    label, place = chunks.text_at(tag, place + 24, end)
    down_label, place = chunks.text_at(tag, place, end)
    # As bits, because the value of a slider that was never moved may be NaN.
    slider = struct.unpack(f"<{real}", struct.pack(f"<{bits}", *chunks.whole(tag, place, end, bits)))[0]
    return Button(
        handle=handle,
        position=(x, y),
        size=(width, height),
        attributes=attributes,
        label=label,
        down_label=down_label,
        slider=round(500 * (1 + min(max(slider, -1.0), 1.0))) if math.isfinite(slider) else 0,
        colors=_colors_of(chunks),
    )


def _colors_of(chunks: Chunks) -> tuple[Color, Color, Color] | None:
    if "Bnc" not in chunks.places:
        return None
    up_r, up_g, up_b, down_r, down_g, down_b, red, green, blue = chunks.reals("Bnc")
    return (up_r, up_g, up_b), (down_r, down_g, down_b), (red, green, blue)
