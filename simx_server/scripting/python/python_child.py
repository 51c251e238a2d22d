"""The process of one Python script: standard library only, started by `process.py` with `python_launcher.py`.

It processes one message at a time. While the script waits for an answer of the server, further requests may arrive
and are processed on top of it (call-backs while ``sysCall_thread`` waits, a function of ``sim`` that calls the script
back); each completes before the one below it continues. So ``sysCall_thread`` needs no thread: its waiting call is
answered late.
"""

from __future__ import annotations

import ast
import builtins
import faulthandler
import importlib.util
import os
import random
import signal
import sys
import types
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

import python_guard
import python_limits
import python_stubs
from python_link import Link, Output

TURNS = 1000
"""Iterations of the thread's loops after which the process requests from the server whether the thread switches."""

_TURN = "__simx_turn__"


class ApiError(RuntimeError):
    """A function of the server refused; the text names it."""


class Abandoned(BaseException):
    """The script's thread is replaced by another one: its present call ends here."""


class Namespace(types.ModuleType):
    """``sim`` and the other namespaces: constants as they are, functions that call the server; ``import sim`` also
    finds it.
    """

    def __init__(self, name: str, known: dict[str, Any], invoke: Callable[..., Any]) -> None:
        super().__init__(name, "Functions and constants of the simulation.")
        self._invoke = invoke
        for key, constant in known.items():
            if isinstance(constant, dict):
                constant = types.SimpleNamespace(**constant)
            setattr(self, key, self._function(key) if constant is None else constant)

    def _function(self, key: str) -> Callable[..., Any]:
        invoke, full = self._invoke, f"{self.__name__}.{key}"

        def function(*arguments: Any) -> Any:
            return invoke(full, arguments)

        function.__name__ = function.__qualname__ = key
        return function

    def __getattr__(self, key: str) -> NoReturn:
        if key.startswith("__"):
            raise AttributeError(key)
        try:
            self._invoke(f"{self.__name__}.{key}", ())
        except ApiError as problem:
            raise AttributeError(str(problem)) from None
        raise AttributeError(f"{self.__name__}.{key}: is not provided")


