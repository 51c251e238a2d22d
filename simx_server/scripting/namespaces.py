"""One script's view of the server: the objects behind ``sim``, ``simIK`` ... and the lookup of their methods."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from functools import cache
from inspect import isgenerator
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from simx_client.protocol.nearest import did_you_mean

from ..errors import CommandError
from . import api
from .interpreter import Constant, Plain, Waiting
from .signature import Signature

if TYPE_CHECKING:
    from simx_server.world.world import World

    from .script import Script


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
def constants(space: str) -> Mapping[str, Constant]:
    """Return the constants of the parts, and for ``sim`` also those of the remote API."""
    found: dict[str, Constant] = dict(api.known_constants()) if space == "sim" else {}
    for part in reversed(api.NAMESPACES[space].__mro__):
        found.update(vars(part).get("CONSTANTS", {}))
    return MappingProxyType(found)


class Namespaces:
    """The namespaces of one script."""

    def __init__(self, world: World, script: Script) -> None:
        self._spaces = {space: kind(world, script) for space, kind in api.NAMESPACES.items()}

    @staticmethod
    def names() -> Mapping[str, Mapping[str, Constant | None]]:
        """Return for each namespace its constants, and every function's name with None."""
        return {space: {**constants(space), **dict.fromkeys(signatures(space))} for space in api.NAMESPACES}

    def invoke(self, full_name: str, values: list[Any]) -> tuple[Any, ...] | Waiting:
        """Call a function with a script's plain values; return its results as a tuple, or a generator that returns
        them.

        Raises:
            CommandError: the function does not exist, arguments have the wrong type, or the function fails.
        """
        space, _, name = full_name.partition(".")
        known = signatures(space)
        signature = known.get(name)
        if signature is None:
            advice = did_you_mean(name, [*known, *constants(space)])
            raise CommandError(f"is not provided by this server{advice}")
        function: Callable[..., Any] = getattr(self._spaces[space], name)
        result = function(*signature.bind(values))
        return _waiting(result) if isgenerator(result) else _as_tuple(result)


def _waiting(steps: Any) -> Waiting:
    taken: Generator[None, None, Any] = steps
    result = yield from taken
    return _as_tuple(result)


def _as_tuple(result: Plain) -> tuple[Any, ...]:
    if result is None:
        return ()
    return result if isinstance(result, tuple) else (result,)
