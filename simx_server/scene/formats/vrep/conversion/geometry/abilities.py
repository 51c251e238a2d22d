"""The special properties of an object: which sensors and calculations regard it."""

from __future__ import annotations

from simx_server.scene.formats.annotations import DETECTABLE_KINDS
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import Dummy, VrepObject

_COLLIDABLE, _MEASURABLE, _RENDERABLE = 0x1, 0x2, 0x200
_DETECTABLE = {kind: 0x10 << place for place, kind in enumerate(DETECTABLE_KINDS)}


def annotate_abilities_of_dummy(conversion: Conversion, dummy: Dummy) -> None:
    """Annotate what differs from the defaults, by which a dummy may be measured alone."""
    bits = dummy.properties
    kinds = _kinds(bits)
    conversion.annotate(
        "dummy",
        conversion.name(dummy),
        detectable=len(kinds) == len(_DETECTABLE) or ",".join(kinds) or None,
        collidable=True if bits & _COLLIDABLE else None,
        measurable=None if bits & _MEASURABLE else False,
    )


def annotate_abilities(conversion: Conversion, item: VrepObject, *, is_drawn: bool = True) -> None:
    """Annotate what differs from the defaults, by which all may be done with an object that has a form.

    Args:
        is_drawn: whether images show a part of it; sensors detect the unseen only where a scene says so.
    """
    bits = item.properties
    conversion.annotate(
        "shape",
        conversion.name(item),
        renderable=None if bits & _RENDERABLE else False,
        detectable=_detectable(bits, is_drawn),
        collidable=None if bits & _COLLIDABLE else False,
        measurable=None if bits & _MEASURABLE else False,
    )


def _detectable(bits: int, is_drawn: bool) -> str | bool | None:
    """Return the kinds of sensors that detect it, where not simply all of them see it."""
    kinds = _kinds(bits)
    if not kinds or (len(kinds) == len(_DETECTABLE) and is_drawn):
        return None if kinds else False
    return ",".join(kinds)


def _kinds(bits: int) -> list[str]:
    return [kind for kind, bit in _DETECTABLE.items() if bits & bit]
