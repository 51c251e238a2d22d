"""The life of one script: its start, calls into it, and its end, by an error or otherwise."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from simx_server.parts.status_bar import as_log_line

from ..scene.properties import SCRIPTS_INACTIVE
from .bodies import with_call_backs
from .interpreter import TIME_LIMIT, Function, Interpreter, ScriptError
from .script import (
    PYTHON,
    USUAL_VERBOSITY,
    CodeNotAllowed,
    Script,
    ScriptKind,
    ScriptSide,
    Spaces,
    script_folder,
)

if TYPE_CHECKING:
    from simx_server.parts.communication.signals import Signals
    from simx_server.parts.status_bar import StatusBar
    from simx_server.simulation.simulation import Simulation

    from .lua.interpreter import LuaInterpreter

logger = logging.getLogger(__name__)

THREAD_FUNCTIONS = ("sysCall_thread", "sysCall_threadmain")

NEVER_CALLED: Mapping[str, str] = MappingProxyType(
    {
        "sysCall_userConfig": "it answers a double click in V-REP's window, and there is none",
        "sysCall_realTimeIdle": "scripts run in simulation steps, and in sysCall_nonSimulation while stopped",
        "sysCall_beforeInstanceSwitch": "the server has one scene at a time",
        "sysCall_afterInstanceSwitch": "the server has one scene at a time",
    }
)
"""Call-backs of CoppeliaSim that can never come here, and why; a script that has one is told so."""


_MAIN, _SANDBOX = ScriptKind.MAIN, ScriptKind.SANDBOX
"""Kinds of scripts without an object. Python takes as long as for a call to find a member of an enumeration."""

OpenSpaces = Callable[[Script], Spaces]
"""Creates the namespaces of a script that starts."""


class Lives:
    """Starts, calls and ends scripts."""

    def __init__(
        self,
        sim: Simulation,
        signals: Signals,
        status_bar: StatusBar,
        open_spaces: OpenSpaces,
        changed: Callable[[], object],
        api_called: Callable[[], object],
        *,
        allows_code: bool,
        needs_seccomp: bool,
    ) -> None:
        """Create the lives of scripts.

        Args:
            changed: called when a script has started or was stopped by an error.
            api_called: called after each function of the API that a script has called.
        """
        self._sim = sim
        self._signals = signals
        self._status_bar = status_bar
        self._open_spaces = open_spaces
        self._changed = changed
        self._api_called = api_called
        self.allows_code = allows_code
        self._needs_seccomp = needs_seccomp
        self._active = 0
        self._retired: list[Script] = []
        """Removed scripts that end when the present call into a script returns."""
        self.time_limit = TIME_LIMIT
        """Processor seconds for one call into a script; a script takes the value at its start."""

    @property
    def is_active(self) -> bool:
        """Return whether a call into any script is in progress."""
        return self._active > 0

    def describe(self, script: Script) -> str:
        """Return a script's description for messages."""
        if script.kind == ScriptKind.MAIN:
            return f"main script ({script.file})"
        if script.kind == ScriptKind.SANDBOX:
            return script.kind.text
        objects = self._sim.scene.objects
        item = objects.get(script.owner) or objects.get(script.home)
        return f"{script.kind.text} of '{item.name if item else 'a removed object'}' ({script.file})"

    def run(self, script: Script, function: str, *arguments: Any) -> list[Any]:
        """Call any function of a script and return all its results.

        Raises:
            ScriptError: the script failed.
        """
        if not self._running(script).has(function):
            raise ScriptError(f"the {self.describe(script)} has no function '{function}'")
        return self._returned(script, lambda interpreter: interpreter.call(function, *arguments))

    def evaluate(self, script: Script, source: bytes) -> list[Any]:
        """Execute a piece of text among a script's variables and return its results.

        Raises:
            ScriptError: the script does not run, or the text fails.
        """
        return self._returned(script, lambda interpreter: interpreter.evaluate(source))

    def _returned(self, script: Script, action: Callable[[Interpreter], list[Any]]) -> list[Any]:
        """Return the results of a call into a running script, and note the text of an error."""
        running = self._running(script)
        try:
            return self.within(action, running)
        except ScriptError as problem:
            script.traceback = str(problem)
            raise

    def _running(self, script: Script) -> Interpreter:
        """Return the interpreter of a script. Raises ScriptError: the script does not run."""
        if script.interpreter is not None:
            return script.interpreter
        where = self.describe(script)
        if script.problem:
            raise ScriptError(f"the {where} was stopped by an error: {script.problem}")
        raise ScriptError(f"the {where} exists only while the simulation runs; start the simulation first")

    def begin(self, script: Script) -> None:
        script.problem = ""
        script.switching.level = 0
        script.switching.is_last = False
        script.raises_errors = script.stops_at_errors
        script.console_verbosity = script.bar_verbosity = USUAL_VERBOSITY
        self._sim.parts.replan()
        try:
            source = script.code(self._sim, allows_code=self.allows_code)
            spaces = self._open_spaces(script)
            side = ScriptSide(
                self._sim,
                script,
                spaces,
                self._serve_others,
                self._api_called,
                self._status_bar,
                allows_code=self.allows_code,
            )
            lua = None
            if script.language == PYTHON:
                folder = script_folder(self._sim, script.folder)
                script.interpreter = _python_interpreter(
                    script.file, side, self.time_limit, folder, self._needs_seccomp
                )
            else:
                script.interpreter = lua = _lua_interpreter(script.file, side, self.time_limit)
                source = with_call_backs(
                    source, threaded=script.threaded, is_child=script.kind == ScriptKind.CHILD
                )
            if script.threaded and lua is not None:
                lua.start_text(source, THREAD_FUNCTIONS)
                script.has_thread = bool(self.within(lambda interpreter: interpreter.resume(), lua))
            else:
                self.within(lambda interpreter: interpreter.run(source), script.interpreter)
            if script.is_removed:
                return
            for function in filter(script.interpreter.has, NEVER_CALLED):
                self._status_bar.add(
                    f"{function} of the {self.describe(script)} is never called: {NEVER_CALLED[function]}"
                )
            thread = next(filter(script.interpreter.has, THREAD_FUNCTIONS), None)
            if thread and not script.has_thread:
                script.interpreter.start_thread(thread)
                script.has_thread = True
        except ScriptError as problem:
            self.fail(script, str(problem))
        self._changed()

    def call(self, script: Script, function: str, *arguments: Any) -> list[Any] | None:
        """Call a function if the script has it and may run; return None if not. An error ends the script."""
        if not (script.enabled or function == "sysCall_init"):
            return None
        if not self._may_run(script):
            return None
        interpreter = script.interpreter
        assert interpreter is not None
        is_there = True
        self._active += 1
        try:
            results = interpreter.attempt(function, *arguments)
            is_there = results is not None
            return results
        except ScriptError as problem:
            failure = str(problem)
        finally:
            if is_there:
                self._leave()
            else:
                self._active -= 1
        self.fail(script, failure)
        return None

    def resume(self, script: Script) -> None:
        if script.has_thread and script.enabled and self._may_run(script):
            script.has_thread = bool(self._attempt(script, lambda interpreter: interpreter.resume()))

    def deliver(self, script: Script, function: Function, *arguments: Any) -> list[Any] | None:
        """Call a function that a script gave for an event; return None if the script may not run. An error ends it."""
        if not script.enabled or not self._may_run(script):
            return None
        return self._attempt(script, lambda _: function(*arguments))

    def call_scheduled(self, script: Script, now: float) -> None:
        """Make the calls of a script that are due. `now`: seconds of the wall clock."""
        for number, call in list(script.scheduled.items()):
            is_due = self._sim.time >= call.moment if call.in_simulation_time else now >= call.moment
            if is_due and script.enabled and self._may_run(script) and number in script.scheduled:
                del script.scheduled[number]
                self._attempt(script, lambda _, call=call: call.function(*call.arguments))

    def _may_run(self, script: Script) -> bool:
        if script.interpreter is None or script.is_removed:
            return False
        kind = script.kind
        if kind is _MAIN or kind is _SANDBOX:
            return True
        if not script.active_in_run and self._sim.is_running:
            return False
        scene, home = self._sim.scene, script.home
        if home not in scene.objects:
            self._end(script, "its object was removed")
            return False
        return not scene.overridden(home) & SCRIPTS_INACTIVE

    def _attempt(self, script: Script, action: Callable[[Interpreter], Any]) -> Any:
        interpreter = script.interpreter
        if interpreter is None:
            return None
        try:
            return self.within(action, interpreter)
        except ScriptError as problem:
            self.fail(script, str(problem))
            return None

    def within(self, action: Callable[[Interpreter], Any], interpreter: Interpreter) -> Any:
        self._active += 1
        try:
            return action(interpreter)
        finally:
            self._leave()

    def _leave(self) -> None:
        """Note that a call into a script has returned."""
        self._active -= 1
        self._sim.interruptions.script_point()
        if self._retired and not self._active:
            self._end_retired()

    def retire(self, script: Script) -> None:
        """End a script for good, with its cleanup; within a call into a script, when that has returned."""
        script.is_removed = True
        self._retired.append(script)
        if not self._active:
            self._end_retired()

    def _end_retired(self) -> None:
        while self._retired:
            script = self._retired.pop()
            if script.has("sysCall_cleanup"):
                self._attempt(script, lambda interpreter: interpreter.call("sysCall_cleanup"))
            self.drop(script)
            self._changed()

    def _end(self, script: Script, reason: str) -> None:
        """End a script until the next start."""
        self.drop(script)
        script.problem = reason
        self._changed()

    def fail(self, script: Script, problem: str) -> None:
        """End a script that has failed, and tell of it."""
        self._end(script, problem)
        script.traceback = problem
        logger.error("the %s is stopped: %s", self.describe(script), as_log_line(problem))
        self._tell(f"{self.describe(script)} is stopped: {problem}")

    def announce(self, script: Script) -> None:
        """Print a warning now if a script that starts later will not be allowed to run."""
        try:
            script.code(self._sim, allows_code=self.allows_code)
        except CodeNotAllowed as problem:
            logger.warning("the %s will not run: %s", self.describe(script), problem)
            self._tell(f"{self.describe(script)} will not run: {problem}")
        except ScriptError as problem:
            logger.warning("%s", problem)

    def _tell(self, text: str) -> None:
        self._status_bar.add(text)
        self._sim.parts.tell(lambda part: part.script_stopped(text))

    def drop(self, script: Script) -> None:
        """Delete a script's state, and the signals it set."""
        script.close()
        script.problem = ""
        script.enabled = script.starts_enabled
        self._signals.clear_owned(script.signal_owner)
        self._sim.parts.tell(lambda part: part.script_ended(script.signal_owner))

    def _serve_others(self) -> None:
        if not self._sim.physics_calls.is_in_step:  # a request may need a copy of the state
            self._sim.interruptions.serve_others()


def _lua_interpreter(name: str, side: ScriptSide, time_limit: float) -> LuaInterpreter:
    """Return an interpreter for Lua; the import is delayed until a scene has such a script."""
    from .lua.interpreter import LuaInterpreter

    return LuaInterpreter(name, side, time_limit=time_limit)


def _python_interpreter(
    name: str, side: ScriptSide, time_limit: float, folder: Path | None, needs_seccomp: bool
) -> Interpreter:
    """Return an interpreter for Python; the import is delayed until a scene has such a script."""
    from .python.interpreter import PythonInterpreter

    return PythonInterpreter(name, side, time_limit=time_limit, folder=folder, needs_seccomp=needs_seccomp)
