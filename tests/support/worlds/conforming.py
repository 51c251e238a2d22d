"""What the conformance tests are written with: the original's declarations, and a test per function and name."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import simx_client as v
from simx_client.protocol.commands import BY_NAME

FOLDER = Path(__file__).parents[2] / "conformance"
SCENE = FOLDER / "scene.xml"
ONESHOT, BLOCKING = v.simx_opmode_oneshot, v.simx_opmode_blocking
STREAMING, BUFFER = v.simx_opmode_streaming, v.simx_opmode_buffer
DISCONTINUE, REMOVE = v.simx_opmode_discontinue, v.simx_opmode_remove
OK, NOVALUE, REMOTE_ERROR = 0, 1, 8

NO_OBJECT = 777_776
"""A handle that no object has; even, because as an option its bit 0 would mean a file of the client."""


@dataclass(frozen=True)
class Declaration:
    """One function as the original's binding has it; a line of ``binding.txt``."""

    name: str
    parameters: tuple[str, ...]
    without_data: str
    """What is returned when there is no data, as Python, with ``rc`` for the return code; ``-`` for anything."""
    key: tuple[str, ...]
    """The parameters that make two calls the same command."""

    @property
    def is_remote(self) -> bool:
        return "operationMode" in self.parameters

    def failure(self, rc: int) -> Any:
        """What a call returns with this code and no data."""
        return eval(self.without_data, {"rc": rc})  # the file is ours

    @property
    def arguments(self) -> list[str]:
        """Without the client and the mode."""
        return [name for name in self.parameters if name not in ("clientID", "operationMode")]


def _read(line: str) -> Declaration:
    head, _, rest = line.partition(") -> ")
    name, _, parameters = head.partition("(")
    without_data, _, key = rest.partition("  key: ")
    return Declaration(name, tuple(parameters.split(", ")), without_data, tuple(key.split()))


BINDING = {
    declaration.name: declaration
    for declaration in map(_read, (FOLDER / "binding.txt").read_text(encoding="utf-8").splitlines())
}
"""All 133 functions of the original's newest binding, by name."""


def sample(declaration: Declaration) -> list[Any]:
    """Arguments of the right kinds that mean nothing in any scene: unknown handles, names and files."""
    command = BY_NAME[declaration.name]
    samples: dict[str, Any] = {
        "int": NO_OBJECT, "float": 0.5, "bool": True, "text": "no such thing", "bytes": b"data", "ints": [NO_OBJECT],
        "floats": [0.5], "texts": ["text"], "vector3": [0.1, 0.2, 0.3], "vector4": [0.0, 0.0, 0.0, 1.0],
        "matrix12": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0], "pixels": [0, 1, 2],
        "optional_text": "text", "optional_ints2": [1, 2], "optional_ints12": [0] * 12,
        "optional_floats3": [0.0] * 3, "optional_floats6": [0.0] * 6,
    }  # fmt: skip
    return [
        samples[argument.kind.name]
        for argument in command.arguments
        if argument.name in declaration.arguments
    ]


def of(name: str) -> Callable[[Any], Any]:
    """Mark a test of one function: it runs once under each of the function's names and takes it as ``simx``."""
    names = BY_NAME[name].names
    return pytest.mark.parametrize("simx", [getattr(v, each) for each in names], ids=names)


def covered() -> set[str]:
    """The names given to ``of`` in all files of this suite."""
    found: set[str] = set()
    for file in FOLDER.glob("test_*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "of":
                found.add(ast.literal_eval(node.args[0]))
    return found


def assert_types(value: Any, like: Any) -> None:
    """Exactly the types of an example, element by element: scripts ask for `tuple`, `int` and `bool` by name."""
    assert type(value) is type(like), (value, like)
    if isinstance(like, tuple):
        assert len(value) == len(like), (value, like)
        for one, other in zip(value, like, strict=True):
            assert_types(one, other)
    elif isinstance(like, list) and like:
        for one in value:
            assert_types(one, like[0])
