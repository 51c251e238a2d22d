"""An environment of `simIK` as bytes, from which the same environment is read.

MessagePack in a form of this project. Objects of the scene have their paths in it, so that they are found in another
session; those that were made in the environment keep their handles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import msgpack

from simx_server.errors import CommandError
from simx_server.scene.naming.paths import path_of
from simx_server.scene.poses.poses import Pose, normalised

from .chain import Constraint, Element
from .environment import Environment, EnvironmentGroup, GroupFlag
from .own_objects import WORLD, OwnJoint, OwnObject
from .solver import Calculation, Method

if TYPE_CHECKING:
    from simx_server.scene.objects import Scene

_FORM = "simx environment 1"
MOST_BYTES = 1 << 20


def save(environment: Environment, scene: Scene) -> bytes:
    """Return an environment as bytes."""
    paths: dict[int, str] = {}

    def named(handle: int) -> int:
        """Note the path of an object of the scene."""
        if handle != WORLD and handle not in environment.own and handle in scene.objects:
            paths[handle] = path_of(scene, handle)
        return handle

    def by_joint(values: Mapping[int, Any]) -> dict[int, Any]:
        return {named(handle): value for handle, value in values.items()}

    kept = environment.kept()
    content = {
        "form": _FORM,
        "own": {
            handle: (one.name, one.joint, named(one.parent), _list(one.local), one.value)
            for handle, one in environment.own.all().items()
        },
        "groups": {number: _group(group, named) for number, group in environment.groups.items()},
        "passive": sorted(map(named, environment.passive)),
        "targets": {named(tip): named(target) for tip, target in environment.targets.items()},
        "poses": {handle: _list(pose) for handle, pose in by_joint(kept.poses).items()},
        **{name: by_joint(values) for name, values in kept.by_joint().items()},
        "paths": paths,
    }
    return msgpack.packb(content)


def load(environment: Environment, scene: Scene, data: bytes) -> None:
    """Fill an empty environment. An error leaves it empty.

    Raises:
        CommandError: it is not empty, the bytes are not those of an environment, or an object does not exist.
    """
    if environment.own.all() or environment.groups:
        raise CommandError(
            "the environment is not empty; load into one that simIK.createEnvironment has made"
        )
    if len(data) > MOST_BYTES:
        raise CommandError(f"a saved environment has at most {MOST_BYTES} bytes, not {len(data)}")
    try:
        content = msgpack.unpackb(data, strict_map_key=False)
        if content["form"] != _FORM:
            raise ValueError("another form")
        places = {int(handle): scene.resolve(str(path)) for handle, path in content["paths"].items()}
        twin = Environment.like(environment)
        _fill(twin, content, lambda handle: places.get(handle, handle))
        for group in twin.groups.values():
            for element in group.elements.values():
                twin.check(element)
    except CommandError:
        raise
    except Exception as error:  # msgpack raises many kinds, and the content may be anything
        raise CommandError(f"the bytes are not an environment that simIK.save made: {error}") from None
    environment.become(twin)


def _fill(environment: Environment, content: Any, here: Callable[[int], int]) -> None:
    own = {
        int(handle): OwnObject(
            str(name), None if kind is None else OwnJoint(kind), here(int(parent)), _pose(local), float(value)
        )
        for handle, (name, kind, parent, local, value) in content["own"].items()
    }
    environment.own.put(own)
    for number, (name, how, elements, flags) in content["groups"].items():
        method, damping, iterations = how
        group = EnvironmentGroup(
            str(name), Calculation(Method(method), float(damping), int(iterations)), flags=GroupFlag(flags)
        )
        group.elements = {int(each): _element(values, here) for each, values in elements.items()}
        environment.groups[int(number)] = group
    environment.passive = {here(int(each)) for each in content["passive"]}
    environment.targets = {here(int(a)): here(int(b)) for a, b in content["targets"].items()}
    kept = environment.kept()
    kept.poses.update({here(int(each)): _pose(pose) for each, pose in content["poses"].items()})
    for name, values in kept.by_joint().items():
        is_interval = name == "intervals"
        for each, value in content[name].items():
            values[here(int(each))] = _interval(value) if is_interval else float(value)


def _group(group: EnvironmentGroup, named: Callable[[int], int]) -> tuple[Any, ...]:
    elements = {
        number: (
            named(each.tip),
            named(each.target),
            named(each.base),
            int(each.constraints),
            each.precision,
            each.weights,
            named(each.axes),
            each.enabled,
        )
        for number, each in group.elements.items()
    }
    how = int(group.how.method), group.how.damping, group.how.iterations
    return group.name, how, elements, int(group.flags)


def _element(values: Any, here: Callable[[int], int]) -> Element:
    tip, target, base, constraints, precision, weights, axes, enabled = values
    (near, turned), (linear, angular) = precision, weights
    return Element(
        here(int(tip)),
        here(int(target)),
        here(int(base)),
        Constraint(constraints),
        (float(near), float(turned)),
        (float(linear), float(angular)),
        here(int(axes)),
        bool(enabled),
    )


def _interval(value: Any) -> tuple[bool, float, float]:
    cyclic, least, extent = value
    return bool(cyclic), float(least), float(extent)


def _list(pose: Pose) -> list[float]:
    return [*pose[0], *pose[1]]


def _pose(values: Any) -> Pose:
    x, y, z, *turn = map(float, values)
    return (x, y, z), normalised(turn)
