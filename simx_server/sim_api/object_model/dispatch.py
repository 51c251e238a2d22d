"""The one verb of API 2: call the method NAME of the object HANDLE with arguments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.sim_api.effects import Effect

from .classes import SELF, class_of
from .instances.custom import method_at
from .methods import (
    app,
    creating,
    custom,
    drawing,
    ik,
    paths,
    properties,
    scene,
    scene_objects,
    scripts,
    sensors,
    shapes,
)
from .methods.method import METHODS, Call, Method, methods_of
from .values import Ref, from_script

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

    from .methods.api_1 import Api1

MODULES = (
    properties,
    scene,
    scene_objects,
    shapes,
    sensors,
    drawing,
    creating,
    scripts,
    app,
    paths,
    ik,
    custom,
)
"""The modules that declare the methods."""


def methods(kind: str) -> Mapping[str, Method]:
    """Return the methods of a class with those of the classes above it."""
    return methods_of(kind)


def is_known(name: str) -> bool:
    """Return whether any class has a method of a name."""
    return any(name in known for known in METHODS.values())


def effect_of(world: World, script: Script, handle: int, name: str) -> Effect | None:
    """Return what a method does to the simulator; None: no object or method is meant."""
    try:
        found = methods(class_of(world, handle, script)).get(name)
    except CommandError:
        return "reads" if name == "isValid" else None
    if found is None:
        return None if method_at(world, handle, name) is None else "changes"
    return found.effect


def call_method(sim: Api1, world: World, script: Script, handle: int, name: str, arguments: list[Any]) -> Any:
    """Call a method.

    Args:
        sim: the functions of API 1, as the caller has them.
        world: the world.
        script: the caller.
        handle: the object.
        name: the method, as `simulation.start`.
        arguments: values of API 2.

    Returns:
        A result, a tuple of several, None for a method without results, or a generator that returns them and yields
        once per simulation step.

    Raises:
        CommandError: no such object or method, wrong arguments, or the method fails.
    """
    if handle == SELF:
        handle = script.handle
    try:
        kind = class_of(world, handle, script)
    except CommandError:
        if name == "isValid":
            return False
        raise
    found = methods(kind).get(name)
    if found is None:
        own = method_at(world, handle, name)
        if own is None:
            raise _no_such_method(kind, name)
        return tuple(own(Ref(handle), *arguments))
    return found.run(Call(sim, world, script, handle), arguments)


def _no_such_method(kind: str, name: str) -> CommandError:
    others = [each for each, known in METHODS.items() if name in known]
    if others:
        return CommandError(
            f"the method {name} is not available for this object type, {kind}; it is one of {', '.join(others)}"
        )
    return CommandError(
        f"no method of class {kind} is called '{name[:60]}'{did_you_mean(name, list(methods(kind)))}"
    )


def values_of(arguments: list[Any], *, texts_are_bytes: bool) -> list[Any]:
    """Return a script's arguments as values of API 2. Raises CommandError.

    Args:
        arguments: of a call.
        texts_are_bytes: whether the script's texts are bytes.
    """
    found: list[Any] = []
    for place, each in enumerate(arguments, 1):
        try:
            found.append(from_script(each, texts_are_bytes=texts_are_bytes))
        except TypeError as problem:
            raise CommandError(f"argument {place} must be {problem}") from None
    return found
