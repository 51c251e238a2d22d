"""The start of every Lua state of this process, compiled once: the chunks of the sandbox and the names of the API.

Compiling takes 0.9 ms, and a state is made for each script at each start of the simulation. Loading the compiled form
of the sandbox takes 0.2 ms; that of the names 0.7 ms, which only scripts that list a namespace need. Only texts of
this package are compiled here; a script's own chunks are accepted as text alone.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, cast

from simx_client.protocol.cli.installing import package_line
from simx_server.scripting.interpreter import Constant, ScriptError

_CHUNKS = {file.stem: file.read_bytes() for file in Path(__file__).parent.rglob("*.lua")}
"""The Lua files in this folder and below: ``sandbox`` is called first, and calls the others."""


def load_lupa() -> Any:
    """Return the lupa module for Lua 5.4.

    Raises:
        ScriptError: it is not installed; the text contains the command that installs it.
    """
    try:
        return importlib.import_module("lupa.lua54")
    except ImportError as problem:
        raise ScriptError(
            f"Lua scripts need the package lupa, which is not installed: {package_line('lupa')}"
        ) from problem


def new_runtime(memory_limit: int = 0) -> Any:
    """Return a new Lua state from which no object of Python can be reached.

    Args:
        memory_limit: bytes that it may allocate; 0: no limit.
    """
    return load_lupa().LuaRuntime(
        encoding=None,
        unpack_returned_tuples=True,
        register_eval=False,
        register_builtins=False,
        attribute_filter=_deny,
        max_memory=memory_limit,
    )


@cache
def chunks() -> Mapping[bytes, bytes]:
    """Return the compiled Lua files by name."""
    return {name.encode(): _compiled(text, b"=sandbox") for name, text in _CHUNKS.items()}


def names(known: Mapping[str, Mapping[str, Constant | None]]) -> bytes:
    """Return a compiled chunk that returns a table of all namespaces, with their constants and functions.

    Its argument is a function that returns the function of a full name, such as ``sim.getObject``.

    Args:
        known: always the same object, for which the chunk is made once.
    """
    return _names(_Same(known))


class _Same:
    """A mapping as a key of a cache: equal only to itself."""

    def __init__(self, names: Mapping[str, Mapping[str, Constant | None]]) -> None:
        self.names = names

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.names is other.names

    def __hash__(self) -> int:
        return id(self.names)


@lru_cache(maxsize=2)
def _names(known: _Same) -> bytes:
    spaces = [
        b"[%b]={%b}"
        % (_literal(space), b",".join(_member(space, name, value) for name, value in members.items()))
        for space, members in known.names.items()
    ]
    return _compiled(b"local bind = ...\nreturn {" + b",\n".join(spaces) + b"}", b"=sandbox")


def _member(space: str, name: str, value: Constant | None) -> bytes:
    bound = b"bind(%b)" % _literal(f"{space}.{name}") if value is None else _literal(value)
    return b"[%b]=%b" % (_literal(name), bound)


def _compiled(text: bytes, name: bytes) -> bytes:
    functions = new_runtime().globals()
    chunk = functions[b"load"](text, name, b"t")
    return functions[b"string"][b"dump"](chunk)


def _literal(value: Any) -> bytes:
    """Return a constant as Lua's source."""
    if isinstance(value, Mapping):
        items = cast("Mapping[Any, Any]", value).items()
        return b"{" + b",".join(b"[%b]=%b" % (_literal(key), _literal(item)) for key, item in items) + b"}"
    if isinstance(value, bool):
        return b"true" if value else b"false"
    if isinstance(value, int):
        return b"%d" % value
    if isinstance(value, float):
        return value.hex().encode() if math.isfinite(value) else b"(%d/0)" % math.copysign(1, value)
    text = cast("str | bytes", value)
    return b'"%b"' % b"".join(b"\\%03d" % byte for byte in (text.encode() if isinstance(text, str) else text))


def _deny(_object: object, name: Any, _is_setting: bool) -> Any:
    text = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
    raise AttributeError(f"scripts cannot reach {text}")
