"""The needs of a program: the functions of the remote API that it calls, and the things that it names in them."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache, cached_property

from simx_client.calls.operation_modes import MODE_MASK

from ..protocol import constants
from ..protocol.commands import BY_NAME
from ..protocol.table.meanings import Role
from .model import model_calls
from .places import Place, Wanted
from .program import BINDING, OTHER_APIS, PYREP_PACKAGES, ZMQ_CLIENTS, Library, Program
from .pyrep.calls import PyRepCalls, pyrep_calls
from .reading.ports import Ports
from .reading.scopes import Called, Names
from .reading.texts import ANY, Texts, is_known
from .reading.things import Foreign, Meaning

_FUNCTION = re.compile(r"simx[A-Z]")
_FROM_BINDING = re.compile(r"simx?[A-Z_]")
_REGULAR = re.compile(r"sim\w*\.\w+")
_CONSTANT = re.compile(r"sim\w*\.[a-z0-9]+(?:_[a-z0-9]+)+")
_FINDING = ("sim.getObject", "sim.getObjectHandle")
_OF_CLIENT = re.compile(rf"{BINDING}\.(?:(?:client|modern)\.)?Client(?:\.of)?\(\)\.(\w+)")


@dataclass(frozen=True)
class Use:
    """One call of a function of the table."""

    called: str
    """The function, under the name that the program uses."""

    call: Called
    place: Place
    _parameters: tuple[str, ...]
    _texts: Texts

    @property
    def function(self) -> str:
        """Return its first name in the table."""
        return BY_NAME[self.called].name

    def argument(self, name: str) -> ast.expr | None:
        """Return the expression for a parameter; None where the call does not show it."""
        return self._texts.written(self.call, name, self._parameters) if name in self._parameters else None

    def values(self, name: str) -> frozenset[str]:
        """Return the possible texts of an argument; `ANY` for an unknown one."""
        node = self.argument(name)
        return frozenset((ANY,)) if node is None else self._texts.of(node, self.call.scope)

    @cached_property
    def modes(self) -> frozenset[int]:
        """Return its operation modes, as far as they are known."""
        node = self.argument("operationMode")
        if isinstance(node, ast.BinOp):  # a rate is added
            node = node.left
        texts = self._texts.of(node, self.call.scope) if node is not None else ()
        return frozenset(int(each) & MODE_MASK for each in texts if each.isdecimal())


@dataclass
class Wants:
    """All needs of a program, each once with the place where it is first named."""

    functions: dict[str, Place] = field(default_factory=dict[str, Place])
    """Functions of the table, under the name that the program uses."""

    unknown: dict[str, Place] = field(default_factory=dict[str, Place])
    """Names called like functions of the remote API, but missing in the table."""

    doubtful: dict[str, Place] = field(default_factory=dict[str, Place])
    """As `unknown`, but called on an object that is known only at run time, and may have them."""

    uses: list[Use] = field(default_factory=list["Use"])
    """All calls of functions of the table."""

    client: dict[str, Place] = field(default_factory=dict[str, Place])
    """Methods of `simx_client.Client` that it calls."""

    regular: dict[str, Place] = field(default_factory=dict[str, Place])
    """Functions that it calls by the ZeroMQ remote API, with their namespace: `sim.getObject`."""

    regular_constants: dict[str, Place] = field(default_factory=dict[str, Place])
    """Constants that it reads by the ZeroMQ remote API: `sim.handle_world`."""

    elsewhere: dict[str, dict[str, Place]] = field(default_factory=dict[str, dict[str, Place]])
    """Functions of remote APIs that are not served that it calls, by the module of their client."""

    pyrep: PyRepCalls | None = None
    """Its use of PyRep and RLBench; None for a program that imports neither."""

    model: dict[str, Place] = field(default_factory=dict[str, Place])
    """Its calls by API 2, such as `sim.scene.getObject`."""

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
    """Kinds of things that are named only at run time, and where."""

    def of_kind(self, kind: str) -> list[Wanted]:
        return [each for each in self.named if each.kind == kind]

    @property
    def brings_objects(self) -> bool:
        """Return whether it loads or makes objects itself."""
        if self.pyrep is not None and self.pyrep.brings_objects:
            return True
        return any(BY_NAME[name].adds_objects for name in self.functions)

    @property
    def is_of_a_remote_api(self) -> bool:
        """Return whether it calls a function or a method of an API that simx serves."""
        return bool(self.functions or self.client or self.regular or self.model or self.pyrep is not None)


def wants_of(program: Program, names: Names) -> Wants:
    """Return the needs of a program, read from its calls."""
    wants = Wants()
    meaning = Meaning(names)
    texts = Ports(names, meaning)
    for call in names.calls:
        place = Place(call.scope.file, call.line)
        for name, is_sure in called_functions(call, names, meaning):
            if name not in BY_NAME:
                (wants.unknown if is_sure else wants.doubtful).setdefault(name, place)
                continue
            wants.functions.setdefault(name, place)
            parameters = _parameters(name, call, is_sure=is_sure)
            wants.uses.append(Use(name, call, place, parameters, texts))
            if is_sure:
                _count(wants, name, call, parameters, place)
            _read(wants, name, texts, call, parameters, place)
        _other_calls(wants, call, place, texts, meaning)
    _read_names(wants, names, meaning)
    wants.model = model_calls(program)
    if not program.imports.keys().isdisjoint(PYREP_PACKAGES):
        wants.pyrep = pyrep_calls(names, meaning, texts)
        wants.named += wants.pyrep.named
    wants.named = _once(wants.named)
    wants.calls = list({each[:2]: each for each in reversed(wants.calls)}.values())[::-1]
    wants.signals = list({each[:3]: each for each in reversed(wants.signals)}.values())[::-1]
    return wants


def called_functions(call: Called, names: Names, meaning: Meaning) -> Iterator[tuple[str, bool]]:
    """Yield (function of the remote API, whether that is certain) for each function that a call may call.

    A call on an object that is known only at run time counts by its name, unless the program has a function or
    method of that name.
    """
    things = meaning.of(call.node.func, call.scope)
    for thing in things:
        if isinstance(thing, Foreign):
            module, _, name = thing.path.rpartition(".")
            is_binding = module == BINDING
            is_batch = module.startswith(f"{BINDING}.batch.")
            is_module = "(" not in module and module.partition(".")[0] not in OTHER_APIS
            if _FUNCTION.match(name) and (is_binding or is_batch or is_module):
                yield name, is_binding
    is_own = call.name in names.functions
    if not things and not is_own and _FUNCTION.match(call.name):
        yield call.name, False


def _parameters(name: str, call: Called, *, is_sure: bool) -> tuple[str, ...]:
    """Return the parameters that the call must give. A batch (`simx_client.batch`) takes neither client id nor
    operation mode; a wrapper often adds the client id."""
    command = BY_NAME[name]
    if is_sure or any(each.arg in ("clientID", "operationMode") for each in call.node.keywords):
        return command.parameters
    without = tuple(each.name for each in command.arguments)
    given = len(call.node.args) + len(call.node.keywords)
    short = command.parameters[1:] if command.parameters[:1] == ("clientID",) else without
    return next((each for each in (without, short) if len(each) == given), command.parameters)


def _other_calls(wants: Wants, call: Called, place: Place, texts: Texts, meaning: Meaning) -> None:
    """Calls of this project's own ``Client``, of the ZeroMQ remote API, and of remote APIs that are not served."""
    for thing in meaning.of(call.node.func, call.scope):
        if not isinstance(thing, Foreign):
            continue
        if found := _OF_CLIENT.fullmatch(thing.path):
            wants.client.setdefault(found[1], place)
            for node in call.node.args if client_methods().get(found[1]) else ():
                is_star = isinstance(node, ast.Starred)
                names = texts.elements(node.value, call.scope) if is_star else texts.of(node, call.scope)
                wants.named += [Wanted("object", each, place) for each in sorted(names) if is_known(each)]
        top, _, rest = thing.path.partition(".")
        if top in ZMQ_CLIENTS and _REGULAR.fullmatch(name := _short(rest)):
            wants.regular.setdefault(name, place)
            if name in _FINDING and call.node.args and _must_exist(call.node.args[1:]):
                found = sorted(filter(is_known, texts.of(call.node.args[0], call.scope)))
                wants.named += [Wanted("object", each, place) for each in found if each.startswith("/")]
        elif top in OTHER_APIS and top not in (*ZMQ_CLIENTS, *PYREP_PACKAGES):
            wants.elsewhere.setdefault(top, {}).setdefault(rest, place)


