"""Refuse calls that run code in the server, unless the operator allows them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import to_text
from simx_server.sim_api.namespaces import Namespaces

from .functions import Function

if TYPE_CHECKING:
    from simx_server.world.world import World

_NOT_ALLOWED = "the server runs no code of clients; start it with --allow-code if it shall"

_LUA = frozenset(
    (
        *(
            "_G",
            "assert",
            "collectgarbage",
            "coroutine",
            "debug",
            "dofile",
            "error",
            "getfenv",
            "getmetatable",
        ),
        *("io", "ipairs", "jit", "load", "loadfile", "loadstring", "math", "module", "next", "os", "package"),
        *(
            "pairs",
            "pcall",
            "print",
            "rawequal",
            "rawget",
            "rawlen",
            "rawset",
            "require",
            "select",
            "setfenv",
        ),
        *("setmetatable", "string", "table", "tonumber", "tostring", "type", "unpack", "utf8", "xpcall"),
    )
)
"""Lua's library: ``load`` makes a function of a text."""

_PYTHON = frozenset(("__import__", "builtins", "compile", "eval", "exec", "getattr", "open", "setattr"))


def require_code(world: World) -> None:
    """Refuse to run a text. Raises CommandError unless the operator allows code of clients."""
    if not world.scripts.allows_code:
        raise CommandError(_NOT_ALLOWED)


def check(world: World, function: Function, arguments: list[Any]) -> None:
    """Refuse a function of ``sim`` that a client may not call.

    Raises:
        CommandError: with the reason and what to do.
    """
    if function.effect == "needs a script":
        raise CommandError("works only in a script of the scene; a client calls its functions itself")
    if world.scripts.allows_code:
        return
    if function.effect == "runs code":
        require_code(world)
    if function.name == "callScriptFunction":
        for each in arguments[:2]:  # CoppeliaSim takes function and script in either order
            if isinstance(each, (bytes, str)):
                _check_function(to_text(each))  # the name as the function reads it


def _check_function(called: str) -> None:
    """Refuse functions that a script has from the server or its language, and that may run a text."""
    first = called.partition("@")[0].partition(".")[0].strip()
    is_of_server = first in Namespaces.names() or (first.startswith("sim") and first[3:4].isupper())
    if first in _LUA or first in _PYTHON or first.startswith("__") or is_of_server:
        raise CommandError(f"'{called[:80]}' is no function of the script's own, and {_NOT_ALLOWED}")
