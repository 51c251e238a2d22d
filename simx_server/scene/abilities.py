"""The special properties of objects: whether other calculations may collide with, measure and detect them.

The scene's file says so, or a program (`sim.setObjectSpecialProperty`); models may forbid it (`Scene.overridden`).
"""

from __future__ import annotations

from .formats.annotations.annotation import Value
from .objects import ObjectKind, SceneObject

_DEFAULTS = {
    "shape": {"collidable": True, "measurable": True, "detectable": True},
    "dummy": {"collidable": False, "measurable": True, "detectable": False},
}
"""Values by the kind of annotation that has them; octrees and point clouds have that of shapes."""

NO_ABILITY: dict[str, Value] = dict.fromkeys(_DEFAULTS["dummy"], False)
"""The annotation of a new dummy of V-REP."""


def note_of(item: SceneObject) -> str:
    """Return the kind of annotation that has an object's abilities."""
    return "dummy" if item.kind == ObjectKind.DUMMY else "shape"


def ability(item: SceneObject, key: str) -> Value:
    """Return whether an object itself is collidable, measurable or detectable (the key), without its models.

    The value of detectable may be a list of `DETECTABLE_KINDS` of sensors, with commas between them.
    """
    kind = note_of(item)
    return item.annotations.get(kind, {}).get(key, _DEFAULTS[kind][key])
