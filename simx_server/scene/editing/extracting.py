"""Extract a part of a scene from its spec: some bodies and leaves, and the elements that act on them.

Copying and emptying a spec of thousands of bodies for one of them would take too long: the part is built element by
element.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import Any

import mujoco

from .copies.element_copies import LEAVES, Copier
from .transplant import OBJECT_TYPES, TRANSMISSIONS, equality_kind

_AS_IT_IS = Copier(lambda name: name)

_KIND_OF = {kind: element for element, kinds in OBJECT_TYPES.items() for kind in kinds}

_HOLDING = (
    mujoco.mjtEq.mjEQ_CONNECT,
    mujoco.mjtEq.mjEQ_WELD,
    mujoco.mjtEq.mjEQ_JOINT,
    mujoco.mjtEq.mjEQ_TENDON,
)

_WRAPPED = {
    mujoco.mjtWrap.mjWRAP_JOINT: "joint",
    mujoco.mjtWrap.mjWRAP_SITE: "site",
    mujoco.mjtWrap.mjWRAP_SPHERE: "geom",
    mujoco.mjtWrap.mjWRAP_CYLINDER: "geom",
}


def extract(
    spec: mujoco.MjSpec,
    bodies: Mapping[str, str],
    leaves: Iterable[tuple[str, str]],
    without: AbstractSet[tuple[str, str]] = frozenset(),
) -> mujoco.MjSpec:
    """Return a new spec with some of a spec's bodies and leaves, under the same names and without assets.

    Elements that act on them (tendons, actuators, sensors, equalities, pairs, exclusions) are included if all elements
    that they name are.

    Args:
        bodies: name to the name of the parent body, parents first; a body whose parent is not among them is placed in
            the world, where it has no frame unless it was there before.
        leaves: kind and name of leaves outside these bodies; they are placed in the world in the same way.
        without: kind and name of leaves of these bodies, and of tendons, that are left out. Deleting them later would
            cost one search of the whole spec each.

    Raises CommandError for plugins.
    """
    part = mujoco.MjSpec()
    twins: dict[str, Any] = {"world": part.worldbody}
    frames: dict[str, dict[Any, Any]] = {"world": {}}
    for name, parent in bodies.items():
        old = spec.body(name)
        twin = twins.get(parent, part.worldbody).add_body()
        _AS_IT_IS.element(old, twin)
        if parent in twins:
            _AS_IT_IS.frame(old, twin, twins[parent], frames[parent])
        frames[name] = _AS_IT_IS.leaves(old, twin, without=without)
        twins[name] = twin
    for kind, name in leaves:
        old = getattr(spec, kind)(name)
        twin = getattr(part.worldbody, f"add_{kind}")()
        _AS_IT_IS.element(old, twin)
        if old.parent.name == "world":
            _AS_IT_IS.frame(old, twin, part.worldbody, frames["world"])
    present = {kind: {element.name for element in getattr(part, many)} for kind, many in LEAVES.items()}
    present["body"] = {body.name for body in part.bodies}  # the world too
    for kind, element in acting_on(spec, present, without):
        copy_acting(_AS_IT_IS, kind, element, part)
    return part


def acting_on(
    spec: mujoco.MjSpec, present: dict[str, set[str]], without: AbstractSet[tuple[str, str]] = frozenset()
) -> Iterator[tuple[str, Any]]:
    """Yield kind and element of the tendons, actuators, sensors, equalities, pairs and exclusions of a part of a spec.

    They name only elements of the part.

    Args:
        spec: the spec.
        present: the part: kind to the names of its bodies and leaves. Tendons and actuators are added.
        without: ("tendon", name) of tendons that do not belong to it.
    """
    return _Acting(spec, present, without).find()


def copy_acting(copier: Copier, kind: str, element: Any, target: mujoco.MjSpec) -> None:
    """Copy an element of `acting_on` into a spec."""
    twin = getattr(target, f"add_{kind}")()
    copier.element(element, twin)
    if kind == "tendon":
        copier.path(element, twin)


class _Acting:
    """Find the elements that name only elements of a part."""

    def __init__(
        self, spec: mujoco.MjSpec, present: dict[str, set[str]], without: AbstractSet[tuple[str, str]]
    ) -> None:
        self._spec = spec
        self._without = without
        self._present = present
        present["tendon"], present["actuator"] = set(), set()

    def find(self) -> Iterator[tuple[str, Any]]:
        """Yield tendons, actuators, sensors, equalities, pairs and exclusions, each with its kind."""
        yield from self._actuation()
        yield from self._constraints()

    def _actuation(self) -> Iterator[tuple[str, Any]]:
        for tendon in self._spec.tendons:
            if ("tendon", tendon.name) not in self._without and all(map(self._wraps, tendon.path)):
                self._present["tendon"].add(tendon.name)
                yield "tendon", tendon
        for actuator in self._spec.actuators:
            if self._is_of_the_part(actuator):
                self._present["actuator"].add(actuator.name)
                yield "actuator", actuator
        for sensor in self._spec.sensors:
            if self._has(_KIND_OF.get(sensor.objtype), sensor.objname) and (
                not sensor.refname or self._has(_KIND_OF.get(sensor.reftype), sensor.refname)
            ):
                yield "sensor", sensor

    def _constraints(self) -> Iterator[tuple[str, Any]]:
        for equality in self._spec.equalities:
            kind = equality_kind(equality) if equality.type in _HOLDING else None
            if self._has(kind, equality.name1) and (not equality.name2 or self._has(kind, equality.name2)):
                yield "equality", equality
        for pair in self._spec.pairs:
            if self._has("geom", pair.geomname1) and self._has("geom", pair.geomname2):
                yield "pair", pair
        for exclude in self._spec.excludes:
            if self._has("body", exclude.bodyname1) and self._has("body", exclude.bodyname2):
                yield "exclude", exclude

    def _has(self, kind: str | None, name: str) -> bool:
        return kind is not None and name in self._present[kind]

    def _wraps(self, wrap: Any) -> bool:
        if wrap.target is None:  # a pulley
            return True
        side = wrap.sidesite
        return self._has(_WRAPPED.get(wrap.type), wrap.target.name) and (
            side is None or self._has("site", side.name)
        )

    def _is_of_the_part(self, actuator: Any) -> bool:
        names = {actuator.target, actuator.refsite, actuator.slidersite} - {""}
        kinds = [element for element, types in TRANSMISSIONS.items() if actuator.trntype in types]
        return bool(kinds) and all(self._has(kinds[0], name) for name in names)
