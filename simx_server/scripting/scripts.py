"""The child scripts of a scene: when they run, and calls into them from outside.

A script lives from start to stop. At start its file is read and ``sysCall_init`` called; each pass calls
``sysCall_actuation`` before physics and ``sysCall_sensing`` after it; at stop ``sysCall_cleanup``. An error in one of
these ends that script until the next start; an error in a function that a client calls is the client's alone.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from simx_client.protocol import constants

from ..errors import UnknownName
from ..library import MODELS
from ..scene.properties import SCRIPTS_INACTIVE
from . import api as sim_api
from .api import SimApi
from .exchange import check_results
from .lua import TIME_LIMIT, LuaInterpreter, ScriptError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..simulation import Simulation

logger = logging.getLogger(__name__)

_THREADED = 240
"""Added to the type of an old threaded script, which counts as the plain one."""

_ADD_ON = 2
"""Type of an add-on, which the constants of the remote API lack."""

_TYPES = {
    constants.sim_scripttype_mainscript: "main script",
    constants.sim_scripttype_childscript: "child script",
    _ADD_ON: "add-on",
    constants.sim_scripttype_customizationscript: "customization script",
    8: "sandbox script",
}


@dataclass(slots=True)
class Script:
    """One child script."""

    owner: int
    """Handle of its object."""

    file: str
    """As the annotation says it, relative to the scene's folder."""

    interpreter: LuaInterpreter | None = None
    """None while the simulation is stopped and after an error."""

    problem: str = ""
    """What ended it in this run."""

    folder: Path | None = None
    """Where the file is, for the script of a model that was loaded into the scene; None: the scene's folder."""


class AddOn(Protocol):
    """Functions of the server itself that a client calls as it would those of an add-on's script."""

    def call(
        self, function: str, ints: list[int], floats: list[float], strings: list[str], buffer: bytes
    ) -> tuple[list[int], list[float], list[str], bytes]: ...


class _LuaSide:
    """What a script's interpreter sees of the simulation."""

    def __init__(self, sim: Simulation, script: Script, signal_owner: object) -> None:
        self._sim = sim
        self._api = SimApi(sim, script.owner, signal_owner)

    def names(self) -> Mapping[str, int | float | None]:
        return {**sim_api.known_constants(), **dict.fromkeys(sim_api.signatures())}

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...]:
        return sim_api.invoke(self._api, name, arguments)

    def output(self, text: str) -> None:
        self._sim.status_bar.add(text)


