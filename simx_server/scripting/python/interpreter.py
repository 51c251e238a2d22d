"""One Python script, in a separate process as in CoppeliaSim; see `interpreter.Interpreter`.

A script can use ``sim`` and the other namespaces (also by ``import sim`` and ``require('sim')``), ``self`` to store
values, modules beside the scene, Python's library and the installed packages. Its global functions ``sysCall_init``
and so on are the call-backs. The flat old names are not available: they are older than scripts in Python.

Several results of a function of the server are a tuple, one is the value itself, none is None. Strings: every ``str``
becomes bytes on the way to the server; on the way back text (UTF-8 without control characters) becomes ``str`` and
other strings ``bytes``, but results of functions that pack, and of those that return images, buffers or data blocks,
are always ``bytes``. CoppeliaSim's choice between the two depends on the data as well. Lists, dicts and numbers keep
their types; arrays of numpy become lists.

`python_launcher.py` limits the rights of a script, `process.py` its time. A script that was killed has ended: each
later call returns the reason. A script stays usable after an error inside it.
"""

from __future__ import annotations

import logging
import re
import textwrap
import time
from collections.abc import Generator, Iterable
from pathlib import Path
from typing import Any

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import (
    NOT_IN_A_THREAD,
    TIME_LIMIT,
    Api,
    Plain,
    ScriptError,
    Waiting,
    refusal,
)
from simx_server.scripting.modules.absent import no_such_plugin

from ..conversion.strings import GIVES_BYTES, LONG_LIST, NUMBERS, with_texts
from .process import PythonProcess
from .python_wire import MAX_DEPTH, MAX_NUMBERS, MAX_TEXT, Packer, Unpacker, WireError

logger = logging.getLogger(__name__)

_PLUGIN = re.compile(r": (?:NameError: name|ModuleNotFoundError: No module named) '(sim[A-Z]\w*)'[^\n]*$")

_LONGEST_TEXT = 1 << 16
"""Maximum characters of one printed line, and of an error."""

_LONGEST_NAME = 200
"""Maximum characters of a function's name; a search for similar names would take long with a longer one."""

_MOST_TURNS = 1 << 20

_WALLS = ("landlock", "seccomp")


class PythonFunction:
    """A function that a script passed to the server; see `interpreter.Function`."""

    def __init__(self, interpreter: PythonInterpreter, number: int) -> None:
        self.interpreter = interpreter
        self.number = number

    def __call__(self, *arguments: Any) -> list[Any]:
        return self.interpreter.apply(self, arguments)


_CALL_TIME = 40e-6
"""Seconds that a call of the API counts as towards `Switching.seconds`; it takes 20 to 40 microseconds."""


_TURN_TIME = 0.5e-6
"""Seconds that an iteration of a loop counts as towards `Switching.seconds`; a short one takes a quarter of that."""


