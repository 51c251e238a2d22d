"""A ``sim`` that echoes, waits and refuses, without a simulation: interpreters of both languages are tested with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Switching, Waiting


class EchoApi:
    """Notes what a script prints, and how often others had a turn. A language adds names and a module ``tools``."""

    is_ending = False

    def __init__(self) -> None:
        self.printed: list[str] = []
        self.switching = Switching()
        self.served = self.calculated = 0

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        if name == "sim.break_down":
            raise ValueError("a slip of the server")
        if name == "sim.pause":
            return self._pause(arguments[0])
        raise CommandError("is not provided" if name != "sim.refuse" else "no object with handle 7")

    def function(self, name: str) -> Callable[[Sequence[Any]], tuple[Any, ...] | Waiting]:
        return lambda values: self.invoke(name, list(values))

    def count_calls(self, count: int) -> None:
        self.calculated += count

    def _pause(self, count: int) -> Waiting:
        for _ in range(count):
            yield
        if count > 2:
            raise CommandError("too long a pause")
        return (count, "done")

    def phases_changed(self) -> None:
        pass

    def serve_others(self) -> None:
        self.served += 1

    def output(self, text: str) -> None:
        self.printed.append(text)
