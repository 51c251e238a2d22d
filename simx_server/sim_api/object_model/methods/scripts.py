"""Methods of scripts, of the client that calls, and of script objects."""

from __future__ import annotations

from typing import Any

from simx_server.errors import CommandError
from simx_server.scripting.conversion.strings import with_texts
from simx_server.scripting.interpreter import Waiting
from simx_server.sim_api.object_model.classes import SELF, script_at
from simx_server.sim_api.object_model.values import from_script

from .method import Call, Options, method, option, text_option
from .scene import found_object


def _handle(call: Call) -> int:
    """Return the handle of the script in API 1; that of a script object's script for a script object."""
    scene = call.world.simulation.scene
    if call.handle in scene.objects:
        found = next((one for one in call.world.scripts.all() if one.place == call.handle), None)
        if found is None:
            raise CommandError(f"script object '{scene.get(call.handle).name}' has no script: it was removed")
        return found.handle
    return call.handle


def _own(call: Call) -> None:
    """Refuse for another script than the one that calls. Raises CommandError."""
    if call.handle not in (SELF, call.script.handle):
        raise CommandError("a script waits and steps for itself only: use sim.self")


@method("detachedScript", "getObject", "reads")
def get_object(call: Call, path: str, options: Options = None) -> Any:
    """Return the object of a path that starts at the object of the script."""
    script = script_at(call.world, call.handle, call.script)
    home = script.home if script is not None and script.home != -1 else None
    return found_object(call, path, home if path.startswith((".", ":")) else None, options)


@method("detachedScript script", "callFunction", "changes")
def call_function(call: Call, name: str, argument: Any = None) -> Any:
    """Call a function of a script with one value, and return its first result."""
    values = [] if argument is None else [argument]
    found = call.sim.callScriptFunction(_handle(call), name, *values)
    return (from_script(with_texts(found[0])) if found else None,)


@method("detachedScript script", "executeString", "runs code")
def execute_string(call: Call, text: str) -> Any:
    """Run a piece of Lua in a script; return 0 and its first result, or -1 and the message."""
    code, *results = call.sim.executeScriptString(text, _handle(call))
    return code, (from_script(with_texts(results[0])) if results else None)


@method("detachedScript script", "init", "changes")
def init(call: Call) -> Any:
    """End a script with its cleanup, and start it again."""
    return call.sim.initScript(_handle(call)) and None


@method("detachedScript", "step", "needs a script")
def step(call: Call) -> Waiting:
    """Wait for the next simulation step."""
    _own(call)
    return _no_result(call.sim.step())


@method("detachedScript", "yield", "needs a script")
def yield_(call: Call) -> Waiting:
    """Let others run: wait for the next simulation step."""
    return step(call)


@method("detachedScript", "wait", "needs a script")
def wait(call: Call, delay: float, simulation_time: bool = True) -> Waiting:
    """Wait for some seconds, of the simulation or of the wall clock."""
    _own(call)
    return _no_result(call.sim.wait(delay, simulation_time))


def _no_result(steps: Waiting) -> Waiting:
    yield from steps
    return ()


@method("detachedScript", "setStepping", "needs a script")
def set_stepping(call: Call, enable: bool) -> None:
    """Switch the automatic switching of the script's thread off, or on again."""
    _own(call)
    call.sim.setStepping(enable)


@method("detachedScript", "getStepping", "reads")
def get_stepping(call: Call) -> bool:
    """Return whether the thread switches only where the script says so."""
    script = script_at(call.world, call.handle, call.script)
    return script is not None and script.switching.level > 0


@method("detachedScript", "lock", "needs a script")
def lock(call: Call, acquire: bool) -> None:
    """Hold the thread until the lock is released."""
    _own(call)
    if acquire:
        call.sim.acquireLock()
    else:
        call.sim.releaseLock()


@method("detachedScript", "broadcast", "changes")
def broadcast(call: Call, message: dict[str, Any]) -> None:
    """Call ``sysCall_msg`` of all other scripts."""
    call.sim.broadcastMsg(message)


@method("detachedScript", "setEventFilters", "needs a script")
def set_event_filters(call: Call, filters: dict[str, Any]) -> None:
    """Choose the properties of which ``sysCall_event`` hears."""
    _own(call)
    call.sim.setEventFilters(filters)


@method("detachedScript", "setModuleEntry", "changes")
def set_module_entry(call: Call, handle: int, options: Options = None) -> int:
    """Create or change an entry of the menu of modules, and return its handle."""
    return call.sim.moduleEntry(handle, text_option(options, "label"), -1)


@method("detachedScript", "getStackTraceback", "reads")
def get_stack_traceback(call: Call) -> str:
    """Return the error that stopped a script; '' for one that runs."""
    script = script_at(call.world, call.handle, call.script)
    return script.problem if script is not None else ""


@method("detachedScript", "remove", "changes")
def remove(call: Call, options: Options = None) -> None:
    """Remove a script with its script object."""
    script = script_at(call.world, call.handle, call.script)
    if script is None or script.place == -1:
        raise CommandError("only the script of a script object can be removed")
    call.sim.removeObjects([script.place], bool(option(options, "delayed", False)))
