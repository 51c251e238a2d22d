"""One script's view of the server: the objects behind ``sim``, ``simIK`` ... and the lookup of their methods."""

from __future__ import annotations

import re
from collections.abc import Callable, Generator, Mapping, Sequence
from functools import cache
from types import GeneratorType, MappingProxyType
from typing import TYPE_CHECKING, Any

from simx_client.protocol.nearest import did_you_mean
from simx_server import sim_api as api
from simx_server.errors import CommandError, Unsupported
from simx_server.scripting.conversion.signature import Signature
from simx_server.scripting.interpreter import OLD_SPACES, Constant, Plain, Waiting
from simx_server.scripting.modules.absent import no_such_plugin

from .effects import Effect, declared, declares_no_edit

if TYPE_CHECKING:
    from simx_server.scripting.script import Call, Script
    from simx_server.world.world import World


_CONSTANT = re.compile(r"[a-z0-9]+(_[a-z0-9]+)+")
"""Form of the names of constants. In V-REP an unknown one is nil, and scripts with a wrong name work."""


@cache
def signatures(space: str) -> Mapping[str, Signature]:
    """Return every function of a namespace with its parameters."""
    found: dict[str, Signature] = {}
    for part in api.NAMESPACES[space].__mro__:
        for name, member in vars(part).items() if issubclass(part, api.ApiPart) else ():
            if not name.startswith("_") and callable(member):
                found.setdefault(name, Signature.of(member))
    return MappingProxyType(found)


@cache
def effects(space: str) -> Mapping[str, Effect]:
    """Return what each function of a namespace does. Raises TypeError: one declares nothing, nor does its class."""
    found: dict[str, Effect] = {}
    known = signatures(space)
    for part in api.NAMESPACES[space].__mro__:
        if not issubclass(part, api.ApiPart):
            continue
        for name, member in vars(part).items():
            if name in known and name not in found:
                effect: Effect | None = declared(member) or part.common_effect
                if effect is None:
                    raise TypeError(f"{part.__name__}.{name} declares no effect")
                found[name] = effect
    return MappingProxyType(found)


@cache
def constants(space: str) -> Mapping[str, Constant]:
    """Return the constants of the parts, and for ``sim`` also those of the remote API."""
    found: dict[str, Constant] = dict(api.known_constants()) if space == "sim" else {}
    for part in reversed(api.NAMESPACES[space].__mro__):
        found.update(vars(part).get("CONSTANTS", {}))
    return MappingProxyType(found)


_OLD_PLUGIN = re.compile(r"ext([A-Z][A-Za-z0-9]*)_\w")
"""Start of V-REP 3's name of a plug-in's function: ``simExtOctomap_prune`` is ``sim.extOctomap_prune`` here."""


DONE, FAILED = 1, -1
"""Codes of V-REP's functions."""

_SETTER = re.compile(r"\w+\.(?:set|reset|handle|remove|add)")


class Namespaces:
    """The namespaces of one script."""

    def __init__(self, world: World, script: Script) -> None:
        self._script = script
        self._say_once = world.scripts.told_once.tell
        self._spaces = {space: kind(world, script) for space, kind in api.NAMESPACES.items()}
        self._functions: dict[str, Call] = {}
        """Functions that were called, by full name."""

    def space(self, name: str) -> Any:
        """Return the object with the functions of a namespace."""
        return self._spaces[name]

    @staticmethod
    @cache
    def names() -> Mapping[str, Mapping[str, Constant | None]]:
        """Return for each namespace its constants, and every function's name with None; always the same object."""
        return {space: {**constants(space), **dict.fromkeys(signatures(space))} for space in api.NAMESPACES}

    @staticmethod
    @cache
    def without_edits() -> frozenset[str]:
        """Return the full names of the functions that never edit the scene: they only read, or declare it."""
        return frozenset(
            f"{space}.{name}"
            for space in api.NAMESPACES
            for name, effect in effects(space).items()
            if effect == "reads" or declares_no_edit(getattr(api.NAMESPACES[space], name))
        )

    def invoke(self, full_name: str, values: Sequence[Any]) -> tuple[Any, ...] | Waiting:
        """Call a function with a script's plain values; return its results as a tuple, or a generator that returns
        them.

        Raises:
            CommandError: the function does not exist, arguments have the wrong type, or the function fails.
        """
        return self.function(full_name)(values)

    def function(self, full_name: str) -> Call:
        """Return a function for many calls with plain values; each is an `invoke` with this name."""
        known = self._functions.get(full_name)
        if known is not None:
            return known
        space, _, name = full_name.partition(".")
        signature = signatures(space).get(name)
        if signature is None:
            return lambda values: self._without(space, name, values)
        known = self._functions[full_name] = self._made(
            full_name, getattr(self._spaces[space], name), signature
        )
        return known

    def _made(self, full_name: str, function: Callable[..., Any], signature: Signature) -> Call:
        bind = signature.bind

        def called(values: Sequence[Any]) -> tuple[Any, ...] | Waiting:
            try:
                result = function(*bind(values))
            except CommandError as problem:
                if self._stops_at(problem):
                    raise  # here: a frame that holds its exception waits for the garbage collector
                return self._going_on(full_name, signature, problem)
            if result.__class__ is GeneratorType:
                return self._waiting(full_name, signature, result)
            return _as_tuple(result)

        return called

    def _waiting(self, full_name: str, signature: Signature, steps: Any) -> Waiting:
        taken: Generator[None, None, Any] = steps
        try:
            result = yield from taken
        except CommandError as problem:
            if self._stops_at(problem):
                raise  # here: a frame that holds its exception waits for the garbage collector
            return self._going_on(full_name, signature, problem)
        return _as_tuple(result)

    def _stops_at(self, problem: CommandError) -> bool:
        """Return whether a failure is an error in V-REP too, and errors stop the script."""
        return self._script.raises_errors and not isinstance(problem, Unsupported)

    def _going_on(self, full_name: str, signature: Signature, problem: CommandError) -> tuple[Any, ...]:
        """Return what a call gave in V-REP that has failed here, and tell of it once."""
        if isinstance(problem, Unsupported):
            answer: Any = problem.answer
            if answer is None and signature.gives_number:
                answer = DONE if _SETTER.match(full_name) else FAILED
            self._say_once(f"{full_name}: {problem}")
        else:
            answer = FAILED if signature.gives_number else None
            self._say_once(f"{full_name}: {problem}", about=f"{full_name} in script {self._script.handle}")
        return _as_tuple(answer)

    def _without(self, space: str, name: str, values: Sequence[Any]) -> tuple[Any, ...]:
        """Read a constant of a name that does not exist, which is nil in V-REP. Raises CommandError: a function."""
        if not values and _CONSTANT.fullmatch(name):
            self._say_once(f"{space}.{name} is no constant of V-REP: a script reads nil there")
            return (None,)
        if space == "sim" and (plugin := _missing_plugin(name)):
            raise CommandError(no_such_plugin(plugin, api.NAMESPACES))
        advice = did_you_mean(name, [*signatures(space), *constants(space)])
        raise CommandError(f"is not provided by this server{advice}")


def _missing_plugin(name: str) -> str:
    """Return the plug-in that an old name of a function belongs to, if the server does not have it; else ''."""
    found = _OLD_PLUGIN.match(name)
    if found is None or f"Ext{found[1]}_" in OLD_SPACES or f"sim{found[1]}" in api.NAMESPACES:
        return ""
    return f"sim{found[1]}"


def _as_tuple(result: Plain) -> tuple[Any, ...]:
    if isinstance(result, tuple):
        return result
    return () if result is None else (result,)