class Script:
    """The script's module, the requests for it, and modules that lie beside the scene.

    It finds and loads these modules. The classes of `importlib.abc` would give it nothing, and their import takes as
    long as all others.
    """

    def __init__(self, link: Link, name: str, namespaces: dict[str, dict[str, Any]]) -> None:
        self._link = link
        self._name = name
        self._files = {name}
        self._output = Output(link)
        self._told: set[str] = set()
        self._sources: dict[str, bytes] = {}
        self._is_in_thread = False
        self._turns_left = TURNS
        module = types.ModuleType("__main__")
        self._globals: dict[Any, Any] = module.__dict__  # a script may add keys other than names
        sys.modules["__main__"] = module
        sys.stdout = sys.stderr = self._output
        self._globals.update(__file__=name, self=types.SimpleNamespace())
        builtins.__dict__["require"] = self._require
        builtins.__dict__[_TURN] = self._turn
        for key, known in namespaces.items():
            sys.modules[key] = self._globals[key] = Namespace(key, known, self._invoke)
        sys.meta_path.append(self)

    def serve(self) -> list[Any]:
        """Process requests until the answer to the innermost open call arrives."""
        while True:
            message = self._link.receive()
            kind = message[0]
            if kind == "ok":
                return message[1]
            if kind == "refused":
                raise ApiError(message[1])
            if kind == "abandon":
                raise Abandoned
            self._obey(message)

    def _obey(self, message: list[Any]) -> None:
        kind, *arguments = message
        outer, self._is_in_thread = self._is_in_thread, kind == "thread"
        try:
            results = getattr(self, f"_do_{kind}")(*arguments)
            self._output.finish()
            self._link.send("done", results, self._new_names())
        except Abandoned:
            self._link.send("done", [], self._new_names())
        except BaseException as problem:
            text = self._describe(problem)
            del problem  # its frames may hold the objects that filled the memory
            self._told = set()  # the results that were not sent held the new names
            self._output.finish()
            self._link.send("failed", text, self._new_names())
        finally:
            self._is_in_thread = outer

    def _turn(self) -> None:
        """Count an iteration; called in each iteration of each loop of the script."""
        self._turns_left -= 1
        if self._turns_left <= 0:
            self._turns_left = TURNS
            if self._is_in_thread:
                self._link.send("turns", TURNS)
                self.serve()

    def _do_run(self, source: bytes) -> list[Any]:
        exec(_compile(source, self._name), self._globals)
        return []

    def _do_evaluate(self, source: bytes) -> list[Any]:
        text = source.decode()
        try:
            code = compile(text.strip(), self._name, "eval")
        except SyntaxError:
            exec(_compile(source, self._name), self._globals)
            return []
        return _results(eval(code, self._globals))

    def _do_thread(self, name: str) -> list[Any]:
        return self._do_call(name, [])

    def _do_has(self, name: str) -> list[Any]:
        return [callable(self._find(name))]

    def _do_call(self, name: str, arguments: list[Any]) -> list[Any]:
        function = self._find(name)
        if not callable(function):
            raise ApiError(f"has no function '{name}'")
        model = sys.modules.get("sim-2")
        if model is not None and name.startswith("sysCall_"):
            arguments = model._arguments(arguments)
        return _results(function(*arguments))

    def _do_call_number(self, number: int, arguments: list[Any]) -> list[Any]:
        return _results(self._link.function(number)(*arguments))

    def _require(self, name: str) -> Any:
        """Return a module as ``import`` does; a version, as in ``require('sim-2')``, is left out for a namespace."""
        plain, sign, version = name.rpartition("-")
        is_api_2 = name in ("sim-2", "simIK-2")
        known = sys.modules.get(plain) if sign and version.isdigit() and not is_api_2 else None
        return known if isinstance(known, Namespace) else importlib.import_module(name)

    def _find(self, name: str) -> Any:
        first, *rest = name.split(".")
        # A table of the script's: a dict, or a namespace, which stands for all that has attributes.
        value: dict[Any, Any] | types.SimpleNamespace | None = self._globals.get(first)
        for part in rest:
            value = value.get(part) if isinstance(value, dict) else getattr(value, part, None)
        return value

    def _new_names(self) -> list[str] | None:
        """Return the names of all functions if they have changed; a request for each would cost a round trip."""
        names = {key for key, value in self._globals.items() if callable(value) and isinstance(key, str)}
        if names == self._told:
            return None
        self._told = names
        return sorted(names)

    def _invoke(self, name: str, arguments: Sequence[Any]) -> Any:
        try:
            self._link.send("invoke", name, arguments)
        except (TypeError, ValueError) as problem:
            raise ApiError(f"{name}: {problem}") from None
        results = self.serve()
        if len(results) == 1:
            return results[0]
        return tuple(results) if results else None

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        if path is None and fullname not in self._sources:
            self._link.send("module", fullname)
            (source,) = self.serve()
            if source is None:
                return None
            self._sources[fullname] = source
        loader: Any = self  # without `load_module`, which Python no longer calls
        return importlib.util.spec_from_loader(fullname, loader) if fullname in self._sources else None

    def create_module(self, spec: Any) -> None:
        """Have Python make the module."""

    def exec_module(self, module: types.ModuleType) -> None:
        exec(self.get_code(module.__name__), module.__dict__)

    def get_source(self, fullname: str) -> str:
        return importlib.util.decode_source(self._sources[fullname])

    def get_code(self, fullname: str) -> types.CodeType:
        file = f"{fullname}.py"
        self._files.add(file)
        return _compile(self._sources[fullname], file)

    def _describe(self, problem: BaseException) -> str:
        """Return ``file:line: reason``; the line is the innermost one of the script."""
        if isinstance(problem, SyntaxError) and problem.filename in self._files:
            return f"{problem.filename}:{problem.lineno}: {problem.msg}"
        place, trace = self._name, problem.__traceback__
        while trace:
            if trace.tb_frame.f_code.co_filename in self._files:
                place = f"{trace.tb_frame.f_code.co_filename}:{trace.tb_lineno}"
            trace = trace.tb_next
        if isinstance(problem, MemoryError):
            return f"{place}: used more than {python_limits.MEMORY_LIMIT >> 20} MiB of memory"
        if isinstance(problem, ApiError):
            return f"{place}: {problem}"
        if isinstance(problem, SystemExit):
            return f"{place}: a script cannot end the program (sys.exit)"
        try:
            text = str(problem)
        except Exception:  # of a class that the script defines
            text = ""
        return f"{place}: {type(problem).__name__}{text and ': ' + text}"


def _compile(source: bytes, file: str) -> types.CodeType:
    """Return the code of a script with a counter in each loop, so that a loop without calls of ``sim`` can switch,
    after the same number of iterations in each run. Line numbers stay.
    """
    tree = ast.parse(source, file)
    for node in ast.walk(tree):
        if isinstance(node, (ast.While, ast.For, ast.AsyncFor)):
            name = ast.copy_location(ast.Name(_TURN, ast.Load()), node)
            call = ast.copy_location(ast.Call(name, [], []), node)
            node.body.insert(0, ast.copy_location(ast.Expr(call), node))
    return compile(tree, file, "exec")


def _results(value: Any) -> list[Any]:
    if value is None:
        return []
    # A script's values are of no type.
    return list(value) if isinstance(value, tuple) else [value]  # pyright: ignore[reportUnknownArgumentType]


def main() -> None:
    """Take over the pipes, and serve requests; `python_launcher.py` has built the walls and tells which are missing."""
    reading, writing, missing, *libraries = sys.argv[1:]
    del sys.argv[1:]
    link = Link(int(reading), int(writing))
    faulthandler.register(signal.SIGUSR1, all_threads=True)
    _, name, namespaces, folder = link.receive()
    random.seed(1)
    sys.dont_write_bytecode = True
    sys.path[:] = libraries
    folders = list(libraries)
    if folder is not None:
        folders.append(os.path.realpath(folder))
        os.chdir(folder)
    script = Script(link, name, namespaces)
    python_guard.drop_native_modules()
    stubs = python_stubs.stubs()
    python_guard.hide_modules()
    sys.modules.update(stubs)
    python_guard.refuse(folders, libraries)
    link.send("ready", missing.split(",") if missing else [])
    while True:
        script.serve()


if __name__ == "__main__":
    main()
