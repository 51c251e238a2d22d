"""One embedded script: where its text is, which kind it is, and its interpreter while it lives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from simx_client.protocol import constants
from simx_server.files.library import MODELS

from ..errors import CommandError
from .interpreter import Constant, Interpreter, ScriptError, Switching, Waiting

if TYPE_CHECKING:
    from collections.abc import Callable

    from simx_server.parts.status_bar import StatusBar
    from simx_server.world.simulation import Simulation


PYTHON = "python"
LUA = "lua"

SUFFIXES = (".lua", ".py")
"""Of the files that may be scripts when a client says so."""

_NOT_ALLOWED = "and the server runs no code of clients; start it with --allow-code if it shall"


class CodeNotAllowed(ScriptError):
    """A script is a client's, and the operator has not allowed those."""


class ScriptKind(IntEnum):
    """The values are V-REP's script types."""

    MAIN = constants.sim_scripttype_mainscript
    CHILD = constants.sim_scripttype_childscript
    CUSTOMIZATION = constants.sim_scripttype_customizationscript

    @property
    def text(self) -> str:
        """In words, as used in messages."""
        return f"{self.name.lower()} script"


@dataclass(slots=True, eq=False)
class Script:
    """One script of the scene."""

    handle: int
    kind: ScriptKind
    owner: int
    """Handle of its object; -1 for a main script."""

    file: str
    """As the annotation says it, relative to the scene's folder; for a text within the scene what messages call it."""

    text: str | None = None
    """Its text, when that is within the scene."""

    folder: Path | None = None
    """Where the file is, for the script of a model that was loaded into the scene; None: the scene's folder."""

    of_client: bool = False
    """A client sent the scene or model that it is annotated in."""

    language: str = LUA
    threaded: bool = False
    """An old body without functions that is one thread."""

    switching: Switching = field(default_factory=Switching)
    interpreter: Interpreter | None = None
    """None while it does not live: a child script while the simulation is stopped, any after an error."""

    enabled: bool = True
    """Switched off by a script it is not called, but for its init, until switched on or dropped."""

    has_thread: bool = False
    """Its thread is alive."""

    problem: str = ""
    """Why it was stopped, when an error did that."""

    @property
    def signal_owner(self) -> object:
        """Under what its signals are kept."""
        return ("script", self.handle)

    def has(self, function: str) -> bool:
        """Whether it lives and has this function."""
        return self.interpreter is not None and self.interpreter.has(function)

    def path(self, sim: Simulation) -> Path:
        """Its file, which must lie in the scene's folder or that folder's models. Raises ScriptError."""
        return find_file(sim, self.folder, self.file)

    def source(self, sim: Simulation) -> bytes:
        """Its text. Raises ScriptError."""
        if self.text is not None:
            return self.text.encode("utf-8", "surrogateescape")
        try:
            return self.path(sim).read_bytes()
        except OSError as problem:
            raise ScriptError(f"{self.file} cannot be read: {problem.strerror}") from problem

    def code(self, sim: Simulation, *, allows_code: bool) -> bytes:
        """Return its text.

        Args:
            allows_code: scripts may run code that clients send.

        Raises:
            ScriptError: the text cannot be read; CodeNotAllowed: it may not be run.
        """
        text = self.source(sim)
        if allows_code:
            return text
        if self.of_client and (self.text is not None or Path(self.file).suffix not in SUFFIXES):
            raise CodeNotAllowed(f"a client sent the scene or model that it is in, {_NOT_ALLOWED}")
        if self.text is None and sim.files.client_files.holds(self.path(sim), text):
            raise CodeNotAllowed(f"a client sent {self.file}, {_NOT_ALLOWED}")
        return text

    def close(self) -> None:
        """Free its interpreter."""
        self.has_thread = False
        interpreter, self.interpreter = self.interpreter, None
        if interpreter is not None:
            interpreter.close()


def script_folder(sim: Simulation, folder: Path | None) -> Path | None:
    """What lies beside a script: `folder` if its model brought one, else the scene's; None without a file."""
    scene = sim.scene.path
    return folder or (None if scene is None else scene.resolve().parent)


def find_file(sim: Simulation, folder: Path | None, name: str) -> Path:
    """A file beside the scene (or in `folder`), in the ``models/`` there, or among the shipped ones; nothing else.

    Raises ScriptError.
    """
    folder = script_folder(sim, folder)
    if folder is None:
        raise ScriptError(f"{name} cannot be found: the scene was not loaded from a file")
    # A model's file names its script as it lies beside it, also when a scene includes that file.
    for base in (folder, sim.files.sources.shipped):
        for path in ((base / name).resolve(), (base / MODELS / name).resolve()):
            if not path.is_relative_to(base):
                raise ScriptError(f"{name} is outside the scene's folder {base}; put it there")
            if path.is_file():
                tell_of_file(sim, path)
                return path
    raise ScriptError(f"{name} is not in the scene's folder {folder}, nor in its {MODELS}/")


def tell_of_file(sim: Simulation, path: Path) -> None:
    """A script's file is read: recordings keep it."""
    sim.tell(lambda part: part.file_read(path, sim.files.sources))


class Spaces(Protocol):
    """The namespaces of one script, `sim` and its like; see `namespaces.Namespaces`."""

    def names(self) -> Mapping[str, Mapping[str, Constant | None]]: ...
    def invoke(self, full_name: str, values: list[Any]) -> tuple[Any, ...] | Waiting: ...


class ScriptSide:
    """What a script's interpreter sees of the server; see `interpreter.Api`."""

    def __init__(
        self,
        sim: Simulation,
        script: Script,
        spaces: Spaces,
        serve_others: Callable[[], None],
        status_bar: StatusBar,
        *,
        allows_code: bool,
    ) -> None:
        self._sim = sim
        self._status_bar = status_bar
        self._allows_code = allows_code
        self._script = script
        self._spaces = spaces
        self.switching = script.switching
        self.serve_others = serve_others

    @property
    def is_ending(self) -> bool:
        return self._sim.is_ending

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        return self._spaces.names()

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        self._sim.interruptions.script_point()
        return self._spaces.invoke(name, arguments)

    def module(self, name: str) -> bytes | None:
        suffix = ".py" if self._script.language == PYTHON else ".lua"
        relative = name.removesuffix(suffix).replace(".", "/") + suffix
        try:
            path = find_file(self._sim, self._script.folder, relative)
            text = path.read_bytes()
        except ScriptError as problem:
            if "outside" in str(problem):
                raise
            return None
        except OSError as problem:
            raise CommandError(f"{relative} cannot be read: {problem.strerror}") from problem
        if not self._allows_code and self._sim.files.client_files.holds(path, text):
            raise CommandError(f"a client sent {relative}, {_NOT_ALLOWED}")
        return text

    def output(self, text: str) -> None:
        self._status_bar.add(text)
