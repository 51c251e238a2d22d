"""The scripts of the loaded scene: which there are, when they live, and when which of their functions is called.

A **child script** lives from start to stop, a **main script** too; a **customization script** lives from the load of
the scene to its close, whether the simulation runs or not.

| when | main and child scripts | customization scripts |
|---|---|---|
| scene loaded, object added | (added while running: as at start) | `sysCall_init` |
| each idle pass while stopped | | `sysCall_nonSimulation`, threads |
| start, before the state is saved | | `sysCall_beforeSimulation` |
| start | `sysCall_init` | |
| each pass before physics | threads, then `sysCall_actuation` | the same, after the child scripts |
| each pass after physics | `sysCall_sensing` | the same, after the child scripts |
| pause; each idle pass then; continue | `sysCall_suspend`, `sysCall_suspended`, `sysCall_resume` | the same |
| stop, before the state is restored | threads once more, `sysCall_cleanup` | |
| stop, after that | | `sysCall_afterSimulation` |
| scene closed, object removed | (object removed: no call) | `sysCall_cleanup` |

Of several scripts those deeper in the tree come first, children in their order before their parent, as in V-REP's
default order. In a pass simulated time is that of the pass's begin, in sensing too. With a main script the child
scripts' actuation and sensing come when it calls ``sim.handleChildScripts``; physics comes between the two in any case.

An error in one of these ends that script until the next start (a customization script: until the scene is loaded
again); an error in a function that a client calls is the client's alone.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..scene.properties import SCRIPTS_INACTIVE
from ..scene.script_texts import SCRIPT_NOTES
from .bodies import with_call_backs
from .exchange import check_results
from .interpreter import TIME_LIMIT, Interpreter, ScriptError
from .lua import LuaInterpreter
from .namespaces import Namespaces
from .script import LUA, PYTHON, Script, ScriptKind, ScriptSide, script_folder
from .targets import AddOn, find_target, split_target

if TYPE_CHECKING:
    from ..scene.annotations import Annotation
    from ..simulation import Simulation

logger = logging.getLogger(__name__)

FIRST_HANDLE = 2_000_003
"""Handles of scripts are far above those of objects and above all script types; V-REP's began about there too."""

THREAD_FUNCTIONS = ("sysCall_thread", "sysCall_threadmain")

_IDLE_FUNCTIONS = ("sysCall_nonSimulation", "sysCall_suspended")

_KINDS = {kind: ScriptKind[script_type.upper()] for kind, script_type in SCRIPT_NOTES.items()}


