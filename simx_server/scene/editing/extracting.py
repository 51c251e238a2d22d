"""Extract a part of a scene from its spec: some bodies and leaves, and the elements that act on them.

Copying and emptying a spec of thousands of bodies for one of them would take too long: the part is built element by
element.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
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
    _Acting(spec, part, without).take()
    return part


class _Acting:
    """Copy the elements that name only elements of the part."""

    def __init__(
        self, spec: mujoco.MjSpec, part: mujoco.MjSpec, without: AbstractSet[tuple[str, str]]
    ) -> None:
        self._spec = spec
        self._part = part
        self._without = without
        self._present: dict[str, set[str]] = {
            kind: {element.name for element in getattr(part, many)} for kind, many in LEAVES.items()
        }
        self._present["body"] = {body.name for body in part.bodies}  # the world too
        self._present["tendon"], self._present["actuator"] = set(), set()

    def take(self) -> None:
        """Add the tendons, actuators, sensors, equalities, pairs and excludes of the part."""
        self._take_actuation()
        self._take_constraints()

    def _take_actuation(self) -> None:
        spec, part = self._spec, self._part
        for tendon in spec.tendons:
            if ("tendon", tendon.name) not in self._without and all(map(self._wraps, tendon.path)):
                twin = part.add_tendon()
                _AS_IT_IS.element(tendon, twin)
                _AS_IT_IS.path(tendon, twin)
                self._present["tendon"].add(tendon.name)
        for actuator in spec.actuators:
            if self._is_of_the_part(actuator):
                _AS_IT_IS.element(actuator, part.add_actuator())
                self._present["actuator"].add(actuator.name)
        for sensor in spec.sensors:
            if self._has(_KIND_OF.get(sensor.objtype), sensor.objname) and (
                not sensor.refname or self._has(_KIND_OF.get(sensor.reftype), sensor.refname)
            ):
                _AS_IT_IS.element(sensor, part.add_sensor())

    def _take_constraints(self) -> None:
        spec, part = self._spec, self._part
        for equality in spec.equalities:
            kind = equality_kind(equality) if equality.type in _HOLDING else None
            if self._has(kind, equality.name1) and (not equality.name2 or self._has(kind, equality.name2)):
                _AS_IT_IS.element(equality, part.add_equality())
        for pair in spec.pairs:
            if self._has("geom", pair.geomname1) and self._has("geom", pair.geomname2):
                _AS_IT_IS.element(pair, part.add_pair())
        for exclude in spec.excludes:
            if self._has("body", exclude.bodyname1) and self._has("body", exclude.bodyname2):
                _AS_IT_IS.element(exclude, part.add_exclude())

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
