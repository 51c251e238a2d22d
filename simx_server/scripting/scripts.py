"""The scripts of the loaded scene, and calls into them. `phases.py` decides which one runs when."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simx_server.parts.add_ons import AddOn
from simx_server.scene.formats.script_texts import SCRIPT_NOTES
from simx_server.world.part import Part

from .exchange import check_results
from .lives import Lives, OpenSpaces
from .phases import Phases
from .script import LUA, PYTHON, Script, ScriptKind
from .targets import find_target, split_target

if TYPE_CHECKING:
    from simx_server.parts.signals import Signals
    from simx_server.parts.status_bar import StatusBar
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.formats.annotations import Annotation
    from simx_server.sensors.proximity.proximity import ProximitySensors
    from simx_server.sensors.vision.vision_sensors import VisionSensors
    from simx_server.world.simulation import Simulation

logger = logging.getLogger(__name__)

FIRST_HANDLE = 2_000_003
"""Handles of scripts are far above those of objects and above all script types; V-REP's start at a similar number."""

_KINDS = {kind: ScriptKind[script_type.upper()] for kind, script_type in SCRIPT_NOTES.items()}


class Scripts(Part):
    """All scripts of the loaded scene. Physics thread only."""

    def __init__(
        self,
        sim: Simulation,
        signals: Signals,
        status_bar: StatusBar,
        vision: VisionSensors,
        proximity: ProximitySensors,
        open_spaces: OpenSpaces,
        *,
        allows_code: bool = False,
    ) -> None:
        """Create an empty list of scripts.

        Args:
            open_spaces: creates the namespaces of a script that starts.
            allows_code: scripts may run code that clients send, by the operator's decision.
        """
        self._sim = sim
        self._scripts: list[Script] = []
        self._next_handle = FIRST_HANDLE
        self._is_of_client = False
        """Whether a client sent the scene."""
        self.add_ons: dict[str, AddOn] = {}
        """Add-ons by name; script type 2 of simxCallScriptFunction."""
        self._lives = Lives(sim, signals, status_bar, open_spaces, self._changed, allows_code=allows_code)
        self._phases = Phases(sim, self, self._lives, status_bar, vision, proximity)

    @property
    def allows_code(self) -> bool:
        """Return whether scripts may run code that clients send."""
        return self._lives.allows_code

    @allows_code.setter
    def allows_code(self, allows: bool) -> None:
        self._lives.allows_code = allows

    # --- events ----------------------------------------------------------------------------------

    def scene_closing(self) -> None:
        self.close()

    def scene_loaded(self) -> None:
        self._find()

    def model_changed(self, twins: Twins | None) -> None:
        self._find_more()

    def run_starting(self) -> None:
        self._phases.call_all("sysCall_beforeSimulation", ScriptKind.CUSTOMIZATION)

    def run_started(self) -> None:
        self._phases.start()

    def run_paused(self) -> None:
        self._phases.call_all("sysCall_suspend")

    def run_resumed(self) -> None:
        self._phases.call_all("sysCall_resume")

    def run_stopping(self) -> None:
        self._phases.stop()

    def run_stopped(self) -> None:
        self._phases.watch()
        self._phases.call_all("sysCall_afterSimulation", ScriptKind.CUSTOMIZATION)

    def actuate(self) -> None:
        """Run the scripts' threads and actuation, before physics."""
        self._phases.actuate()

    def judge_images(self) -> None:
        """Have scripts process the images of their vision sensors, and call them on detections."""
        self._phases.judge_images()

    def sense(self) -> None:
        """Run the scripts' sensing, after physics and the sensors."""
        self._phases.sense()

    @property
    def want_idle(self) -> bool:
        """Return whether a script wants to run while the simulation is stopped or paused."""
        return self._phases.wants_idle

    def idle(self) -> None:
        """Run the scripts while no simulation step is due: the simulation is stopped or paused."""
        if self.want_idle:
            self._phases.idle()

    @property
    def time_limit(self) -> float:
        """Return the processor seconds for one call into a script; a script takes the value at its start."""
        return self._lives.time_limit

    @time_limit.setter
    def time_limit(self, seconds: float) -> None:
        self._lives.time_limit = seconds

    def _changed(self) -> None:
        self._phases.watch()

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
        """Call a function of a script with four arguments; return its four results. `targets.py` finds the script.

        Raises:
            CommandError: the script or function does not exist, it fails, or a result has the wrong type.
        """
        function, name = split_target(function, description)
        target = find_target(self, self._sim.scene, options, name)
        if not isinstance(target, Script):
            return target.call(function, ints, floats, strings, buffer)
        results = self.run(target, function, ints, floats, strings, buffer)
        return check_results(f"{target.file}: {function}", results)

    def notify(self, owner: int, function: str, *arguments: Any) -> list[Any] | None:
        """Call a call-back of an object's scripts, of the child script before the customization script.

        Returns the results of the first that returns any, None when no script has it. An error ends that script.
        """
        for kind in (ScriptKind.CHILD, ScriptKind.CUSTOMIZATION):
            script = self.of(owner, kind)
            if script is not None and script.has(function):
                results = self._lives.call(script, function, *arguments)
                if results:
                    return results
        return None

    def get(self, handle: int) -> Script | None:
        """Return the script with this handle."""
        return next((script for script in self._scripts if script.handle == handle), None)

    def of(self, owner: int, kind: ScriptKind) -> Script | None:
        """Return an object's script of this kind; for a main script the owner is -1."""
        return next((one for one in self._scripts if one.owner == owner and one.kind == kind), None)

    def all(self, kind: ScriptKind | None = None) -> list[Script]:
        """Return the scripts (of a kind) in the order in which they are called."""
        if len(self._scripts) < 2:
            return [one for one in self._scripts if kind is None or one.kind == kind]
        places = self._sim.scene.leaves_first()
        chosen = [script for script in self._scripts if kind is None or script.kind == kind]
        return sorted(chosen, key=lambda script: places.get(script.owner, -1))

    def list_scripts(self) -> str:
        """Return the scripts of the scene in one line, for messages."""
        return ", ".join(self.describe(script) for script in self._scripts) or "none"

    def describe(self, script: Script) -> str:
        """Return a script's description for messages."""
        return self._lives.describe(script)

    def run(self, script: Script, function: str, *arguments: Any) -> list[Any]:
        """Call any function of a script and return all its results.

        Raises:
            ScriptError: the script failed.
        """
        return self._lives.run(script, function, *arguments)

    def handle_children(self, function: str) -> int:
        """Call a function of all child scripts, for actuation after their threads; return how many have it."""
        return self._phases.handle_children(function)

    # --- the scene -------------------------------------------------------------------------------

    def close(self) -> None:
        """End all scripts when the scene is closed."""
        self._phases.call_all("sysCall_cleanup", ScriptKind.CUSTOMIZATION)
        for script in self._scripts:
            self._lives.drop(script)
        self._scripts = []
        self._changed()

    def _find(self) -> None:
        """Find the main script of another scene; the others are found as after an edit."""
        self._is_of_client = self._sim.scene_is_of_client
        note = self._sim.scene.annotations.main_script
        if note is not None:
            self._lives.announce(self._add(ScriptKind.MAIN, -1, note, "main"))

    def _find_more(self) -> None:
        """Start the scripts of new objects after an edit of the scene, or after an edit was undone.

        The script of a removed object is dropped at its next call, because this method may run within a call.
        """
        objects = self._sim.scene.objects
        if not self._sim.is_running and not self._lives.is_active:
            gone = [one for one in self._scripts if one.owner not in objects and one.kind != ScriptKind.MAIN]
            for script in gone:
                self._lives.drop(script)
                self._scripts.remove(script)
        known = {(script.owner, script.kind) for script in self._scripts}
        for handle in self._with_scripts():
            item = objects[handle]
            for key, kind in _KINDS.items():
                note = item.annotations.get(key)
                if note is not None and (handle, kind) not in known:
                    script = self._add(kind, handle, note, item.name)
                    if kind == ScriptKind.CUSTOMIZATION or self._sim.is_running:
                        self._lives.begin(script)
                        self._lives.call(script, "sysCall_init")
                    else:
                        self._lives.announce(script)

    def _with_scripts(self) -> list[int]:
        """Return handles of the objects that have scripts. These are few, so the search uses the annotations."""
        scene = self._sim.scene
        named = [
            name for name, notes in scene.annotations.objects.items() if not _KINDS.keys().isdisjoint(notes)
        ]
        handles = map(scene.by_name, named)
        return sorted(handle for handle in handles if handle is not None)

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
            of_client=bool(note.get("of_client", self._is_of_client)),
            language=language,
            threaded=bool(note.get("threaded", False)),
        )
        self._next_handle += 1
        self._scripts.append(script)
        return script
