"""One Lua interpreter for one script: a sandbox with a time limit, a memory limit and a ``sim`` table.

Values cross as plain Python ones: ``None``, ``bool``, ``int``, ``float``, ``bytes`` (Lua strings are bytes)
and lists of them (tables, 1-based, up to the first gap). What a function of ``sim`` gets and gives is
said by ``Api``; this file knows no simulation.
"""

from __future__ import annotations

import importlib
import logging
import time
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from ..errors import CommandError
from .sandbox import GUARD, HOOK_INTERVAL

logger = logging.getLogger(__name__)

TIME_LIMIT = 2.0
"""Processor seconds that one call into a script may take; well below the 5 s a blocking client waits."""

MEMORY_LIMIT = 64 << 20
"""Bytes that one script may hold."""

INSTALL = "Lua scripts need the package lupa, which is not installed: pip install lupa"


class ScriptError(CommandError):
    """A script failed, or cannot be called: the text says which script, where and why."""


class Api(Protocol):
    """What a script finds under ``sim``."""

    def names(self) -> Mapping[str, int | float | None]:
        """Constants by name, and every function's name with None."""
        ...

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...]:
        """Call one function with plain values; raises CommandError with a text for the script's author."""
        ...

    def output(self, text: str) -> None:
        """What the script prints."""
        ...


def load_lupa() -> Any:
    """The lupa module for Lua 5.4; ScriptError with the install line when there is none."""
    try:
        return importlib.import_module("lupa.lua54")
    except ImportError as problem:
        raise ScriptError(INSTALL) from problem


class LuaInterpreter:
    """The state of one running script. Only the physics thread may use it."""

    def __init__(self, name: str, api: Api, *, time_limit: float = TIME_LIMIT) -> None:
        self.name = name
        self._api = api
        self._time_limit = time_limit
        self._deadline = 0.0
        lupa = load_lupa()
        self._lua_type = lupa.lua_type
        self._memory_error: type[Exception] = lupa.LuaMemoryError
        self._runtime = lupa.LuaRuntime(
            encoding=None,
            unpack_returned_tuples=True,
            register_eval=False,
            register_builtins=False,
            attribute_filter=_deny,
            max_memory=MEMORY_LIMIT,
        )
        known = {
            key.encode(): False if constant is None else constant for key, constant in api.names().items()
        }
        load = self._runtime.globals()[b"load"]
        guard = load(GUARD, b"=sandbox", b"t")
        self._run, self._call, self._has = guard(
            self._late, self._invoke, self._print, HOOK_INTERVAL, self._runtime.table_from(known)
        )

    def close(self) -> None:
        """Free the Lua state. It and this object hold each other in a way Python's collector cannot see."""
        del self._run, self._call, self._has, self._runtime

    def run(self, source: bytes) -> None:
        """Execute the script's text, which defines its functions. Raises ScriptError."""
        self._enter(self._run, source, b"@" + self.name.encode())

    def has(self, function: str) -> bool:
        """Whether a function of this name exists; dots reach into tables."""
        return bool(self._has(function.encode()))

    def call(self, function: str, *arguments: Any) -> list[Any]:
        """Call a function with plain values; all its results as plain values. Raises ScriptError."""
        return self._enter(self._call, function.encode(), *(self._to_lua(value) for value in arguments))

    def _enter(self, action: Callable[..., Any], *arguments: Any) -> list[Any]:
        self._deadline = time.thread_time() + self._time_limit
        try:
            answer = action(*arguments)
        except self._memory_error:
            raise ScriptError(f"{self.name}: used more than {MEMORY_LIMIT >> 20} MiB of memory") from None
        ok, *results = answer if isinstance(answer, tuple) else (answer,)
        if ok is not True:
            raise ScriptError(_located(self.name, _text(results[0])))
        return [self._from_lua(value) for value in results]

    def _late(self) -> bool:
        return time.thread_time() > self._deadline

    def _print(self, text: bytes) -> None:
        self._api.output(_text(text))

    def _invoke(self, name: bytes, *arguments: Any) -> tuple[Any, ...]:
        """Run one function of ``sim``: ``(True, results...)`` or ``(False, text)``, never an exception.

        Lua's ``pcall`` would hand an exception to the script as an object and lose it for the log.
        """
        function = _text(name)
        try:
            results = self._api.invoke(function, [self._from_lua(value) for value in arguments])
            return (True, *(self._to_lua(value) for value in results))
        except CommandError as problem:
            return False, f"sim.{function}: {problem}".encode()
        except Exception:
            logger.exception("sim.%s failed inside script %s", function, self.name)
            return False, f"sim.{function}: failed inside the server; its log says why".encode()

    def _to_lua(self, value: Any) -> Any:
        if isinstance(value, str):
            return value.encode("utf-8", "surrogateescape")
        if isinstance(value, (list, tuple)):
            return self._runtime.table_from([self._to_lua(item) for item in value])
        return value

    def _from_lua(self, value: Any) -> Any:
        kind = self._lua_type(value)
        if kind == "table":
            return [self._from_lua(value[i]) for i in range(1, len(value) + 1)]
        if kind is not None:
            raise ScriptError(f"{self.name}: a {kind} cannot leave the script")
        return value


def _deny(_object: object, name: Any, _is_setting: bool) -> Any:
    raise AttributeError(f"scripts cannot reach {_text(name)}")


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _located(name: str, problem: str) -> str:
    """Lua puts ``file:line:`` in front of most errors; the others get the file's name here."""
    return problem if problem.startswith(f"{name}:") else f"{name}: {problem}"
