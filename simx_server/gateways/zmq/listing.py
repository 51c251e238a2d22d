"""List the members of a namespace, from which a client builds an object: ``zmqRemoteApi.info``."""

from __future__ import annotations

from functools import cache
from typing import Any, cast

from simx_server.errors import CommandError
from simx_server.sim_api.listing.coverage import Support, script_functions
from simx_server.sim_api.namespaces import Namespaces

from .functions import split_name

MORE_FUNCTIONS = ("testCB", "handleExtCalls")
"""Functions of ``sim`` that only clients of this protocol have."""


@cache
def namespace(full_name: str) -> dict[str, Any]:
    """Return the members of a namespace, or of a table of constants in one, such as ``simOMPL.Algorithm``.

    Raises:
        CommandError: there is none of this name; the text lists those that exist.
    """
    space, inner = split_name(full_name)
    spaces = Namespaces.names()
    if space not in spaces:
        raise CommandError(
            f"there is no namespace '{full_name[:80]}'; this server has {', '.join(sorted(spaces))}"
        )
    members = {name: _described(value) for name, value in spaces[space].items()}
    if space == "sim":
        members |= {name: _described(None) for name in MORE_FUNCTIONS}
    if not inner:
        return members
    found = members.get(inner, {})
    return {} if "func" in found or "const" in found else found


def offered() -> dict[str, dict[str, str]]:
    """Return for each name with its namespace how much of it there is, and what differs from CoppeliaSim.

    The support is that of `coverage.Support`, or ``constant``.
    """
    lines = {line.name: line for line in script_functions()}
    found: dict[str, dict[str, str]] = {}
    for space in Namespaces.names():
        for name, member in namespace(space).items():
            full_name = f"{space}.{name}"
            line = lines.get(full_name)
            if "func" in member:
                support = line.support if line else Support.FULL
                found[full_name] = {"support": support, "differs": line.differs if line else ""}
            else:  # a constant, or a table of them
                found[full_name] = {"support": "constant", "differs": ""}
    return found


def _described(value: Any) -> dict[str, Any]:
    if value is None:
        return {"func": {}}
    if isinstance(value, dict):
        constants = cast(dict[str, Any], value)
        return {name: {"const": each} for name, each in constants.items()}
    return {"const": value}