def _must_exist(options: list[ast.expr]) -> bool:
    """Return whether an object must exist, by the options of `sim.getObject`, as far as they are written there."""
    if not options:
        return True
    return isinstance(options[0], ast.Dict) and all(
        isinstance(key, ast.Constant) and key.value != "noError" for key in options[0].keys
    )


@cache
def client_methods() -> dict[str, bool]:
    """Attributes of ``Client``, and whether each is a method that takes names of objects."""
    from simx_client.client import Client

    members = {name: getattr(Client, name) for name in dir(Client) if not name.startswith("_")}
    return {
        name: inspect.isfunction(member)
        and bool({"name", "names"} & set(inspect.signature(member).parameters))
        for name, member in members.items()
    }


def _short(path: str) -> str:
    """``sim.getObject`` of ``RemoteAPIClient().require('sim').getObject``; stepping is the client's own."""
    path = re.sub(r"^(?:\w+\.)*RemoteAPIClient\(\)\.(setStepping|step)$", r"sim.\1", path)
    return re.sub(r"^.*\('(\w+)(?:-\d+)?'\)", r"\1", path)


def _read(
    wants: Wants, called: str, texts: Ports, call: Called, parameters: tuple[str, ...], place: Place
) -> None:
    naming = {name: meaning for name, meaning in BY_NAME[called].takes.items() if meaning.names}
    owner = next((name for name, meaning in naming.items() if meaning.names == "script owner"), None)
    for name, meaning in naming.items():
        what, _, thing = meaning.names.partition(" ")
        if name not in parameters or name == owner or meaning.role is Role.REMOVES:
            continue
        if meaning.names == "port":
            for port in texts.ports(call, name, parameters):
                wants.ports.setdefault(port, place)
            continue
        found = texts.argument(call, name, parameters)
        known = sorted(text for text in found if is_known(text))
        if meaning.names == "script function":
            owners = texts.argument(call, owner, parameters) if owner in parameters else frozenset[str]()
            _script_call(wants, owners, found, place)
        elif thing == "signal":
            wants.signals += [(what, text, meaning.role is Role.MAKES, place) for text in known]
            _note_unclear(wants, thing, found, place)
        else:
            wants.named += [Wanted(meaning.names, text, place) for text in known]
            _note_unclear(wants, meaning.names, found, place)


