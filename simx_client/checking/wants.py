"""What a program asks of the remote API: the functions it calls, and what it names in them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from ..protocol import constants
from ..protocol.commands import BY_NAME
from ..surface import functions
from .names import Called, Names
from .ports import Ports
from .program import BINDINGS, Program
from .texts import ANY, Texts, is_known

NAMING = {
    "objectName": "object",
    "collectionName": "collection",
    "collisionObjectName": "collision",
    "distanceObjectName": "distance",
    "uiName": "ui",
    "scenePathAndName": "scene file",
    "modelPathAndName": "model file",
    "uiPathAndName": "ui file",
}
"""Arguments that name something of the scene, or a file, and what."""

BRINGING = ("simxLoadScene", "simxLoadModel", "simxCopyPasteObjects", "simxCreateDummy")
"""After these there may be objects that the scene does not have at first."""

_FUNCTION = re.compile(r"simx[A-Z]")

SIGNAL_KINDS = ("Float", "Integer", "String")


@dataclass(frozen=True, order=True)
class Place:
    """Where something stands in the program."""

    file: Path
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


@dataclass(frozen=True, order=True)
class Wanted:
    """Something a program names; a text with ``*`` is known in parts."""

    kind: str
    name: str
    place: Place = field(compare=False)


@dataclass
class Wants:
    """All of it, each thing once with the place where it is first named."""

    functions: dict[str, Place] = field(default_factory=dict[str, Place])
    """Of the table, under the name that the program uses."""

    unknown: dict[str, Place] = field(default_factory=dict[str, Place])
    """Called as if they were functions of the remote API."""

    constants: dict[str, Place] = field(default_factory=dict[str, Place])
    """Constants of the binding that do not exist."""

    miscounted: list[tuple[Place, str, int, int]] = field(default_factory=list[tuple[Place, str, int, int]])
    """(place, function, arguments needed, arguments given)."""

    named: list[Wanted] = field(default_factory=list[Wanted])
    calls: list[tuple[str, str, Place]] = field(default_factory=list[tuple[str, str, Place]])
    """(object, script function, place)."""

    signals: list[tuple[str, str, bool, Place]] = field(default_factory=list[tuple[str, str, bool, Place]])
    """(kind in lower case, name, whether it is set here, place)."""

    ports: dict[int, Place] = field(default_factory=dict[int, Place])
    unclear: dict[str, list[Place]] = field(default_factory=dict[str, list[Place]])
    """What is named only at run time, and where."""

    def of_kind(self, kind: str) -> list[Wanted]:
        return [each for each in self.named if each.kind == kind]

    @property
    def brings_objects(self) -> bool:
        """Whether it loads or makes objects itself."""
        return any(name in self.functions for name in BRINGING)


def wants_of(program: Program, names: Names) -> Wants:
    """Read them off the calls."""
    wants = Wants()
    texts = Ports(names)
    public = functions()
    for call in names.calls:
        name = _name_of(call, names)
        # One that the program defines itself, or a method of a wrapper, is followed into, not taken for the API's.
        if not _FUNCTION.match(name) or name in names.functions:
            continue
        place = Place(call.scope.file, call.line)
        if name not in public:
            wants.unknown.setdefault(name, place)
            continue
        wants.functions.setdefault(name, place)
        parameters = _parameters(name, call, names)
        _count(wants, name, call, parameters, place)
        _read(wants, name, texts, call, parameters, place)
    _constants(wants, names)
    wants.named = _once(wants.named)
    wants.calls = list({each[:2]: each for each in reversed(wants.calls)}.values())[::-1]
    wants.signals = list({each[:3]: each for each in reversed(wants.signals)}.values())[::-1]
    return wants


def _name_of(call: Called, names: Names) -> str:
    """Of the function called, also after ``import simxStart as start``, or by ``getattr(vrep, 'simxStart')``."""
    node = call.node.func
    if isinstance(node, ast.Name):
        return names.modules.get(node.id, node.id)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "getattr":
        wanted = node.args[1] if len(node.args) > 1 else None
        return str(wanted.value) if isinstance(wanted, ast.Constant) else ""
    return call.name


def _parameters(name: str, call: Called, names: Names) -> tuple[str, ...]:
    """What the call has to give: in a batch (`simx_client.batch`) neither client id nor operation mode."""
    command = BY_NAME[name]
    receiver = call.node.func.value if isinstance(call.node.func, ast.Attribute) else None
    is_module = receiver is None or (isinstance(receiver, ast.Name) and receiver.id in names.modules)
    without = tuple(each.name for each in command.arguments)
    is_batched = not is_module and len(call.node.args) + len(call.node.keywords) == len(without)
    return without if is_batched else command.parameters


def _read(
    wants: Wants, called: str, texts: Ports, call: Called, parameters: tuple[str, ...], place: Place
) -> None:
    command = BY_NAME[called]
    if "functionName" in parameters:
        _script_call(wants, texts, call, parameters, place)
        return
    if called == "simxStart":
        for port in texts.ports(call, parameters):
            wants.ports.setdefault(port, place)
    for name in parameters:
        if name in NAMING:
            found = texts.argument(call, name, parameters)
            wants.named += [Wanted(NAMING[name], text, place) for text in sorted(found) if is_known(text)]
            _note_unclear(wants, NAMING[name], found, place)
        elif name in ("signalName", "retSignalName"):
            kind = next((each for each in SIGNAL_KINDS if each in command.name), "String").lower()
            sets = command.name.startswith(("simxSet", "simxAppend", "simxQuery")) and name == "signalName"
            if command.name.startswith("simxClear"):
                continue
            found = texts.argument(call, name, parameters)
            wants.signals += [(kind, text, sets, place) for text in sorted(found) if is_known(text)]
            _note_unclear(wants, "signal", found, place)


def _script_call(wants: Wants, texts: Texts, call: Called, parameters: tuple[str, ...], place: Place) -> None:
    objects = texts.argument(call, "scriptDescription", parameters)
    functions = texts.argument(call, "functionName", parameters)
    for function in sorted(functions):
        name, _, owner = function.partition("@")
        for each in (owner,) if owner else sorted(objects):
            if is_known(each) or is_known(name):
                wants.calls.append((each, name, place))
    _note_unclear(wants, "script function", functions, place)


def _note_unclear(wants: Wants, what: str, found: Iterable[str], place: Place) -> None:
    if any(text and not is_known(text) for text in found) and place not in wants.unclear.setdefault(what, []):
        wants.unclear[what].append(place)


def _count(wants: Wants, called: str, call: Called, parameters: tuple[str, ...], place: Place) -> None:
    """Too many or too few arguments are an error only when the call is made; here already."""
    node = call.node
    if any(isinstance(each, ast.Starred) for each in node.args) or any(
        not each.arg for each in node.keywords
    ):
        return
    given, needed = len(node.args) + len(node.keywords), len(parameters)
    if given != needed:
        wants.miscounted.append((place, called, needed, given))


def _constants(wants: Wants, names: Names) -> None:
    for node, scope in names.read:
        base = node.value
        if not (isinstance(base, ast.Name) and node.attr.startswith(("sim_", "simx_"))):
            continue
        is_binding = names.modules.get(base.id, "").rpartition(".")[2] in BINDINGS
        if is_binding and not isinstance(getattr(constants, node.attr, None), int):
            wants.constants.setdefault(node.attr, Place(scope.file, node.lineno))


def _once(named: Iterable[Wanted]) -> list[Wanted]:
    """Each once, with its first place. A pattern that knows less than ANY-free texts stays: both may be meant."""
    found: dict[tuple[str, str], Wanted] = {}
    for each in named:
        found.setdefault((each.kind, each.name), each)
    return [each for each in found.values() if each.name != ANY]
