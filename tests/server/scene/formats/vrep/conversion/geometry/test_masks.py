"""Respondable masks of a file as the bits and exclusions of a model."""

from __future__ import annotations

import itertools
import random

import pytest
from vrep_shapes import box_leaf, converted, file_of, shape_of

from simx_server.scene.colliding.mask_bits import Masked, Motion, assign
from simx_server.scene.formats.vrep.conversion.geometry.masks import Masks, add_exclusions
from simx_server.scene.formats.vrep.objects import Dummy, Joint, Shape, VrepFile


def should_meet(one: Masked, other: Masked) -> bool:
    """V-REP's rule."""
    if Motion.DYNAMIC not in (one.motion, other.motion):
        return False
    byte = 0x00FF if one.top == other.top else 0xFF00
    return bool(one.mask & other.mask & byte)


def meet(one: tuple[int, int], other: tuple[int, int]) -> bool:
    """MuJoCo's rule."""
    return bool(one[0] & other[1] or other[0] & one[1])


def check(shapes: list[Masked]) -> int:
    bits = assign(shapes)
    excluded = {frozenset(pair) for pair in bits.excluded}
    for a, b in itertools.combinations(range(len(shapes)), 2):
        if shapes[a].motion == shapes[b].motion == Motion.FIXED:
            continue  # neither moves, so MuJoCo never compares them
        found = meet(bits.geoms[a], bits.geoms[b]) and frozenset((a, b)) not in excluded
        assert found == should_meet(shapes[a], shapes[b]), (shapes[a], shapes[b])
    for shape, geom in zip(shapes, bits.geoms, strict=True):
        assert any(geom)
        assert meet(geom, (1, 1)) == bool(shape.mask & 0xFF00), "the geoms of another scene"
    return len(bits.excluded)


def test_shapes_of_a_plain_scene_have_the_bits_of_any_geom() -> None:
    shapes = [Masked(0xFFFF, top, Motion(top % 3 and 2)) for top in range(5)]
    assert assign(shapes).geoms == [(1, 1)] * 5


def test_bits_are_exact_while_there_are_enough_of_them() -> None:
    masks = (0xFFFF, 0xFF0F, 0xFFF0, 0x0FFF, 0xF0FF, 0x00FF, 0xFF00, 0)
    assert check([Masked(mask, top) for mask in masks for top in (1, 2, 3)] * 2) == 0
    moving = [Masked(0xFFFF, 1, Motion.CARRIED), Masked(0xFFFF, 2, Motion.FIXED), Masked(0xFFFF, 2)]
    assert check(moving * 2) == 0


def test_thousands_of_blocks_with_a_mask_of_their_own_are_one_class() -> None:
    blocks = [Masked(0x0F0F, top) for top in range(20_000)]
    assert len(set(assign([*blocks, Masked(0xF0F0, -5)]).geoms)) == 2
    assert check(blocks[:30]) == 0


def test_links_of_many_robots_need_few_exclusions() -> None:
    robots = [Masked(0xFF0F if link % 2 else 0xFFF0, top) for top in range(30) for link in range(6)]
    assert 0 < check(robots) <= 30 * 9


@pytest.mark.parametrize("seed", range(6))
def test_any_masks_act_as_in_vrep(seed: int) -> None:
    rng = random.Random(seed)
    shapes = [
        Masked(rng.getrandbits(16) & rng.getrandbits(16), rng.randrange(6), rng.choice(list(Motion)))
        for _ in range(60)
    ]
    check(shapes)


def scene(count: int) -> VrepFile:
    """Many shapes with masks of their own in one tree."""
    base = Dummy(handle=1, name="base")
    shapes = [
        shape_of(
            box_leaf(), handle=2 + place, parent=1, is_respondable=True, is_dynamic=True, mass=1.0, mask=mask
        )
        for place, mask in enumerate(range(1, count + 1))
    ]
    return file_of(base, *shapes)


def test_pairs_that_have_no_bits_left_are_excluded_by_their_bodies() -> None:
    conversion = converted(scene(60))
    add_exclusions(conversion)
    excluded = Masks.of(conversion).excluded
    assert excluded
    assert conversion.spec.compile().nexclude == len(excluded)


def motion(file: VrepFile, handle: int) -> tuple[int, int]:
    return Masks.assigned(file).bits[handle]


def test_static_shapes_that_joints_carry_do_not_meet_other_static_ones() -> None:
    base = shape_of(handle=1, is_respondable=True)
    joint = Joint(handle=2, name="joint", parent=1)
    link = shape_of(handle=3, parent=2, is_respondable=True)
    block = shape_of(handle=4, is_respondable=True, is_dynamic=True)
    held = Shape(handle=5, parent=6, name="held", is_respondable=True, is_dynamic=True)
    model = Dummy(handle=6, name="model", is_model_base=True, model_properties=0x20)
    file = file_of(base, joint, link, block, held, model)
    assert not meet(motion(file, 1), motion(file, 3))
    assert meet(motion(file, 3), motion(file, 4))
    assert meet(motion(file, 1), motion(file, 4))
    assert not meet(motion(file, 5), motion(file, 3)), "its model forbids it to move"
