"""`lib`, the C library as PyRep finds it: functions by name. No exception leaves one: a failure is a code, and a line.

The line says which function failed and why, once for each text, on standard error; PyRep's own exception has only the
code.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from . import c_values as c
from .functions import special_functions
from .plain import FAILED, ROWS, Call, failure_of, plain_function
from .worlds import VERBOSITY, NoSimulation, Worlds

_QUIET = frozenset(
    (
        "simGetObjectHandle",
        "simGetObjectName",
        "simGetObjectParent",
        "simGetIkGroupHandle",
        "simGetCollectionHandle",
    )
)
"""Functions with which programs find out whether something exists."""

_MOST_TOLD = 1000
"""Failures that are told; a program may fail differently for ever."""


class Library:
    """The C library's functions as attributes, made when they are first used."""

    def __init__(self) -> None:
        self._worlds = Worlds()
        self._told: set[str] = set()

    # --- life: see `worlds.py` -------------------------------------------------------------------

    def simExtLaunchUIThread(self, _name: Any, _options: int, scene: Any, _root: Any) -> None:
        """Open a scene, a path, and wait for the end of the simulation; a folder stands for an empty scene."""
        world = self._worlds.launch((c.text(scene) or b"").decode())
        if world is not None and world.problem is None:
            world.wait()

    def simExtCanInitSimThread(self) -> int:
        """Return 1 when the simulation is open, 0 before that. Raises the reason if it cannot be opened."""
        return int(self._worlds.is_open())

    def simExtSimThreadInit(self) -> None:
        """Do nothing: the calling thread may use the simulation already."""

    def simExtSimThreadDestroy(self) -> None:
        """End the simulation."""
        self._worlds.end(self._worlds.present())

    def simExtPostExitRequest(self) -> None:
        """Ask the threads of the program to end."""
        self._worlds.present().exit_requested = True

    def simExtGetExitRequest(self) -> int:
        """Return whether the end was asked for; the end itself counts."""
        try:
            return int(self._worlds.present().exit_requested)
        except Exception:
            return 1

    def simQuitSimulator(self, _is_quiet: bool) -> None:
        """Ask for the end."""
        self.simExtPostExitRequest()

    def simExtStep(self, is_step_wanted: bool = True) -> None:
        """Make one simulation step if one is wanted and the simulation runs; else let scripts do regular work."""
        try:
            self._worlds.present().present_library().step(if_running=bool(is_step_wanted))
        except Exception as problem:
            self._tell("simExtStep", problem)

    def simReleaseBuffer(self, _buffer: Any) -> int:
        """Do nothing: see `c_values`."""
        return 1

    def simSetStringParameter(self, number: int, value: Any) -> int:
        """Set a parameter; how much is printed may be set before the launch."""
        try:
            text = c.text(value) or b""
            try:
                self._call("sim.setStringParameter", [int(number), text])
            except NoSimulation:
                if number != VERBOSITY:
                    raise
                self._worlds.note_verbosity(text.decode())
            return 1
        except Exception as problem:
            return self._failed("simSetStringParameter", problem, FAILED)

    # --- the other functions ---------------------------------------------------------------------

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return a function by its name, and keep it. Raises AttributeError: the library has none of this name."""
        if name in ROWS:
            function, failure = plain_function(name, self._call), failure_of(name)
        elif (special := special_functions().get(name)) is not None:
            function, failure = _bound(special.function, self._call), special.failure
        else:
            raise AttributeError(f"the library has no function {name} here")
        guarded = self._guarded(name, function, failure)
        setattr(self, name, guarded)
        return guarded

    def _call(self, function: str, arguments: list[Any]) -> tuple[Any, ...]:
        return self._worlds.present().present_library().call(function, arguments)

    def _guarded(self, name: str, function: Callable[..., Any], failure: Any) -> Callable[..., Any]:
        def guarded(*arguments: Any) -> Any:
            try:
                return function(*arguments)
            except Exception as problem:
                return self._failed(name, problem, failure)

        guarded.__name__ = name
        guarded.__doc__ = function.__doc__
        return guarded

    def _failed(self, name: str, problem: Exception, failure: Any) -> Any:
        if name not in _QUIET:
            self._tell(name, problem)
        return failure

    def _tell(self, name: str, problem: Exception) -> None:
        text = f"{name}: {problem or type(problem).__name__}"
        if text in self._told or len(self._told) >= _MOST_TOLD:
            return
        self._told.add(text)
        print(text, file=sys.stderr)


def function_names() -> frozenset[str]:
    """Return the names of all functions of the library; does not need cffi."""
    own = (name for name in vars(Library) if name.startswith("sim"))
    return frozenset((*own, *ROWS, *special_functions()))


def _bound(function: Callable[..., Any], call: Call) -> Callable[..., Any]:
    def bound(*arguments: Any) -> Any:
        return function(call, *arguments)

    bound.__doc__ = function.__doc__
    return bound
