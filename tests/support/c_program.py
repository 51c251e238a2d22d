"""A program that calls the simulator's C library as PyRep does: with values of C, and from two threads."""

from __future__ import annotations

import os
import threading
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

from simx_client.pyrep import c_values
from simx_client.pyrep.library import Library
from simx_client.pyrep.root import root_folder

ffi: Any = c_values.ffi
HEADLESS = 65536


class Out(NamedTuple):
    """An argument that receives something."""

    kind: str
    """Its type in C: ``float[3]``, ``int *`` ..."""


class CProgram:
    """One program; a context, at whose end its simulation is closed."""

    def __init__(self, scene: Path | str = "") -> None:
        """Launch a simulation; an empty text opens an empty scene."""
        self.lib = Library()
        folder = os.getcwd()
        self._opener = threading.Thread(target=self._open, args=(str(scene).encode(),), daemon=True)
        self._opener.start()
        try:
            while not self.lib.simExtCanInitSimThread():
                self._opener.join(0.005)
        finally:
            os.chdir(folder)
        self.lib.simExtSimThreadInit()
        self.lib.simExtStep(True)

    def _open(self, scene: bytes) -> None:
        os.chdir(root_folder())
        self.lib.simExtLaunchUIThread(b"PyRep", HEADLESS, scene, b"")

    def __enter__(self) -> CProgram:
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        self.shutdown()

    def shutdown(self) -> None:
        """End the simulation as PyRep does."""
        self.lib.simStopSimulation()
        self.lib.simExtPostExitRequest()
        self.lib.simExtSimThreadDestroy()
        self._opener.join()

    def run(self, steps: int) -> None:
        """Start the simulation, and make steps."""
        self.lib.simStartSimulation()
        for _ in range(steps):
            self.lib.simExtStep(True)

    def handle(self, name: str) -> int:
        """Return the handle of an object, which must be there."""
        found: int = self.lib.simGetObjectHandle(name.encode())
        assert found > 0, name
        return found

    def call(self, function: str, *arguments: Any) -> tuple[Any, ...]:
        """Call a function; return its result, and what each `Out` received."""
        given = [ffi.new(each.kind) if isinstance(each, Out) else each for each in arguments]
        result = getattr(self.lib, function)(*given)
        received = [
            _python(each)
            for each, argument in zip(given, arguments, strict=True)
            if isinstance(argument, Out)
        ]
        return (result, *received)

    def done(self, function: str, *arguments: Any) -> Any:
        """Call a function that must succeed; return what its only `Out` received, or None."""
        result, *received = self.call(function, *arguments)
        assert result != c_values.NULL
        assert not isinstance(result, int) or result >= 0, function
        return received[0] if received else None


def _python(value: Any) -> Any:
    """Return what a pointer points to: a list for an array."""
    kind = ffi.typeof(value)
    return list(value) if kind.kind == "array" else value[0]


def numbers(pointer: Any, count: int) -> list[Any]:
    """Return the elements of an array."""
    return [pointer[index] for index in range(count)]


def text(pointer: Any) -> str:
    """Return a text."""
    return ffi.string(pointer).decode()
