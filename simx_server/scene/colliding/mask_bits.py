"""Respondable masks as the bits by which MuJoCo decides what may collide.

V-REP: two shapes collide when their masks share a bit, of the local bytes where the same object is at the top of both,
else of the global ones. Two static shapes never collide. MuJoCo: two geoms collide when the `contype` of one and the
`conaffinity` of the other share a bit.

Shapes with the same mask in the same tree are one class, and so are classes that collide with the same ones. Each class
gets its own bit in `contype`, and the bits of those that it collides with in `conaffinity`. Bit 0 belongs to the
shapes that collide with everything, and to geoms without a mask, whose `contype` and `conaffinity` are 1 by default.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.naming.names import INTERNAL

ALL_MASKS = 0xFFFF
"""Mask that meets every other mask except 0."""

EXCLUSION = INTERNAL + "mask:"
"""Part of the names of exclusions by masks; in copies a prefix precedes it."""

_LOCAL, _GLOBAL = 0x00FF, 0xFF00

MOST = 31
"""Most classes that can have their own bit; the highest bit is the sign."""


class Motion(IntEnum):
    """How a shape may move."""

    FIXED = 0
    """It is static, and so is all that carries it."""
    CARRIED = 1
    """It is static, and moves with what carries it."""
    DYNAMIC = 2


class Masked(NamedTuple):
    """The facts that decide with which others a shape collides."""

    mask: int
    top: int
    """Handle of the object at the top of its tree."""
    motion: Motion = Motion.DYNAMIC


class Bits(NamedTuple):
    """How MuJoCo decides the same."""

    geoms: list[tuple[int, int]]
    """contype and conaffinity of each shape's geoms."""
    excluded: list[tuple[int, int]]
    """Pairs of shapes, by place, that the bits let collide and the masks do not: there are more classes than bits."""


def assign(shapes: Sequence[Masked]) -> Bits:
    """Return the bits of shapes that can collide, which must not be changed."""
    return _assigned(tuple(shapes))


@lru_cache(maxsize=16)
def _assigned(shapes: tuple[Masked, ...]) -> Bits:
    """Return the same; each edit of a scene asks again, mostly for the same shapes."""
    places: dict[Masked, list[int]] = {Masked(ALL_MASKS, -1): []}
    """The first class is that of geoms without a mask."""
    for place, shape in enumerate(_without_needless_trees(shapes)):
        places.setdefault(shape, []).append(place)
    meets = _meets(np.array(list(places)))
    members = list(places.values())
    groups = _fit(_alike(meets), members)
    touches = np.array([[meets[np.ix_(a, b)].any() for b in groups] for a in groups])
    geoms = [(0, 0)] * len(shapes)
    for number, group in enumerate(groups):
        affinity = sum(1 << other for other in range(1, len(groups)) if touches[number, other])
        for one in group:
            # Never 0 for both: that is a geom which touches nothing whatever its mask.
            contype = 1 << number | int(meets[0, one])
            for place in members[one]:
                geoms[place] = (contype, affinity) if number else (1, 1)
    excluded: list[tuple[int, int]] = []
    for number, group in enumerate(groups[1:], 1):
        for other in range(number, len(groups)):
            if touches[number, other] and not meets[np.ix_(group, groups[other])].all():
                excluded += _wrong(group, groups[other], meets, members)
    return Bits(geoms, excluded)


def _without_needless_trees(shapes: Sequence[Masked]) -> list[Masked]:
    """Return the shapes with one tree for all trees whose shapes are alike, so that a thousand blocks are one class.

    That is the same where both bytes of the mask are 0, or neither.
    """
    kinds_of: dict[int, set[Masked]] = {}
    for shape in shapes:
        kinds_of.setdefault(shape.top, set()).add(shape)
    trees: dict[tuple[int, Motion], int] = {}

    def simpler(shape: Masked) -> Masked:
        if len(kinds_of[shape.top]) > 1 or bool(shape.mask & _LOCAL) != bool(shape.mask & _GLOBAL):
            return shape
        tree = trees.setdefault(
            (shape.mask, shape.motion), -2 - len(trees)
        )  # no handle, and not the first class's
        return shape._replace(top=tree)

    return [simpler(shape) for shape in shapes]


def _meets(kinds: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return (n, n): which of the classes (mask, top, motion) collide. Fixed ones may: MuJoCo lets none of them."""
    masks, tops, motions = kinds[:, 0].astype(np.uint16), kinds[:, 1], kinds[:, 2]
    common = masks[:, np.newaxis] & masks
    in_one_tree = tops[:, np.newaxis] == tops
    shared = (common & np.where(in_one_tree, np.uint16(_LOCAL), np.uint16(_GLOBAL))) != 0
    is_static = motions != Motion.DYNAMIC
    is_fixed = motions == Motion.FIXED
    both_fixed = is_fixed[:, np.newaxis] & is_fixed
    return shared & (both_fixed | ~(is_static[:, np.newaxis] & is_static))


def _alike(meets: NDArray[np.bool_]) -> list[list[int]]:
    """Return the classes grouped by what they collide with; the first class is in the first group."""
    groups: dict[bytes, list[int]] = {}
    for one, row in enumerate(meets):
        groups.setdefault(row.tobytes(), []).append(one)
    return list(groups.values())


def _fit(groups: list[list[int]], members: list[list[int]]) -> list[list[int]]:
    """Return at most as many groups as there are bits: the first, the largest ones, and one of all others."""
    if len(groups) <= MOST:
        return groups
    sizes = [sum(len(members[one]) for one in group) for group in groups]
    by_size = sorted(range(1, len(groups)), key=lambda number: -sizes[number])
    kept, others = by_size[: MOST - 2], by_size[MOST - 2 :]
    rest = [one for number in sorted(others) for one in groups[number]]
    return [groups[0], *(groups[number] for number in sorted(kept)), rest]


def _wrong(
    group: list[int], other: list[int], meets: NDArray[np.bool_], members: list[list[int]]
) -> list[tuple[int, int]]:
    """Return the pairs of shapes in two groups that collide by the groups' bits, but not by the masks."""
    return [
        (first, second)
        for a in group
        for b in other
        if not meets[a, b] and (group is not other or a <= b)
        for first in members[a]
        for second in members[b]
        if a != b or first < second
    ]
