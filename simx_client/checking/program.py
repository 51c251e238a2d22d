"""A script and its modules, as syntax trees; no code of it is run."""

from __future__ import annotations

import ast
import logging
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from simx_client.old_python.convert import decode
from simx_client.old_python.loading import IsPython2, convert_if_python2

from ..errors import SimxError
from ..protocol.nearest import file_like
from .reading.bindings import CONSTANTS_ONLY, FUNCTIONS_AND_CONSTANTS, is_legacy_binding
from .reading.folders import added_folders
from .search import Search, in_folder, is_wrapper

logger = logging.getLogger(__name__)

BINDINGS = (*FUNCTIONS_AND_CONSTANTS, *CONSTANTS_ONLY)

BINDING = "vrep"
"""Name for any binding of the legacy remote API, also that of this package."""

ZMQ_CLIENTS = ("coppeliasim_zmqremoteapi_client", "zmqRemoteApi")
"""Clients of CoppeliaSim's ZeroMQ remote API, which `simx-server --zmq` serves."""

PYREP, RLBENCH = "pyrep", "rlbench"
"""The first one is also the name of wrappers of the legacy remote API, which are read."""

PYREP_PACKAGES = (PYREP, RLBENCH)
"""Packages over the simulator's C library, for which `simx-run --pyrep` has a stand-in."""

OTHER_APIS = (*ZMQ_CLIENTS, *PYREP_PACKAGES, "b0RemoteApi")
"""Clients of other remote APIs. They are known by their names, and not read if a program contains them."""

MOST_FILES = 300
MOST_BYTES = 4_000_000


class CannotRead(SimxError):
    """The file does not exist, or is not valid in any version of Python."""


@dataclass(frozen=True, eq=False)
class Source:
    """One file of the program."""

    path: Path
    tree: ast.Module
    is_python2: bool

    @property
    def folder(self) -> Path | None:
        """Return the folder of its submodules, if it is a package."""
        return self.path.parent if self.path.name == "__init__.py" else None


@dataclass(frozen=True)
class Folder:
    """A package without ``__init__.py``."""

    folder: Path


@dataclass(frozen=True)
class Library:
    """A module outside the program, by its dotted name; `BINDING` for a binding of the remote API."""

    name: str


Module = Source | Folder | Library


@dataclass
class Program:
    """The script, first, and its modules."""

    sources: list[Source] = field(default_factory=list[Source])
    imports: dict[str, tuple[Path, int]] = field(default_factory=dict[str, tuple[Path, int]])
    """Top-level names of modules outside the program, and where they are first imported."""

    trouble: list[tuple[Path, str]] = field(default_factory=list[tuple[Path, str]])
    """Modules of the program that cannot be read, with the reason."""

    links: dict[tuple[Path, int, str], Module] = field(default_factory=dict[tuple[Path, int, str], Module])
    """Meaning of an import, by the importing file, the dots before the name, and the name."""

    packages: dict[str, Path] = field(default_factory=dict[str, Path])
    """Folders of PyRep and RLBench by name, if the program uses them and they are here."""

    files: dict[Path, Module] = field(default_factory=dict[Path, Module])
    """Modules by file or folder."""

    @property
    def script(self) -> Source:
        return self.sources[0]

    def submodule(self, module: Source | Folder, name: str) -> Module | None:
        """Return a module of a package, if something imports it."""
        file = None if module.folder is None else in_folder(module.folder, name)
        return None if file is None else self.files.get(file.resolve())


def read_program(path: Path) -> Program:
    """Read the script and the modules that it imports, without the binding that it contains.

    Its modules are those beside it, on the paths it adds to ``sys.path``, on PYTHONPATH, and installed
    packages that wrap a remote API.

    Raises:
        CannotRead: the script itself cannot be read; the text says why and what to do.
    """
    return _Reader(path).read()


