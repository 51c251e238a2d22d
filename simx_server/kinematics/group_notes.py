"""A group of inverse kinematics as an annotation: read when a file is loaded, and written when it is saved."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import WORLD, Annotation
from simx_server.scene.saved import listed, numbers_text

from .chain import Constraint, Element
from .group import Group
from .solver import Calculation, Method

if TYPE_CHECKING:
    from simx_server.scene.saved import Saved

_CONSTRAINTS = {
    "pose": Constraint.POSE,
    "position": Constraint.POSITION,
    "orientation": Constraint.ORIENTATION,
    "x": Constraint.X,
    "y": Constraint.Y,
    "z": Constraint.Z,
    "alpha_beta": Constraint.ALPHA_BETA,
    "gamma": Constraint.GAMMA,
    "none": Constraint(0),
}
"""Words of an annotation."""

_METHODS = {
    "pseudo_inverse": Method.PSEUDO_INVERSE,
    "damped": Method.DAMPED_LEAST_SQUARES,
    "transpose": Method.JACOBIAN_TRANSPOSE,
}
"""Words of an annotation."""

_METHOD_WORDS = {method: word for word, method in _METHODS.items()}

_ON = ("yes", "on", "true")

_DEFAULT = Calculation()
_PRECISION = "{},{!r}".format(*Element(0, 0).precision)


_WORDS = (
    ("x", Constraint.X),
    ("y", Constraint.Y),
    ("z", Constraint.Z),
    ("alpha_beta", Constraint.ALPHA_BETA),
    ("gamma", Constraint.GAMMA),
)


def read_group(name: str, note: Annotation, named: Callable[[str], int]) -> Group:
    """Return the group of an annotation; `named` returns the handle of a name."""
    return Group(
        name,
        _read_elements(note, named),
        _read_calculation(note),
        explicit=note.get("handling", "auto") == "explicit",
        enabled=bool(note.get("enabled", True)),
        restore=frozenset(filter(None, str(note.get("restore", "")).split(","))),
        after=str(note.get("after", "")),
        ignores_steps=bool(note.get("ignores_steps", False)),
        margins=_read_pair(str(note.get("margins", "0,0"))),
    )


def _read_elements(note: Annotation, named: Callable[[str], int]) -> list[Element]:
    if "tip" not in note:
        return []
    tips = str(note["tip"]).split(";")

    def values(key: str, default: str) -> list[str]:
        words = str(note.get(key, default)).split(";")
        return words if len(words) > 1 else words * len(tips)

    return [
        Element(
            named(tip),
            -1 if target == WORLD else named(target),
            -1 if base == WORLD else named(base),
            _read_constraints(constraints),
            _read_pair(precision),
            _read_pair(weights),
            -1 if axes == WORLD else named(axes),
            active in _ON,
        )
        for tip, target, base, constraints, precision, weights, axes, active in zip(
            tips,
            values("target", ""),
            values("base", WORLD),
            values("constraints", "pose"),
            values("precision", _PRECISION),
            values("weights", "1,1"),
            values("axes", WORLD),
            values("active", "yes"),
            strict=True,
        )
    ]


def _read_calculation(note: Annotation) -> Calculation:
    damping = float(note.get("damping", _DEFAULT.damping))
    usual = "damped" if damping > 0 else "pseudo_inverse"
    method = _METHODS[str(note.get("method", usual))]
    return Calculation(method, damping, int(note.get("iterations", _DEFAULT.iterations)))


def _read_constraints(words: str) -> Constraint:
    wanted = Constraint(0)
    for word in words.split(","):
        wanted |= _CONSTRAINTS[word]
    return wanted


def _read_pair(words: str) -> tuple[float, float]:
    first, second = words.split(",")
    return float(first), float(second)


def note_of(saved: Saved, group: Group) -> Annotation | None:
    """Return the annotation of a group; None where objects of it are not saved."""
    note: Annotation = {
        "method": _METHOD_WORDS[group.how.method],
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
