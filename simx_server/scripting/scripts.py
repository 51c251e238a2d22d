"""The scripts of the loaded scene, and calls into them. `phases.py` decides which one runs when."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import count
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simx_server.parts.add_ons import AddOn
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scene.objects import ObjectKind
from simx_server.simulation.part import Part

from .callbacks.outside import OutsideCalls
from .calling_order import Called, called
from .exchange import check_results
from .interpreter import SENSING, Function, ScriptError
from .lives import Lives, OpenSpaces
from .named_ports import named_ports
from .phases import Phases
from .saving import save_script
from .script import LUA, PYTHON, LooseScript, Order, Script, ScriptKind, Traversal
from .targets import find_target, split_target

if TYPE_CHECKING:
    from simx_server.parts.communication.signals import Signals
    from simx_server.parts.status_bar import StatusBar
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.formats.annotations import Annotation
    from simx_server.scene.saved import Saved
    from simx_server.sensors.force import ForceSensors
    from simx_server.sensors.proximity.proximity import ProximitySensors
    from simx_server.sensors.vision.vision_sensors import VisionSensors
    from simx_server.simulation.simulation import Simulation

    from .callbacks.objects import ObjectCallBacks

logger = logging.getLogger(__name__)

FIRST_HANDLE = 2_000_003
"""Handles of scripts are far above those of objects and above all script types; V-REP's start at a similar number."""

SANDBOX_HANDLE = FIRST_HANDLE - 1

_MOST_NOTES, _LONGEST_NOTE = 10_000, 500
"""Notes that are kept so that each is printed once, and their characters."""

