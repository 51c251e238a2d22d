"""Give elements of a spec other names, and all that refer to them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco

from simx_server.scene.dependencies import EQUALITY
from simx_server.scene.editing.copies.element_copies import LEAVES, Copier
from simx_server.scene.editing.transplant import OBJECT_TYPES, TRANSMISSIONS, equality_kind
from simx_server.scene.naming.names import INTERNAL

Names = Mapping[tuple[str, str], str]
"""New names by kind of element and old name."""

_KIND_OF_TYPE = {kind: element for element, kinds in OBJECT_TYPES.items() for kind in kinds}
_KIND_OF_DRIVE = {kind: element for element, kinds in TRANSMISSIONS.items() for kind in kinds}


def rename_elements(spec: mujoco.MjSpec, names: Names) -> bool:
    """Rename bodies, joints, geoms, sites, cameras, lights and tendons; others of their kind make room.

    Returns:
        Whether any has another name now.
    """
    names = {key: name for key, name in names.items() if key[1] != name}
    if not names:
        return False
    names = {**_making_room(spec, names), **names}
    paths = [(tendon, str(tendon.name), [_wrap(wrap) for wrap in tendon.path]) for tendon in spec.tendons]
    renamed = [
        (element, names[kind, element.name])
        for kind, many in (("body", "bodies"), *LEAVES.items())
        for element in getattr(spec, many)
        if (kind, element.name) in names
    ]
    for number, (element, _) in enumerate(renamed):  # MuJoCo refuses a name that another element has for now
        element.name = f"{INTERNAL}new:{number}"
    for element, name in renamed:
        element.name = name
    for tendon, name, _ in paths:
        tendon.name = f"{INTERNAL}old:{name}"
    for tendon, name, path in paths:  # a path cannot be changed
        twin = spec.add_tendon()
        _copier_named(names.get(("tendon", name), name)).element(tendon, twin)
        spec.delete(tendon)
        for wrap in path:
            _add_wrap(twin, wrap, names)
    for element, attribute, kind in _references(spec):
        old = getattr(element, attribute)
        if (kind, old) in names:
            setattr(element, attribute, names[kind, old])
    for equality in spec.equalities:
        if EQUALITY in equality.name:  # it is found by the name of its joint
            equality.name = EQUALITY + equality.name1
    _rename_in_lists(spec, names)
    return True


def _copier_named(name: str) -> Copier:
    return Copier(lambda _: name)


def _making_room(spec: mujoco.MjSpec, names: Names) -> dict[tuple[str, str], str]:
    """Return names for elements that have one of the new names and keep no object."""
    made: dict[tuple[str, str], str] = {}
    for kind, many in (("body", "bodies"), *LEAVES.items(), ("tendon", "tendons")):
        new = {name for (which, _), name in names.items() if which == kind}
        taken = {element.name for element in getattr(spec, many)} | new
        for name in [name for name in taken & new if (kind, name) not in names]:
            if any(element.name == name for element in getattr(spec, many)):
                number = next(n for n in range(1, len(taken) + 2) if f"{INTERNAL}{name}_{n}" not in taken)
                made[kind, name] = f"{INTERNAL}{name}_{number}"
                taken.add(made[kind, name])
    return made


def _references(spec: mujoco.MjSpec) -> Iterator[tuple[Any, str, str]]:
    """Yield each reference to another element: the element that has it, its attribute, and the other's kind."""
    for actuator in spec.actuators:
        yield actuator, "target", _KIND_OF_DRIVE.get(actuator.trntype, "")
        yield actuator, "refsite", "site"
        yield actuator, "slidersite", "site"
    for sensor in spec.sensors:
        yield sensor, "objname", _KIND_OF_TYPE.get(sensor.objtype, "")
        yield sensor, "refname", _KIND_OF_TYPE.get(sensor.reftype, "")
    for equality in spec.equalities:
        yield equality, "name1", equality_kind(equality)
        yield equality, "name2", equality_kind(equality)
    for pair in spec.pairs:
        yield pair, "geomname1", "geom"
        yield pair, "geomname2", "geom"
    for exclude in spec.excludes:
        yield exclude, "bodyname1", "body"
        yield exclude, "bodyname2", "body"
    for camera in (*spec.cameras, *spec.lights):
        yield camera, "targetbody", "body"


def _rename_in_lists(spec: mujoco.MjSpec, names: Names) -> None:
    """Rename the bodies that skins and flexible bodies list."""
    lists = [(skin, "bodyname") for skin in spec.skins]
    lists += [(flex, name) for flex in spec.flexes for name in ("nodebody", "vertbody")]
    for element, attribute in lists:
        old = list(getattr(element, attribute))
        new = [names.get(("body", name), name) for name in old]
        if new != old:
            setattr(element, attribute, new)


def _wrap(wrap: Any) -> tuple[Any, str, str, float, float]:
    """Return a place of a tendon's path: type, element, side site, coefficient, divisor."""
    kind = wrap.type
    is_round = kind in (mujoco.mjtWrap.mjWRAP_SPHERE, mujoco.mjtWrap.mjWRAP_CYLINDER)
    name = wrap.target.name if wrap.target is not None else ""
    side = wrap.sidesite.name if is_round and wrap.sidesite is not None else ""
    coefficient = wrap.coef if kind == mujoco.mjtWrap.mjWRAP_JOINT else 0.0
    divisor = wrap.divisor if kind == mujoco.mjtWrap.mjWRAP_PULLEY else 0.0
    return kind, name, side, coefficient, divisor


def _add_wrap(tendon: Any, wrap: tuple[Any, str, str, float, float], names: Names) -> None:
    kind, name, side, coefficient, divisor = wrap
    if kind == mujoco.mjtWrap.mjWRAP_PULLEY:
        tendon.wrap_pulley(divisor)
    elif kind == mujoco.mjtWrap.mjWRAP_JOINT:
        tendon.wrap_joint(names.get(("joint", name), name), coefficient)
    elif kind == mujoco.mjtWrap.mjWRAP_SITE:
        tendon.wrap_site(names.get(("site", name), name))
    else:
        tendon.wrap_geom(names.get(("geom", name), name), names.get(("site", side), side))
