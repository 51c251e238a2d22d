"""Programs for remote APIs that this server does not offer: their names, and the alternative."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

from .places import Place

NAMES: Mapping[str, str] = MappingProxyType(
    {
        "b0RemoteApi": "CoppeliaSim's B0-based remote API",
    }
)
"""Description by the module that such a program imports."""

OFFER = (
    "The server offers the legacy remote API (docs/api.md), client objects (docs/python.md), the ZeroMQ remote API "
    "(docs/zmq.md), PyRep (docs/pyrep.md), and Lua or Python scripts in the scene (docs/scripts.md)"
)


def sentences(imports: Mapping[str, Place]) -> Iterator[tuple[Place, str]]:
    """Yield (place, sentence) for each of these APIs that a program imports."""
    for module, place in imports.items():
        text = f"it uses {NAMES[module]}, and simx-server has no gateway for that. {OFFER}"
        if module == "b0RemoteApi":
            text += (
                ". Its functions are called as the legacy ones: use simxStart for the client, and an operation mode in "
                "place of each simxServiceCall(), simxDefaultPublisher() or simxDefaultSubscriber(...)"
            )
        yield place, text
