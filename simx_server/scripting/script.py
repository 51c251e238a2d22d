"""One embedded script: the place of its text, its kind, and its interpreter while it runs."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import field
from enum import IntEnum
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from simx_client.protocol import constants
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.files.library import MODELS

from ..errors import CommandError
from .interpreter import Constant, Function, Interpreter, ScriptError, Switching, Waiting
from .modules import absent, own_module

if TYPE_CHECKING:
    from simx_server.parts.status_bar import StatusBar
    from simx_server.simulation.simulation import Simulation


PYTHON = "python"
LUA = "lua"

SUFFIXES = (".lua", ".py")
"""Endings of files that may be scripts when a client sends a path."""

EDITING_LIMIT = 60.0
"""Processor seconds of edits of the scene that do not count against the time limit of one call into a script."""

USUAL_VERBOSITY = 450
"""sim.verbosity_scriptinfos."""

_NOT_ALLOWED = "and the server runs no code of clients; start it with --allow-code if it shall"


class CodeNotAllowed(ScriptError):
    """A script comes from a client, and the operator has not allowed scripts of clients."""


class ScriptKind(IntEnum):
    """Kinds of scripts; the values are V-REP's script types."""

    MAIN = constants.sim_scripttype_mainscript
    CHILD = constants.sim_scripttype_childscript
    CUSTOMIZATION = constants.sim_scripttype_customizationscript
    SANDBOX = 8
    """The one that belongs to the simulator and has no text: programs run pieces of Lua in it."""

    @property
    def text(self) -> str:
        """Return the kind in words, for messages."""
        return f"{self.name.lower()} script"


class Order(IntEnum):
    """When a script is called compared with siblings; the values are V-REP's sim.scriptexecorder_*."""

    FIRST = 0
    NORMAL = 1
    LAST = 2


class Traversal(IntEnum):
    """When a script is called compared with those below its object, in V-REP's numbers."""

    REVERSE = 0
    FORWARD = 1
    """Before them."""
    PARENT = 2
    """As the next script above."""


@dataclass(frozen=True, slots=True)
class Scheduled:
    """A call that a script has left for later."""

    function: Function
    arguments: tuple[Any, ...]
    moment: float
    """Seconds of the wall clock (`time.monotonic`), or simulated ones."""
    in_simulation_time: bool


@dataclass(slots=True)
class LooseScript:
    """A script that a script has made and that belongs to no object yet."""

    kind: ScriptKind
    text: str = ""