class Scripts:
    """All scripts of the loaded scene. Physics thread only."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._scripts: list[Script] = []
        self._next_handle = FIRST_HANDLE
        self._later: list[Callable[[], object]] = []
        self._active = 0
        """Calls into scripts that are going on, within each other."""

        self.add_ons: dict[str, AddOn] = {}
        """By name; script type 2 of simxCallScriptFunction."""
        self.time_limit = TIME_LIMIT
        """Processor seconds for one call into a script; taken over when a script begins."""
        self.allows_code = False
        """Scripts may run code that clients send: the operator said so."""
        self.is_stopping = False
        """The run is being stopped: threads go on for the last time."""
        sim.on_load.append(self._find)
        sim.on_closing.append(self._close)
        sim.on_model_changed.append(self._find_more)
        sim.on_starting.append(lambda: self._call_all("sysCall_beforeSimulation", ScriptKind.CUSTOMIZATION))
        sim.on_start.append(self._start)
        sim.on_pass_begin.append(lambda: self._phase("sysCall_actuation"))
        sim.on_sensing.append(lambda: self._phase("sysCall_sensing"))
        sim.on_pass_end.append(self._do_what_was_left)
        sim.on_pause.append(lambda: self._call_all("sysCall_suspend"))
        sim.on_resume.append(lambda: self._call_all("sysCall_resume"))
        sim.on_stopping.append(self._stop)
        sim.on_stop.append(lambda: self._call_all("sysCall_afterSimulation", ScriptKind.CUSTOMIZATION))

    # --- for handlers and the API ----------------------------------------------------------------

    def call(
        self,
        description: str,
        options: int,
        function: str,
        ints: list[int],
        floats: list[float],
        strings: list[str],
        buffer: bytes,
    ) -> tuple[list[int], list[float], list[str], bytes]:
        """Call a function of a script with four arguments; its four results. `targets.py` says who is meant.

        Raises:
            CommandError: no such script or function, an error in it, or results of the wrong kind.
        """
        function, name = split_target(function, description)
        target = find_target(self, self._sim.scene, options, name)
        if not isinstance(target, Script):
            return target.call(function, ints, floats, strings, buffer)
        results = self.run(target, function, ints, floats, strings, buffer)
        return check_results(f"{target.file}: {function}", results)

    def run(self, script: Script, function: str, *arguments: Any) -> list[Any]:
        """Call any function of a script; all its results. Raises ScriptError."""
        if script.interpreter is None:
            where = self.describe(script)
            if script.problem:
                raise ScriptError(f"the {where} was stopped by an error: {script.problem}")
            raise ScriptError(
                f"the {where} exists only while the simulation runs; start the simulation first"
            )
        if not script.interpreter.has(function):
            raise ScriptError(f"the {self.describe(script)} has no function '{function}'")
        return self._within(lambda interpreter: interpreter.call(function, *arguments), script.interpreter)

    def notify(self, owner: int, function: str, *arguments: Any) -> list[Any] | None:
        """Call a call-back of an object's scripts, of the child script before the customization script.

        Gives the results of the first that returns any, None when no script has it. An error ends that script.
        """
        for kind in (ScriptKind.CHILD, ScriptKind.CUSTOMIZATION):
            script = self.of(owner, kind)
            if script is not None and script.has(function):
                results = self._call(script, function, *arguments)
                if results:
                    return results
        return None

    def get(self, handle: int) -> Script | None:
        """The script with this handle."""
        return next((script for script in self._scripts if script.handle == handle), None)

    def of(self, owner: int, kind: ScriptKind) -> Script | None:
        """An object's script of this kind; for a main script the owner is -1."""
        return next((one for one in self._scripts if one.owner == owner and one.kind == kind), None)

    def all(self, kind: ScriptKind | None = None) -> list[Script]:
        """The scripts (of a kind) in the order in which they are called."""
        places = {handle: place for place, handle in enumerate(self._leaves_first(-1))}
        chosen = [script for script in self._scripts if kind is None or script.kind == kind]
        return sorted(chosen, key=lambda script: places.get(script.owner, -1))

    def list_scripts(self) -> str:
        """The scripts of the scene in one line, for messages."""
        return ", ".join(self.describe(script) for script in self._scripts) or "none"

    def describe(self, script: Script) -> str:
        """A script in a message's words."""
        if script.kind == ScriptKind.MAIN:
            return f"main script ({script.file})"
        item = self._sim.scene.objects.get(script.owner)
        return f"{script.kind.text} of '{item.name if item else 'a removed object'}' ({script.file})"

    def later(self, action: Callable[[], object]) -> None:
        """Do something that a script may not do while it runs (stop, start, another scene): after the pass.

        At once when no script runs.
        """
        self._later.append(action)
        if not self._active:
            self._do_what_was_left()

    def handle_children(self, function: str) -> int:
        """Call a function of all child scripts, for actuation after their threads; how many have it."""
        if function == "sysCall_actuation":
            for script in self.all(ScriptKind.CHILD):
                self._resume(script)
        return self._call_all(function, ScriptKind.CHILD)

    # --- the scene -------------------------------------------------------------------------------

    def _leaves_first(self, handle: int) -> list[int]:
        found: list[int] = []
        for child in self._sim.scene.children(handle):
            found += [*self._leaves_first(child), child]
        return found

    def _close(self) -> None:
        self._call_all("sysCall_cleanup", ScriptKind.CUSTOMIZATION)
        for script in self._scripts:
            self._drop(script)
        self._scripts = []
        self._watch_idle()

    def _find(self) -> None:
        """Another scene: its main script, if it has one; the others are found as after an edit."""
        note = self._sim.scene.annotations.main_script
        if note is not None:
            self._add(ScriptKind.MAIN, -1, note, "main")

    def _find_more(self) -> None:
        """The scene was edited, or an edit was taken back: scripts of new objects begin.

        The script of an object that is no more ends with its next call, for this may be within one.
        """
        objects = self._sim.scene.objects
        if not self._sim.is_running and not self._active:
            gone = [one for one in self._scripts if one.owner not in objects and one.kind != ScriptKind.MAIN]
            for script in gone:
                self._remove(script)
        known = {(script.owner, script.kind) for script in self._scripts}
        for handle, item in tuple(objects.items()):
            for key, kind in _KINDS.items():
                note = item.annotations.get(key)
                if note is not None and (handle, kind) not in known:
                    script = self._add(kind, handle, note, item.name)
                    if kind == ScriptKind.CUSTOMIZATION or self._sim.is_running:
                        self._begin(script)
                        self._call(script, "sysCall_init")

    def _add(self, kind: ScriptKind, owner: int, note: Annotation, name: str) -> Script:
        text, file = note.get("text"), str(note.get("file", ""))
        language = str(note.get("language", PYTHON if file.endswith(".py") else LUA))
        middle = "" if kind == ScriptKind.CHILD else f".{kind.name.lower()}"
        suffix = ".py" if language == PYTHON else ".lua"
        script = Script(
            handle=self._next_handle,
            kind=kind,
            owner=owner,
            file=file or f"{name}{'' if name == 'main' else middle}{suffix}",
            text=None if text is None else str(text),
            folder=Path(str(note["folder"])) if "folder" in note else None,
            language=language,
            threaded=bool(note.get("threaded", False)),
        )
        self._next_handle += 1
        self._scripts.append(script)
        if script.text is None:
            try:
                script.path(self._sim)
            except ScriptError as problem:
                logger.warning("%s", problem)
        return script

    # --- one script ------------------------------------------------------------------------------

    def _begin(self, script: Script) -> None:
        script.problem = ""
        script.switching.level = 0
        try:
            source = script.source(self._sim)
            side = ScriptSide(self._sim, script, Namespaces(self._sim, script), self._serve_others)
            if script.language == PYTHON:
                folder = script_folder(self._sim, script.folder)
                script.interpreter = _python_interpreter(script.file, side, self.time_limit, folder)
            else:
                script.interpreter = LuaInterpreter(script.file, side, time_limit=self.time_limit)
                source = with_call_backs(
                    source, threaded=script.threaded, is_child=script.kind == ScriptKind.CHILD
                )
            self._within(lambda interpreter: interpreter.run(source), script.interpreter)
            if thread := next(filter(script.interpreter.has, THREAD_FUNCTIONS), None):
                script.interpreter.start_thread(thread)
                script.has_thread = True
        except ScriptError as problem:
            self._fail(script, str(problem))
        self._watch_idle()

    def _call(self, script: Script, function: str, *arguments: Any) -> list[Any] | None:
        """Call a function if the script has it and may run; None if not. An error ends the script."""
        if not self._may_run(script) or not script.has(function):
            return None
        return self._attempt(script, lambda interpreter: interpreter.call(function, *arguments))

    def _resume(self, script: Script) -> None:
        if script.has_thread and self._may_run(script):
            script.has_thread = bool(self._attempt(script, lambda interpreter: interpreter.resume()))

    def _may_run(self, script: Script) -> bool:
        if script.interpreter is None:
            return False
        if script.kind == ScriptKind.MAIN:
            return True
        if script.owner not in self._sim.scene.objects:
            self._fail(script, "its object was removed")
            return False
        return not self._sim.scene.overridden(script.owner) & SCRIPTS_INACTIVE

    def _attempt(self, script: Script, action: Callable[[Interpreter], Any]) -> Any:
        interpreter = script.interpreter
        if interpreter is None:
            return None
        try:
            return self._within(action, interpreter)
        except ScriptError as problem:
            self._fail(script, str(problem))
            return None

    def _within(self, action: Callable[[Interpreter], Any], interpreter: Interpreter) -> Any:
        self._active += 1
        try:
            return action(interpreter)
        finally:
            self._active -= 1

    def _fail(self, script: Script, problem: str) -> None:
        """Stop one script until the next start."""
        self._drop(script)
        script.problem = problem
        logger.error("the %s is stopped: %s", self.describe(script), problem)
        self._sim.status_bar.add(f"{self.describe(script)} is stopped: {problem}")
        self._watch_idle()

    def _drop(self, script: Script) -> None:
        """Forget a script's state, and the signals it set."""
        script.close()
        script.problem = ""
        self._sim.signals.clear_owned(script.signal_owner)

    def _remove(self, script: Script) -> None:
        self._drop(script)
        self._scripts.remove(script)

    # --- all of them -----------------------------------------------------------------------------

    def _call_all(self, function: str, kind: ScriptKind | None = None) -> int:
        return sum(self._call(script, function) is not None for script in self.all(kind))

    def _start(self) -> None:
        simulated = [one for one in self.all() if one.kind != ScriptKind.CUSTOMIZATION]
        for script in simulated:
            self._begin(script)
        for script in simulated:
            self._call(script, "sysCall_init")

    def _phase(self, function: str) -> None:
        main = self.of(-1, ScriptKind.MAIN)
        if main is None:
            self.handle_children(function)
        else:
            self._call(main, function)
        if function == "sysCall_actuation":
            for script in self.all(ScriptKind.CUSTOMIZATION):
                self._resume(script)
        self._call_all(function, ScriptKind.CUSTOMIZATION)

    def _stop(self) -> None:
        self.is_stopping = True
        try:
            simulated = [one for one in self.all() if one.kind != ScriptKind.CUSTOMIZATION]
            for script in simulated:
                script.switching.level += 1
                self._resume(script)
            for script in simulated:
                self._call(script, "sysCall_cleanup")
                self._drop(script)
        finally:
            self.is_stopping = False

    def _idle(self) -> None:
        """No pass comes: the simulation is stopped or paused."""
        if self._sim.is_running:
            self._call_all("sysCall_suspended")
        else:
            for script in self.all(ScriptKind.CUSTOMIZATION):
                self._resume(script)
            self._call_all("sysCall_nonSimulation", ScriptKind.CUSTOMIZATION)
        self._do_what_was_left()

    def _watch_idle(self) -> None:
        """Idle passes are asked for only while a script wants them."""
        wants = any(one.has_thread or any(map(one.has, _IDLE_FUNCTIONS)) for one in self._scripts)
        listeners = self._sim.on_idle
        if wants and self._idle not in listeners:
            listeners.append(self._idle)
        elif not wants and self._idle in listeners:
            listeners.remove(self._idle)

    def _do_what_was_left(self) -> None:
        while self._later:
            self._later.pop(0)()

    def _serve_others(self) -> None:
        self._sim.serve_others()


def _python_interpreter(name: str, side: ScriptSide, time_limit: float, folder: Path | None) -> Interpreter:
    """Imported only when a scene has such a script."""
    from .python_interpreter import PythonInterpreter

    return PythonInterpreter(name, side, time_limit=time_limit, folder=folder)
