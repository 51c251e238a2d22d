"""Groups of inverse kinematics of V-REP 3, which the server's own kinematics handle."""

from __future__ import annotations

from simx_server.scene.formats.annotations import WORLD
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import Dummy, IkElement, IkGroup

_MOST_ITERATIONS = 10_000

METHODS = {0: "pseudo_inverse", 1: "damped", 2: "transpose"}

CONSTRAINTS = {1: "x", 2: "y", 4: "z", 8: "alpha_beta", 16: "gamma"}
"""Words for the bits of an element's constraints."""


def add_ik_groups(conversion: Conversion) -> None:
    """Annotate the groups, those without a usable element left out; a tip may have no target yet."""
    names = {group.id: group.name for group in conversion.file.ik_groups}
    kept: set[int] = set()
    for group in conversion.file.ik_groups:
        elements = [element for element in group.elements if _is_usable(conversion, group, element)]
        if elements and group.name:
            _add(conversion, group, elements, names.get(group.after) if group.after in kept else None)
            kept.add(group.id)
        else:
            conversion.report.leave_out("groups of inverse kinematics without a tip", group.name)


def _is_usable(conversion: Conversion, group: IkGroup, element: IkElement) -> bool:
    """Return whether an element may move something: it is enabled, and its tip and base exist."""
    is_complete = isinstance(conversion.file.objects.get(element.tip), Dummy) and (
        element.base == -1 or element.base in conversion.names
    )
    if not is_complete:
        conversion.report.leave_out("elements of inverse kinematics without a tip", group.name)
    return is_complete and element.enabled and bool(element.constraints & sum(CONSTRAINTS))


def _target(conversion: Conversion, element: IkElement) -> int:
    """Return the dummy that is linked to the element's tip, -1 for none."""
    tip = conversion.file.objects[element.tip]
    return tip.linked if isinstance(tip, Dummy) else -1


def _add(conversion: Conversion, group: IkGroup, elements: list[IkElement], after: str | None) -> None:
    names = conversion.names
    targets = [_target(conversion, element) for element in elements]
    restore = [part for part, flag in zip(("position", "orientation"), group.restore, strict=True) if flag]
    conversion.annotate(
        "ik",
        group.name,
        tip=";".join(names[element.tip] for element in elements),
        target=";".join(names.get(target, WORLD) for target in targets),
        base=";".join(names.get(element.base, WORLD) for element in elements),
        constraints=";".join(_words(element.constraints) for element in elements),
        precision=";".join(_pair(element.precision) for element in elements),
        weights=";".join(_pair(element.weights) for element in elements),
        method=METHODS.get(group.method, "damped"),
        damping=max(group.damping, 0.0),
        iterations=min(max(group.iterations, 1), _MOST_ITERATIONS),
        handling="explicit" if group.is_explicit else "auto",
        enabled=None if group.is_enabled else False,
        ignores_steps=group.ignores_steps or None,
        restore=",".join(restore) or None,
        after=after,
    )


def _words(constraints: int) -> str:
    return ",".join(word for bit, word in CONSTRAINTS.items() if constraints & bit)


def _pair(values: tuple[float, float]) -> str:
    return ",".join(repr(float(max(value, 0.0))) for value in values)