class _Reader:
    def __init__(self, path: Path) -> None:
        self._search = Search(path)
        script = read_source(path, for_sure=False)
        self._program = Program([script], files={path.resolve(): script})
        self._waiting = [script]

    def read(self) -> Program:
        unknown: list[Imported] = []
        while self._waiting:
            source = self._waiting.pop(0)
            has_grown = [self._search.add(each) for each in added_folders(source.tree, source.path)]
            again, unknown = (unknown, []) if any(has_grown) else ([], unknown)
            for each in (*again, *imported(source)):
                self._follow(each)
                if isinstance(self._program.links[each.key], Library):
                    unknown.append(each)
        for each in unknown:
            if not each.level:
                place = each.importer.path, each.line
                self._program.imports.setdefault(each.module.partition(".")[0], place)
        if not self._program.imports.keys().isdisjoint(PYREP_PACKAGES):
            found = {name: self._search.package(name) for name in PYREP_PACKAGES}
            self._program.packages = {name: folder for name, folder in found.items() if folder}
        return self._program

    def _follow(self, each: Imported) -> None:
        """Link an import to its module, the packages above it and the modules that it imports from it."""
        parts = each.module.split(".")
        for count in range(1, len(parts)):
            self._link(each.importer, each.level, ".".join(parts[:count]))
        found = self._link(each.importer, each.level, each.module)
        for name in each.names:
            if self._is_module(each, found, name):
                self._link(each.importer, each.level, f"{each.module}.{name}".lstrip("."))

    def _is_module(self, each: Imported, found: Module, name: str) -> bool:
        """Return whether a name imported from a package is a module of it."""
        if found == Library(BINDING):  # a folder named like a binding keeps its modules
            module, level = f"{each.module}.{name}", each.level
            return self._search.own(module, each.importer.path, level, is_python2=False) is not None
        if name in BINDINGS:
            return True
        return not isinstance(found, Library) and bool(found.folder and in_folder(found.folder, name))

    def _link(self, importer: Source, level: int, module: str) -> Module:
        key = (importer.path, level, module)
        known = self._program.links.get(key)
        if known is None or known == Library(module):
            known = self._program.links[key] = self._find(importer, level, module)
        return known

    def _find(self, importer: Source, level: int, module: str) -> Module:
        top, _, _ = module.partition(".")
        if not level and top == "simx_client":
            return Library(module.replace(top, BINDING, 1))
        if not level and top in OTHER_APIS and not (top == PYREP and self._is_wrapper(top, importer)):
            return Library(module)
        file = self._search.own(module, importer.path, level, is_python2=importer.is_python2)
        name = module.rpartition(".")[2]
        if name in BINDINGS and (file is None or file.is_dir()):
            return Library(BINDING)
        if file is None and not level:
            file = self._search.installed(module)
        if file is None:
            return Library(module)
        return self._module(file)

    def _is_wrapper(self, top: str, importer: Source) -> bool:
        """Return whether a package with another API's name wraps the legacy one."""
        file = self._search.own(
            top, importer.path, 0, is_python2=importer.is_python2
        ) or self._search.installed(top)
        return file is not None and is_wrapper(file if file.is_dir() else file.parent)

    def _module(self, file: Path) -> Module:
        known = self._program.files.get(file.resolve())
        if known is None:
            known = self._program.files[file.resolve()] = self._read(file)
        return known

    def _read(self, file: Path) -> Module:
        if file.is_dir():
            return Folder(file)
        try:
            if is_legacy_binding(file.read_bytes()):
                return Library(BINDING)
            if len(self._program.sources) >= MOST_FILES:
                raise CannotRead(f"left out: more than {MOST_FILES} files are imported")
            found = read_source(file, for_sure=self._program.script.is_python2)
        except (CannotRead, OSError) as error:
            self._program.trouble.append((file, str(error)))
            return Library(file.stem)
        self._program.sources.append(found)
        self._waiting.append(found)
        return found


def read_source(path: Path, *, for_sure: bool) -> Source:
    """Read one file; convert it if it is Python 2 (`for_sure`: even if Python 3 could run it). Raises
    CannotRead."""
    if path.suffix == ".ipynb":
        raise CannotRead(
            f"{path} is a notebook; save it as a script first: jupyter nbconvert --to script {path}"
        )
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise CannotRead(f"{path} has {size:,} bytes; files of a program are read up to {MOST_BYTES:,}")
        source = path.read_bytes()
    except OSError as error:
        meant = file_like(path, (".py",)) or ";"
        raise CannotRead(f"cannot open {path}: {error.strerror}{meant} name the script's .py file") from error
    try:
        converted = convert_if_python2(source, str(path), for_sure=for_sure)
        if converted is None:
            return Source(path, ast.parse(decode(source), str(path)), is_python2=False)
        return Source(path, _placed(converted.text), is_python2=True)
    except IsPython2 as error:
        raise CannotRead(str(error)) from error
    except (RecursionError, MemoryError) as error:
        raise CannotRead(f"{path} is nested too deeply to be read; shorten its longest expression") from error
    except (SyntaxError, ValueError) as error:  # ValueError: a NUL in the source
        line = getattr(error, "lineno", None)
        where = f"{path}, line {line}" if line else str(path)
        raise CannotRead(
            f"{where}, is no Python: {getattr(error, 'msg', error)}; mend the line, then check again"
        ) from error


def _placed(text: str) -> ast.Module:
    """Return the tree of a converted text, its nodes with the lines of the original, which has fewer lines."""
    tree = ast.parse(text)
    added = [
        number
        for number, line in enumerate(text.split("\n"), 1)
        if line.startswith("from simx_client.python2 import ") or "= xxx_todo_changeme" in line
    ]
    for node in ast.walk(tree):
        if isinstance(node, (ast.stmt, ast.expr)):
            node.lineno -= sum(each < node.lineno for each in added)
    return tree


@dataclass(frozen=True)
class Imported:
    """An import statement, or a call that imports."""

    importer: Source
    level: int
    """Number of dots before the name."""

    module: str
    names: tuple[str, ...]
    """Names imported from the module; some may be modules too."""

    line: int

    @property
    def key(self) -> tuple[Path, int, str]:
        return self.importer.path, self.level, self.module


def imported(source: Source) -> Iterator[Imported]:
    """Yield all imports of a file."""
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Import):
            yield from (Imported(source, 0, alias.name, (), node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            names = tuple(alias.name for alias in node.names)
            yield Imported(source, node.level, node.module or "", names, node.lineno)
        elif isinstance(node, ast.Call) and (name := imported_by_call(node)):
            yield Imported(source, 0, name, (), node.lineno)


def imported_by_call(node: ast.Call) -> str:
    """Return the module of ``importlib.import_module("vrep")`` or ``__import__("vrep")``."""
    called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    if called in ("import_module", "__import__") and node.args and isinstance(node.args[0], ast.Constant):
        name = node.args[0].value
        return name if isinstance(name, str) and not name.startswith(".") else ""
    return ""
