"""Calls of clients: most go to the namespaces of scripts; some mean something else for a client.

The latter are those of CoppeliaSim's add-on that serves this protocol: they list the namespaces and step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from simx_client.protocol.nearest import did_you_mean
from simx_server import sim_api as api
from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Function, Waiting
from simx_server.service.clients.rights import may
from simx_server.sim_api.namespaces import signatures
from simx_server.simulation.simulation import SimulationState

from . import permissions
from .forms import FORMS
from .functions import Function as Described
from .functions import described
from .listing import namespace
from .wire.messages import EVAL

if TYPE_CHECKING:
    from .client import Client

MOST_TEST_CALLS = 10_000
"""Calls of a function of the client by one sim.testCB."""

_Own = Callable[["Client", list[Any]], "tuple[Any, ...] | Waiting"]


def invoke(client: Client, full_name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
    """Run a function of a namespace; return its results, or a generator that returns them and yields once per step.

    Args:
        arguments: as scripts give them.

    Raises:
        CommandError: the function does not exist, is refused, or fails.
    """
    function = described(full_name)
    if function.effect is not None and not may(client.session, function):
        raise CommandError(
            f"{full_name[:80]} may change something, and {client.name} is a viewer, who may only read"
        )
    own = _OWN.get(function.full_name)
    if own is not None:
        return own(client, arguments)
    if not function.is_known:
        raise _no_such_function(full_name, function)
    if function.space == "sim":
        permissions.check(client.world, function, arguments)
    outcome = client.namespaces.function(function.full_name)(arguments)
    form = FORMS.get(function.full_name)
    return outcome if form is None or not isinstance(outcome, tuple) else form(arguments, outcome)


class NoSuchFunction(CommandError):
    """A name that no function of this server has."""


def _no_such_function(full_name: str, function: Described) -> NoSuchFunction:
    has_space = function.space in api.NAMESPACES
    known = signatures(function.space) if has_space else api.NAMESPACES
    wanted = function.name if has_space else function.space
    return NoSuchFunction(f"No such function: {full_name}{did_you_mean(wanted, list(known))}")


def _text(arguments: list[Any], what: str) -> str:
    if not arguments or not isinstance(arguments[0], bytes):
        raise CommandError(f"argument 1 must be {what}")
    return arguments[0].decode("utf-8", "replace")


def _info(_client: Client, arguments: list[Any]) -> tuple[Any, ...]:
    return (namespace(_text(arguments, "the name of a namespace")),)


def _require(_client: Client, arguments: list[Any]) -> tuple[Any, ...]:
    namespace(_text(arguments, "the name of a namespace"))
    return ()


def _eval(client: Client, arguments: list[Any]) -> tuple[Any, ...]:
    """Run a piece of Lua, an expression or statements, in the sandbox script; return its results."""
    permissions.require_code(client.world)
    text = _text(arguments, "a piece of Lua")
    scripts = client.world.scripts
    chunk, *problem = scripts.run(scripts.sandbox, "load", f"return {text}")
    if chunk is None:
        chunk, *problem = scripts.run(scripts.sandbox, "load", text)
    if chunk is None:
        raise CommandError(problem[0].decode("utf-8", "replace"))
    return tuple(chunk())


def set_stepping(client: Client, arguments: list[Any]) -> tuple[Any, ...]:
    """Raise the level with true, lower it with false, set it with a number; return the level before."""
    enable: Any = arguments[0] if arguments else True
    client.forget_lost_stepping()
    before = client.level
    if isinstance(enable, bool) or not isinstance(enable, (int, float)):
        client.level = before + 1 if enable else max(0, before - 1)
    else:
        client.level = max(0, int(enable))
    client.set_stepping()
    return (before,)


def step(client: Client, _arguments: list[Any]) -> Waiting:
    """Wait for the next simulation step; return at once while the simulation is stopped or paused."""
    if why := client.session.lost_stepping:
        client.forget_lost_stepping()
        raise CommandError(f"{why}; call sim.setStepping(True) again")
    simulation = client.world.simulation
    before = simulation.step_count
    if simulation.state is SimulationState.RUNNING:
        yield
        while simulation.state is SimulationState.RUNNING and simulation.step_count == before:
            yield
    return ()


def lock_simulation(client: Client, _arguments: list[Any]) -> tuple[Any, ...]:
    client.forget_lost_stepping()
    client.locks += 1
    client.set_stepping()
    return ()


def unlock_simulation(client: Client, _arguments: list[Any]) -> tuple[Any, ...]:
    client.forget_lost_stepping()
    client.locks = max(0, client.locks - 1)
    client.set_stepping()
    return ()


def _test_call_backs(_client: Client, arguments: list[Any]) -> tuple[Any, ...]:
    """Call a function of the client: ``sim.testCB(a, function, b, n)`` calls function(a, b) n times, and once more."""
    first, function, second, times = [*arguments, None, None, None, None][:4]
    if not isinstance(function, Function):
        raise CommandError("argument 2 must be a function")
    times = 99 if times is None else times
    if not isinstance(times, (int, float)) or not 0 <= times <= MOST_TEST_CALLS:
        raise CommandError(f"argument 4 must be a number from 0 to {MOST_TEST_CALLS}")
    for _ in range(int(times)):
        function(first, second)
    return tuple(function(first, second))


def _nothing(_client: Client, _arguments: list[Any]) -> tuple[Any, ...]:
    """Do nothing: a client is served when its message comes, whatever the timing of threads."""
    return ()


_OWN: Mapping[str, _Own] = {
    "zmqRemoteApi.info": _info,
    "zmqRemoteApi.require": _require,
    EVAL: _eval,
    "sim.setStepping": set_stepping,
    "sim.step": step,
    "sim.yield": step,
    "sim.switchThread": step,
    "sim.acquireLock": lock_simulation,
    "sim.releaseLock": unlock_simulation,
    "sim.testCB": _test_call_backs,
    "sim.handleExtCalls": _nothing,
    "sim.setThreadSwitchTiming": _nothing,
    "sim.setThreadAutomaticSwitch": _nothing,
}
"""Functions that mean something else for a client than for a script."""