@dataclass(slots=True, eq=False)
class Script:
    """One script of the scene."""

    handle: int
    kind: ScriptKind
    owner: int
    """Handle of the object that it serves; -1 for a main script."""

    file: str
    """Path in the annotation, relative to the scene's folder; for a text within the scene its name in messages."""

    text: str | None = None
    """Its text, when that is within the scene."""

    folder: Path | None = None
    """Folder of the file, for the script of a model that was loaded into the scene; None: the scene's folder."""

    of_client: bool = False
    """Whether a client sent the scene or model with its annotation."""

    language: str = LUA
    threaded: bool = False
    """An old body without functions that is one thread."""

    switching: Switching = field(default_factory=Switching)
    interpreter: Interpreter | None = None
    """None while it is not running: a child script while the simulation is stopped, any script after an error."""

    place: int = -1
    """Handle of the script object that has it, as in CoppeliaSim since 4.7; its owner is that object's parent. -1: it
    lies in its owner."""

    enabled: bool = True
    """A disabled script is not called, except for its init, until it is enabled or dropped."""

    starts_enabled: bool = True
    """A script that was disabled while it did not run does not start until it is enabled."""

    joint_bases: bool = False
    """A pose relative to a joint is one in its fixed frame, as before CoppeliaSim 4.0.1; else in its moving frame."""

    full_results: bool = False
    """Functions of proximity sensors return all values also where nothing is detected, as since CoppeliaSim 4.3."""
    stops_at_errors: bool = True
    """Whether an error of the API stops it from its start on; the scripts of old versions of V-REP went on."""

    console_verbosity: int = USUAL_VERBOSITY
    bar_verbosity: int = USUAL_VERBOSITY
    """Greatest sim.verbosity_* of its messages in the server's log and the status bar."""

    raises_errors: bool = True
    """Whether an error of the API stops it now."""

    active_in_run: bool = True
    """Whether a customization script is called during a run."""

    order: Order = Order.NORMAL

    traversal: Traversal = Traversal.REVERSE

    has_thread: bool = False
    """Whether its thread is running."""

    scheduled: dict[int, Scheduled] = field(default_factory=dict[int, Scheduled])
    """Calls left for later, by number."""

    schedule_numbers: count[int] = field(default_factory=lambda: count(1))

    events: dict[tuple[Any, ...], bytes] = field(default_factory=dict[tuple[Any, ...], bytes])
    """Events that its call-back gets next, in CBOR."""

    changes: Callable[[], Sequence[bytes]] | None = None
    """Returns events for what has changed since its last call, if the script watches anything."""

    watch_all: Callable[[], Callable[[], Sequence[bytes]]] | None = None
    """Starts to watch everything, for a script that receives events and has chosen nothing; returns `changes`."""

    problem: str = ""
    """Reason why it was stopped, if an error stopped it."""

    traceback: str = ""
    """The text of its last error, until a script has read it."""

    is_removed: bool = False
    """Whether it was removed: it ends when the present call into it returns, and is not called any more."""

    @property
    def home(self) -> int:
        """Return the handle of the object in which it lies: where relative paths in it start."""
        return self.owner if self.place == -1 else self.place

    @property
    def is_of_run(self) -> bool:
        """Return whether it lives for one run; a customization script outlives it."""
        return self.kind in (ScriptKind.MAIN, ScriptKind.CHILD)

    @property
    def signal_owner(self) -> Hashable:
        """Return the key under which its signals are stored."""
        return ("script", self.handle)

    @property
    def is_enabled(self) -> bool:
        """Return whether it is called, or, if it does not run yet, will start."""
        if self.interpreter is None:
            # A script that did not start yet will, if it is enabled; one that an error stopped will not.
            return self.starts_enabled and not self.problem and self.kind != ScriptKind.CUSTOMIZATION
        return self.enabled

    def has(self, function: str) -> bool:
        """Return whether it is running and has this function."""
        return self.interpreter is not None and self.interpreter.has(function)

    def path(self, sim: Simulation) -> Path:
        """Return its file, which must lie in the scene's folder or that folder's models.

        Raises:
            ScriptError: the file does not exist there.
        """
        return find_file(sim, self.folder, self.file)

    def source(self, sim: Simulation) -> bytes:
        """Return its text.

        Raises:
            ScriptError: the text cannot be read.
        """
        return self._read(sim)[0]

    def _read(self, sim: Simulation) -> tuple[bytes, Path | None]:
        """Return its text and the file of that. Raises ScriptError."""
        if self.text is not None:
            return self.text.encode("utf-8", "surrogateescape"), None
        path = self.path(sim)
        try:
            return path.read_bytes(), path
        except OSError as problem:
            raise ScriptError(f"{self.file} cannot be read: {problem.strerror}") from problem

    def code(self, sim: Simulation, *, allows_code: bool) -> bytes:
        """Return its text.

        Args:
            allows_code: scripts may run code that clients send.

        Raises:
            ScriptError: the text cannot be read; CodeNotAllowed: it may not be run.
        """
        text, path = self._read(sim)
        if allows_code:
            return text
        if self.of_client and (self.text is not None or Path(self.file).suffix not in SUFFIXES):
            raise CodeNotAllowed(f"a client sent the scene or model that it is in, {_NOT_ALLOWED}")
        if path is not None and sim.files.client_files.holds(path, text):
            raise CodeNotAllowed(f"a client sent {self.file}, {_NOT_ALLOWED}")
        return text

    def close(self) -> None:
        """Free its interpreter."""
        self.has_thread = False
        self.scheduled.clear()
        self.events.clear()
        self.changes = self.watch_all = None
        interpreter, self.interpreter = self.interpreter, None
        if interpreter is not None:
            interpreter.close()


def script_folder(sim: Simulation, folder: Path | None) -> Path | None:
    """Return the folder of a script: `folder` if its model brought one, else the scene's; None without a file."""
    scene = sim.scene.path
    return folder or (None if scene is None else scene.resolve().parent)


def find_file(sim: Simulation, folder: Path | None, name: str) -> Path:
    """Return a file beside the scene (or in `folder`), in its ``models/``, or among the shipped ones; only these.

    Raises:
        ScriptError: the file does not exist.
    """
    folder = script_folder(sim, folder)
    if folder is None:
        raise ScriptError(f"{name} cannot be found: the scene was not loaded from a file")
    # A model's file gives the script's path relative to itself, also when a scene includes that file.
    is_plain = os.path.basename(name) == name
    for base in (folder, sim.files.sources.shipped):
        for path in (base / name, base / MODELS / name):
            if is_plain and path.parent == base and not os.path.lexists(path):
                continue  # resolving it would find the same, and takes longer
            path = path.resolve()
            if not path.is_relative_to(base):
                raise ScriptError(f"{name} is outside the scene's folder {base}; put it there")
            if path.is_file():
                tell_of_file(sim, path)
                return path
    raise ScriptError(f"{name} is not in the scene's folder {folder}, nor in its {MODELS}/")


