"""A server that echoes, for Python scripts without a simulation, and interpreters that end with their test."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from echo_api import EchoApi

from simx_server.scripting.interpreter import Constant, Waiting
from simx_server.scripting.python.interpreter import PythonInterpreter


class PythonEchoApi(EchoApi):
    """With a function that calls back; it can make its process end."""

    def __init__(self) -> None:
        super().__init__()
        self.vanish = False
        self.interpreter: PythonInterpreter | None = None

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        names = ("echo", "refuse", "break_down", "pause", "packFloatTable", "callBack")
        return {"sim": {"handle_self": -4, **dict.fromkeys(names)}, "simIK": {"echo": None}}

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        if name in ("sim.echo", "simIK.echo"):
            return tuple(arguments)
        if name == "sim.packFloatTable":
            return (b"abcd",)
        if name == "sim.callBack":
            assert self.interpreter is not None
            return tuple(self.interpreter.call(arguments[0].decode(), *arguments[1:]))
        return super().invoke(name, arguments)

    def module(self, name: str) -> bytes | None:
        return {"tools": b"def double(x):\n    return 2 * x\ndef fail():\n    raise ValueError('odd')\n"}.get(
            name
        )

    def serve_others(self) -> None:
        super().serve_others()
        if self.vanish:
            os._exit(0)


class Scripts:
    """Makes interpreters that end with the test."""

    def __init__(self) -> None:
        self.api = PythonEchoApi()
        self.made: list[PythonInterpreter] = []

    def __call__(
        self,
        source: str,
        *,
        time_limit: float = 5.0,
        folder: Path | None = None,
        needs_seccomp: bool = True,
    ) -> PythonInterpreter:
        interpreter = PythonInterpreter(
            "test.py", self.api, time_limit=time_limit, folder=folder, needs_seccomp=needs_seccomp
        )
        self.made.append(interpreter)
        self.api.interpreter = interpreter
        interpreter.run(source.encode())
        return interpreter


@pytest.fixture
def script() -> Iterator[Scripts]:
    scripts = Scripts()
    yield scripts
    for interpreter in scripts.made:
        interpreter.close()
