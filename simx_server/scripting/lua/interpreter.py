"""One Lua 5.4 interpreter for one script: a sandbox with a time limit and a memory limit.

It is independent of the simulation. `crossing/` has the values that a script receives and returns.
"""

from __future__ import annotations

import itertools
import logging
import re
import time
from collections.abc import Callable, Sequence
from typing import Any, Final

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import (
    ENDING_LIMIT,
    MAX_DEPTH,
    MEMORY_LIMIT,
    NOT_IN_A_THREAD,
    OLD_SPACES,
    PHASES,
    TIME_LIMIT,
    TIMEOUT,
    Api,
    ScriptError,
    Waiting,
    no_such_module,
    refusal,
)
from simx_server.scripting.modules import own_modules
from simx_server.scripting.modules.absent import no_such_plugin

from .crossing.flat import flat
from .crossing.values import LuaFunction, Values
from .prepared import chunks, load_lupa, names, new_runtime
from .sources import too_much
from .turns import may_make_coroutines, with_turns

logger = logging.getLogger(__name__)

_PLUGIN = re.compile(r"attempt to index a nil value \(global '(sim[A-Z]\w*)'\)$")
_OLD_NAME = re.compile(r"attempt to call a nil value \(global 'sim([A-Z])(\w*)'\)")


_FAILED = (False, b"failed inside the server; its log says why")
"""Result that a script gets for an internal error of the server."""

_PHASES: Final = {name: name.encode() for name in PHASES}

_LONGEST_LINE = 100_000
"""Maximum bytes of a printed line, and of an error's text."""

_CALL_TIME = 10e-6
"""Seconds that a call of the API counts as towards `Switching.seconds`; it takes 6 to 10 microseconds."""


_TURN_TIME = 0.2e-6
"""Seconds that an iteration of a loop counts as towards `Switching.seconds`; a short one takes half of that."""


