"""The scripts of the loaded scene, and calls into them. `phases.py` decides which one runs when."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import count
from typing import TYPE_CHECKING, Any

from simx_server.parts.add_ons import AddOn
from simx_server.simulation.part import Part

from .calling_order import Called, called
from .conversion.exchange import check_results
from .interpreter import Function, ScriptError
from .lives import Lives, OpenSpaces
from .named_ports import named_ports
from .phases import Phases
from .script import LooseScript, Order, Script, ScriptKind
from .script_notes import KINDS, read_script, save_script
from .targets import find_target, split_target
from .told_once import ToldOnce

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


logger = logging.getLogger(__name__)

FIRST_HANDLE = 2_000_003
"""Handles of scripts are far above those of objects and above all script types; V-REP's start at a similar number."""

SANDBOX_HANDLE = FIRST_HANDLE - 1


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
        self._name_ports = name_ports
        self.describe_api = describe_api
        self._scripts: list[Script] = []
        self._called = Called()
        self._ordered_by: object = None
        """The tree of the scene from which `_called` follows; None: it is not known."""

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
        self.told_once = ToldOnce(status_bar)
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
        self.phases = Phases(sim, self, self._lives, self.told_once, status_bar, vision, proximity, force)

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
        self.phases.objects.note_changes()
        if self._is_loading:
            self._is_loading = False
            self.phases.call_customizations("sysCall_afterLoad")

    def scene_edited(self) -> None:
        self._find_more()
        self.phases.objects.note_changes()

    def copying_objects(self, handles: Collection[int]) -> None:
        self.phases.objects.before_copy(handles)

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        self.phases.objects.copied(copies)

    def saving(self, saved: Saved) -> None:
        for script in self._scripts:
            save_script(saved, script, self._sim)

    def run_starting(self) -> None:
        self.phases.call_customizations("sysCall_beforeSimulation")

    def run_started(self) -> None:
        self.phases.start()

    def run_paused(self) -> None:
        self.phases.call_all("sysCall_suspend")

    def run_resumed(self) -> None:
        self.phases.call_all("sysCall_resume")

    def run_stopping(self) -> None:
        self.phases.stop()

    def run_stopped(self) -> None:
        self.phases.watch()
        self.phases.call_customizations("sysCall_afterSimulation")

    @property
    def time_limit(self) -> float:
        """Return the processor seconds for one call into a script; a script takes the value at its start."""
        return self._lives.time_limit

    @time_limit.setter
    def time_limit(self, seconds: float) -> None:
        self._lives.time_limit = seconds

    def _changed(self) -> None:
        self.phases.watch()

    def _edited(self) -> None:
        self.phases.objects.tell()

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
        scene = self._sim.scene
        if scene.tree is not self._ordered_by:
            self._called, self._ordered_by = called(self._scripts, scene), scene.tree
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
            self.phases.begin(script)
        return self._lives.run(script, function, *arguments)

    def evaluate(self, script: Script, source: bytes) -> list[Any]:
        """Execute a piece of text among a script's variables and return its results.

        Raises:
            ScriptError: the script does not run, or the text fails.
        """
        if script is self.sandbox and script.interpreter is None:
            self.phases.begin(script)
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
            key = next(key for key, kind in KINDS.items() if kind == script.kind)
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
            self.phases.begin(script)
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

    def enable(self, script: Script, enabled: bool) -> None:
        """Have a script called or not. One that does not run yet starts only while it is enabled."""
        script.enabled = enabled
        if script.interpreter is None:
            script.starts_enabled = enabled
            runs = self._sim.is_running or script.kind == ScriptKind.CUSTOMIZATION
            if enabled and runs and not script.problem:
                self.phases.begin(script)

    def tell(self, function: str, event: dict[str, Any]) -> None:
        """Call a call-back of all scripts that have it, with one table."""
        self.phases.call_all(function, event)

    def broadcast(self, sender: Script, message: object) -> None:
        """Call ``sysCall_msg(message, sender)`` of all scripts but the sender."""
        for script in self.all():
            if script is not sender:
                self._lives.call(script, "sysCall_msg", message, sender.handle)

    # --- the scene -------------------------------------------------------------------------------

    def close(self) -> None:
        """End all scripts when the scene is closed."""
        self.phases.call_customizations("sysCall_cleanup")
        for script in (*self._scripts, self.sandbox):
            self._lives.drop(script)
        self._scripts = []
        self._reorder()
        self.phases.objects.forget()
        self.loose.clear()
        self.told_once.forget()
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
            for key, kind in KINDS.items():
                note = item.annotations.get(key)
                if note is not None and (handle, kind) not in known:
                    script = self._add(kind, handle, note, item.name)
                    if kind == ScriptKind.CUSTOMIZATION or self._sim.is_running:
                        if script.starts_enabled:
                            self.phases.begin(script)
                    else:
                        self._lives.announce(script)

    def _with_scripts(self) -> list[int]:
        """Return handles of the objects that have scripts. These are few, so the search uses the annotations."""
        scene = self._sim.scene
        named = [
            name for name, notes in scene.annotations.objects.items() if not KINDS.keys().isdisjoint(notes)
        ]
        handles = map(scene.by_name, named)
        return sorted(handle for handle in handles if handle is not None)

    def _add(self, kind: ScriptKind, home: int, note: Annotation, name: str) -> Script:
        script = read_script(
            note,
            kind,
            self._handles.pop((home, kind), self._next_handle),
            name,
            self._sim.scene.objects.get(home),
            is_of_client=self._is_of_client,
        )
        self._next_handle += 1
        self._scripts.append(script)
        self._reorder()
        with suppress(ScriptError):  # its start, or the announcement of it, reports the reason
            self._name_ports(named_ports(script.code(self._sim, allows_code=self.allows_code)))
        return script
