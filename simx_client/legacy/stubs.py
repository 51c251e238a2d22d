"""Write ``__init__.pyi`` and ``calls.pyi`` from the table, for completion in editors and for type checkers.

``python -m simx_client.legacy.stubs`` writes the files; a test fails when one is stale.
"""

from __future__ import annotations

import inspect
from pathlib import Path

from simx_client.connection.calls import is_batched
from simx_client.protocol import constants
from simx_client.protocol.commands import TABLE, Command, Place
from simx_client.protocol.kinds import Kind

from . import local

_PACKAGE = Path(__file__).parents[1]
PATH = _PACKAGE / "__init__.pyi"
CALLS_PATH = _PACKAGE / "connection" / "calls.pyi"

_ACCEPTED = {
    "int": "SupportsIndex",
    "float": "SupportsFloat",
    "bool": "bool | int",
    "str": "str | bytes",
    "bytearray": "bytes | bytearray | str | memoryview",
    "list[int]": "Iterable[SupportsIndex]",
    "list[float]": "Iterable[SupportsFloat]",
    "list[str]": "Iterable[str]",
}
"""Types accepted for an argument, wider than those of a result."""

_HEADER = '''"""Generated from the table by ``python -m simx_client.legacy.stubs``; do not edit."""

from collections.abc import Iterable
from typing import Any, SupportsFloat, SupportsIndex

from simx_client.calls.images import DepthBuffer, VisionImage
from simx_client.client import Client as Client

'''


_CALLS_HEADER = '''"""Generated from the table by ``python -m simx_client.legacy.stubs``; do not edit."""

from collections.abc import Iterable, Sequence
from typing import Any, SupportsFloat, SupportsIndex

from simx_client.calls.answers import Answer
from simx_client.calls.images import DepthBuffer, VisionImage
from simx_client.calls.marshalling import Marshal
from simx_client.protocol.commands import Command

def is_batched(command: Command) -> bool: ...

class Calls:
    noted: list[Answer[Any]]
    where: str
    def __init__(self, server: int, where: str) -> None: ...
    def note(self, marshal: Marshal, arguments: tuple[Any, ...]) -> Answer[Any]: ...
    def repeat(self, noted: Sequence[Answer[Any]]) -> None: ...
'''


def _accepted(kind: Kind) -> str:
    annotation, _, optional = kind.annotation.partition(" | ")
    wide = _ACCEPTED[annotation]
    return f"{wide} | None" if optional else wide


def _returned(kind: Kind) -> str:
    return {"pixels": "VisionImage", "depths": "DepthBuffer"}.get(kind.name, kind.annotation)


def _remote(name: str, command: Command) -> str:
    kinds = {argument.name: _accepted(argument.kind) for argument in command.arguments}
    parameters = ", ".join(f"{p}: {kinds.get(p, 'SupportsIndex')}" for p in command.parameters)
    results = ", ".join(["int", *[_returned(result.kind) for result in command.results]])
    returns = f"tuple[{results}]" if command.results else "int"
    return f"def {name}({parameters}) -> {returns}: ..."


def _local(name: str) -> str:
    signature = inspect.signature(getattr(local, name))
    kinds = {each.name: str(each.annotation) for each in signature.parameters.values()}
    parameters = ", ".join(f"{each}: {_ACCEPTED.get(kind, kind)}" for each, kind in kinds.items())
    return f"def {name}({parameters}) -> {signature.return_annotation}: ..."


def _noted(name: str, command: Command) -> str:
    parameters = ["self", *[f"{each.name}: {_accepted(each.kind)}" for each in command.arguments]]
    results = [_returned(result.kind) for result in command.results]
    value = results[0] if len(results) == 1 else f"tuple[{', '.join(results)}]" if results else "None"
    return f"    def {name}({', '.join(parameters)}) -> Answer[{value}]: ..."


def render_calls() -> str:
    """Return the stub file of the recorder of a batch."""
    lines = [_noted(name, command) for command in TABLE if is_batched(command) for name in command.names]
    return _CALLS_HEADER + "\n".join(lines) + "\n"


def render() -> str:
    """Return the stub file of the package."""
    lines = [f"{name}: int" for name in vars(constants) if not name.startswith("_")]
    for command in TABLE:
        for name in command.names:
            line = _local(name) if command.place is Place.LOCAL else _remote(name, command)
            lines.append(line.replace("'", ""))
    return _HEADER + "\n".join(lines) + "\n\n__all__: list[str]\n"


if __name__ == "__main__":
    PATH.write_text(render(), encoding="utf-8")
    CALLS_PATH.write_text(render_calls(), encoding="utf-8")
