"""Find a program's modules: beside it, on paths it adds, on PYTHONPATH, installed ones that wrap a binding."""

from __future__ import annotations

import importlib.util
import os
import re
import sys
from functools import cache
from importlib.machinery import ModuleSpec
from pathlib import Path

_SPEAKS = re.compile(rb"\bsimx[A-Z]\w|\bRemoteAPIClient\b")
"""Text in some file of a package that wraps a remote API."""

_LARGEST = 250
"""Maximum number of files of a package that may be a wrapper; larger ones, such as NumPy, are not read."""

_OURS = ("simx_client", "simx_server")


class Search:
    """The folders of one program, in the order in which Python searches them."""

    def __init__(self, script: Path) -> None:
        self._script = script.absolute().parent
        self.folders = [self._script, self._script.resolve()]
        self.folders += [Path(each) for each in os.environ.get("PYTHONPATH", "").split(os.pathsep) if each]

    def add(self, folder: str) -> bool:
        """Add a folder that the program adds; return whether it exists and is new.

        A relative path starts at the working folder, and is often written for the script's folder; both are
        tried.
        """
        found = False
        for written in dict.fromkeys((folder, folder.replace("\\", "/"))):
            for base in (Path(), self._script):
                path = (base / written).absolute()
                try:
                    is_new = path not in self.folders and path.is_dir()
                except (OSError, ValueError):  # a NUL, or too long a name
                    continue
                if is_new:
                    self.folders.append(path)
                    found = True
        return found

    def own(self, module: str, importer: Path, level: int, *, is_python2: bool) -> Path | None:
        """Return the file, or the folder, of a module of the program.

        Args:
            module: dotted; may be empty where only dots are written.
            importer: file with the import.
            level: number of dots before it.
            is_python2: modules of the importer's folder are found without a dot.
        """
        if level:
            base = importer.absolute().parent
            for _ in range(level - 1):
                base = base.parent
            return in_folder(base, module)
        folders = [importer.absolute().parent, *self.folders] if is_python2 else self.folders
        return next((found for each in folders if (found := in_folder(each, module))), None)

    def package(self, name: str) -> Path | None:
        """Return the folder of a package that the program imports, whatever it contains."""
        for each in self.folders:
            found = in_folder(each, name)
            if found is not None and found.name == "__init__.py":
                return found.parent
        spec = _spec(name)
        return Path(spec.origin).parent if spec is not None and spec.origin else None

    @staticmethod
    def installed(module: str) -> Path | None:
        """Return the file of an installed module, if its package wraps a remote API."""
        top, _, rest = module.partition(".")
        found = _wrapper(top)
        if found is None or not rest:
            return found
        return in_folder(found.parent, rest) if found.name == "__init__.py" else in_folder(found, rest)


def in_folder(folder: Path, module: str) -> Path | None:
    """Return the file of a module, or the folder of a package without ``__init__.py``."""
    base = folder.joinpath(*module.split(".")) if module else folder
    try:
        for file in (base / "__init__.py", *([base.with_name(base.name + ".py")] if module else [])):
            if file.is_file():
                return file
        return base if base.is_dir() else None
    except (OSError, ValueError):
        return None


def is_installed(name: str) -> bool:
    """Return whether Python would find a top-level module, without running it."""
    return _spec(name) is not None


def _spec(name: str) -> ModuleSpec | None:
    try:
        return importlib.util.find_spec(name)
    except (ImportError, ValueError, AttributeError):
        return None


@cache
def _wrapper(top: str) -> Path | None:
    if not top or top in sys.stdlib_module_names or top in _OURS:
        return None
    spec = _spec(top)
    if spec is None:
        return None
    if spec.submodule_search_locations is None:
        file = Path(spec.origin or "")
        return file if file.suffix == ".py" and speaks([file]) else None
    for folder in map(Path, spec.submodule_search_locations):
        if is_wrapper(folder):
            return in_folder(folder, "")
    return None


def is_wrapper(folder: Path) -> bool:
    """Return whether a package uses a remote API."""
    files: list[Path] = []
    for where, folders, names in os.walk(folder):
        folders.sort()
        files += [Path(where, name) for name in sorted(names) if name.endswith(".py")]
        if len(files) > _LARGEST:
            return False
    return speaks(files)


def speaks(files: list[Path]) -> bool:
    """Return whether one of these files names functions of a remote API."""
    for file in files:
        try:
            if _SPEAKS.search(file.read_bytes()):
                return True
        except OSError:
            continue
    return False
