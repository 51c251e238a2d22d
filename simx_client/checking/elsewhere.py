"""Programs for remote APIs that this server does not offer: their names, and the alternative."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from ..protocol.commands import TABLE
from .wants import Place, Wants

NAMES: Mapping[str, str] = MappingProxyType(
    {
        "coppeliasim_zmqremoteapi_client": "CoppeliaSim's ZeroMQ remote API",
        "zmqRemoteApi": "CoppeliaSim's ZeroMQ remote API",
        "b0RemoteApi": "CoppeliaSim's B0-based remote API",
        "pyrep": "PyRep, which runs CoppeliaSim inside its own process",
    }
)
"""Description by the module that such a program imports."""

TWINS: Mapping[str, str] = MappingProxyType({each.twin: each.name for each in reversed(TABLE) if each.twin})
"""Functions of the regular API (`sim.getObject`), and their legacy counterparts."""

_REGULAR = re.compile(r"sim\w*\.\w+$")

OFFER = (
    "The server offers the legacy remote API (docs/api.md), client objects (docs/python.md), and Lua or Python "
    "scripts in the scene, which call sim.* functions (docs/script-functions.md)"
)


def functions(wants: Wants) -> dict[str, str]:
    """Return the regular API's functions that a program calls, with the legacy counterpart of each or an
    empty text."""
    names = {name for calls in wants.elsewhere.values() for name in calls if _REGULAR.match(name)}
    return {name: TWINS.get(name, "") for name in sorted(names)}


def sentences(wants: Wants, imports: Mapping[str, Place]) -> Iterator[tuple[Place, str]]:
    """Yield (place, sentence) for each of these APIs that a program imports."""
    for module, place in imports.items():
        text = f"it uses {NAMES[module]}, and simx-server has no gateway for that. {OFFER}"
        called = {name: TWINS.get(name) for name in wants.elsewhere.get(module, {}) if _REGULAR.match(name)}
        if called:
            without = [name for name, twin in called.items() if twin is None]
            text += f". {len(called) - len(without)} of the {len(called)} functions have a legacy counterpart"
            text += f"; without one: {', '.join(without)}" if without else ""
        elif module == "b0RemoteApi":
            text += (
                ". Its functions are called as the legacy ones: use simxStart for the client, and an operation mode in "
                "place of each simxServiceCall(), simxDefaultPublisher() or simxDefaultSubscriber(...)"
            )
        yield place, text