class Scripts:
    """All scripts of the loaded scene. Physics thread only."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._scripts: list[Script] = []
        self.add_ons: dict[str, AddOn] = {}
        """By name; script type 2 of simxCallScriptFunction."""
        self.time_limit = TIME_LIMIT
        """Processor seconds for one call into a script; taken over at the next start."""
        sim.on_load.append(self._find)
        sim.on_close.append(self._find)
        sim.on_model_changed.append(self._find_more)
        sim.on_start.append(self._start)
        sim.on_pass_begin.append(lambda: self._call_all("sysCall_actuation"))
        sim.on_sensing.append(lambda: self._call_all("sysCall_sensing"))
        sim.on_stopping.append(self._stop)

    def call(
        self,
        description: str,
        script_type: int,
        function: str,
        ints: list[int],
        floats: list[float],
        strings: list[str],
        buffer: bytes,
    ) -> tuple[list[int], list[float], list[str], bytes]:
        """Call a function of a script with four arguments; its four results.

        The object is named by `description`, or after an ``@`` in `function`; `function` may reach into tables
        with dots.

        Raises:
            CommandError: no such script or function, an error in it, or results of the wrong kind.
        """
        function, at, rest = (f"{function}@{description}" if description else function).partition("@")
        if script_type == _ADD_ON and rest in self.add_ons:
            return self.add_ons[rest].call(function, ints, floats, strings, buffer)
        script = self._target(rest if at else "", script_type)
        if script.interpreter is None:
            where = self._describe(script)
            if script.problem:
                raise ScriptError(f"the {where} was stopped by an error: {script.problem}")
            raise ScriptError(
                f"the {where} exists only while the simulation runs; start the simulation first"
            )
        if not script.interpreter.has(function):
            raise ScriptError(f"the {self._describe(script)} has no function '{function}'")
        results = script.interpreter.call(function, ints, floats, strings, buffer)
        return check_results(f"{script.file}: {function}", results)

    def list_scripts(self) -> str:
        """The scripts of the scene in one line, for messages."""
        return ", ".join(self._describe(script) for script in self._scripts) or "none"

    def _target(self, name: str, script_type: int) -> Script:
        plain = script_type & ~_THREADED if 0 <= script_type < 256 else script_type
        kind = _TYPES.get(plain, f"script with handle or type {script_type}")
        if plain == constants.sim_scripttype_childscript and name:
            try:
                owner = self._sim.scene.resolve(name)
            except UnknownName as problem:
                raise ScriptError(f"{problem}; scripts of this scene: {self.list_scripts()}") from None
            for script in self._scripts:
                if script.owner == owner:
                    return script
        of = f" of '{name}'" if name else ""
        raise ScriptError(f"there is no {kind}{of}; scripts of this scene: {self.list_scripts()}")

    def _describe(self, script: Script) -> str:
        item = self._sim.scene.objects.get(script.owner)
        return f"child script of '{item.name if item else 'a removed object'}' ({script.file})"

    def _find(self) -> None:
        """Another scene: see which scripts it has."""
        self._scripts = []
        self._find_more()

    def _find_more(self) -> None:
        """The scene was edited, or an edit was taken back: scripts of new objects begin.

        While running, the script of an object that is no more ends with its next call: this may be within one.
        """
        objects = self._sim.scene.objects
        if not self._sim.is_running:
            self._scripts = [script for script in self._scripts if script.owner in objects]
        known = {script.owner for script in self._scripts}
        for handle, item in objects.items():
            note = item.annotations.get("script", {})
            if "file" not in note or handle in known:
                continue
            folder = Path(str(note["folder"])) if "folder" in note else None
            script = Script(handle, str(note["file"]), folder=folder)
            self._scripts.append(script)
            try:
                self._path(script)
            except ScriptError as problem:
                logger.warning("%s", problem)
            if self._sim.is_running:
                self._begin(script)
                self._call(script, "sysCall_init")

    def _path(self, script: Script) -> Path:
        """The script's file, which must lie in the scene's folder. Raises ScriptError."""
        scene = self._sim.scene.path
        if script.folder is not None:
            folder = script.folder
        elif scene is not None:
            folder = scene.resolve().parent
        else:
            raise ScriptError(f"{script.file} cannot be found: the scene was not loaded from a file")
        # A model's file names its script as it lies beside it, also when a scene includes that file.
        for path in ((folder / script.file).resolve(), (folder / MODELS / script.file).resolve()):
            if not path.is_relative_to(folder):
                raise ScriptError(f"{script.file} is outside the scene's folder {folder}; put it there")
            if path.is_file():
                return path
        raise ScriptError(f"{script.file} is not in the scene's folder {folder}, nor in its {MODELS}/")

    def _start(self) -> None:
        for script in self._scripts:
            self._begin(script)
        self._call_all("sysCall_init")

    def _begin(self, script: Script) -> None:
        script.problem = ""
        try:
            source = self._path(script).read_bytes()
            side = _LuaSide(self._sim, script, self._signal_owner(script))
            script.interpreter = LuaInterpreter(script.file, side, time_limit=self.time_limit)
            script.interpreter.run(source)
        except (ScriptError, OSError) as problem:
            self._end(script, str(problem))

    def _call_all(self, function: str) -> None:
        for script in tuple(self._scripts):
            self._call(script, function)

    def _call(self, script: Script, function: str) -> None:
        if script.interpreter is None:
            return
        if script.owner not in self._sim.scene.objects:
            self._end(script, "its object was removed")
            return
        inactive = self._sim.scene.overridden(script.owner) & SCRIPTS_INACTIVE
        if script.interpreter.has(function) and not inactive:
            try:
                script.interpreter.call(function)
            except ScriptError as problem:
                self._end(script, str(problem))

    def _stop(self) -> None:
        self._call_all("sysCall_cleanup")
        for script in self._scripts:
            self._drop(script, "")

    def _end(self, script: Script, problem: str) -> None:
        """Stop one script until the next start."""
        self._drop(script, problem)
        logger.error("the %s is stopped: %s", self._describe(script), problem)
        self._sim.status_bar.add(f"{self._describe(script)} is stopped: {problem}")

    def _drop(self, script: Script, problem: str) -> None:
        """Forget a script's state, and the signals it set."""
        if script.interpreter is not None:
            script.interpreter.close()
        script.interpreter = None
        script.problem = problem
        self._sim.signals.clear_owned(self._signal_owner(script))

    @staticmethod
    def _signal_owner(script: Script) -> object:
        return ("script", script.owner)
