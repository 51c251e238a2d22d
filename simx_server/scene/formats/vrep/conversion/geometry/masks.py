"""The bits by which MuJoCo decides what may collide, from the respondable masks of a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from simx_client.protocol import constants as c
from simx_server.scene.colliding.mask_bits import ALL_MASKS, EXCLUSION, Masked, Motion, assign
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import Joint, Shape, VrepFile, VrepObject


@dataclass(frozen=True)
class Masks:
    """The bits of the respondable shapes of one file."""

    bits: Mapping[int, tuple[int, int]]
    """By handle: contype and conaffinity of its geoms."""
    moves: Mapping[int, bool]
    """By handle: whether physics or a joint moves the shape. A motion by programs alone does not count."""
    excluded: list[tuple[int, int]]
    """Pairs of handles that the bits cannot keep apart."""

    @classmethod
    def of(cls, conversion: Conversion) -> Masks:
        """Return the bits of a conversion's file."""
        return conversion.part(cls, lambda: cls.assigned(conversion.file))

    @classmethod
    def assigned(cls, file: VrepFile) -> Masks:
        """Assign bits to all respondable shapes of a file."""
        shapes = [each for each in file.objects.values() if isinstance(each, Shape) and each.is_respondable]
        kinds = [Masked(shape.mask & ALL_MASKS, *_place(file, shape)) for shape in shapes]
        bits = assign(kinds)
        handles = [shape.handle for shape in shapes]
        return cls(
            dict(zip(handles, bits.geoms, strict=True)),
            {handle: kind.motion != Motion.FIXED for handle, kind in zip(handles, kinds, strict=True)},
            [(handles[one], handles[other]) for one, other in bits.excluded],
        )


def add_exclusions(conversion: Conversion) -> None:
    """Exclude the pairs of bodies that the bits cannot keep apart; call this once all bodies exist."""
    for number, (one, other) in enumerate(Masks.of(conversion).excluded):
        conversion.spec.add_exclude(
            name=f"{EXCLUSION}{number}",
            bodyname1=conversion.names[one],
            bodyname2=conversion.names[other],
        )


def _place(file: VrepFile, shape: Shape) -> tuple[int, Motion]:
    """Return the object at the top of a shape's tree, and what may move the shape."""
    way = list(_above(file, shape))
    is_held = any(
        each.is_model_base and each.model_properties & c.sim_modelproperty_not_dynamic for each in way
    )
    if shape.is_dynamic and not is_held:
        return way[-1].handle, Motion.DYNAMIC
    is_carried = any(
        isinstance(each, Joint) or (isinstance(each, Shape) and each.is_dynamic) for each in way[1:]
    )
    return way[-1].handle, Motion.CARRIED if is_carried else Motion.FIXED


def _above(file: VrepFile, item: VrepObject) -> list[VrepObject]:
    """Return an object and all above it."""
    way = [item]
    while (parent := file.objects.get(way[-1].parent)) is not None and len(way) <= len(file.objects):
        way.append(parent)
    return way
