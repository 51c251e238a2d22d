"""Expand xacro files to URDF, by ROS's own library xacro, which is in the extra `urdf`; ROS itself is not needed.

The library evaluates expressions of the file as Python, without a sandbox. Therefore only files are expanded that the
operator has stored, with all the files that they include; a file that a client has sent is refused.
"""

from __future__ import annotations

import errno
import importlib
import importlib.util
import io
import logging
import os
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

from simx_client.protocol.cli.installing import extra_line
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.xml_texts import refuse_entities

from .recognising import XACRO

logger = logging.getLogger(__name__)

_EXPRESSIONS = ("${", "$(")

_INDEX = "ament_index_python"
"""The module of ROS 2 by which the library finds packages; another one takes its place during an expansion."""

_MESSAGES = ("warning", "message", "error", "print_location")
"""Functions of the library that print."""

_UNDEFINED = "Undefined substitution argument"
"""The library's words for an argument without a value."""

_lock = RLock()
"""The library keeps the state of an expansion in its module."""


@dataclass(frozen=True)
class Expanded:
    """The result of an expansion."""

    root: ElementTree.Element
    files: tuple[Path, ...]
    """The other files that were read, resolved."""


class _Refused(Exception):
    """A reason why the expansion cannot go on, in words for the user."""


@cache
def is_available() -> bool:
    """Return whether the library is installed."""
    return importlib.util.find_spec("xacro") is not None


def is_xacro(data: bytes, name: str) -> bool:
    """Return whether a text is xacro: by its ending, its elements or its expressions."""
    if name.lower().endswith(XACRO):
        return True
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError):
        return b"<xacro:" in data  # a prefix that is not declared
    return any(
        (element.tag.startswith("{") and "xacro" in element.tag.partition("}")[0])
        or (
            element.tag in ("link", "joint", "mesh", "origin", "mass")
            and any(sign in value for value in element.attrib.values() for sign in _EXPRESSIONS)
        )
        for element in root.iter()
    )


def expand(data: bytes, name: str, file: Path | None, sources: Sources) -> Expanded:
    """Return the URDF of a xacro file.

    Args:
        data: its bytes.
        name: its name in errors.
        file: the file; None for a text without a file.
        sources: search folders for packages, values of the file's arguments, and the files that may be read.

    Raises:
        SceneError: a client sent it or a file that it includes, it or its arguments are not valid, a package is
            missing, or the library is not installed.
    """
    if file is None:
        raise SceneError(f"'{name}' is xacro; give it as a file, since it may name others")
    if sources.contents is not None:
        raise SceneError(refusal(name))
    if not is_available():
        raise SceneError(f"'{name}' is a xacro file; ROS's library expands those: {extra_line('urdf')}")
    reading = _Reading(name, file, sources)
    try:
        with _lock, reading.hooked() as library:
            library.init_stacks(str(file))
            document = library.parse(reading.open(file))
            library.process_doc(document, mappings=dict(sources.xacro_arguments), verbosity=0)
            text = document.documentElement.toxml()
        return Expanded(ElementTree.fromstring(text), tuple(dict.fromkeys(reading.files)))
    except (MemoryError, SceneError):
        raise
    except RecursionError:
        raise SceneError(f"'{name}' includes itself, or is nested too deeply") from None
    except Exception as error:  # expressions may raise anything
        problem = reading.problem or _in_words(error)
        raise SceneError(f"cannot expand '{name}': {problem}") from None


def refusal(name: str) -> str:
    """Return the sentence that refuses a client's xacro file."""
    return (
        f"'{name}' is a xacro file, whose expressions are programs: only the operator's own are expanded, and none "
        f"with --check-files; expand it first, as with `xacro {name} > robot.urdf`"
    )


def _in_words(error: Exception) -> str:
    text = (" ".join(str(error).split()) or type(error).__name__)[:600]
    if _UNDEFINED in text:
        text += "; start the server with --xacro NAME:=VALUE"
    return text


class _Reading:
    """The files of one expansion: which may be read, and which were."""

    def __init__(self, name: str, file: Path, sources: Sources) -> None:
        self._name, self._file, self._sources = name, file, sources.for_one_read()
        self.files: list[Path] = []
        self.problem = ""
        """The first reason that this class has found; the library wraps the exception in its own."""

    def open(self, name: str | Path, *_: object, **__: object) -> io.BytesIO:
        """Open a file for the library. Raises OSError, _Refused."""
        path = Path(name)
        found = self._sources.first([path])
        if found is None:
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
        data = self._sources.read(found)
        if not self._sources.trusts(found, data):  # after reading: a client may store another one at any time
            self._refuse(refusal(found.name))
        try:
            refuse_entities(data, found.name)
        except SceneError as problem:
            self._refuse(str(problem))
        if found != self._file.resolve():
            self.files.append(found)
        return io.BytesIO(data)

    def find(self, package: str) -> str:
        """Return the folder of a package. Raises _Refused."""
        for folder in self._sources.package_folders(package, self._file):
            if self._sources.allows(folder) and folder.is_dir():
                self.files += self._sources.package_files(f"package://{package}/", self._file)
                return str(folder)
        self._refuse(
            f"no folder of the package {package} was found above the file or in ROS_PACKAGE_PATH: start the server "
            f"with --package {package}=DIR"
        )
        raise AssertionError

    def _refuse(self, problem: str) -> None:
        self.problem = self.problem or problem
        raise _Refused(problem)

    @contextmanager
    def hooked(self) -> Generator[Any]:
        """Let the library read files and find packages by this object only."""
        library: Any = importlib.import_module("xacro")
        index, packages = ModuleType(_INDEX), ModuleType(f"{_INDEX}.packages")
        packages.get_package_share_directory = self.find  # type: ignore[attr-defined]
        index.packages = packages  # type: ignore[attr-defined]
        told: dict[str, Any] = dict.fromkeys(_MESSAGES, _told)
        names = {_INDEX: index, f"{_INDEX}.packages": packages}
        with _replaced(library.__dict__, {"open": self.open, **told}), _replaced(sys.modules, names):
            library.all_includes.clear()
            yield library


@contextmanager
def _replaced(names: Any, values: Mapping[str, Any]) -> Generator[None]:
    """Give names of a dictionary other values, and put the former ones back."""
    before = {name: names[name] for name in values if name in names}
    names.update(values)
    try:
        yield
    finally:
        for name in values:
            names.pop(name, None)
        names.update(before)


def _told(*words: object, **_: object) -> None:
    logger.debug("xacro: %s", " ".join(map(str, words)))
