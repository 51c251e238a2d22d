"""Several copies of a robot in a scene: `simx:copies:NAME` adds copies of a body when a file is read.

::

    <include file="models/pioneer_p3dx.xml"/>
    <text name="simx:copies:Pioneer_p3dx" data="count=2 y=1"/>

NAME, a body at the top with all below it, is copied with its motors, sensors, scripts and registered entries.
Names are V-REP's: `Pioneer_p3dx#0` is the first copy, `Pioneer_p3dx#1` the second; all parts get the same suffix.
Each copy stands `x=`, `y=`, `z=` metres from the one before, turned by `turn_deg=` about the vertical. Copies with the
same number belong together, also those of several lines: an IK group whose target is another body has it in the copies.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import mujoco

from simx_server.errors import CommandError
from simx_server.scene.editing.copies.element_copies import LEAVES, Copier
from simx_server.scene.editing.transplant import delete_all
from simx_server.scene.naming.names import copy_names
from simx_server.scene.registered import concerned, renamed, renamed_registered

from .annotations import PREFIX, Annotation, Annotations, SceneError

KIND = "copies"

_MOST_ELEMENTS = 5_000
"""Most elements of all copies together."""

_NAMED = (*LEAVES, "tendon")
"""Kinds of elements that carry objects, beside bodies."""


def copy_models(spec: mujoco.MjSpec, annotations: Annotations, welded: set[str]) -> set[str]:
    """Execute the annotations of this kind, and remove them.

    Args:
        spec: the scene; all its elements have names.
        welded: names of bodies that lost their free joint when they were mounted.

    Returns:
        The names of the copies of these bodies.

    Raises:
        SceneError: no body at the top, too many elements, or an element that cannot be copied.
    """
    notes = {name: kinds.pop(KIND) for name, kinds in annotations.objects.items() if KIND in kinds}
    if not notes:
        return set()
    for name in notes:
        body = spec.body(name)
        if body is None or body.parent.name != "world":
            raise SceneError(
                f"text '{PREFIX}{KIND}:{name}' is for a body at the top of the scene; '{name}' is none"
            )
    for key in list(spec.keys):  # their positions belong to the scene without copies
        spec.delete(key)
    counts = {name: int(note.get("count", 1)) for name, note in notes.items()}
    _check(sum(count * _size(spec.body(name)) for name, count in counts.items()))
    # With each number fewer bodies are copied: the part shrinks, and with it the elements that act on it.
    part, bodies, elements, total = spec.copy(), set[str](), list[tuple[str, str]](), 0
    result = set[str]()
    taken = {name for _, name in _elements(spec)}
    taken |= {name for each in annotations.registered.values() for name in each}
    for number in range(1, max(counts.values()) + 1):
        chosen = {name for name in bodies or counts if number <= counts[name]}
        if chosen != bodies:
            _delete_others(part, chosen)
            bodies, elements = chosen, _elements(part)
        total += len(elements)
        _check(total)
        names = _add(part, spec, elements, taken, number, annotations)
        for name in bodies:
            _place(spec.body(names[name]), notes[name], number)
        result |= {names[name] for name in welded & names.keys()}
    return result


def _check(elements: int) -> None:
    if elements > _MOST_ELEMENTS:
        raise SceneError(f"the copies have more than {_MOST_ELEMENTS} elements; write fewer into count=")


def _size(top: Any) -> int:
    """Return the number of elements in a body and all below it, without those that act on them."""
    size, waiting = 0, [top]
    while waiting:
        body = waiting.pop()
        size += 1 + sum(len(list(getattr(body, many))) for many in LEAVES.values())
        waiting += list(body.bodies)
    return size


def _add(
    part: mujoco.MjSpec,
    spec: mujoco.MjSpec,
    elements: Collection[tuple[str, str]],
    taken: set[str],
    number: int,
    annotations: Annotations,
) -> dict[str, str]:
    """Add a part to the scene under new names, which are taken then; return old name to new.

    `elements`: kind and name, of the part. `number`: from 1.
    """
    carriers = [(kind, name) for kind, name in elements if kind in ("body", *_NAMED)]
    # Where a body and a joint share a name, one object has its kind appended.
    objects = {name for _, name in carriers} | {f"{name}_{kind}" for kind, name in carriers}
    registered = concerned(annotations.registered, objects)
    wanted = {name for _, name in elements} | {name for notes in registered.values() for name in notes}
    names = copy_names(wanted | objects, taken, number)
    taken.update(names.values())
    try:
        Copier(lambda name: names.get(name, name), references=True).everything(part, spec)
    except CommandError as problem:
        raise SceneError(str(problem)) from None
    for name in objects & annotations.objects.keys():
        annotations.objects[names[name]] = renamed(annotations.objects[name], names)
    for kind, notes in registered.items():
        for name, note in notes.items():
            annotations.registered[kind][names[name]] = renamed_registered(note, names)
    return names


def _delete_others(part: mujoco.MjSpec, chosen: Collection[str]) -> None:
    """Remove all but these bodies and the elements that act within and between them."""
    for many in (part.skins, part.flexes):
        for element in list(many):
            part.delete(element)
    for sensor in list(part.sensors):
        if sensor.objtype == mujoco.mjtObj.mjOBJ_UNKNOWN or sensor.objname == "world":
            part.delete(sensor)
    world = part.worldbody
    others = [("body", body.name) for body in world.bodies if body.name not in chosen]
    others += [
        (kind, leaf.name) for kind, many in LEAVES.items() if kind != "joint" for leaf in getattr(world, many)
    ]
    delete_all(part, others)


def _elements(spec: mujoco.MjSpec) -> list[tuple[str, str]]:
    """Return kind and name of every element that has a separate name in the model."""
    lists: dict[str, Any] = {kind: getattr(spec, many) for kind, many in LEAVES.items()}
    lists |= {kind: getattr(spec, f"{kind}s") for kind in ("tendon", "actuator", "sensor", "pair", "exclude")}
    lists |= {"body": spec.bodies[1:], "equality": spec.equalities}
    return [(kind, element.name) for kind, many in lists.items() for element in many if element.name]


def _place(body: Any, note: Annotation, steps: int) -> None:
    for axis, key in enumerate(("x", "y", "z")):
        body.pos[axis] += steps * float(note.get(key, 0.0))
    half = math.radians(float(note.get("turn_deg", 0.0))) * steps / 2
    quat = body.quat.copy()
    mujoco.mju_mulQuat(quat, [math.cos(half), 0, 0, math.sin(half)], body.quat)
    body.quat[:] = quat
