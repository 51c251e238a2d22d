"""The legacy functions, made from the table: real functions with the original's parameter names.

Wrappers in old projects call them by keyword, list them with ``dir``, read their parameter names and test for
``types.FunctionType``; so each is compiled from a two-line definition, as dataclasses make their methods.
"""

from __future__ import annotations

from types import FunctionType
from typing import Any

from simx_client.calls.marshalling import Marshal
from simx_client.connection.clients import invoke
from simx_client.protocol import constants as c
from simx_client.protocol.commands import TABLE, Command, Place

from . import local
from .files import invoke_loading

_TEMPLATE = "def {name}({parameters}):\n    return _invoke(_marshal, clientID, ({arguments}), {mode})\n"


def _compile(name: str, command: Command, marshal: Marshal) -> FunctionType:
    source = _TEMPLATE.format(
        name=name,
        parameters=", ".join(command.parameters),
        arguments="".join(f"{argument.name}, " for argument in command.arguments),
        mode="operationMode" if command.place is Place.REMOTE else c.simx_opmode_blocking,
    )
    namespace: dict[str, Any] = {
        "_invoke": invoke_loading if command.loads_file else invoke,
        "_marshal": marshal,
    }
    exec(
        compile(source, f"<simx_client {name}>", "exec"), namespace
    )  # the text comes from the table, not from input
    function = namespace[name]
    function.__doc__ = docstring(command)
    function.__module__ = "simx_client"
    return function


def docstring(command: Command) -> str:
    """Return the text that ``help`` shows: the sentence of the table, and the results."""
    results = ", ".join(f"{result.name}: {result.kind.annotation}" for result in command.results)
    if command.place is Place.LOCAL:
        return command.doc
    returns = f"(return code, {results})" if results else "the return code"
    return f"{command.doc}\n\nReturns {returns}; 0 is success, other codes are the simx_return_ flags."


def functions() -> dict[str, FunctionType]:
    """Return every public function by name, aliases included."""
    made: dict[str, FunctionType] = {}
    for command in TABLE:
        if command.place is Place.LOCAL:
            for name in command.names:
                made[name] = getattr(local, name)
        else:
            marshal = Marshal(command)
            for name in command.names:
                made[name] = _compile(name, command, marshal)
    return made


FUNCTIONS = functions()
"""Those of `simx_client`."""