_SCHEDULED = attrgetter("scheduled")
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
        force: ForceSensors,
        open_spaces: OpenSpaces,
        name_ports: Callable[[Collection[int]], None],
        describe_api: Callable[[], Mapping[str, str]],
        *,
        allows_code: bool = False,
        needs_seccomp: bool = True,
    ) -> None:
        """Create an empty list of scripts.

        Args:
            open_spaces: creates the namespaces of a script that starts.
            name_ports: receives the ports at which a script's text starts the remote API.
            describe_api: returns what each function and constant of the API is, by full name.
            allows_code: scripts may run code that clients send, by the operator's decision.
            needs_seccomp: Python scripts do not run where the kernel cannot restrict their system calls.
        """
        self._sim = sim
        self._status_bar = status_bar
        self._name_ports = name_ports
        self.describe_api = describe_api
        self._scripts: list[Script] = []
        self._called = Called()
        self._ordered_by: object = None
        """The order of the scene's objects from which `_called` follows; None: it is not known."""

        self._next_handle = FIRST_HANDLE
        self._is_loading = True
        """Whether scripts still have to be told that the scene is loaded."""
        self._is_of_client = False
        """Whether a client sent the scene."""
        self.loose: dict[int, LooseScript] = {}
        """Scripts without an object, by handle."""
        self._handles: dict[tuple[int, ScriptKind], int] = {}
        """Handles that scripts have before they are found, by object and kind."""
        self.event_numbers = count(1)
        """Numbers of events, so that a program can tell their order."""
        self._told: set[str] = set()
        """Notes that scripts of this scene have caused, and that are printed once: about stand-ins."""
        self.add_ons: dict[str, AddOn] = {}
        """Add-ons by name; script type 2 of simxCallScriptFunction."""
        self.sandbox = Script(SANDBOX_HANDLE, ScriptKind.SANDBOX, -1, "sandbox", text="")
        """Runs pieces of Lua; it starts when it is used, and ends with the scene."""
        self._lives = Lives(
            sim,
            signals,
            status_bar,
            open_spaces,
            self._changed,
            self._edited,
            allows_code=allows_code,
            needs_seccomp=needs_seccomp,
        )
        self._phases = Phases(sim, self, self._lives, status_bar, vision, proximity, force)

    @property
    def allows_code(self) -> bool:
        """Return whether scripts may run code that clients send."""
        return self._lives.allows_code

    @allows_code.setter
    def allows_code(self, allows: bool) -> None:
        self._lives.allows_code = allows

    @property
    def is_active(self) -> bool:
        """Return whether a call into any script is in progress."""
        return self._lives.is_active

    # --- events ----------------------------------------------------------------------------------

    def scene_closing(self) -> None:
        self.close()

    def scene_loaded(self) -> None:
        self._find()
        self._is_loading = True

    def model_changed(self, twins: Twins | None) -> None:
        self._find_more()
        self._phases.objects.note_changes()
        if self._is_loading:
            self._is_loading = False
            self._phases.call_customizations("sysCall_afterLoad")

    def scene_edited(self) -> None:
        self._find_more()
        self._phases.objects.note_changes()

    def copying_objects(self, handles: Collection[int]) -> None:
        self.of_objects.before_copy(handles)

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        self.of_objects.copied(copies)

    def saving(self, saved: Saved) -> None:
        for script in self._scripts:
            save_script(saved, script, self._sim)

    def run_starting(self) -> None:
        self._phases.call_customizations("sysCall_beforeSimulation")

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
        self._phases.call_customizations("sysCall_afterSimulation")

    @property
    def has_work(self) -> bool:
        """Return whether the scene has scripts."""
        return bool(self._scripts) or self.outside.has()

    @property
    def outside(self) -> OutsideCalls:
        """Return the call-backs of clients, which come after those of the scripts."""
        return self._phases.outside

    @property
    def senses(self) -> bool:
        """Return whether a script may have something to do after the sensors."""
        return self.outside.has(SENSING) or any(map(self._may_sense, self._scripts))

    def _may_sense(self, script: Script) -> bool:
        if script.interpreter is None:
            return False
        is_lost = script.kind != ScriptKind.MAIN and script.home not in self._sim.scene.objects
        return is_lost or SENSING not in script.interpreter.lacking or bool(script.events or script.changes)

    @property
    def judges(self) -> bool:
        """Return whether scripts process images, or are called on detections."""
        return self._phases.judges

    def refuse_step(self) -> bool:
        """Ask the scripts with `sysCall_beforeMainScript`; return whether one refuses the coming simulation step."""
        return self._phases.refuse_step()

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
    def of_objects(self) -> ObjectCallBacks:
        """Return the call-backs for objects that are made, copied and removed."""
        return self._phases.objects

    @property
    def want_idle(self) -> bool:
        """Return whether a script wants to run while the simulation is stopped or paused."""
        return self._phases.wants_idle or any(map(_SCHEDULED, self._scripts))

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

    def _edited(self) -> None:
        self._phases.objects.tell()

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
        if target is self.sandbox:
            raise ScriptError(
                "a client calls functions of the sandbox script through sim.executeScriptString only"
            )
        if not isinstance(target, Script):
            return target.call(function, ints, floats, strings, buffer)
        results = self.run(target, function, ints, floats, strings, buffer)
        return check_results(f"{target.file}: {function}", results)

    def notify(self, owner: int, function: str, *arguments: Any) -> list[Any] | None:
        """Call a call-back of an object's scripts, of the child script before the customization script.

        Returns the results of the first that returns any, None when no script has it. An error ends that script.
        """
        its_own = [script for script in self._scripts if script.owner == owner]
        for script in sorted(its_own, key=lambda script: script.kind != ScriptKind.CHILD):
            if script.has(function):
                results = self._lives.call(script, function, *arguments)
                if results:
                    return results
        return None

    def get(self, handle: int) -> Script | None:
        """Return the script with this handle, or the one of the script object with it."""
        if handle == SANDBOX_HANDLE:
            return self.sandbox
        return next(
            (one for one in self._scripts if handle in (one.handle, one.place) and handle != -1), None
        )

    def of(self, owner: int, kind: ScriptKind) -> Script | None:
        """Return an object's first script of this kind, or the one of a script object; for a main script the owner is
        -1.
        """
        if kind == ScriptKind.SANDBOX:
            return self.sandbox
        for one in self._scripts:
            if one.kind == kind and owner in (one.owner, one.home):
                return one
        return None

    def all(self, kind: ScriptKind | None = None) -> tuple[Script, ...]:
        """Return the scripts (of a kind) in the order in which they are called."""
        every = self.called().every
        return every if kind is None else tuple(script for script in every if script.kind == kind)

    def called(self) -> Called:
        """Return the scripts in the order in which they are called."""
        places = self._sim.scene.leaves_first()
        if places is not self._ordered_by:
            self._called, self._ordered_by = called(self._scripts, self._sim.scene), places
        return self._called

    def set_order(self, script: Script, order: Order) -> None:
        """Set when a script is called compared with its siblings."""
        script.order = order
        self._reorder()

    def _reorder(self) -> None:
        """Find the order of calls again: there are other scripts, or the order of one has changed."""
        self._ordered_by = None
        self._sim.parts.replan()

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
        if script is self.sandbox and script.interpreter is None:
            self._phases.begin(script)
        return self._lives.run(script, function, *arguments)

    def evaluate(self, script: Script, source: bytes) -> list[Any]:
        """Execute a piece of text among a script's variables and return its results.

        Raises:
            ScriptError: the script does not run, or the text fails.
        """
        if script is self.sandbox and script.interpreter is None:
            self._phases.begin(script)
        return self._lives.evaluate(script, source)

    def deliver(self, script: Script, function: Function, *arguments: Any) -> list[Any] | None:
        """Call a function that a script gave for an event; return None if the script may not run. An error ends it."""
        return self._lives.deliver(script, function, *arguments)

    def remove(self, script: Script) -> None:
        """Remove a script from the scene; it ends when the present call into it returns.

        The annotation goes too, so copies of the object have no such script. A stop that reverts an edit of the
        scene brings back what was removed during the run.
        """
        if script not in self._scripts:
            return  # it has removed itself before, in the same call
        self._scripts.remove(script)
        self._reorder()
        scene = self._sim.scene
        if script.kind == ScriptKind.MAIN:
            scene.annotations = replace(scene.annotations, main_script=None)
        elif (item := scene.objects.get(script.home)) is not None:
            key = next(key for key, kind in _KINDS.items() if kind == script.kind)
            item.annotations = {kind: note for kind, note in item.annotations.items() if kind != key}
            notes = {**scene.annotations.objects, item.name: dict(item.annotations)}
            scene.annotations = replace(scene.annotations, objects=notes)
        self._lives.retire(script)
        self._changed()

    def restart(self, script: Script) -> bool:
        """End a script and start it again, as far as it runs now; return whether it runs."""
        if script.has("sysCall_cleanup"):
            self._lives.call(script, "sysCall_cleanup")
        self._lives.drop(script)
        if self._sim.is_running or script.kind == ScriptKind.CUSTOMIZATION:
            self._phases.begin(script)
        self._changed()
        return script.interpreter is not None

    def make_loose(self, kind: ScriptKind) -> int:
        """Return the handle of a new script without text and object; see `making.py`."""
        handle = self._next_handle
        self._next_handle += 1
        self.loose[handle] = LooseScript(kind)
        return handle

    def adopt(self, home: int, kind: ScriptKind, handle: int) -> None:
        """Find the script that an object was annotated with, as the script with this handle, and start it."""
        self._handles[home, kind] = handle
        self._find_more()

    def handle_customizations(self, function: str, *values: Any) -> int:
        """Call a phase of the customization scripts for a main script; return how many have it."""
        return self._phases.handle_customizations(function, *values)

    def handle_embedded(self, function: str, *values: Any) -> int:
        """Call a phase of child and customization scripts for a main script; return how many have it."""
        return self._phases.handle_embedded(function, *values)

    def handle_children(self, function: str, *values: Any) -> int:
        """Call a function of all child scripts, for actuation after their threads; return how many have it."""
        return self._phases.handle_children(function, *values)

    def handle_child(self, owner: int, function: str, *values: Any) -> int:
        """Call a function of the child script of an object; return 1 if it has it, else 0."""
        script = self.of(owner, ScriptKind.CHILD)
        return int(script is not None and self._lives.call(script, function, *values) is not None)

    def enable(self, script: Script, enabled: bool) -> None:
        """Have a script called or not. One that does not run yet starts only while it is enabled."""
        script.enabled = enabled
        if script.interpreter is None:
            script.starts_enabled = enabled
            runs = self._sim.is_running or script.kind == ScriptKind.CUSTOMIZATION
            if enabled and runs and not script.problem:
                self._phases.begin(script)

    def tell(self, function: str, event: dict[str, Any]) -> None:
        """Call a call-back of all scripts that have it, with one table."""
        self._phases.call_all(function, event)

    def broadcast(self, sender: Script, message: object) -> None:
        """Call ``sysCall_msg(message, sender)`` of all scripts but the sender."""
        for script in self.all():
            if script is not sender:
                self._lives.call(script, "sysCall_msg", message, sender.handle)

    def say_once(self, text: str, *, about: str = "") -> None:
        """Print a line to the status bar, and so to the log, unless a script of this scene has caused it before.

        Args:
            about: what the line is about, where it contains values that change; there is one line about each.
        """
        if self.is_first(about or text):
            self._status_bar.add(text)

    def is_first(self, note: str) -> bool:
        """Return whether no script of this scene has caused a note before, and keep its first characters; false from a
        number of notes on that only a faulty script causes.
        """
        note = note[:_LONGEST_NOTE]
        if note in self._told or len(self._told) >= _MOST_NOTES:
            return False
        self._told.add(note)
        return True

    # --- the scene -------------------------------------------------------------------------------

    def close(self) -> None:
        """End all scripts when the scene is closed."""
        self._phases.call_customizations("sysCall_cleanup")
        for script in (*self._scripts, self.sandbox):
            self._lives.drop(script)
        self._scripts = []
        self._reorder()
        self._phases.objects.forget()
        self.loose.clear()
        self._told.clear()
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
            gone = [one for one in self._scripts if one.home not in objects and one.kind != ScriptKind.MAIN]
            for script in gone:
                self._lives.drop(script)
                self._scripts.remove(script)
                self._reorder()
        for script in self._scripts:
            if script.place in objects:
                script.owner = objects[script.place].parent
        known = {(script.home, script.kind) for script in self._scripts}
        for handle in self._with_scripts():
            item = objects[handle]
            for key, kind in _KINDS.items():
                note = item.annotations.get(key)
                if note is not None and (handle, kind) not in known:
                    script = self._add(kind, handle, note, item.name)
                    if kind == ScriptKind.CUSTOMIZATION or self._sim.is_running:
                        if script.starts_enabled:
                            self._phases.begin(script)
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

    def _add(self, kind: ScriptKind, home: int, note: Annotation, name: str) -> Script:
        item = self._sim.scene.objects.get(home)
        is_object = item is not None and item.kind == ObjectKind.SCRIPT
        text, file = note.get("text"), str(note.get("file", ""))
        language = str(note.get("language", PYTHON if file.endswith(".py") else LUA))
        middle = "" if kind == ScriptKind.CHILD else f".{kind.name.lower()}"
        suffix = ".py" if language == PYTHON else ".lua"
        script = Script(
            handle=self._handles.pop((home, kind), self._next_handle),
            kind=kind,
            owner=item.parent if item is not None and is_object else home,
            place=home if is_object else -1,
            file=file or f"{name}{'' if name == 'main' else middle}{suffix}",
            text=None if text is None else str(text),
            folder=Path(str(note["folder"])) if "folder" in note else None,
            of_client=bool(note.get("of_client", self._is_of_client)),
            language=language,
            threaded=bool(note.get("threaded", False)),
            enabled=bool(note.get("enabled", True)),
            starts_enabled=bool(note.get("enabled", True)),
            joint_bases=bool(note.get("joint_bases", False)),
            full_results=bool(note.get("full_results", language == PYTHON)),
            stops_at_errors=bool(note.get("stops_at_errors", True)),
            order=Order[str(note.get("order", "normal")).upper()],
            traversal=Traversal[str(note.get("traversal", "reverse")).upper()],
        )
        self._next_handle += 1
        self._scripts.append(script)
        self._reorder()
        with suppress(ScriptError):  # its start, or the announcement of it, reports the reason
            self._name_ports(named_ports(script.code(self._sim, allows_code=self.allows_code)))
        return script
