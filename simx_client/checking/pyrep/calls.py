"""Read what a program uses of PyRep and RLBench: calls, functions of the C library, names of objects and files."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from ..places import Place, Wanted
from ..program import PYREP_PACKAGES, RLBENCH
from ..reading.paths import Paths
from ..reading.scopes import Called, Names
from ..reading.texts import Texts, is_known
from ..reading.things import Foreign, Meaning

_C_FUNCTION = re.compile(r"pyrep\.backend\.(?:sim|_sim_cffi)\.(?:lib\.)?(sim[A-Z]\w*)")
"""PyRep's own function has the name of the one of the C library that it calls."""

_CLASS = re.compile(r"(?:\.|^)(?P<name>[A-Z]\w*)(?P<rest>.*)")
_OBJECT = re.compile(r"pyrep\.objects(?:\.\w+)?\.[A-Z]\w*(?:\.get_object)?")
_BRINGING = re.compile(r"\.(?:import_\w+|create\w*|copy|sim(?:Load|Create|Import|CopyPaste)\w+)$")

_FILES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "PyRep.launch": ("scene file", "scene_file"),
        "PyRep.import_model": ("model file", "filename"),
        "simLoadScene": ("scene file", ""),
        "simLoadModel": ("model file", ""),
    }
)
"""Kind of the file that a call names by its first argument, and the name of that argument."""


@dataclass(frozen=True)
class FileNamed:
    """A file that a call opens."""

    kind: str
    paths: tuple[str, ...]
    """Possible paths; relative ones start at the working folder."""

    place: Place


@dataclass
class PyRepCalls:
    """Everything that a program uses of PyRep and RLBench, each with the place where it is first used."""

    calls: dict[str, Place] = field(default_factory=dict[str, Place])
    """Calls by their classes and methods: ``PyRep.launch``."""

    functions: dict[str, Place] = field(default_factory=dict[str, Place])
    """Functions of the C library that it calls by PyRep's module `backend.sim`."""

    named: list[Wanted] = field(default_factory=list[Wanted])
    files: list[FileNamed] = field(default_factory=list[FileNamed])
    brings_objects: bool = False
    """It loads or makes objects."""


def pyrep_calls(names: Names, meaning: Meaning, texts: Texts) -> PyRepCalls:
    """Return what a program uses."""
    found = PyRepCalls(brings_objects=RLBENCH in names.program.imports)
    paths = {source.path: Paths(source.tree, source.path) for source in names.program.sources}
    for call in names.calls:
        place = Place(call.scope.file, call.line)
        for path in sorted(_meant(call, meaning)):
            function = _C_FUNCTION.fullmatch(path)
            name = function[1] if function else _brief(path)
            if name:
                (found.functions if function else found.calls).setdefault(name, place)
            found.brings_objects = found.brings_objects or _BRINGING.search(path) is not None
            if _OBJECT.fullmatch(path) or name == "simGetObjectHandle":
                found.named += [Wanted("object", each, place) for each in _names(call, texts)]
            if name in _FILES:
                found.files += _file(name, call, place, paths[call.scope.file])
    found.named += [Wanted(each.kind, path, each.place) for each in found.files for path in each.paths]
    return found


def _meant(call: Called, meaning: Meaning) -> Iterator[str]:
    for thing in meaning.of(call.node.func, call.scope):
        if isinstance(thing, Foreign) and thing.path.partition(".")[0] in PYREP_PACKAGES:
            yield thing.path


def _brief(path: str) -> str:
    """Return ``PyRep.launch`` for ``pyrep.pyrep.PyRep().launch``; empty for a call without a class."""
    found = _CLASS.search(path)
    return found["name"] + re.sub(r"\(.*?\)", "", found["rest"]) if found else ""


def _names(call: Called, texts: Texts) -> list[str]:
    """Return the names in the first argument, which may be a handle too."""
    found = texts.of(call.node.args[0], call.scope) if call.node.args else frozenset[str]()
    return sorted(each for each in found if is_known(each) and not each.isdecimal())


def _file(name: str, call: Called, place: Place, paths: Paths) -> Iterator[FileNamed]:
    kind, argument = _FILES[name]
    nodes: list[ast.expr] = [each.value for each in call.node.keywords if each.arg == argument]
    for node in nodes or call.node.args[:1]:
        if values := tuple(each for each in paths.values(node) if each):
            yield FileNamed(kind, values, place)