def tell_of_file(sim: Simulation, path: Path) -> None:
    """Report that a script's file was read: recordings store it."""
    sim.parts.tell(lambda part: part.file_read(path, sim.files.sources))


Call = Callable[[Sequence[Any]], "tuple[Any, ...] | Waiting"]
"""A function of the API that takes a script's plain values."""

_MOST_FUNCTIONS = 1000
"""Maximum number of functions that are kept for a script: it may call any name."""


class Spaces(Protocol):
    """The namespaces of one script, `sim` and the others; see `namespaces.Namespaces`."""

    def names(self) -> Mapping[str, Mapping[str, Constant | None]]: ...
    def without_edits(self) -> frozenset[str]: ...
    def function(self, full_name: str) -> Call: ...


class ScriptSide:
    """The server as a script's interpreter sees it; see `interpreter.Api`."""

    def __init__(
        self,
        sim: Simulation,
        script: Script,
        spaces: Spaces,
        serve_others: Callable[[], None],
        api_called: Callable[[], object],
        status_bar: StatusBar,
        *,
        allows_code: bool,
    ) -> None:
        self._sim = sim
        self._status_bar = status_bar
        self._allows_code = allows_code
        self._script = script
        self._spaces = spaces
        self._without_edits = spaces.without_edits()
        self._functions: dict[str, Call] = {}
        """Functions of the API that the script has called, by full name."""

        self.switching = script.switching
        self.serve_others = serve_others
        self._api_called = api_called

    @property
    def is_ending(self) -> bool:
        return self._sim.is_ending

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        return self._spaces.names()

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        return self.function(name)(arguments)

    def function(self, name: str) -> Call:
        known = self._functions.get(name)
        if known is None:
            known = self._made(self._spaces.function(name), edits=name not in self._without_edits)
            if len(self._functions) < _MOST_FUNCTIONS:
                self._functions[name] = known
        return known

    def _made(self, call: Call, *, edits: bool) -> Call:
        """Return a function of the API with what each call of a script does besides.

        Args:
            call: the function.
            edits: whether it is one that edits the scene: then its processor time is measured, which takes as long as
                most calls.
        """
        sim, switching, api_called = self._sim, self.switching, self._api_called
        interruptions = sim.interruptions

        def called(values: Sequence[Any]) -> tuple[Any, ...] | Waiting:
            interruptions.script_point()
            waited, edited, edition = interruptions.waited, interruptions.edited, sim.edition
            began = time.thread_time() if edits else 0.0
            try:
                results = call(values)
            finally:
                if sim.edition == edition:
                    switching.spent += interruptions.waited - waited
                else:  # an edit of the scene, whose costs grow with the scene
                    cost = time.thread_time() - began if edits else interruptions.edited - edited
                    switching.spent += min(cost, max(0.0, EDITING_LIMIT - switching.edited))
                    switching.edited += cost
            api_called()
            return results

        return called

    def count_calls(self, count: int) -> None:
        script_point = self._sim.interruptions.script_point
        for _ in range(count):
            script_point()

    def module(self, name: str) -> bytes | None:
        suffix = ".py" if self._script.language == PYTHON else ".lua"
        relative = name.removesuffix(suffix).replace(".", "/") + suffix
        try:
            path = find_file(self._sim, self._script.folder, relative)
            text = path.read_bytes()
        except ScriptError as problem:
            if "outside" in str(problem):
                raise
            return own_module(name, self._script.language) or self._stand_in(name)
        except OSError as problem:
            raise CommandError(f"{relative} cannot be read: {problem.strerror}") from problem
        if not self._allows_code and self._sim.files.client_files.holds(path, text):
            raise CommandError(f"a client sent {relative}, {_NOT_ALLOWED}")
        return text

    def _stand_in(self, name: str) -> bytes | None:
        """Return a module in place of a plug-in that is not there, and tell of it."""
        text = absent.stand_in(name, self._script.language)
        if text is not None:
            self._status_bar.add(absent.no_such_plugin(name, ()))
        return text

    def phases_changed(self) -> None:
        self._sim.parts.replan()

    def output(self, text: str) -> None:
        self._status_bar.add(text)