def _script_call(wants: Wants, objects: Iterable[str], functions: Iterable[str], place: Place) -> None:
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


def _read_names(wants: Wants, names: Names, meaning: Meaning) -> None:
    """Names of the binding that are read without a call, or imported."""
    has_zmq = not names.program.imports.keys().isdisjoint(ZMQ_CLIENTS)
    for node, scope in names.read:
        if not (has_zmq or _FROM_BINDING.match(node.attr)):
            continue
        things = meaning.of(node.value, scope)
        place = Place(scope.file, node.lineno)
        if _FROM_BINDING.match(node.attr) and Foreign(BINDING) in things:
            _take(wants, node.attr, place, is_call=True)
        for thing in things if has_zmq else ():
            top, _, rest = thing.path.partition(".") if isinstance(thing, Foreign) else ("", "", "")
            name = f"{_short(rest)}.{node.attr}"
            if top in ZMQ_CLIENTS and _CONSTANT.fullmatch(name):
                wants.regular_constants.setdefault(name, place)
    for (scope, _), imports in names.imports.items():
        for each in imports:
            if each.attribute and names.program.links.get((scope.file, each.level, each.module)) == Library(
                BINDING
            ):
                _take(wants, each.attribute, Place(*names.lines[each]), is_call=False)


def _take(wants: Wants, name: str, place: Place, *, is_call: bool) -> None:
    """Note one name of the binding; the call itself reports a function that does not exist."""
    if name in BY_NAME:
        wants.functions.setdefault(name, place)
    elif _FUNCTION.match(name):
        if not is_call:
            wants.unknown.setdefault(name, place)
    elif name.startswith(("sim_", "simx_")) and not isinstance(getattr(constants, name, None), int):
        wants.constants.setdefault(name, place)


def _once(named: Iterable[Wanted]) -> list[Wanted]:
    """Return each thing once, with its first place. A pattern stays beside a text that it matches."""
    found: dict[tuple[str, str], Wanted] = {}
    for each in named:
        found.setdefault((each.kind, each.name), each)
    return [each for each in found.values() if each.name != ANY]