class PythonInterpreter:
    """The parent's side of one running script."""

    def __init__(
        self,
        name: str,
        api: Api,
        *,
        time_limit: float = TIME_LIMIT,
        folder: Path | None = None,
        needs_seccomp: bool = True,
    ) -> None:
        """Start the script's process, which initializes while the server continues.

        Args:
            folder: the scene's folder, whose files the script may read; None: none.
            needs_seccomp: the script does not run where the kernel cannot restrict its system calls.
        """
        self.name = name
        self.lacking: frozenset[str] = frozenset()
        self._api = api
        self._names: set[str] = set()
        self._depth = 0
        self._in_thread = False
        self._thread = ""
        """The thread's function until it has started."""
        self._held: list[Any] | Waiting | None = None
        """Answer for the waiting thread: its results, or a generator that is not complete."""
        self._held_call = ""
        self._turns = 0
        """Iterations of the thread's loops, since its resumption."""
        self._is_warned = False
        self._process = PythonProcess(
            name,
            Packer(self._number_of),
            Unpacker(self._function_of, MAX_TEXT, MAX_NUMBERS),
            api.serve_others,
            lambda: api.is_ending,
            time_limit,
            folder,
            needs_seccomp=needs_seccomp,
        )
        self._process.begin()
        known = {space: dict(names) for space, names in api.namespaces().items()}
        self._process.send("hello", name, known, None if folder is None else str(folder))

    def close(self) -> None:
        """End the script's process."""
        self._process.ended = self._process.ended or f"{self.name}: the script has ended"
        self._forget_thread()
        self._process.close()

    def run(self, source: bytes) -> None:
        """Execute the script's text; common indentation, as in a scene's file, is removed."""
        first = next((line for line in source.splitlines() if line.strip()), b"")
        if first[:1].isspace():
            source = textwrap.dedent(source.decode("utf-8", "surrogateescape")).encode(
                "utf-8", "surrogateescape"
            )
        self._ask("run", source)

    def has(self, function: str) -> bool:
        """Return whether a function of this name exists; dots select members of objects, modules and dicts.

        Functions that existed when the process ended still count: their next call returns the reason of the end.
        """
        if self._process.ended or ("." not in function and not self._depth):
            return function in self._names
        return self._ask("has", function) == [True]

    def call(self, function: str, *arguments: Any) -> list[Any]:
        """Call a function with plain values and return its results.

        Raises:
            ScriptError: the script failed.
        """
        return self._ask("call", function, [with_texts(value) for value in arguments])

    def attempt(self, function: str, *arguments: Any) -> list[Any] | None:
        """Call a function as `call` does if it exists; return None if not. Its name has no dots."""
        return self.call(function, *arguments) if self.has(function) else None

    def evaluate(self, source: bytes) -> list[Any]:
        """Execute a piece of Python among the script's globals; return the value of one that is an expression."""
        return self._ask("evaluate", source)

    def apply(self, function: PythonFunction, arguments: tuple[Any, ...]) -> list[Any]:
        """Call a function that the script passed to the server."""
        return self._ask("call_number", function.number, [with_texts(value) for value in arguments])

    def start_thread(self, function: str) -> None:
        """Make a function the script's thread; an earlier thread ends with an exception at the point where it waits."""
        if not self.has(function):
            raise ScriptError(f"{self.name}: has no function '{function}'")
        if self._held is not None:
            self._forget_thread()
            self._ask("abandon")
        self._thread = function

    def resume(self) -> bool:
        """Run the thread until it waits; return True while it is running."""
        if self._depth:
            raise ScriptError(f"{self.name}: its thread cannot go on while another function of it runs")
        self._turns = 0
        if self._thread:
            function, self._thread = self._thread, ""
            self._ask("thread", function, in_thread=True)
        elif self._held is not None:
            held, self._held = self._held, None
            answer = self._advance(self._held_call, held) if isinstance(held, Generator) else held
            if answer is not None:
                self._ask(*answer, in_thread=True)
        return self._held is not None

    def _forget_thread(self) -> None:
        held, self._held, self._thread = self._held, None, ""
        if isinstance(held, Generator):
            held.close()

    def _ask(self, *message: Any, in_thread: bool = False) -> list[Any]:
        """Send a request and serve the script until it is done, or until its thread waits."""
        if self._process.ended:
            raise ScriptError(self._process.ended)
        if not self._depth:
            self._process.begin()
            self._api.switching.called = self._api.switching.edited = 0.0
        outer, self._in_thread = self._in_thread, in_thread
        self._depth += 1
        try:
            self._process.send(*message)
            return self._serve()
        except WireError as problem:
            raise self._process.kill(f"{self.name}: its process sent {problem}") from problem
        except (TypeError, ValueError) as problem:
            raise ScriptError(f"{self.name}: {problem}") from problem
        finally:
            self._depth -= 1
            self._in_thread = outer
            if not self._depth:
                self._process.finish()

    def _serve(self) -> list[Any]:
        kind: Plain
        rest: list[Plain]
        while True:
            kind, *rest = self._process.receive()
            match kind, rest:
                case "invoke", [str(name), list(arguments)]:
                    if not self._serve_call(name[:_LONGEST_NAME], arguments):
                        return []
                case "turns", [int(turns)] if 0 < turns <= _MOST_TURNS:
                    self._turns += turns
                    if self._in_thread and self._api.switching.is_tired(self._turns * _TURN_TIME):
                        self._held = ["ok", []]
                        return []
                    self._process.send("ok", [])
                case "ready", [list(told)]:
                    self._process.started()
                    self._warn_of_missing([wall for wall in _WALLS if wall in told])
                case "print", [str(text)]:
                    self._api.output(_clean(text))
                case "module", [str(name)]:
                    self._process.send(*self._module(name))
                case "done", [list(results), names]:
                    self._learn(names)
                    return _from_script(results)
                case "failed", [str(text), names]:
                    self._learn(names)
                    raise ScriptError(self._explain(_clean(text)))
                case _:
                    raise self._process.kill(f"{self.name}: its process sent an unknown message")

    def _serve_call(self, name: str, arguments: list[Any]) -> bool:
        """Answer a call of the API; return False when the thread must wait for the answer."""
        _from_script(arguments)
        self._process.serve_when_due()
        answer = self._invoke(name, arguments)
        if answer is None:
            return False
        self._process.serve_when_due()
        try:
            self._process.send(*answer)
        except (TypeError, ValueError) as problem:  # the result cannot be sent
            self._process.send("refused", f"{name}: {problem}")
        return True

    def _warn_of_missing(self, walls: list[str]) -> None:
        """Log once which protection of the kernel is missing."""
        if walls and not self._is_warned:
            self._is_warned = True
            logger.warning(
                "%s runs without the kernel's %s, which its author can make use of: run only scripts whose author "
                "you trust",
                self.name,
                " and ".join(walls),
            )

    def _explain(self, text: str) -> str:
        plugin = _PLUGIN.search(text)
        return f"{text}: {no_such_plugin(plugin[1], self._api.namespaces())}" if plugin else text

    def _learn(self, names: Plain) -> None:
        if isinstance(names, list):
            self._names = {name for name in names if isinstance(name, str)}

    def _invoke(self, name: str, arguments: list[Any]) -> list[Any] | None:
        """Return the answer to a call of the API; None when the thread must wait for it."""
        began, spent = time.monotonic(), self._api.switching.spent
        try:
            try:
                results = self._api.invoke(name, arguments)
            finally:
                if self._api.switching.spent > spent:
                    self._process.grant(time.monotonic() - began)
            if isinstance(results, Generator):
                if not self._in_thread:
                    raise CommandError(NOT_IN_A_THREAD)
                return self._advance(name, results)
            answer = [
                "ok",
                [with_texts(value, as_bytes=bool(GIVES_BYTES.search(name))) for value in results],
            ]
        except Exception as problem:
            return self._refusal(name, problem)
        if self._in_thread and self._api.switching.gives_way(_CALL_TIME):
            self._held = answer
            return None
        return answer

    def _advance(self, name: str, waiting: Waiting) -> list[Any] | None:
        try:
            next(waiting)
        except StopIteration as end:
            return ["ok", [with_texts(value) for value in end.value or ()]]
        except Exception as problem:
            return self._refusal(name, problem)
        self._held, self._held_call = waiting, name
        return None

    def _refusal(self, name: str, problem: Exception) -> list[Any]:
        if isinstance(problem, CommandError):
            return ["refused", refusal(name, problem)]
        logger.error("%s failed inside script %s", name, self.name, exc_info=problem)
        return ["refused", f"{name}: failed inside the server; its log says why"]

    def _module(self, name: str) -> list[Any]:
        try:
            return ["ok", [self._api.module(name)]]
        except (CommandError, ValueError) as problem:  # a name that no file can have
            return ["refused", f"import {name}: {problem}"]

    def _number_of(self, value: Any) -> int:
        if isinstance(value, PythonFunction):
            if value.interpreter is self:
                return value.number
            raise TypeError("a function of one script cannot be given to another")
        raise TypeError(f"a {type(value).__name__} cannot enter a script in Python")

    def _function_of(self, number: Any) -> PythonFunction:
        if not isinstance(number, int):
            raise TypeError
        return PythonFunction(self, number)


def _from_script(value: Plain, depth: int = MAX_DEPTH + 2) -> Any:
    """Convert every string to bytes, in place.

    Raises:
        WireError: the nesting is deeper than a correct side sends.
    """
    if type(value) is str:
        return _encoded(value)
    if type(value) is list:
        if len(value) > LONG_LIST and set(map(type, value)) <= NUMBERS:
            return value
        places: Iterable[tuple[Any, Any]] = enumerate(value)
    elif type(value) is dict:
        places = value.items()
    else:
        return value
    if depth == 0:
        raise WireError("a list that is nested too deeply")
    for place, item in places:
        if type(item) is str or (type(item) in (list, dict) and item):
            value[place] = _from_script(item, depth - 1)
    return value


def _clean(text: str) -> str:
    """Return text that a log can hold, whatever the process sent."""
    return text[:_LONGEST_TEXT].encode("utf-8", "replace").decode()


def _encoded(text: str) -> bytes:
    try:
        return text.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:  # another lone surrogate, which valid text does not contain
        return text.encode("utf-8", "replace")