class LuaInterpreter:
    """The state of one running script; see `interpreter.Interpreter`."""

    def __init__(self, name: str, api: Api, *, time_limit: float = TIME_LIMIT) -> None:
        self.name = name
        self._api = api
        self._time_limit = time_limit
        self._depth = 0
        self._has_ended = False
        self._deadline: float | None = None
        """When the thread's processor time ends the call; set at the first check, as the two below, since reading
        clocks takes as long as a short call.
        """
        self._serve_next = 0.0
        self._end_by = 0.0
        self._waiting: dict[int, Waiting] = {}
        self._spaces = {space.encode(): members for space, members in api.namespaces().items()}
        self._has_coroutines = False
        """Whether the script may run as a coroutine, so that its loops are counted."""

        self.lacking: frozenset[str] = frozenset()
        self._tokens = itertools.count(1)
        lupa = load_lupa()
        self._memory_error: type[Exception] = lupa.LuaMemoryError
        self._raised: BaseException | None = None
        self._face: Any
        runtime: Any = new_runtime(MEMORY_LIMIT)
        self._values = Values(self, runtime, lupa.lua_type, self._breathe)
        known, compiled = runtime.globals(), chunks()
        collect = known[b"collectgarbage"]
        collect(b"stop")  # of what follows nothing is garbage
        guard = known[b"load"](compiled[b"sandbox"], b"=sandbox", b"b")
        face = guard(
            self._sealed(self._late, True),
            self._sealed(self._function, None),
            self._proceed,
            self._sealed(self._print, None),
            self._sealed(self._module, _FAILED),
            self._sealed(self._counted, None),
            self._sealed(self._is_tired, False),
            self._sealed(_refuse, b"failed inside the server; its log says why"),
            self._values.to_lua(PHASES),
            self._sealed(self._note_lacking, None),
            MAX_DEPTH,
            self._values.to_lua(list(api.namespaces())),
            self._sealed(self._member, (False, None)),
            self._sealed(lambda: names(api.namespaces()), b""),
            self._values.to_lua(dict(OLD_SPACES)),
            runtime.table_from(compiled),
            self._sealed(self._values.given_list, None),
            self._sealed(api.count_calls, None),
        )
        collect(b"restart")
        collect(b"step", -int(collect(b"count")))  # the next collection comes when that has doubled
        # As functions, not the table that holds them: lupa cannot index a table while a coroutine runs.
        self._face = dict(face.items())

    def close(self) -> None:
        """Free the Lua state; if the script is running, at the end of that call.

        The state and this object refer to each other in a way that Python's collector cannot detect.
        """
        self._has_ended = True
        if not self._depth:
            self._face = None
            self._values.close()
            self._waiting.clear()

    def run(self, source: bytes) -> None:
        """Execute the script's text, which defines its functions.

        Raises:
            ScriptError: the script failed.
        """
        self._enter(b"run", source, b"@" + self.name.encode())

    def has(self, function: str) -> bool:
        """Return whether a function of this name exists; dots select members of tables."""
        return not self._has_ended and bool(self._face[b"has"](function.encode()))

    def call(self, function: str, *arguments: Any) -> list[Any]:
        """Call a function with plain values and return all its results as plain values.

        Raises:
            ScriptError: the script failed.
        """
        return self._enter(b"call", function.encode(), *map(self._values.to_lua, arguments))

    def attempt(self, function: str, *arguments: Any) -> list[Any] | None:
        """Call a function as `call` does if it exists; return None if not. Its name has no dots."""
        if function in self.lacking and not self._depth:
            return None
        name = _PHASES.get(function) or function.encode()
        return self._enter(b"attempt", name, *map(self._values.to_lua, arguments))

    def evaluate(self, source: bytes) -> list[Any]:
        """Execute a piece of Lua among the script's globals, and return its results."""
        return self._enter(b"evaluate", source)

    def apply(self, function: LuaFunction, arguments: tuple[Any, ...]) -> list[Any]:
        """Call a function that the script passed to the server."""
        return self._enter(b"apply", function.function, *map(self._values.to_lua, arguments))

    def start_text(self, source: bytes, functions: Sequence[str]) -> None:
        """Make the script's text the script's thread, and then the first of these functions that it has defined.

        Raises:
            ScriptError: it is not Lua.
        """
        self._has_coroutines = True
        self._enter(b"start_text", source, b"@" + self.name.encode(), " ".join(functions).encode())

    def start_thread(self, function: str) -> None:
        """Make a function the script's thread."""
        self._enter(b"start_thread", function.encode())

    def resume(self) -> bool:
        """Run the thread until it waits; return True while it is running."""
        return bool(self._enter(b"resume")[0])

    def _enter(self, action: bytes, *arguments: Any) -> Any:
        """Call a function of `sandbox.lua`; return its results after the status, or None if its only one is nil."""
        if self._has_ended:
            raise ScriptError(f"{self.name}: the script has ended")
        switching, outer = self._api.switching, self._deadline
        if not self._depth:
            self._deadline = None
            switching.spent = switching.edited = switching.called = 0.0
        elif switching.is_free:
            self._deadline = None
        self._depth += 1
        try:
            answer: tuple[Any, ...] | bool | None = self._face[action](*arguments)
        except self._memory_error:
            raise ScriptError(f"{self.name}: used more than {MEMORY_LIMIT >> 20} MiB of memory") from None
        finally:
            self._depth -= 1
            if self._depth and switching.is_free:
                self._deadline = outer
            if self._has_ended:
                self.close()
            if self._raised and not self._depth:
                raised, self._raised = self._raised, None
                raise raised
        if answer is True:
            return []
        if answer is None:
            return None
        ok, *results = answer if isinstance(answer, tuple) else (answer,)
        if ok is not True:
            raise ScriptError(self._explain(_shown(results[0])))
        return [self._values.from_lua(value) for value in results]

    def _sealed(self, action: Callable[..., Any], failed: Any) -> Callable[..., Any]:
        """Return a function for Lua that never raises, because lupa passes exceptions to scripts.

        Args:
            action: the function of Python.
            failed: the result if it raises.
        """

        def call(*arguments: Any) -> Any:
            try:
                return action(*arguments)
            except Exception:
                logger.exception("a call of script %s failed inside the server", self.name)
            except BaseException as interruption:  # it is raised again when the script has returned
                self._raised = interruption
            return failed

        return call

    def _late(self) -> bool:
        """Check the clock for Lua's hook; the server answers other clients meanwhile, without cost to the script."""
        if self._raised:
            return True
        if self._deadline is None:
            self._deadline = time.thread_time() + self._time_limit - self._api.switching.spent
            now = time.monotonic()
            self._serve_next, self._end_by = now + TIMEOUT, now + ENDING_LIMIT
        if time.monotonic() > self._serve_next:
            before = time.thread_time()
            self._api.serve_others()
            self._deadline += time.thread_time() - before
            self._serve_next = time.monotonic() + TIMEOUT
            if self._api.is_ending and time.monotonic() > self._end_by:
                return True
        return time.thread_time() > self._deadline + self._api.switching.spent

    def _counted(self, source: bytes) -> bytes | None:
        """Return a chunk with counted loops; None without loops, or for a script that makes no coroutines.

        A loop of a few instructions takes three times as long with its counter.
        """
        self._has_coroutines = self._has_coroutines or may_make_coroutines(source)
        return with_turns(source) if self._has_coroutines else None

    def _note_lacking(self, bits: int) -> None:
        self.lacking = frozenset(name for place, name in enumerate(PHASES) if bits >> place & 1)
        self._api.phases_changed()

    def _member(self, space: bytes, name: bytes) -> tuple[bool, Any]:
        """Return whether a name of a namespace is a function, and the value of a constant."""
        members, member = self._spaces[space], _text(name)
        value = members.get(member)
        return value is None and member in members, self._values.to_lua(value)

    def _is_tired(self, turns: int) -> bool:
        return self._api.switching.is_tired(turns * _TURN_TIME)

    def _print(self, text: bytes) -> None:
        self._api.output(_shown(text))

    def _module(self, name: bytes) -> tuple[Any, ...]:
        try:
            source = self._api.module(_text(name))
        except CommandError as problem:
            return False, f"require '{_text(name)}': {problem}".encode("utf-8", "replace")
        except ValueError:  # no file can have this name
            source = None
        if source is None:
            missing = no_such_module(_text(name), own_modules("lua"), self._api)
            return False, f"require '{_text(name)}': {missing}".encode("utf-8", "replace")
        return True, source

    def _function(self, name: bytes) -> Callable[..., tuple[Any, ...]]:
        """Return a function of the API as Lua calls it, with the level of the coroutine (see `sandbox.lua`), the kinds
        of the arguments (see `_given`; None: all are values of `_SIMPLE`) and the arguments.

        Its results are ``(status, ...)`` as `sandbox.lua` defines it. It never raises an exception: Lua's ``pcall``
        would pass it to the script as an object, and the log would not show it.
        """
        full_name = _text(name)
        run, given, to_lua, switching = (
            self._api.function(full_name),
            self._values.given,
            self._values.to_lua,
            self._api.switching,
        )

        def called(level: int, kinds: bytes | None, *values: Any) -> tuple[Any, ...]:
            try:
                results = run(values if kinds is None else given(kinds, values))
                if not isinstance(results, tuple):
                    return self._started(level, results)
                if level and switching.gives_way(_CALL_TIME) and level == 1:
                    return b"switch", *map(to_lua, results)
                return flat(results, to_lua)
            except BaseException as problem:
                return self._refusal(full_name, problem)

        return called

    def _started(self, level: int, waiting: Waiting) -> tuple[Any, ...]:
        """Advance a function that waits for the first time."""
        if not level:
            raise CommandError(NOT_IN_A_THREAD)
        token = next(self._tokens)
        self._waiting[token] = waiting
        return self._advance(token)

    def _proceed(self, token: int) -> tuple[Any, ...]:
        try:
            return self._advance(token)
        except BaseException as problem:
            return self._refusal("sim", problem)

    def _advance(self, token: int) -> tuple[Any, ...]:
        try:
            next(self._waiting[token])
        except StopIteration as end:
            del self._waiting[token]
            return (True, *map(self._values.to_lua, end.value or ()))
        except BaseException:
            del self._waiting[token]
            raise
        return b"wait", token

    def _refusal(self, function: str, problem: BaseException) -> tuple[Any, ...]:
        """Return the status and the text for a script whose call has failed."""
        if isinstance(problem, CommandError):
            return False, refusal(function, problem).encode("utf-8", "surrogateescape")
        if isinstance(problem, Exception):
            logger.error("%s failed inside script %s", function, self.name, exc_info=problem)
            return False, f"{function}: failed inside the server; its log says why".encode()
        self._raised = problem  # as in `_sealed`
        return _FAILED

    def _breathe(self) -> None:
        """Answer other clients, and end a call that takes too long."""
        if self._late():
            raise ScriptError(f"{self.name}: took too long and was stopped (a very large table?)")

    def _explain(self, problem: str) -> str:
        """Return the message with the file's name in front, as Lua does for most; add advice to unknown old names."""
        missing = _OLD_NAME.search(problem)
        if missing:
            try:
                self._api.invoke(f"sim.{missing[1].lower()}{missing[2]}", [])
            except CommandError as advice:
                problem = f"{problem[: missing.start()]}sim{missing[1]}{missing[2]}: {advice}"
        plugin = _PLUGIN.search(problem)
        if plugin:
            problem = f"{problem}: {no_such_plugin(plugin[1], self._api.namespaces())}"
        return problem if problem.startswith(f"{self.name}:") else f"{self.name}: {problem}"


def _refuse(source: bytes) -> bytes | None:
    reason = too_much(source)
    return None if reason is None else reason.encode()


def _shown(text: bytes) -> str:
    return _text(text if len(text) <= _LONGEST_LINE else text[:_LONGEST_LINE] + b"...")


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
