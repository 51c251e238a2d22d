"""A group of inverse kinematics as an annotation, from which the same group is read when the file is loaded."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import WORLD, Annotation
from simx_server.scene.saved import listed, numbers_text

from .chain import Constraint

if TYPE_CHECKING:
    from simx_server.scene.saved import Saved

    from .groups import Group
    from .solver import Method

_WORDS = (
    ("x", Constraint.X),
    ("y", Constraint.Y),
    ("z", Constraint.Z),
    ("alpha_beta", Constraint.ALPHA_BETA),
    ("gamma", Constraint.GAMMA),
)


def note_of(saved: Saved, group: Group, methods: dict[Method, str]) -> Annotation | None:
    """Return the annotation of a group; None where objects of it are not saved."""
    note: Annotation = {
        "method": methods[group.how.method],
        "damping": group.how.damping,
        "iterations": group.how.iterations,
        "handling": "explicit" if group.explicit else "auto",
        "enabled": group.enabled,
    }
    if group.restore:
        note["restore"] = ",".join(sorted(group.restore, reverse=True))
    if group.after:
        note["after"] = group.after
    if group.ignores_steps:
        note["ignores_steps"] = True
    if any(group.margins):
        note["margins"] = numbers_text(group.margins)
    if not group.elements:
        return None if saved.is_model else note
    named = {
        "tip": [saved.name(each.tip) for each in group.elements],
        "target": [WORLD if each.target == -1 else saved.name(each.target) for each in group.elements],
        "base": [WORLD if each.base == -1 else saved.name(each.base) for each in group.elements],
        "axes": [WORLD if each.axes == -1 else saved.name(each.axes) for each in group.elements],
    }
    for key, names in named.items():
        found = [name for name in names if name is not None]
        if len(found) < len(names):
            return None
        note[key] = listed(found, ";")
    note["constraints"] = ";".join(_words(each.constraints) for each in group.elements)
    note["precision"] = ";".join(numbers_text(each.precision) for each in group.elements)
    note["active"] = ";".join("yes" if each.enabled else "no" for each in group.elements)
    note["weights"] = ";".join(numbers_text(each.weights) for each in group.elements)
    return note


def _words(constraints: Constraint) -> str:
    return ",".join(word for word, part in _WORDS if part in constraints) or "none"
