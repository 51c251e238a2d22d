"""Calls of clients of API 2: most are methods of objects; some mean something else for a client than for a script."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import GeneratorType
from typing import TYPE_CHECKING, Any, cast

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Waiting
from simx_server.sim_api.object_model.classes import SELF
from simx_server.sim_api.object_model.dispatch import call_method, effect_of

from ..zmq import permissions
from ..zmq.calls import lock_simulation, set_stepping, step, unlock_simulation
from ..zmq.functions import described

if TYPE_CHECKING:
    from ..zmq.client import Client

_IN_SCRIPTS = (
    "works only in a script of the scene: a client has its own clock, and its calls end with its answer"
)

_Own = Callable[["Client", list[Any]], "tuple[Any, ...] | Waiting"]


def invoke(client: Client, target: int, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
    """Call a method; return its results, or a generator that returns them and yields once per simulation step.

    Raises:
        CommandError: no such object or method, the client may not call it, or it fails.
    """
    world, script = client.world, client.script
    is_self = target in (SELF, script.handle)
    if is_self and name in _OF_CLIENT:
        if client.session.may_only_read and name not in _READING:
            raise _viewer(client, name)
        return _OF_CLIENT[name](client, arguments)
    effect = effect_of(world, script, script.handle if is_self else target, name)
    if client.session.may_only_read and effect not in ("reads", None):
        raise _viewer(client, name)
    if effect == "needs a script" and name != "wait":
        raise CommandError(_IN_SCRIPTS)
    if effect == "runs code":
        permissions.require_code(world)
    if name == "callFunction":
        permissions.check(world, described("sim.callScriptFunction"), arguments[:1])
    found = call_method(client.namespaces.space("sim"), world, script, target, name, arguments)
    if found is None:
        return ()
    return cast(Any, found) if isinstance(found, (GeneratorType, tuple)) else (found,)


def _viewer(client: Client, name: str) -> CommandError:
    return CommandError(f"{name[:80]} may change something, and {client.name} is a viewer, who may only read")


def _stepping(client: Client, arguments: list[Any]) -> tuple[Any, ...]:
    set_stepping(client, [bool(arguments[0]) if arguments else True])
    return ()


def _is_stepping(client: Client, _arguments: list[Any]) -> tuple[Any, ...]:
    return (client.level > 0,)


def _lock(client: Client, arguments: list[Any]) -> tuple[Any, ...]:
    if not arguments or arguments[0]:
        return lock_simulation(client, [])
    return unlock_simulation(client, [])


_READING = ("getStepping",)

_OF_CLIENT: Mapping[str, _Own] = {
    "setStepping": _stepping,
    "getStepping": _is_stepping,
    "step": step,
    "yield": step,
    "lock": _lock,
}
"""Methods of `sim.self` that mean something else for a client than for a script."""
